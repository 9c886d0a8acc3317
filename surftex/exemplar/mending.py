"""Mending pictures by their own texture: fill what shall go, knit what was laid side by side.

Pixels outside stay as they are and act as neighbours. A hole is too small to steer its own potentials: a patch beside
it is drawn along, and the hole follows the patch, and keeps the shares of levels by itself.
"""

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.errors import InputError
from surftex.exemplar.lattice import Plane
from surftex.exemplar.learn import learn_texture
from surftex.exemplar.measure import level_shares
from surftex.exemplar.model import TextureModel, random_levels
from surftex.exemplar.picture import checked_picture
from surftex.exemplar.relaxation import Relaxation
from surftex.exemplar.smoothing import within_levels
from surftex.kernels.pool import PartTick, Tick
from surftex.randomness import stream

_BESIDE, _AHEAD = 96, 15
_RATE = 6.0
"""How strongly the shares of levels within the hole steer it."""
_ENOUGH = 10_000
"""Pixels around a hole from which its texture is learnt, at least."""


def fill(
    image: ArrayLike,
    mask: ArrayLike,
    *,
    model: TextureModel | None = None,
    zone: int = 24,
    sweeps: int = 100,
    seed: int = 0,
    threads: int | None = None,
    tick: Tick | None = None,
    **options: Any,
) -> NDArray[np.uint8]:
    """Replace a part of a picture by the texture around it.

    Parameters
    ----------
    image : (h, w) or (h, w, 3) uint8, uint16 or float
        The picture.
    mask : (h, w) bool
        What shall be replaced.
    model : TextureModel, optional
        The texture to draw; without it that of a zone around the part is learnt.
    zone : int
        Pixels around the part to learn from, at least 1; more where they are few.
    sweeps : int
        How often each pixel is drawn.
    seed : int
        Same seed, same bytes, whatever the number of threads.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share; may raise to cancel.
    **options : Any
        As for `surftex.learn_texture`.

    Returns
    -------
    picture : (h, w) or (h, w, 3) uint8
        Unchanged outside the mask.

    Raises
    ------
    InputError
        If picture and mask do not fit, nothing is to be replaced, or too little is left to learn from.
    """
    picture, names, _ = checked_picture(image)
    hole = _checked_mask(mask, (picture.shape[0], picture.shape[1]))
    if zone < 1:
        raise InputError(f"zone is {zone}; it takes 1 pixel or more")
    if model is None:
        known = _around(hole, zone, _ENOUGH)
        part = PartTick(tick, 0, 0.4)
        model = learn_texture(_codes(picture), mask=known, seed=seed, threads=threads, tick=part, **options)
    elif model.bands.names != names:
        raise InputError(
            f"the model draws {', '.join(model.bands.names)}, the picture has {', '.join(names)}; learn it from "
            "pictures alike"
        )
    return _redrawn(picture, hole, model, sweeps, seed, threads, PartTick(tick, 0.4))


def knit(
    first: ArrayLike,
    second: ArrayLike,
    *,
    side: Literal["right", "below"] = "right",
    zone: int = 24,
    width: int = 14,
    sweeps: int = 100,
    seed: int = 0,
    threads: int | None = None,
    tick: Tick | None = None,
    **options: Any,
) -> NDArray[np.uint8]:
    """Join two pictures: the border between them is drawn anew, by the texture of the zone around it.

    Parameters
    ----------
    first : (h, w) or (h, w, 3) uint8, uint16 or float
        A picture, or what `knit` made.
    second : (h, w) or (h, w, 3) uint8, uint16 or float
        Another, as high, or as wide where it lies below.
    side : {"right", "below"}
        Where it lies.
    zone : int
        Pixels on either side of the border to learn from.
    width : int
        Pixels on either side that are drawn anew at most; it wavers down to 0.4 of that.
    sweeps : int
        As for `fill`.
    seed : int
        As for `fill`.
    threads : int, optional
        As for `fill`.
    tick : callable, optional
        As for `fill`.
    **options : Any
        As for `surftex.learn_texture`.

    Returns
    -------
    picture : (h, w) or (h, w, 3) uint8
        Both side by side.

    Raises
    ------
    InputError
        If the pictures do not fit, or the zone is no wider than what is drawn anew.

    References
    ----------
    .. [1] Zalesny, Auf der Maur, Van Gool. Composite Textures. VAST (2001), section on knitting.
    """
    if not 1 <= width < zone:
        raise InputError(f"width is {width} and zone is {zone}; width takes 1 to zone - 1")
    pictures = [checked_picture(each)[0] for each in (first, second)]
    axis = 1 if side == "right" else 0
    across = [each.shape[1 - axis] for each in pictures]
    bands = [each.shape[2] for each in pictures]
    if across[0] != across[1] or bands[0] != bands[1]:
        what = "high" if axis == 1 else "wide"
        raise InputError(
            f"the pictures have {bands[0]} and {bands[1]} bands and are {across[0]} and {across[1]} pixels {what}; "
            f"those to be knitted are as {what}, both grey or both in colour"
        )
    whole = np.concatenate(pictures, axis=axis)
    border = pictures[0].shape[axis]
    away = np.arange(whole.shape[axis]) + 0.5 - border
    hole = np.abs(away) < np.where(away < 0, *_ragged(across[0], width, seed)[:, :, None])
    known = np.broadcast_to(np.abs(away) < zone, hole.shape)
    if axis == 0:
        hole, known = np.ascontiguousarray(hole.T), known.T
    model = learn_texture(
        _codes(whole), mask=known, seed=seed, threads=threads, tick=PartTick(tick, 0, 0.4), **options
    )
    return _redrawn(whole, hole, model, sweeps, seed, threads, PartTick(tick, 0.4))


