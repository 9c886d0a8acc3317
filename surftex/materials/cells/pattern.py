"""A grown leather on a surface: cells answer at any sample, by walking distance from their centres."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.features.cell_outlines import Outlines, outlined
from surftex.features.cell_planes import CellPlanes, straight_bends
from surftex.features.curves import curve_pieces, drawn
from surftex.fields.noise import Noise
from surftex.fields.profiles import smoothstep
from surftex.geodesics.buckets import Buckets
from surftex.geodesics.curves import flood_curves
from surftex.geodesics.records import Records
from surftex.geodesics.windows import flood_points, within
from surftex.materials.cells.model import Cells
from surftex.materials.cells.relief import Place, layers
from surftex.materials.cells.skeleton import no_wrinkles
from surftex.materials.grooves import Line, lines_at
from surftex.materials.layers import Layers
from surftex.randomness import stream
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.surface import Surface

CHANNELS = ("height_mm", "base_color", "roughness", "specular", "region")

SHAPING = frozenset({
    "relief", "relief_variation", "dome", "shoulder", "groove", "shallows", "blob_height", "wrinkle_depth", "wrinkle_width",
    "grain_height", "color", "furrow_color", "crest_color", "dye", "wear", "mottle", "cell_tone", "roughness",
    "furrow_roughness", "crest_roughness", "specular",
})  # fmt: skip
"""Parameters that `CellsPattern.shape` reads; all others grow other cells, or change what is measured of them."""

_SWITCHES = frozenset({"shallows", "blob_height", "grain_height"})
"""Those of which zero and more than zero are two things to gather."""

KEPT = SHAPING | {
    "leanness", "gap", "rounding", "taper", "waviness", "blob_density", "blob_size", "blob_variation", "blob_threshold",
    "wrinkle_taper", "grain_size", "mottle_size",
}  # fmt: skip
"""Parameters that grow the same cells."""

_FLOODED = 1.5
"""How far wrinkles are flooded, in widths."""

WAVE = 1.2
"""Noise has an rms of 0.31, and three of it make a vector: a waviness of 0.1 moves most sides by up to a tenth of a cell."""

BROAD = 0.36
"""Breadth from which on a cell rises in full, in diameters of the largest particles."""

_AROUND = 1.02
"""Radius of the search around the centre of a cell, in distances of its farthest corner."""


@dataclass(frozen=True, eq=False)
class CellsPattern:
    """Grown leather on a surface; make one with `Cells.place`.

    Attributes
    ----------
    cells : Cells
        What it is like.
    surface : Surface
        Where it lies.
    features : mapping of str to structured array
        Everything placed, by kind: ``particle``, ``cell``, ``wrinkle``.
    """

    cells: Cells
    surface: Surface
    features: Mapping[str, NDArray]
    planes: CellPlanes
    outlines: Outlines
    records: Records | None
    wrinkles: Any
    seed: int

    channels = CHANNELS

    @staticmethod
    def build(
        cells: Cells,
        surface: Surface,
        seed: int,
        features: Mapping[str, NDArray],
        threads: int | None = None,
    ) -> "CellsPattern":
        """Flood from cells that are placed already.

        Parameters
        ----------
        cells : Cells
            What it is like.
        surface : Surface
            Where it lies.
        seed : int
            Of the noise and of what differs from cell to cell.
        features : mapping of str to structured array
            As `CellsPattern.features` has them.
        threads : int, optional
            None means every core.

        Returns
        -------
        pattern : CellsPattern
            Ready to answer.
        """
        table = features["cell"]
        centre = SurfacePoints.trusted(
            np.ascontiguousarray(table["face"]), np.ascontiguousarray(table["barycentric"])
        )
        corner = table["corner_mm"]
        bend = table["bend_mm"] if "bend_mm" in (table.dtype.names or ()) else straight_bends(corner)
        planes = CellPlanes(
            frozen(corner.copy()), frozen(np.array(bend)), frozen(table["sides"].astype(np.int64)),
            frozen(surface.frame[centre.face][:, :2]), frozen(table["scale_mm"].copy()),
        )  # fmt: skip
        records = None
        if len(table):
            radius = np.maximum(_AROUND * planes.radius + cells.waviness * planes.scale, 1e-9)
            buckets = Buckets.of(surface, float(np.median(radius)))
            records = flood_points(surface, centre, radius, buckets=buckets, threads=threads)
        wrinkles = None
        if len(features.get("wrinkle", ())):
            pieces = curve_pieces(surface, features["wrinkle"])
            width = max(cells.wrinkle_width, float(drawn(features["wrinkle"], "width_mm").max()))
            buckets = Buckets.of(surface, width)
            wrinkles = flood_curves(surface, pieces, _FLOODED * width, buckets=buckets, threads=threads)
        return CellsPattern(
            cells, surface, MappingProxyType(dict(features)), planes, outline(cells, planes, seed, threads), records,
            wrinkles, seed,
        )  # fmt: skip

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the reader of a report should know."""
        return no_wrinkles(self.cells, self.surface.area_mm2, self.features)

    def at(self, samples: Samples) -> Layers:
        """Evaluate at samples.

        Parameters
        ----------
        samples : Samples
            n points with their footprints.

        Returns
        -------
        layers : Layers
            The channels named by `channels`.
        """
        return self.shape(self.gather(samples), samples.footprint_mm)

    def gather(self, samples: Samples) -> Place:
        """Find the cell of each sample, and where in it the sample lies: what takes time, and no depth or colour changes.

        Parameters
        ----------
        samples : Samples
            n points with their footprints.

        Returns
        -------
        place : Place
            For `shape`.
        """
        points, footprint = samples.points, samples.footprint_mm
        position = points.positions(self.surface)
        count = len(points)

        def noise(name: str, size_mm: float, octaves: int = 1) -> NDArray[np.float32]:
            return Noise(stream(self.seed, "cells", name), size_mm, octaves).at(position, footprint)

        if self.records is None:
            start, cell, vector = np.zeros(count + 1, np.int64), np.zeros(0, np.int32), np.zeros((0, 2))
        else:
            start, cell, _, vector = within(self.records, points, threads=1)
        wrinkles: tuple[Line, ...] = ()
        if self.wrinkles is not None:
            wrinkles = lines_at(
                self.wrinkles, points, self.features["wrinkle"], partial(wrinkle_left, self.cells)
            )
        lone = ~self._inhabited[self.surface.component[points.face]]
        place = located(
            self.cells, self.planes, self.outlines, start, cell, vector, noise, count, self._numbers, lone
        )
        return place(wrinkles)

    def shape(self, place: Place, footprint_mm: NDArray[np.float32]) -> Layers:
        """Turn places into channels.

        Parameters
        ----------
        place : Place
            From `gather`.
        footprint_mm : (n,) float32
            Side of each sample's patch.

        Returns
        -------
        layers : Layers
            The channels named by `channels`.
        """
        return layers(self.cells, place, footprint_mm)

    def reshaped(self, cells: Cells) -> "CellsPattern | None":
        """Give the same cells other heights and colours.

        Parameters
        ----------
        cells : Cells
            What they shall be like.

        Returns
        -------
        pattern : CellsPattern or None
            Whose `shape` takes what this one gathered; None where more than that has changed, or where wrinkles
            have become wider than they were flooded.
        """
        old, new = self.cells.model_dump(), cells.model_dump()
        changed = {key for key in new if new[key] != old[key]}
        if not changed <= SHAPING:
            return None
        if any(bool(old[key]) != bool(new[key]) for key in changed & _SWITCHES):
            return None
        if bool(cells.mottle + cells.wear) != bool(self.cells.mottle + self.cells.wear):
            return None
        if cells.wrinkle_width > _FLOODED * self.cells.wrinkle_width:
            return None
        return replace(self, cells=cells)

    def keeps(self, cells: Cells) -> bool:
        """Tell whether another material would grow the same cells at the same places.

        Parameters
        ----------
        cells : Cells
            With the same seed.

        Returns
        -------
        keeps : bool
            Then `features` need not be grown anew.
        """
        return self.cells.placing() == cells.placing()

    @cached_property
    def _inhabited(self) -> NDArray[np.bool_]:
        """Whether each component of the surface has cells; one that is too small for any is a cell itself."""
        result = np.zeros(int(self.surface.component.max()) + 1, bool)
        result[self.surface.component[self.features["cell"]["face"]]] = True
        return result

    @cached_property
    def _numbers(self) -> NDArray[np.float32]:
        return cell_numbers(self.seed, len(self.planes))


