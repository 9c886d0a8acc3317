"""A grown leather on a square that repeats: what leaves it on one side comes in on the other."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError, RecipeError
from surftex.features.cell_mesh import paired
from surftex.features.cell_outlines import Outlines
from surftex.features.cell_planes import CellPlanes, plane_cells
from surftex.features.cells_plane import LEAST_SIDE, plane_triangles
from surftex.features.growth_plane import PlaneGround
from surftex.fields.fieldset import FieldSet
from surftex.fields.noise import Noise
from surftex.kernels.pool import PartTick, Tick, slices
from surftex.materials.cells.model import Cells
from surftex.materials.cells.pattern import CHANNELS, cell_numbers, located, outline, wrinkle_left
from surftex.materials.cells.relief import layers
from surftex.materials.cells.skeleton import (
    CELL,
    chosen,
    expected_features,
    grown,
    no_wrinkles,
    particle_table,
    particles_of,
)
from surftex.materials.cells.tile_fields import tile_direction, tile_push
from surftex.materials.cells.tile_wrinkles import nearest_wrinkle, tile_wrinkles
from surftex.materials.grooves import Line
from surftex.materials.layers import Layers
from surftex.materials.limits import refuse_more
from surftex.randomness import stream
from surftex.surface.shapes import plane
from surftex.surface.surface import Surface

_GROWTH = 0.8
_SLICE = 1 << 15
_AROUND = 1.02


@dataclass(frozen=True, eq=False)
class CellsTile:
    """Grown leather on a square tile; make one with `Cells.tile`.

    Attributes
    ----------
    cells : Cells
        What it is like.
    side_mm : float
        Of the square.
    features : mapping of str to structured array
        ``particle``, to go on from, ``cell`` and ``wrinkle``.
    centre_mm : (c, 2) float64
        Of the cells.
    warnings : tuple of str
        What its reader should know.
    """

    cells: Cells
    side_mm: float
    features: Mapping[str, NDArray]
    centre_mm: NDArray[np.float64]
    planes: CellPlanes
    outlines: Outlines
    seed: int
    warnings: tuple[str, ...] = ()

    channels = CHANNELS

    def at(self, place_mm: NDArray[np.floating], footprint_mm: float = 0.0) -> Layers:
        """Evaluate at places.

        Parameters
        ----------
        place_mm : (n, 2) float64
            Anywhere; the tile repeats.
        footprint_mm : float
            Side of the patch that each value stands for.

        Returns
        -------
        layers : Layers
            As `CellsPattern.at`.
        """
        from scipy.spatial import KDTree

        place = np.asarray(place_mm, np.float64) % self.side_mm
        count = len(place)

        def noise(name: str, size_mm: float, octaves: int = 1) -> NDArray[np.float32]:
            return self._noise(Noise(stream(self.seed, "cells", name), size_mm, octaves), place, footprint_mm)

        tree = KDTree(place, boxsize=self.side_mm)
        start, cell, vector = self._near(place, tree)
        wrinkles: tuple[Line, ...] = ()
        table = self.features["wrinkle"]
        if len(table):
            apart, along, length = nearest_wrinkle(
                table, self.side_mm, place, tree, 1.5 * self.cells.wrinkle_width
            )
            at = np.flatnonzero(np.isfinite(apart))
            share, none = wrinkle_left(self.cells, along[at], length[at]), np.zeros(len(at), np.float32)
            wrinkles = (Line(at, apart[at].astype(np.float32), share, none, none > 0, none, none),)
        found = located(
            self.cells, self.planes, self.outlines, start, cell, vector, noise, count,
            cell_numbers(self.seed, len(self.planes)), np.zeros(count, bool),
        )  # fmt: skip
        return layers(self.cells, found(wrinkles), np.full(count, footprint_mm, np.float32))

    def page(
        self, resolution: int, *, threads: int | None = None, tick: Tick | None = None
    ) -> dict[str, NDArray]:
        """Evaluate a page of the whole tile.

        Parameters
        ----------
        resolution : int
            Texels along a side; row 0 is at the top.
        threads : int, optional
            None means every core; cannot change a byte.
        tick : callable, optional
            Told the finished share.

        Returns
        -------
        channels : dict of str to (h, w) or (h, w, 3) array
            As in `surftex.materials.layers.CHANNELS`.

        Raises
        ------
        InputError
            If the resolution is not positive.
        """
        if resolution < 1:
            raise InputError(f"resolution is {resolution}; it takes at least 1 texel")
        step = self.side_mm / resolution
        line = (np.arange(resolution) + 0.5) * step

        def work(first: int, last: int) -> Layers:
            texel = np.arange(first, last)
            place = np.stack([line[texel % resolution], line[::-1][texel // resolution]], axis=1)
            return self.at(place, step)

        parts = slices(work, resolution**2, size=_SLICE, threads=threads, tick=tick)
        whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0].channels}
        return {name: each.reshape(resolution, resolution, *each.shape[1:]) for name, each in whole.items()}

    def _near(
        self, place: NDArray[np.float64], tree: Any
    ) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float64]]:
        """Cells that may hold each place: rows, whose they are, and the place in their planes."""
        reach = _AROUND * self.planes.radius + self.cells.waviness * self.planes.scale
        rows = tree.query_ball_point(self.centre_mm, np.minimum(reach, 0.49 * self.side_mm))
        count = np.fromiter((len(row) for row in rows), np.int64, len(rows))
        sample = (
            np.concatenate([np.asarray(row, np.int64) for row in rows])
            if len(rows)
            else np.zeros(0, np.int64)
        )
        cell = np.repeat(np.arange(len(rows), dtype=np.int32), count)
        order = np.lexsort((cell, sample))
        sample, cell = sample[order], cell[order]
        vector = place[sample] - self.centre_mm[cell]
        vector -= self.side_mm * np.round(vector / self.side_mm)
        return np.searchsorted(sample, np.arange(len(place) + 1)).astype(np.int64), cell, vector

    def _noise(self, noise: Noise, place: NDArray[np.float64], footprint_mm: float) -> NDArray[np.float32]:
        """Blend four copies of a noise, so that it repeats; its variance stays what it is."""
        total, square = np.zeros(len(place)), np.zeros(len(place))
        share = place / self.side_mm
        for x in (0, 1):
            for y in (0, 1):
                weight = np.abs(1 - x - share[:, 0]) * np.abs(1 - y - share[:, 1])
                where = np.zeros((len(place), 3))
                where[:, :2] = place - self.side_mm * np.array([x, y])
                total += weight * noise.at(where, footprint_mm)
                square += weight**2
        return (total / np.sqrt(square)).astype(np.float32)


def sheet_of(side_mm: float) -> Surface:
    """Make the square on which the fields of a tile are asked, and under which it is shown.

    Parameters
    ----------
    side_mm : float
        Of the tile.

    Returns
    -------
    sheet : Surface
        In the xy plane, its lower left corner at the origin, with an unwrap that fills the page.
    """
    if not (np.isfinite(side_mm) and side_mm > 0):
        raise RecipeError(f"a tile of {side_mm:g} mm has no place for cells")
    return plane(side_mm, cells=16)


def make_tile(
    cells: Cells,
    side_mm: float,
    seed: int,
    *,
    fields: FieldSet | None = None,
    features: Mapping[str, NDArray] | None = None,
    max_features: int = 5_000_000,
    threads: int | None = None,
    tick: Tick | None = None,
) -> CellsTile:
    """Grow cells on a square that repeats.

    Parameters
    ----------
    cells : Cells
        What grows.
    side_mm : float
        Of the square.
    seed : int
        Of everything random.
    fields : FieldSet, optional
        Named numbers and directions, on `sheet_of` the tile.
    features : mapping of str to structured array, optional
        Of an earlier tile; with nothing but particles the growth goes on from them.
    max_features : int
        Refuse to give birth to more particles.
    threads : int, optional
        None means every core; cannot change the result.
    tick : callable, optional
        Told the finished share, and the count of particles.

    Returns
    -------
    tile : CellsTile
        Answers at any place.

    Raises
    ------
    RecipeError
        If the square is too small for its cells, a parameter needs a surface, or there is no such field.
    """
    for key in ("cell_size", "cell_ratio"):
        if isinstance(getattr(cells, key), str):
            raise RecipeError(f"cells.{key}: an expression needs a surface; a tile takes a number")
    size, aspect = float(cells.cell_size), float(cells.cell_ratio)
    if not side_mm >= LEAST_SIDE * size * max(aspect, 1.0):
        least = LEAST_SIDE * size * max(aspect, 1.0)
        raise RecipeError(
            f"a tile of {side_mm:g} mm is too small for cells of {size:g} mm; it takes {least:g} mm"
        )
    if cells.wrinkle_potential > 0:
        raise RecipeError(
            "cells.wrinkle_potential: wrinkles that drive the growth need a mesh; a tile takes 0, or a potential of its own"
        )
    if cells.wrinkle_curves is not None:
        raise RecipeError("cells.wrinkle_curves: drawn curves need a mesh; a tile takes wrinkle_count")
    sheet = sheet_of(side_mm) if fields is None else fields.surface
    names = FieldSet(sheet) if fields is None else fields
    refuse_more("cells", expected_features(cells, sheet, seed, names), sheet.area_mm2, max_features)
    direction, stress = (
        None if name is None else tile_direction(sheet, names.direction(name))
        for name in (cells.direction, cells.stress)
    )
    push, warnings = tile_push(cells, names, side_mm)
    ground = PlaneGround(side_mm, size, aspect, direction, push)
    made = dict(features or {})
    start = particles_of(made["particle"]) if "particle" in made else None
    if start is not None and not (start.place < side_mm).all():
        raise RecipeError(
            "cells: the saved particles lie outside the tile; did they grow on another, or on a mesh?"
        )
    particles = grown(
        cells,
        ground,
        seed,
        start=start,
        most=max_features,
        threads=threads,
        tick=PartTick(tick, 0.0, _GROWTH),
    )
    made["particle"] = particle_table(particles, ground.points(particles))
    top = chosen(cells, ground, particles, threads)
    try:
        triangles = plane_triangles(top.place, side_mm, top.aspect, top.angle)
    except InputError as problem:
        raise RecipeError(f"cells.cell_size: {problem}") from None
    regions = paired(triangles, share=cells.quads, most_rad=np.radians(cells.squareness))
    planes, centre = plane_cells(regions, top.place, side_mm, size)
    table = np.zeros(len(planes), CELL)
    table["barycentric"][:, 0] = 1
    table["corner_mm"], table["bend_mm"] = planes.corner, planes.bend
    table["sides"], table["scale_mm"] = planes.sides, planes.scale
    table["corner"] = regions
    made["cell"] = table
    made["wrinkle"] = tile_wrinkles(cells, side_mm, seed, top.place, regions, stress)
    if tick is not None:
        tick(1.0)
    outlines: Any = outline(cells, planes, seed, threads)
    warnings += no_wrinkles(cells, side_mm**2, made)
    return CellsTile(cells, side_mm, MappingProxyType(made), centre, planes, outlines, seed, warnings)
