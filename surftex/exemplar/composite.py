"""`CompositeModel`: several textures side by side, their layout, and what lies between them.

Each label of a layout has a texture of its own; pairs of pixels that join two labels are a class of their own, the
transition. All are drawn together, so nothing has to be knitted afterwards. A label may be parted into labels itself
(a layout within a layout): its parts are drawn like labels of the whole.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked_whole
from surftex.errors import InputError
from surftex.exemplar.bands import Bands
from surftex.exemplar.cliques import first_pairs, quad_pool
from surftex.exemplar.erosion import erosion_series
from surftex.exemplar.exemplar import Exemplar
from surftex.exemplar.labels import MOST_LABELS, LabelModel, checked_labels, learn_labels
from surftex.exemplar.lattice import MISSING, Lattice, Plane
from surftex.exemplar.learn import LEVELS, SPACINGS, checked_options, learning
from surftex.exemplar.measure import level_shares, pair_shares, quad_shares
from surftex.exemplar.model import PAIR_SWEEPS, QUAD_SWEEPS, checked_plane, random_levels
from surftex.exemplar.picture import checked_picture
from surftex.exemplar.relaxation import Relaxation
from surftex.exemplar.smoothing import within_levels
from surftex.exemplar.target import Target, quarters
from surftex.kernels.pool import PartTick, Tick
from surftex.randomness import stream

LEAST_PIXELS = 400
"""Pixels that a label must have for its texture to be learnt."""

_LEAST_JOINTS = 2000
"""Pairs that a type must have within a class to be taken as known."""


@dataclass(frozen=True, eq=False)
class Layout:
    """Labels, some of them parted into further labels.

    Attributes
    ----------
    model : LabelModel
        Of the labels.
    parts : tuple of Layout or None
        For each label, how it is parted.
    """

    model: LabelModel
    parts: tuple["Layout | None", ...]

    @property
    def leaves(self) -> int:
        """Labels that are not parted further."""
        return sum(1 if part is None else part.leaves for part in self.parts)

    def models(self) -> list[LabelModel]:
        """List the models, the whole before its parts."""
        return [self.model, *(each for part in self.parts if part is not None for each in part.models())]

    def joined(self, maps: list[NDArray[np.uint8]]) -> NDArray[np.uint8]:
        """Join one drawing of each model to a map of leaves.

        Parameters
        ----------
        maps : list of arrays
            In the order of `models`; used up.

        Returns
        -------
        leaf : array of uint8
            Numbered label by label, parts in their places.
        """
        label = maps.pop(0)
        leaf, first = np.zeros_like(label), 0
        for number, part in enumerate(self.parts):
            here = label == number
            if part is None:
                leaf[here] = first
                first += 1
            else:
                leaf[here] = first + part.joined(maps)[here]
                first += part.leaves
        return leaf


@dataclass(frozen=True, eq=False)
class CompositeModel:
    """What `learn_composite` learns.

    Attributes
    ----------
    bands : Bands
        How levels become numbers.
    target : Target
        Statistics; its groups are the labels.
    layout : Layout
        How the labels lie.
    over : LabelModel or None
        Layout of the last label where it lies over the others, such as cracks do.
    """

    bands: Bands
    target: Target
    layout: Layout
    over: LabelModel | None = None

    @property
    def labels(self) -> int:
        """Textures that there are."""
        return self.target.groups

    @cached_property
    def nbytes(self) -> int:
        """Bytes of the model as a ``.stex`` file."""
        from surftex.exemplar.store import packed

        return len(packed(self))

    @property
    def sweeps(self) -> int:
        """How often each pixel is drawn where the caller does not say."""
        return QUAD_SWEEPS if len(self.target.quad_band) else PAIR_SWEEPS

    def label_map(
        self,
        width: int,
        height: int,
        seed: int = 0,
        *,
        age: int = 0,
        threads: int | None = None,
        tick: Tick | None = None,
    ) -> NDArray[np.uint8]:
        """Draw a layout.

        Parameters
        ----------
        width : int
            Columns.
        height : int
            Rows.
        seed : int
            Same seed, same bytes.
        age : int
            Steps by which the label that lies over the others has grown; below 0 it is smaller.
        threads : int, optional
            None means every core.
        tick : callable, optional
            Told the finished share.

        Returns
        -------
        label : (height, width) uint8
            From 0 on; it tiles.

        Raises
        ------
        InputError
            If there is an age, but nothing that grows.
        """
        models = self.layout.models()
        label = self.layout.joined(
            [
                model.synthesize(
                    width, height, stream(seed, "exemplar", "layout", number).key if number else seed,
                    threads=threads, tick=PartTick(tick, number / len(models), (number + 1) / len(models)),
                )
                for number, model in enumerate(models)
            ]
        )  # fmt: skip
        if self.over is None:
            if age:
                raise InputError(
                    "no label of this model lies over the others; learn it with one that does (over)"
                )
            return label
        worn = self.over.synthesize(width, height, stream(seed, "exemplar", "over").key, threads=threads) > 0
        series = erosion_series(worn, shrink=max(0, -age), grow=max(0, age))
        return np.where(series[-1 if age > 0 else 0], self.labels - 1, label).astype(np.uint8)

    def synthesize(
        self,
        width: int,
        height: int,
        seed: int = 0,
        *,
        labels: ArrayLike | None = None,
        age: int = 0,
        sweeps: int | None = None,
        threads: int | None = None,
        tick: Tick | None = None,
    ) -> NDArray[np.uint8]:
        """Draw the composite. It tiles, where the layout does.

        Parameters
        ----------
        width : int
            Columns, at least 16.
        height : int
            Rows.
        seed : int
            Same seed, same bytes, whatever the number of threads.
        labels : (height, width) int, optional
            A layout of one's own; one is drawn without it.
        age : int
            As for `label_map`.
        sweeps : int, optional
            How often each pixel is drawn.
        threads : int, optional
            None means every core.
        tick : callable, optional
            Told the finished share; may raise to cancel.

        Returns
        -------
        picture : (height, width) or (height, width, 3) uint8
            Grey or colour, as learnt.

        Raises
        ------
        InputError
            If the size is too small or too large, or the layout does not fit.
        """
        return self.maps(
            width, height, seed, labels=labels, age=age, sweeps=sweeps, threads=threads, tick=tick
        )["picture"]

    def maps(
        self,
        width: int,
        height: int,
        seed: int = 0,
        *,
        labels: ArrayLike | None = None,
        age: int = 0,
        sweeps: int | None = None,
        threads: int | None = None,
        tick: Tick | None = None,
    ) -> dict[str, NDArray[np.uint8]]:
        """Draw the composite with its layout, and the maps that were learnt beside it.

        Parameters
        ----------
        width : int
            As for `synthesize`.
        height : int
            As for `synthesize`.
        seed : int
            As for `synthesize`.
        labels : (height, width) int, optional
            As for `synthesize`.
        age : int
            As for `label_map`.
        sweeps : int, optional
            As for `synthesize`.
        threads : int, optional
            As for `synthesize`.
        tick : callable, optional
            As for `synthesize`.

        Returns
        -------
        maps : dict of str to uint8 arrays
            ``picture``, ``labels``, and any of ``height`` and ``roughness``.

        Raises
        ------
        InputError
            As for `synthesize`.
        """
        plane = checked_plane(width, height, self.target.radius)
        if labels is None:
            label = self.label_map(width, height, seed, age=age, threads=threads, tick=PartTick(tick, 0, 0.2))
        else:
            label = checked_labels(labels, (height, width))
            if label.max() >= self.labels:
                raise InputError(
                    f"the label map names label {label.max()}; the model has {self.labels}, from 0 on"
                )
        group = plane.hold(label[None], 0)[0]
        level = self.levels_on(plane, seed, group, sweeps=sweeps, threads=threads, tick=PartTick(tick, 0.2))
        number = within_levels(plane, level, stream(seed, "exemplar", "within"), group)
        return {**self.bands.maps_of(number.reshape(-1, height, width), label), "labels": label}

    def levels_on(
        self,
        lattice: Lattice,
        seed: int,
        group: NDArray[np.uint8],
        *,
        sweeps: int | None = None,
        threads: int | None = None,
        tick: Tick | None = None,
    ) -> NDArray[np.uint8]:
        """Draw the textures on any lattice.

        Parameters
        ----------
        lattice : Lattice
            Knows the offsets of `surftex.exemplar.relaxation.asked_offsets`.
        seed : int
            As for `synthesize`.
        group : (places,) uint8
            Label of each place.
        sweeps : int, optional
            As for `synthesize`.
        threads : int, optional
            As for `synthesize`.
        tick : callable, optional
            As for `synthesize`.

        Returns
        -------
        level : (c, places) uint8
            What each place of the lattice shows.
        """
        level = np.full((self.target.bands, lattice.places), MISSING, np.uint8)
        for label, single in enumerate(self.target.single):
            site = lattice.site[group[lattice.site] == label]
            level[:, site] = random_levels(single, len(site), stream(seed, "exemplar", "start", label))
        lattice.repeat(level)
        drawn = Relaxation(
            self.target, lattice, level, stream(seed, "exemplar", "sweeps"), group=group, threads=threads
        )
        drawn.run(self.sweeps if sweeps is None else checked_whole(sweeps, "sweeps", 1, 1000), tick=tick)
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


def learn_composite(
    image: ArrayLike,
    labels: ArrayLike,
    *,
    within: Mapping[int, ArrayLike] | None = None,
    over: bool = False,
    order: Literal["quad", "pair"] = "quad",
    pairs: int | None = None,
    spacings: tuple[int, ...] = SPACINGS,
    radius: int = 24,
    height: ArrayLike | None = None,
    roughness: ArrayLike | None = None,
    seed: int = 0,
    threads: int | None = None,
    tick: Tick | None = None,
) -> CompositeModel:
    """Learn several textures, their layout and their transitions from one picture.

    Parameters
    ----------
    image : (h, w) or (h, w, 3) uint8, uint16 or float
        The exemplar.
    labels : (h, w) int
        Label of each pixel, from 0 on; at most 8 in all.
    within : mapping of int to (h, w) int, optional
        For some labels a label map of its own: counts where the label is, and parts it.
    over : bool
        Whether the last label lies over the others, as cracks do: its layout is learnt by itself, and may grow.
    order : {"quad", "pair"}
        As for `surftex.learn_texture`.
    pairs : int, optional
        Most pairs of each label and band.
    spacings : tuple of int
        As for `surftex.learn_texture`.
    radius : int
        As for `surftex.learn_texture`.
    height : (h, w) number, optional
        As for `surftex.learn_texture`.
    roughness : (h, w) number, optional
        As for `surftex.learn_texture`.
    seed : int
        Of what is drawn while learning.
    threads : int, optional
        None means every core; cannot change the model.
    tick : callable, optional
        Told the finished share; may raise to cancel.

    Returns
    -------
    model : CompositeModel
        Some kilobytes for each label.

    Raises
    ------
    InputError
        If picture or label map do not fit, there are too many labels, or one has too few pixels.
    """
    spacings, most = checked_options(order, pairs, spacings, radius)
    picture, names, _ = checked_picture(image, height=height, roughness=roughness)
    label = checked_labels(labels, (picture.shape[0], picture.shape[1]))
    last = int(label.max())
    if over and not last:
        raise InputError("the label map holds one label only; nothing lies over another")
    under = label < last if over else np.ones(label.shape, bool)
    layout, leaf = _layout(_beneath(label, under), within or {}, alone=over)
    cover = learn_labels((~under).astype(np.uint8)) if over else None
    label = np.where(under, leaf, layout.leaves).astype(np.uint8)
    count = layout.leaves + over
    _check_counts(label, count)
    bands = Bands.learnt(picture, names, np.ones(label.shape, bool), LEVELS, label)
    level = bands.levels_of(picture, label)
    found: list[Target] = []
    for each in range(count):
        inside = label == each
        part = PartTick(tick, each / count, (each + 1) / count)
        found.append(learning(level, inside, most, (), radius, seed, threads, part)[1])
    spacings = tuple(k for k in spacings if 6 * k <= min(label.shape)) if order == "quad" else ()
    return CompositeModel(bands, _joined(level, bands, label, found, spacings, threads), layout, cover)


def _beneath(label: NDArray[np.uint8], under: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Give what lies over the labels the nearest of them."""
    from scipy.ndimage import distance_transform_edt

    if under.all() or not under.any():
        return label
    nearest: Any = distance_transform_edt(~under, return_distances=False, return_indices=True)
    return label[nearest[0], nearest[1]]