def outline(cells: Cells, planes: CellPlanes, seed: int, threads: int | None) -> Outlines:
    """Round the cells of a material and dot them with metaballs.

    Parameters
    ----------
    cells : Cells
        What they are like.
    planes : CellPlanes
        c cells.
    seed : int
        Of the metaballs.
    threads : int, optional
        None means every core.

    Returns
    -------
    outlines : Outlines
        Of the c cells.
    """
    return outlined(
        planes, gap=cells.gap, rounding=cells.rounding, taper=cells.taper,
        blob_density=cells.blob_density if cells.blob_height > 0 else 0.0, blob_radius=cells.blob_size,
        blob_variation=cells.blob_variation, random=stream(seed, "cells", "blobs"), threads=threads,
    )  # fmt: skip


def cell_numbers(seed: int, count: int) -> NDArray[np.float32]:
    """Draw what differs from cell to cell.

    Parameters
    ----------
    seed : int
        Of the material.
    count : int
        Cells.

    Returns
    -------
    numbers : (count + 1, 2) float32
        Level and tone, 0 to 1; the last row is for places of no cell.
    """
    return stream(seed, "cells", "cell").uniform(count + 1, 2).astype(np.float32)


def rises(cells: Cells, planes: CellPlanes, outlines: Outlines) -> tuple[NDArray[np.float32], np.float32]:
    """Tell how far cells rise: in proportion to their breadth where they are narrow, so that none is a ridge.

    Parameters
    ----------
    cells : Cells
        What they are like.
    planes : CellPlanes
        c cells.
    outlines : Outlines
        Theirs.

    Returns
    -------
    rise : (c,) float32
        Shares of the full rise, 0 to 1.
    mean : float32
        Over the area.
    """
    full = np.minimum(outlines.breadth / (BROAD * planes.scale), 1)
    rise = (1 - cells.leanness + cells.leanness * full).astype(np.float32)
    mean = np.average(rise, weights=outlines.area) if outlines.area.sum() > 0 else 1.0
    return rise, np.float32(mean)


