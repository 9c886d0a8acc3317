"""The cells of a leather at samples: whose plate, how far out, how far from the furrow."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.features.poisson import Sites
from surftex.geodesics.bounds import nearest_bound
from surftex.geodesics.records import Records
from surftex.geodesics.windows import Buckets, flood_points, nearest, where, within
from surftex.kernels.pool import Tick
from surftex.materials.leather.model import Leather
from surftex.randomness import Stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

NEIGHBOURS = {"round": 5, "ellipse": 6, "box": 8}
"""Nearest sites that decide a plate, by shape: five are exact for Poisson-disk sites up to 5:3; where another length
than the way walked parts the cells, the nearest by one are not all among the nearest by the other."""

_UNEVEN = 0.4
"""Variation of size beyond which as many are asked for as for boxes: a large cell has many small neighbours."""

REACH = 2.6
"""Radius of the search, in spacings: no point of a full surface has fewer than six sites nearer."""

_BOX_EXPONENT = 5.0

_WAVED = 1.5
"""Sizes in medians beyond which borders waver no farther: the noise has one wavelength, and would bite into large cells."""


@dataclass(frozen=True, eq=False)
class Plates:
    """Where n samples lie among the cells.

    Attributes
    ----------
    own : (n,) int32
        Cell of each sample; -1 where there is none.
    ratio : (n,) float32
        0 at the cell's site, 1 on its border.
    border_mm : (n,) float32
        To the border, its corners rounded; inf where a cell is alone.
    own_mm : (n,) float32
        To the site.
    furrow : (n,) float32
        Random number of the furrow nearby, 0 to 1.
    along : (n,) float32
        Where a sample lies in its cell along the cell's direction, -1 to 1; zeros unless asked for.
    """

    own: NDArray[np.int32]
    ratio: NDArray[np.float32]
    border_mm: NDArray[np.float32]
    own_mm: NDArray[np.float32]
    furrow: NDArray[np.float32]
    along: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Cells:
    """The cells of one surface, ready to be asked; make them with `Cells.build`."""

    records: Records
    size_mm: NDArray[np.float64]
    stretch: NDArray[np.float64]
    angle_rad: NDArray[np.float64]
    start: NDArray[np.int64]
    other: NDArray[np.int32]
    apart_mm: NDArray[np.float64]
    place_mm: NDArray[np.float64]
    inscribed_mm: NDArray[np.float64]
    shift: NDArray[np.float64]
    shape: str
    neighbours: int
    key: int

    @cached_property
    def median_mm(self) -> float:
        """Size of the middle one of the cells; 1 where there are none."""
        return float(np.median(self.size_mm)) if len(self.size_mm) else 1.0

    @staticmethod
    def build(
        leather: Leather,
        surface: Surface,
        table: NDArray,
        random: Stream,
        records: Records | None = None,
        threads: int | None = None,
        tick: Tick | None = None,
    ) -> "Cells":
        """Flood from every site, and measure how far neighbours are apart.

        Parameters
        ----------
        leather : Leather
            What the cells are like.
        surface : Surface
            Where they lie.
        table : (c,) structured array
            `face`, `barycentric`, `major_mm`, `minor_mm`, `angle_rad` of each site.
        random : Stream
            Of the cells.
        records : Records, optional
            From `flood_cells`, if that is done already.
        threads : int, optional
            None means every core.
        tick : callable, optional
            Told the finished share.

        Returns
        -------
        cells : Cells
            Read-only.
        """
        major, minor = table["major_mm"].astype(np.float64), table["minor_mm"].astype(np.float64)
        if records is None:
            records = flood_cells(leather, surface, table, threads, tick)
        sites = records.sources
        stretch = major / minor
        angle = table["angle_rad"].astype(np.float64)
        start, other, apart, vector = within(
            records, sites, vectors=leather.cell_shape != "round", threads=threads
        )
        if leather.cell_shape != "round":
            apart = _length(leather.cell_shape, vector, other, stretch, angle)
        start, other, apart = _both_ways(start, other, apart)
        index = np.repeat(np.arange(len(sites)), np.diff(start))
        inscribed = np.full(len(sites), np.inf)
        np.minimum.at(inscribed, index, apart / 2)
        theta = 2 * np.pi * random.uniform(len(sites))[:, 0]
        waved = np.minimum(major, _WAVED * np.median(major)) if len(major) else major
        return Cells(
            records, frozen(major), frozen(stretch), frozen(angle), frozen(start), frozen(other), frozen(apart),
            frozen(sites.positions(surface)),
            frozen(np.where(np.isfinite(inscribed), inscribed, major)),
            frozen(np.stack([np.cos(theta), np.sin(theta)], axis=1) * (major * waved)[:, None]),
            leather.cell_shape, neighbours_of(leather), random.key,
        )  # fmt: skip

    def at(
        self, leather: Leather, points: SurfacePoints, wave: tuple[NDArray[np.float32], NDArray[np.float32]]
    ) -> Plates:
        """Locate samples.

        Parameters
        ----------
        leather : Leather
            What the cells are like.
        points : SurfacePoints
            n samples.
        wave : two (n,) float32
            Noise that makes borders waver, as shares of a cell's squared size.

        Returns
        -------
        plates : Plates
            Of the n samples.
        """
        from surftex.kernels.gather import LANE, RANK
        from surftex.kernels.plates import BLOCK, MOST, PAIRS, ROWS, nearest_plates, plates

        n, most = len(points), self.neighbours
        own, ratio, border = np.zeros(n, np.int32), np.zeros(n, np.float32), np.zeros(n, np.float32)
        own_mm, furrow = np.zeros(n, np.float32), np.zeros(n, np.float32)
        size = self.median_mm
        located = (
            self.start, self.other, self.apart_mm, self.place_mm, self.shift, *wave,
            int(leather.crista_shape == "polygon"),
            leather.rounding * size, np.uint64(self.key), 0.15 * size * (leather.sulcus_variation > 0),
            np.zeros(ROWS * BLOCK), np.zeros(MOST * BLOCK, np.int64), np.full(PAIRS, -1), np.zeros(PAIRS),
            own, ratio, border, own_mm, furrow,
        )  # fmt: skip
        if self.shape == "round" and leather.scale_overlap == 0:
            points.check_on(self.records.surface)
            records = self.records
            shape = BLOCK, most
            scratch = (
                np.zeros(LANE), np.zeros(RANK, np.int64),
                np.zeros(shape, np.int32), np.zeros(shape), np.zeros(shape, np.int32),
            )  # fmt: skip
            nearest_plates(
                *where(records, points), records.row, records.row_id, records.source_of, records.limit_mm,
                *scratch, *located,
            )  # fmt: skip
            site, vectors = np.zeros((0, most), np.int32), np.zeros((0, most, 2))
        else:
            site, distance, vectors = nearest(self.records, points, most, vectors=True, threads=1)
            if self.shape != "round":
                index = np.maximum(site, 0)
                length = _length(
                    self.shape, vectors.reshape(-1, 2), index.ravel(), self.stretch, self.angle_rad
                )
                distance = np.where(site >= 0, length.reshape(site.shape), np.inf)
            plates(site, distance, *located)
        if leather.crista_shape == "inscribed":
            ratio = np.minimum(own_mm / self.inscribed_mm[np.maximum(own, 0)], 1).astype(np.float32)
        along = np.zeros(n, np.float32)
        if leather.scale_overlap > 0:
            slot = np.argmax(site == own[:, None], axis=1)
            vector, cell = vectors[np.arange(n), slot], np.maximum(own, 0)
            turned = vector[:, 0] * np.cos(self.angle_rad[cell]) + vector[:, 1] * np.sin(self.angle_rad[cell])
            along = np.clip(turned / (0.6 * self.size_mm[cell]), -1, 1).astype(np.float32)
        return Plates(own, ratio, border, own_mm, furrow, along)


def neighbours_of(leather: Leather) -> int:
    """Count the nearest sites that decide a plate.

    Parameters
    ----------
    leather : Leather
        What the cells are like.

    Returns
    -------
    count : int
        Sites to ask for.
    """
    return NEIGHBOURS["box" if leather.size_variation > _UNEVEN else leather.cell_shape]


def flood_cells(
    leather: Leather,
    surface: Surface,
    table: NDArray,
    threads: int | None = None,
    tick: Tick | None = None,
) -> Records:
    """Flood from every cell's site, as far as the nearest few of any place.

    Parameters
    ----------
    leather : Leather
        What the cells are like.
    surface : Surface
        Where the cells lie.
    table : (c,) structured array
        `face`, `barycentric`, `major_mm`, `minor_mm` of each site.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    records : Records
        For the nearest sites, as many as `neighbours_of` tells.
    """
    sites = SurfacePoints.trusted(
        np.ascontiguousarray(table["face"]), np.ascontiguousarray(table["barycentric"])
    )
    minor = table["minor_mm"]
    return flood_points(
        surface,
        sites,
        REACH * table["major_mm"].astype(np.float64),
        buckets=Buckets.of(surface, float(np.median(minor)) if len(minor) else 1.0),
        bound_mm=nearest_bound(surface, sites, neighbours_of(leather)),
        threads=threads,
        tick=tick,
    )


def _length(
    shape: str, vector: NDArray, site: NDArray, stretch: NDArray[np.float64], angle: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Length of tangent vectors at sites, in the ellipse or box of each site."""
    cosine, sine = np.cos(angle[site]), np.sin(angle[site])
    x = np.abs(vector[:, 0] * cosine + vector[:, 1] * sine)
    y = np.abs(vector[:, 1] * cosine - vector[:, 0] * sine) * stretch[site]
    if shape == "ellipse":
        return np.hypot(x, y)
    most = np.maximum(np.maximum(x, y), np.finfo(float).tiny)
    return most * (1 + (np.minimum(x, y) / most) ** _BOX_EXPONENT) ** (1 / _BOX_EXPONENT)