def _layout(
    label: NDArray[np.uint8], within: Mapping[int, ArrayLike], *, alone: bool
) -> tuple[Layout, NDArray[np.uint8]]:
    """Learn the layouts, and number the leaves; one label is enough where it may be ``alone``."""
    count = int(label.max(initial=0)) + 1
    odd = [each for each in within if not 0 <= each < count]
    if odd:
        raise InputError(f"label {odd[0]} is parted, but labels run from 0 to {count - 1}")
    if count < 2 and not alone:
        raise InputError("the label map holds one label only; learn the picture without it")
    parts: list[Layout | None] = [None] * count
    maps = [label]
    for each in sorted(within):
        inner, here = checked_labels(within[each], (label.shape[0], label.shape[1])), label == each
        kinds, numbered = np.unique(inner[here], return_inverse=True)
        if len(kinds) < 2:
            raise InputError(f"label {each} is parted into {len(kinds)} label; leave it whole")
        own = np.zeros_like(label)
        own[here] = numbered
        parts[each] = Layout(learn_labels(own, mask=here), (None,) * len(kinds))
        maps.append(own)
    layout = Layout(learn_labels(label, least=1 if alone else 2), tuple(parts))
    return layout, layout.joined(maps)


def _check_counts(label: NDArray[np.uint8], count: int) -> None:
    if count > MOST_LABELS:
        raise InputError(f"there are {count} labels in all; at most {MOST_LABELS} are drawn together")
    present = np.bincount(label.ravel(), minlength=count)
    few = np.flatnonzero(present < LEAST_PIXELS)
    if len(few):
        raise InputError(
            f"label {few[0]} has {present[few[0]]} pixels; a texture is learnt from {LEAST_PIXELS} at least"
        )


