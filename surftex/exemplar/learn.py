"""`learn_texture`: the model of a texture from one picture.

1. The shares of all pairs within a radius are measured in the exemplar; it is not needed after that.
2. A picture is drawn from noise.
3. The shares of all pairs are measured in it.
4. Their distances to the exemplar's are taken.
5. The worst pairs join the model, unless no pair is farther off than its own sampling noise.
6. The picture is drawn on until it has the shares of the model so far.
7. Again from 3.
8. The model is complete; quads join at the end.

This is the analysis of Zalesny, Auf der Maur and Van Gool [1]_; noise, quads and the rule by which the picture
is drawn are ours.

References
----------
.. [1] Zalesny, Auf der Maur, Van Gool. Composite Textures: Emulating Building Materials and Vegetation for 3D
   Models. VAST (2001).
"""

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.errors import InputError
from surftex.exemplar.bands import Bands
from surftex.exemplar.cliques import first_pairs, pair_window, quad_pool
from surftex.exemplar.exemplar import Exemplar
from surftex.exemplar.lattice import Plane
from surftex.exemplar.measure import distance, pair_shares
from surftex.exemplar.model import TextureModel, random_levels
from surftex.exemplar.picture import checked_picture
from surftex.exemplar.relaxation import Relaxation
from surftex.exemplar.target import Target, no_cliques
from surftex.kernels.pool import Tick
from surftex.randomness import stream

LEVELS = 32
"""Levels of each band."""

PAIRS, PAIRS_WITH_QUADS = 30, 16
"""Pairs for each band, alone and beside quads."""

SPACINGS = (1, 2, 4)
"""Spacings of the six shapes of quads."""

_SIDE, _SWEEPS, _AT_ONCE, _APART = 160, 12, 2, 2
_CERTAIN = 2.0
"""Pairs join the model if they are farther off than their noise times this."""


def learn_texture(
    image: ArrayLike,
    *,
    order: Literal["quad", "pair"] = "quad",
    pairs: int | None = None,
    spacings: tuple[int, ...] = SPACINGS,
    radius: int = 24,
    mask: ArrayLike | None = None,
    height: ArrayLike | None = None,
    roughness: ArrayLike | None = None,
    seed: int = 0,
    threads: int | None = None,
    tick: Tick | None = None,
) -> TextureModel:
    """Learn a texture from a picture.

    Parameters
    ----------
    image : (h, w) or (h, w, 3) uint8, uint16 or float
        The exemplar, at least 32 x 32; well from 150 x 150. Floats run from 0 to 1.
    order : {"quad", "pair"}
        Whether fours of pixels join the pairs: they make stones, blades and bricks of what are blotches else.
    pairs : int, optional
        Most pairs of each band; 16 beside quads, 30 without.
    spacings : tuple of int
        Steps between the corners of quads.
    radius : int
        Longest pair; at most a quarter of the picture's shorter side.
    mask : (h, w) bool, optional
        Pixels to learn from.
    height : (h, w) number, optional
        Height aligned with the picture: becomes a band of its own.
    roughness : (h, w) number, optional
        Roughness aligned with the picture.
    seed : int
        Of the picture that is drawn while learning.
    threads : int, optional
        None means every core; cannot change the model.
    tick : callable, optional
        Told the finished share; may raise to cancel.

    Returns
    -------
    model : TextureModel
        Some kilobytes.

    Raises
    ------
    InputError
        If the picture is too small, flat or transparent, or an option is out of range.

    Examples
    --------
    >>> from surftex.randomness import stream
    >>> noise = (255 * stream(1, "example").uniform(64, 64)).astype(np.uint8)
    >>> learn_texture(noise, order="pair").synthesize(40, 30, seed=2).shape
    (30, 40)
    """
    spacings, most = checked_options(order, pairs, spacings, radius)
    picture, names, inside = checked_picture(image, mask=mask, height=height, roughness=roughness)
    bands = Bands.learnt(picture, names, inside, LEVELS)
    quad = spacings if order == "quad" else ()
    level = bands.levels_of(picture)
    exemplar, target = learning(level, inside, most, quad, radius, seed, threads, tick)
    fours = tuple(each for each in quad if 6 * each <= min(picture.shape[:2]))
    band, shape = quad_pool(bands.telling, fours)
    target = replace(
        target,
        quad_band=band,
        quad_shape=shape,
        quad=exemplar.quads(band, shape, target.quarter),
        quad_used=np.ones((1, len(band)), bool),
    )
    return TextureModel(bands, target)