def _ragged(length: int, width: int, seed: int) -> NDArray[np.float64]:
    """(2, length): how far either side of a border is drawn anew; it wavers, so that no straight line remains."""
    from scipy.ndimage import gaussian_filter1d

    numbers = stream(seed, "exemplar", "ragged").uniform(2 * length)[:, 0].reshape(2, length)
    smooth = gaussian_filter1d(numbers, 0.4 * width, axis=1, mode="reflect")
    spread = np.ptp(smooth, axis=1, keepdims=True)
    return width * (0.4 + 0.6 * (smooth - smooth.min(axis=1, keepdims=True)) / np.maximum(spread, 1e-9))


def _redrawn(
    picture: NDArray[np.float32], hole: NDArray[np.bool_], model: TextureModel, sweeps: int, seed: int,
    threads: int | None, tick: Tick | None,
) -> NDArray[np.uint8]:  # fmt: skip
    """Draw the hole anew among frozen neighbours, by the potentials of a patch that is drawn along."""
    target, bands = model.target, model.bands
    reach = max(1, target.radius)
    rows, columns = (np.flatnonzero(hole.any(axis=axis)) for axis in (1, 0))
    cut = tuple(slice(max(0, int(each[0]) - reach), int(each[-1]) + reach + 1) for each in (rows, columns))
    inside = hole[cut]
    height, width = inside.shape
    plane, beside = Plane.of(height, width, reach, wrap=False), Plane.of(_BESIDE, _BESIDE, reach, wrap=True)
    level = plane.hold(bands.levels_of(picture[cut]))
    live = np.zeros(plane.places, bool)
    live[plane.site[inside.ravel()]] = True
    level[:, live] = random_levels(target.single[0], int(live.sum()), stream(seed, "exemplar", "hole"))
    patch = random_levels(target.single[0], _BESIDE**2, stream(seed, "exemplar", "patch"))
    leading = Relaxation(
        target, beside, beside.hold(patch.reshape(-1, _BESIDE, _BESIDE)), stream(seed, "exemplar", "patch sweeps"),
        threads=threads,
    )  # fmt: skip
    drawn = Relaxation(
        target, plane, level, stream(seed, "exemplar", "hole sweeps"), live=live, threads=threads
    )
    for number in range(sweeps):
        leading.sweep()
        leading.follow(1.0 / (1.0 + max(0.0, number - 0.5 * sweeps) / 20.0))
        if number >= _AHEAD or sweeps <= _AHEAD:
            drawn.take(leading)
            drawn.sweep()
            own = level_shares(plane, level, target.levels, site=np.flatnonzero(live).astype(np.int32))
            drawn.push += _RATE * (own - target.single)
        if tick:
            tick((number + 1) / sweeps)
    found = within_levels(plane, level, stream(seed, "exemplar", "hole within"))
    new = _codes(bands.numbers_of(found).reshape(height, width, -1))
    whole = _codes(picture)
    whole[cut][inside] = new[inside]
    return whole if bands.colored else whole[..., 0]


def _codes(picture: NDArray[np.floating]) -> NDArray[np.uint8]:
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def _checked_mask(mask: ArrayLike, shape: tuple[int, int]) -> NDArray[np.bool_]:
    given = np.asarray(mask)
    if given.shape != shape:
        raise InputError(f"the mask has shape {given.shape}, the picture {shape}; they must be aligned")
    hole = given.astype(np.float64) > 0.5 * max(1.0, float(given.max(initial=0)))
    if not hole.any():
        raise InputError("the mask is empty; nothing is to be replaced")
    return hole


def _around(hole: NDArray[np.bool_], zone: int, enough: int) -> NDArray[np.bool_]:
    """Pixels outside a hole and near it."""
    from scipy.ndimage import distance_transform_edt

    away = np.asarray(distance_transform_edt(~hole))
    outside = np.sort(away[~hole])
    if len(outside) < 32**2:
        raise InputError(f"the mask leaves {len(outside)} pixels to learn from; it takes {32**2} at least")
    reach = max(float(zone), float(outside[min(enough, len(outside)) - 1]))
    return ~hole & (away <= reach)