def _joined(
    level: NDArray[np.uint8],
    bands: Bands,
    label: NDArray[np.uint8],
    found: list[Target],
    spacings: tuple[int, ...],
    threads: int | None,
) -> Target:
    """Measure all types that any label has chosen, for all labels and for the transitions."""
    count, every = len(found), len(bands.names)
    chosen = [{tuple(map(int, each)) for each in one.pair_type} for one in found]
    near = {tuple(map(int, each)) for each in first_pairs(every)}
    near |= {
        (band, band, right, down)
        for band in range(every)
        for right, down in ((1, 1), (-1, 1), (2, 0), (0, 2))
    }
    kinds = sorted(
        near.union(*chosen), key=lambda each: (each[0], each[1], abs(each[2]) + abs(each[3]), each)
    )
    pair_type = np.array(kinds, np.int32)
    used = np.array([[kind in some for kind in kinds] for some in [*chosen, near]])
    band, shape = quad_pool(bands.telling, spacings)
    reach = max(int(np.abs(pair_type[:, 2:]).max()), *(3 * each for each in spacings), 1)
    exemplar = Exemplar.of(level, np.ones(label.shape, bool), reach, threads)
    plane: Plane = exemplar.plane
    group = plane.hold(label[None], 0)[0]
    single = level_shares(plane, exemplar.level, LEVELS, group=group, groups=count)
    quarter = np.stack([quarters(each) for each in single])
    pair = pair_shares(
        plane, exemplar.level, pair_type, group=group, groups=count, site=exemplar.site, threads=threads
    )
    used[-1] &= (pair[-1].sum(axis=-1) > 0) & _often(label, pair_type)
    quad = quad_shares(
        plane, exemplar.level, band, shape, quarter, group=group, site=exemplar.site, threads=threads
    )
    target = Target(
        LEVELS, False, single, pair_type, pair, band, shape, quad, quarter, used & (pair.sum(axis=-1) > 0),
        quad.sum(axis=-1) > 0,
    )  # fmt: skip
    return replace(target, pair=np.where(target.pair_used[..., None], pair, 0))


def _often(label: NDArray[np.uint8], pair_type: NDArray[np.int32]) -> NDArray[np.bool_]:
    """(k,) whether enough pairs of each type join two labels."""
    rows, columns = label.shape
    often = np.zeros(len(pair_type), bool)
    for k, (_, _, right, down) in enumerate(pair_type):
        here = label[max(0, -down) : rows - max(0, down), max(0, -right) : columns - max(0, right)]
        there = label[max(0, down) : rows + min(0, down), max(0, right) : columns + min(0, right)]
        often[k] = (here != there).sum() >= min(_LEAST_JOINTS, label.size // 200)
    return often