def checked_options(
    order: str, pairs: int | None, spacings: tuple[int, ...], radius: int
) -> tuple[tuple[int, ...], int]:
    """Check the options of learning.

    Parameters
    ----------
    order : str
        As for `learn_texture`.
    pairs : int, optional
        As for `learn_texture`.
    spacings : tuple of int
        As for `learn_texture`.
    radius : int
        As for `learn_texture`.

    Returns
    -------
    spacings : tuple of int
        Whole numbers.
    most : int
        Pairs of each band.

    Raises
    ------
    InputError
        If one is out of range.
    """
    if order not in ("quad", "pair"):
        raise InputError(f"order is {order!r}; it takes 'quad' or 'pair'")
    if not 1 <= radius <= 64:
        raise InputError(f"radius is {radius}; it takes 1 to 64 pixels")
    spacings = tuple(map(int, spacings))
    if any(not 1 <= each <= 16 for each in spacings) or len(spacings) > 8:
        raise InputError(f"spacings are {spacings}; they take up to 8 numbers from 1 to 16")
    most = (PAIRS if order == "pair" else PAIRS_WITH_QUADS) if pairs is None else pairs
    if not 2 <= most <= 100:
        raise InputError(f"pairs is {most}; it takes 2 to 100 for each band")
    return spacings, most


def learning(
    level: NDArray[np.uint8],
    inside: NDArray[np.bool_],
    most: int,
    spacings: tuple[int, ...],
    radius: int,
    seed: int,
    threads: int | None,
    tick: Tick | None,
) -> tuple[Exemplar, Target]:
    """Choose the pairs of a texture.

    Parameters
    ----------
    level : (c, h, w) uint8
        Of the picture.
    inside : (h, w) bool
        Pixels that count.
    most : int
        Pairs of each band.
    spacings : tuple of int
        Of fours that will be asked of the exemplar.
    radius : int
        As for `learn_texture`.
    seed : int
        As for `learn_texture`.
    threads : int, optional
        As for `learn_texture`.
    tick : callable, optional
        As for `learn_texture`.

    Returns
    -------
    exemplar : Exemplar
        The picture, in levels.
    target : Target
        With pairs, without fours.
    """
    radius = min(radius, min(inside.shape) // 4)
    reach = max(radius, *(3 * each for each in spacings), 1)
    exemplar = Exemplar.of(level, inside, reach, threads)
    target = no_cliques(exemplar.levels(LEVELS))
    plane = Plane.of(_SIDE, _SIDE, reach, wrap=True)
    start = random_levels(target.single[0], _SIDE * _SIDE, stream(seed, "exemplar", "first"))
    drawn = Relaxation(
        target,
        plane,
        plane.hold(start.reshape(-1, _SIDE, _SIDE)),
        stream(seed, "exemplar", "learn"),
        threads=threads,
    )
    return exemplar, _with_pairs(exemplar, drawn, radius, most * target.bands, tick)


def _with_pairs(exemplar: Exemplar, drawn: Relaxation, radius: int, most: int, tick: Tick | None) -> Target:
    """Add the worst pairs, draw on, and so on, until none is certain to be wrong."""
    target, plane = drawn.target, drawn.lattice
    window = pair_window(target.bands, radius)
    wanted, noise = exemplar.pairs(window, target.code), exemplar.noise(window, target.code)
    first = first_pairs(target.bands)
    new = [int(np.flatnonzero((window == each).all(axis=1))[0]) for each in first]
    chosen: list[int] = []
    while new:
        chosen += new
        used = np.zeros((2, len(chosen)), bool)
        used[0] = True
        pair = np.stack([wanted[chosen], np.zeros_like(wanted[chosen])])
        target = replace(target, pair_type=window[chosen], pair=pair, pair_used=used)
        drawn.aim(target)
        for _ in range(_SWEEPS):
            drawn.sweep()
            drawn.follow()
        if tick:
            tick(min(1.0, len(chosen) / most))
        new = []
        if len(chosen) < most:
            found = pair_shares(plane, drawn.level, window, code=target.code, threads=drawn.threads)[0]
            lack = distance(found, wanted) - _CERTAIN * noise
            lack[chosen] = 0
            new = _worst(window, lack, min(_AT_ONCE * target.bands, most - len(chosen)))
    return target


def _worst(window: NDArray[np.int32], lack: NDArray[np.float64], count: int) -> list[int]:
    """Choose the types that lack most, not next to one another."""
    found: list[int] = []
    lack = lack.copy()
    for _ in range(count):
        best = int(lack.argmax())
        if lack[best] <= 0:
            break
        found.append(best)
        same = (window[:, :2] == window[best, :2]).all(axis=1)
        lack[same & (((window[:, 2:] - window[best, 2:]) ** 2).sum(axis=1) <= _APART**2)] = 0
    return found