def shape_length(shape: str, sites: Sites) -> Callable[[NDArray, NDArray, NDArray], NDArray[np.float64]]:
    """Measure tangent vectors in the ellipse or box of their sites.

    Parameters
    ----------
    shape : str
        ``"ellipse"`` or ``"box"``.
    sites : Sites
        c sites.

    Returns
    -------
    length : callable
        ``length(vector (n, 2), site (n,), angle_rad (c,)) -> (n,)`` mm along the major axis.
    """
    stretch = sites.axis_mm[:, 0] / sites.axis_mm[:, 1]
    return lambda vector, site, angle: _length(shape, vector, site, stretch, angle)


def _both_ways(
    start: NDArray[np.int64], other: NDArray[np.int32], apart: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float64]]:
    """Rows of neighbours for each site, ascending, the mean of both directions, without the site itself."""
    from surftex.kernels.pairs import both_ways, sort_rows

    sort_rows(start, other, apart)
    place = np.zeros(len(start), np.int64)
    none, nothing = np.zeros(0, np.int32), np.zeros(0)
    both_ways(start, other, apart, 0, place, none, nothing)
    place = np.cumsum(place)
    begin = place.copy()
    second, length = np.zeros(int(place[-1]), np.int32), np.zeros(int(place[-1]))
    both_ways(start, other, apart, 1, place, second, length)
    sort_rows(begin, second, length)
    return begin, second, length
