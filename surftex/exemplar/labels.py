"""`LabelModel`: the layout of labels as a texture of its own, drawn from coarse to fine.

A label map has up to eight labels. Pairs of labels are counted by both, not by a difference, and up to four labels
have fours as well. Layouts reach farther than any pair: so the map is drawn at a fraction of its size first, and each
finer map starts from the coarser one, by potentials that a small map beside it has found.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.errors import InputError
from surftex.exemplar.cliques import quad_pool
from surftex.exemplar.lattice import MISSING, Lattice, Plane
from surftex.exemplar.measure import level_shares, pair_shares, quad_shares
from surftex.exemplar.model import checked_plane, random_levels
from surftex.exemplar.relaxation import Relaxation
from surftex.exemplar.target import Target, quarters
from surftex.kernels.pool import PartTick, Tick
from surftex.randomness import stream

MOST_LABELS = 8
"""Labels of a map."""

SWEEPS, FINER_SWEEPS = 120, 60
"""How often each label is drawn, on the coarsest map and on each finer one."""

_SPACINGS = (1, 2, 4)
_FARTHEST = 8
_DIRECTIONS = ((1, 0), (0, 1), (1, 1), (-1, 1))
_LEAST_SIDE, _MOST_SCALES = 48, 4
_KEPT = 0.6
"""Share of its pixels that a label must keep on a coarser map."""
_BESIDE, _BESIDE_SWEEPS = 96, 40
_WEIGHINGS = 30


@dataclass(frozen=True, eq=False)
class LabelModel:
    """Layouts of labels; learn one with `learn_labels`.

    Attributes
    ----------
    targets : tuple of Target
        Statistics at each scale, the coarsest first; each is twice as fine as the one before.
    """

    targets: tuple[Target, ...]

    @property
    def labels(self) -> int:
        """How many there are."""
        return self.targets[0].levels

    @cached_property
    def nbytes(self) -> int:
        """Bytes of the model as a ``.stex`` file."""
        from surftex.exemplar.store import packed

        return len(packed(self))

    @property
    def shares(self) -> NDArray[np.float64]:
        """(labels,) how much of the map each covers."""
        return self.targets[-1].single[0, 0].astype(np.float64)

    def synthesize(
        self,
        width: int,
        height: int,
        seed: int = 0,
        *,
        threads: int | None = None,
        tick: Tick | None = None,
    ) -> NDArray[np.uint8]:
        """Draw a label map that tiles.

        Parameters
        ----------
        width : int
            Columns, at least 16.
        height : int
            Rows.
        seed : int
            Same seed, same bytes, whatever the number of threads.
        threads : int, optional
            None means every core.
        tick : callable, optional
            Told the finished share; may raise to cancel.

        Returns
        -------
        label : (height, width) uint8
            From 0 on.

        Raises
        ------
        InputError
            If the size is too small or too large.
        """
        checked_plane(width, height, 1)
        lattices: list[Plane] = []
        onto: list[NDArray[np.int32]] = []
        for number, target in enumerate(self.targets):
            by = 2 ** (len(self.targets) - 1 - number)
            rows, columns = max(8, -(-height // by)), max(8, -(-width // by))
            plane = Plane.of(rows, columns, max(1, target.radius), wrap=True)
            if lattices:
                coarse = lattices[-1]
                row, column = np.minimum(np.arange(rows) // 2, coarse.height - 1), np.arange(columns) // 2
                column = np.minimum(column, coarse.width - 1)
                onto.append((row[:, None] * coarse.width + column).ravel().astype(np.int32))
            lattices.append(plane)
        level = self.levels_on(lattices, onto, seed, threads=threads, tick=tick)
        return lattices[-1].picture(level)[0][:height, :width]

    def levels_on(
        self,
        lattices: Sequence[Lattice],
        onto: Sequence[NDArray[np.int32]],
        seed: int,
        *,
        threads: int | None = None,
        tick: Tick | None = None,
    ) -> NDArray[np.uint8]:
        """Draw labels on any lattices.

        Parameters
        ----------
        lattices : sequence of Lattice
            One for each target, the coarsest first.
        onto : sequence of (n,) int32
            For each lattice but the first: the site of the lattice before that each of its sites lies on.
        seed : int
            As for `synthesize`.
        threads : int, optional
            As for `synthesize`.
        tick : callable, optional
            As for `synthesize`.

        Returns
        -------
        level : (1, places) uint8
            On the last lattice.
        """
        level = np.zeros((1, 0), np.uint8)
        for number, (target, lattice) in enumerate(zip(self.targets, lattices, strict=True)):
            named = ("exemplar", "labels", number)
            site = lattice.site
            if number == 0:
                start = random_levels(target.single[0], len(site), stream(seed, *named, "start"))
            else:
                start = level[:, lattices[number - 1].site][:, onto[number - 1]]
            level = np.full((1, lattice.places), MISSING, np.uint8)
            level[:, site] = start
            lattice.repeat(level)
            drawn = Relaxation(target, lattice, level, stream(seed, *named, "sweeps"), threads=threads)
            part = PartTick(tick, number / len(lattices), (number + 1) / len(lattices))
            if number:
                drawn.take(_beside(target, seed, named, threads))
            drawn.run(FINER_SWEEPS if number else SWEEPS, rate=0.5 if number else 1.0, tick=part)
        return level

    def save(self, path: str | Path) -> None:
        """Write the model.

        Parameters
        ----------
        path : path
            ``.stex`` or ``.json``.

        Raises
        ------
        InputError
            If the name ends otherwise.
        WorkError
            If the file cannot be written.
        """
        from surftex.exemplar.store import save_model

        save_model(self, path)


def learn_labels(labels: ArrayLike, *, mask: ArrayLike | None = None, least: int = 2) -> LabelModel:
    """Learn how labels lie beside one another.

    Parameters
    ----------
    labels : (h, w) int
        From 0 on, at most 8 labels; at least 32 x 32.
    mask : (h, w) bool, optional
        Pixels that count.
    least : int
        Labels that there must be; 1 allows a map of a single one, whose layout is constant.

    Returns
    -------
    model : LabelModel
        Some kilobytes for each scale.

    Raises
    ------
    InputError
        If the map is no label map, or is too small.

    Examples
    --------
    >>> stripes = np.arange(64) // 8 % 2 + np.zeros((64, 1), int)
    >>> learn_labels(stripes).synthesize(40, 30).shape
    (30, 40)
    """
    label = checked_labels(labels)
    inside = np.ones(label.shape, bool) if mask is None else np.asarray(mask, bool)
    if inside.shape != label.shape:
        raise InputError(f"the mask has shape {inside.shape}, the label map {label.shape}")
    present = label[inside]
    count = int(present.max(initial=0)) + 1
    if count < least:
        raise InputError("the label map holds one label only; there is no layout to learn")
    share = np.bincount(present, minlength=count) / max(1, len(present))
    scales = [np.where(inside, label, MISSING).astype(np.uint8)]
    while len(scales) < _MOST_SCALES and min(scales[-1].shape) >= 2 * _LEAST_SIDE:
        coarse = _halved(scales[-1], count)
        known = coarse[coarse != MISSING]
        if (np.bincount(known, minlength=count) < _KEPT * share * max(1, len(known))).any():
            break
        scales.append(coarse)
    spacings = _SPACINGS if len(scales) > 1 else (*_SPACINGS, _FARTHEST)
    return LabelModel(tuple(_target(each, count, spacings) for each in reversed(scales)))


def checked_labels(labels: ArrayLike, shape: tuple[int, int] | None = None) -> NDArray[np.uint8]:
    """Check a label map.

    Parameters
    ----------
    labels : (h, w) int
        From 0 on.
    shape : (int, int), optional
        Rows and columns that it must have: those of a picture.

    Returns
    -------
    label : (h, w) uint8
        The same.

    Raises
    ------
    InputError
        If it is no label map of at most 8 labels, has another shape, or is too small.
    """
    label = np.asarray(labels)
    if label.ndim != 2 or label.dtype.kind not in "iub":
        raise InputError(
            f"the label map has shape {label.shape} and type {label.dtype}; it takes whole numbers, (height, width)"
        )
    if shape is not None and label.shape != shape:
        raise InputError(
            f"the label map has {label.shape[1]} x {label.shape[0]} pixels, the picture {shape[1]} x {shape[0]}; "
            "they must be aligned"
        )
    if min(label.shape) < 32:
        raise InputError(
            f"the label map has {label.shape[1]} x {label.shape[0]} pixels; it takes 32 x 32 at least"
        )
    if label.min() < 0 or label.max() >= MOST_LABELS:
        raise InputError(
            f"the label map runs from {label.min()} to {label.max()}; it takes at most {MOST_LABELS} labels, from 0 on"
        )
    return label.astype(np.uint8)


def _beside(target: Target, seed: int, named: tuple[str | int, ...], threads: int | None) -> Relaxation:
    """Draw a small map until its potentials have settled."""
    plane = Plane.of(_BESIDE, _BESIDE, max(1, target.radius), wrap=True)
    start = random_levels(target.single[0], _BESIDE**2, stream(seed, *named, "beside"))
    level = plane.hold(start.reshape(1, _BESIDE, _BESIDE))
    drawn = Relaxation(target, plane, level, stream(seed, *named, "beside sweeps"), threads=threads)
    drawn.run(_BESIDE_SWEEPS)
    return drawn


def _target(label: NDArray[np.uint8], count: int, spacings: tuple[int, ...]) -> Target:
    offset = [(0, 0, k * right, k * down) for k in spacings for right, down in _DIRECTIONS]
    pair_type = np.array(offset, np.int32)
    band, shape = quad_pool((0,), _SPACINGS if count <= 4 else ())
    reach = max(3 * max(_SPACINGS), max(spacings))
    plane = Plane.of(label.shape[0], label.shape[1], reach, wrap=False)
    level = plane.hold(label[None])
    site = plane.site[label.ravel() != MISSING]
    single = level_shares(plane, level, count, site=site)
    quarter = quarters(single[0], joint=True)[None]
    used = np.zeros((2, len(pair_type)), bool)
    used[0] = True
    return Target(
        count, True, single, pair_type, pair_shares(plane, level, pair_type, code=(8, 0), site=site), band, shape,
        quad_shares(plane, level, band, shape, quarter, site=site), quarter, used, np.ones((1, len(band)), bool),
    )  # fmt: skip


def _halved(label: NDArray[np.uint8], count: int) -> NDArray[np.uint8]:
    """Label that prevails around each four pixels, by weights that leave each label its share of the map."""
    from scipy.ndimage import gaussian_filter

    rows, columns = (length // 2 for length in label.shape)
    cut = label[: 2 * rows, : 2 * columns]
    known = np.maximum(gaussian_filter((cut != MISSING).astype(np.float64), 1.0), 1e-9)
    soft = np.stack([gaussian_filter((cut == each).astype(np.float64), 1.0) / known for each in range(count)])
    soft = soft.reshape(count, rows, 2, columns, 2).mean(axis=(2, 4))
    here = (cut != MISSING).reshape(rows, 2, columns, 2).any(axis=(1, 3))
    share = np.bincount(cut[cut != MISSING], minlength=count) / max(1, int((cut != MISSING).sum()))
    bias, result = np.zeros(count), np.zeros((rows, columns), np.uint8)
    for _ in range(_WEIGHINGS):
        result = (soft + bias[:, None, None]).argmax(axis=0).astype(np.uint8)
        bias += 0.5 * (share - np.bincount(result[here], minlength=count) / max(1, int(here.sum())))
    return np.where(here, result, MISSING).astype(np.uint8)
