"""Outlines of cells, each in a plane of its own: the log map at the middle of its corners."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.features.cells_surface import CellCorners, path_angles
from surftex.geodesics.paths import shortest_path
from surftex.geodesics.tracing import trace
from surftex.kernels.pool import slices
from surftex.randomness import Stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

MOST_BLOBS = 96
"""On one cell."""

_EDGES = 24
_SLICE = 4096
_BEYOND = 0.5
"""How far corners on a border are moved out over it, in diameters: there the border cuts the cells."""


@dataclass(frozen=True, eq=False)
class CellPlanes:
    """c cells in their planes.

    Attributes
    ----------
    corner : (c, 4, 2) float64
        Counter-clockwise; the last repeats the third in triangles.
    sides : (c,) int64
        3 or 4.
    frame : (c, 2, 3) float64
        The plane's axes in space.
    scale : (c,) float64
        Diameter of the largest particles thereabouts.
    """

    corner: NDArray[np.float64]
    sides: NDArray[np.int64]
    frame: NDArray[np.float64]
    scale: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.sides)

    @property
    def radius(self) -> NDArray[np.float64]:
        """(c,) from the centre to the farthest corner."""
        return np.hypot(self.corner[..., 0], self.corner[..., 1]).max(axis=1, initial=0)


@dataclass(frozen=True, eq=False)
class Outlines:
    """Rounded outlines of c cells, as kernels read them; see `surftex.kernels.cell_outlines`.

    Attributes
    ----------
    edge : (c, 24, 2) float64
        Sides, so that the gauge of a place is the largest product.
    edges : (c,) int64
        How many; 0 where a cell was too narrow for its groove.
    middle : (c, 2) float64
        Centre of gravity.
    area : (c,) float64
        Inside the outline.
    blob_start : (c + 1,) int64
        Blobs of cell i are those from blob_start[i] on.
    blob : (b, 3) float64
        Place from the middle, and radius.
    """

    edge: NDArray[np.float64]
    edges: NDArray[np.int64]
    middle: NDArray[np.float64]
    area: NDArray[np.float64]
    blob_start: NDArray[np.int64]
    blob: NDArray[np.float64]

    @property
    def breadth(self) -> NDArray[np.float64]:
        """(c,) from the middle to the nearest side; 0 where there is no outline."""
        steepest = np.hypot(self.edge[..., 0], self.edge[..., 1]).max(axis=1, initial=0)
        return np.where(self.edges > 0, 1 / np.maximum(steepest, 1e-300), 0)


def plane_cells(
    cells: NDArray[np.int64], place: NDArray[np.float64], side: float, scale: float
) -> tuple[CellPlanes, NDArray[np.float64]]:
    """Put the cells of a tile in their planes.

    Parameters
    ----------
    cells : (c, 4) int64
        From `surftex.features.cell_mesh.paired`.
    place : (n, 2) float64
        Of the particles.
    side : float
        Of the tile.
    scale : float
        Diameter of the largest particles.

    Returns
    -------
    planes : CellPlanes
        Of the cells.
    centre : (c, 2) float64
        Origins of the planes, in the tile.
    """
    sides, index = _sides(cells)
    origin = place[index[:, 0]]
    offset = place[index] - origin[:, None]
    offset -= side * np.round(offset / side)
    middle = _mean(offset, sides)
    frame = np.broadcast_to(np.eye(3)[:2], (len(cells), 2, 3)).copy()
    planes = CellPlanes(
        frozen(offset - middle[:, None]), sides, frozen(frame), frozen(np.full(len(cells), scale))
    )
    return planes, (origin + middle) % side


def surface_cells(
    surface: Surface,
    cells: NDArray[np.int64],
    corners: CellCorners,
    scale: NDArray[np.float64],
    *,
    threads: int | None = None,
) -> tuple[CellPlanes, SurfacePoints]:
    """Put the cells of a surface in their planes, by shortest paths from their middles to their corners.

    Parameters
    ----------
    surface : Surface
        Where they lie.
    cells : (c, 4) int64
        From `surftex.features.cell_mesh.paired`.
    corners : CellCorners
        Where the corners are.
    scale : (n,) float64
        Diameter of the largest particles, at each.
    threads : int, optional
        None means every core; cannot change the result.

    Returns
    -------
    planes : CellPlanes
        Of the cells.
    centre : SurfacePoints
        Origins of the planes; their axes are those of the face.
    """
    sides, index = _sides(cells)
    points = corners.points
    origin = SurfacePoints.trusted(
        np.ascontiguousarray(points.face[index[:, 0]]), np.ascontiguousarray(points.barycentric[index[:, 0]])
    )
    offset = _log(surface, origin, points, index, threads)[0]
    middle = _mean(offset, sides)
    centre = trace(
        surface,
        origin,
        np.arctan2(middle[:, 1], middle[:, 0]),
        np.hypot(middle[:, 0], middle[:, 1]),
        threads=threads,
    ).end
    corner, turn = _log(surface, centre, points, index, threads)
    free = corners.free[index]
    size = np.append(scale, np.full(len(points) - len(scale), np.median(scale) if len(scale) else 1.0))[index]
    outward = turn + corners.outward[index]
    beyond = np.where(free, _BEYOND * size, 0)[..., None]
    corner = corner + beyond * np.stack([np.cos(outward), np.sin(outward)], axis=2)
    own = np.where(index < len(scale), size, 0).max(axis=1, initial=0)
    frame = surface.frame[centre.face][:, :2]
    return CellPlanes(frozen(corner), sides, frozen(frame), frozen(own)), centre


def outlined(
    planes: CellPlanes,
    *,
    gap: float,
    rounding: float,
    taper: float,
    blob_density: float,
    blob_radius: float,
    blob_variation: float,
    random: Stream,
    threads: int | None = None,
) -> Outlines:
    """Round cells, and scatter blobs on their tops.

    Parameters
    ----------
    planes : CellPlanes
        c cells.
    gap : float
        Width of the groove's floor, in diameters.
    rounding : float
        Share of a side, from each end, that a rounded corner takes.
    taper : float
        Where the top ends: rho = 1 - taper.
    blob_density : float
        Per square of the diameter, on tops.
    blob_radius : float
        In diameters.
    blob_variation : float
        Standard deviation, as a share.
    random : Stream
        Of the blobs.
    threads : int, optional
        None means every core; cannot change the result.

    Returns
    -------
    outlines : Outlines
        Of the c cells.
    """
    from surftex.kernels.cell_outlines import outlines, scatter_blobs

    count = len(planes)
    edge, edges = np.zeros((count, _EDGES, 2)), np.zeros(count, np.int64)
    middle, area = np.zeros((count, 2)), np.zeros(count)
    width = gap * planes.scale

    def outline(begin: int, end: int) -> None:
        scratch = np.zeros((16, 2)), np.zeros((16, 2)), np.zeros((32, 2))
        outlines(
            begin, end, planes.corner, planes.sides, width, rounding, *scratch, edge, edges, middle, area
        )

    slices(outline, count, size=_SLICE, threads=threads)
    extent = np.hypot(*np.moveaxis(planes.corner - middle[:, None], 2, 0)).max(axis=1, initial=0)
    top, start = 1 - taper, np.zeros(count + 1, np.int64)
    density, radius = blob_density / planes.scale**2, blob_radius * planes.scale
    blob = np.zeros((0, 3))
    for fill in (0, 1):
        if blob_density > 0:
            slices(
                lambda begin, end, fill=fill, start=start, blob=blob: scatter_blobs(
                    begin, end, fill, edge, edges, extent, area * top**2, density, top, radius, blob_variation,
                    np.uint64(random.key), MOST_BLOBS, start, blob,
                ),
                count, size=_SLICE, threads=threads,
            )  # fmt: skip
        if fill == 0:
            start = np.cumsum(start)
            blob = np.zeros((int(start[-1]), 3))
    return Outlines(frozen(edge), frozen(edges), frozen(middle), frozen(area), frozen(start), frozen(blob))


def _sides(cells: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Count the sides, and repeat the last corner in triangles."""
    triangle = cells[:, 3] < 0
    index = cells.copy()
    index[triangle, 3] = cells[triangle, 2]
    return frozen(np.where(triangle, 3, 4)), index


def _mean(offset: NDArray[np.float64], sides: NDArray[np.int64]) -> NDArray[np.float64]:
    total = offset[:, :3].sum(axis=1) + np.where((sides == 4)[:, None], offset[:, 3], 0)
    return total / sides[:, None]


def _log(
    surface: Surface, origin: SurfacePoints, points: SurfacePoints, index: NDArray, threads: int | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners (c, 4, 2) in the log map at each origin, and by how much directions turn on the way back from each."""
    start = SurfacePoints.trusted(np.repeat(origin.face, 4), np.repeat(origin.barycentric, 4, axis=0))
    rows = index.ravel()
    end = SurfacePoints.trusted(
        np.ascontiguousarray(points.face[rows]), np.ascontiguousarray(points.barycentric[rows])
    )
    pieces, length = shortest_path(surface, start, end, threads=threads)
    leaving, arriving = path_angles(pieces, len(rows))
    length = np.where(np.isfinite(length), length, 0)
    vector = np.stack([length * np.cos(leaving), length * np.sin(leaving)], axis=1)
    return vector.reshape(-1, 4, 2), (leaving - arriving).reshape(-1, 4)