def wrinkle_left(cells: Cells, along: NDArray, length: NDArray) -> NDArray[np.float32]:
    """Tell how much of a wrinkle is left between its ends.

    Parameters
    ----------
    cells : Cells
        With the taper of wrinkles.
    along : (n,) float
        Length before the place.
    length : (n,) float
        In all.

    Returns
    -------
    share : (n,) float32
        0 at the ends, 1 between.
    """
    if cells.wrinkle_taper <= 0:
        return np.ones(len(along), np.float32)
    taper = np.maximum(np.minimum(cells.wrinkle_taper, length / 2), 1e-9)
    return smoothstep(0.0, 1.0, (np.minimum(along, length - along) / taper).astype(np.float32))


def located(
    cells: Cells, planes: CellPlanes, outlines: Outlines, start: NDArray, cell: NDArray, vector: NDArray, noise: Any,
    count: int, numbers: NDArray[np.float32], lone: NDArray[np.bool_],
) -> Any:  # fmt: skip
    """Find in which of its candidates each sample lies.

    Parameters
    ----------
    cells : Cells
        What they are like.
    planes : CellPlanes
        c cells.
    outlines : Outlines
        Theirs.
    start : (n + 1,) int64
        Sample i has the candidates start[i] to start[i + 1].
    cell : (e,) int32
        Which cells.
    vector : (e, 2) float64
        The sample in the plane of each.
    noise : callable
        ``noise(name, size_mm, octaves)`` at the samples.
    count : int
        n.
    numbers : (c + 1, 2) float32
        From `cell_numbers`.
    lone : (n,) bool
        Samples of components that are a cell themselves.

    Returns
    -------
    place : callable
        ``place(wrinkles)``, told the `Line` of each, gives the `Place` of the samples.
    """
    from surftex.kernels.cell_relief import cells_at

    size = float(np.median(planes.scale)) if len(planes) else 1.0
    wave = np.zeros((count, 3))
    if cells.waviness > 0:
        for axis in range(3):
            wave[:, axis] = WAVE * cells.waviness * size * noise(f"wave {axis}", 0.9 * size, 2)
    owner, rho = np.full(count, -1, np.int32), np.zeros(count, np.float32)
    border, swelling = np.zeros(count, np.float32), np.zeros(count, np.float32)
    cells_at(
        0, count, start, cell, vector, wave, planes.frame, outlines.edge, outlines.edges, outlines.middle,
        outlines.blob_start, outlines.blob, cells.blob_threshold, owner, rho, border, swelling,
    )  # fmt: skip
    rho[lone] = 0
    rise, mean = rises(cells, planes, outlines)
    scale = np.append(planes.scale, size).astype(np.float32)[owner]
    swelling /= np.float32(cells.blob_size) * scale
    own = numbers[owner]
    none = np.zeros(count, np.float32)
    drifting = cells.mottle + cells.wear > 0

    def place(wrinkles: tuple[Line, ...]) -> Place:
        return Place(
            owner, rho, border, swelling, scale, np.append(rise, mean)[owner], mean, own[:, 0], own[:, 1], wrinkles,
            noise("shallows", 2.5 * size, 2) if cells.shallows > 0 else none,
            noise("grain", cells.grain_size, 2) if cells.grain_height > 0 else none,
            noise("mottle", cells.mottle_size, 2) if drifting else none,
        )  # fmt: skip

    return place
