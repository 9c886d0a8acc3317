"""Cells in planes of their own: the log map at the middle of their corners."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.features.cells_surface import CellCorners
from surftex.features.near_logs import near_logs
from surftex.geodesics.tracing import trace
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_BEYOND = 0.5
"""How far corners on a border are moved out over it, in diameters: there the border cuts the cells."""


@dataclass(frozen=True, eq=False)
class CellPlanes:
    """c cells in their planes.

    Attributes
    ----------
    corner : (c, 4, 2) float64
        Counter-clockwise; the last repeats the third in triangles.
    bend : (c, 4, 2) float64
        Where the middle of the side after each corner lies: off the straight line where the surface is no plane.
    sides : (c,) int64
        3 or 4.
    frame : (c, 2, 3) float64
        The plane's axes in space.
    scale : (c,) float64
        Diameter of the largest particles thereabouts.
    """

    corner: NDArray[np.float64]
    bend: NDArray[np.float64]
    sides: NDArray[np.int64]
    frame: NDArray[np.float64]
    scale: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.sides)

    @property
    def radius(self) -> NDArray[np.float64]:
        """(c,) from the centre to the farthest corner or bend."""
        outline = np.concatenate([self.corner, self.bend], axis=1)
        return np.hypot(outline[..., 0], outline[..., 1]).max(axis=1, initial=0)


def straight_bends(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    """Middles of straight sides.

    Parameters
    ----------
    corner : (c, 4, 2) float64
        As `CellPlanes.corner`.

    Returns
    -------
    bend : (c, 4, 2) float64
        As `CellPlanes.bend`.
    """
    return 0.5 * (corner + np.roll(corner, -1, axis=1))


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
    corner = offset - middle[:, None]
    planes = CellPlanes(
        frozen(corner),
        frozen(straight_bends(corner)),
        sides,
        frozen(frame),
        frozen(np.full(len(cells), scale)),
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
    origin = points.taken(index[:, 0])
    offset = _logs(surface, origin, points, index, threads)
    middle = _mean(offset, sides)
    centre = trace(
        surface,
        origin,
        np.arctan2(middle[:, 1], middle[:, 0]),
        np.hypot(middle[:, 0], middle[:, 1]),
        threads=threads,
    ).end
    corner = _logs(surface, centre, points, index, threads)
    between, side = _middles(surface, points, index, threads)
    bend = _logs(surface, centre, between, side, threads)
    size = np.append(scale, np.full(len(points) - len(scale), np.median(scale) if len(scale) else 1.0))[index]
    beyond = _beyond(surface, centre, corners, index, corner, threads) * (_BEYOND * size)[..., None]
    corner, bend = corner + beyond, bend + 0.5 * (beyond + np.roll(beyond, -1, axis=1))
    own = np.where(index < len(scale), size, 0).max(axis=1, initial=0)
    frame = surface.frame[centre.face][:, :2]
    return CellPlanes(frozen(corner), frozen(bend), sides, frozen(frame), frozen(own)), centre


def _sides(cells: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Count the sides, and repeat the last corner in triangles."""
    triangle = cells[:, 3] < 0
    index = cells.copy()
    index[triangle, 3] = cells[triangle, 2]
    return frozen(np.where(triangle, 3, 4)), index


def _mean(offset: NDArray[np.float64], sides: NDArray[np.int64]) -> NDArray[np.float64]:
    total = offset[:, :3].sum(axis=1) + np.where((sides == 4)[:, None], offset[:, 3], 0)
    return total / sides[:, None]


def _logs(
    surface: Surface,
    origin: SurfacePoints,
    points: SurfacePoints,
    index: NDArray[np.int64],
    threads: int | None,
) -> NDArray[np.float64]:
    """Points (c, 4, 2) in the log map at each origin."""
    cell = np.repeat(np.arange(len(index)), 4)
    return near_logs(surface, origin, points, cell, index.ravel(), threads=threads)[0].reshape(-1, 4, 2)


def _middles(
    surface: Surface, points: SurfacePoints, index: NDArray[np.int64], threads: int | None
) -> tuple[SurfacePoints, NDArray[np.int64]]:
    """Middles of all sides, each once, and (c, 4) which of them lies after each corner."""
    onward = np.roll(index, -1, axis=1)
    low, high = np.minimum(index, onward).ravel(), np.maximum(index, onward).ravel()
    pair, side = np.unique(low * len(points) + high, return_inverse=True)
    first = pair // len(points)
    away, length = near_logs(surface, points, points, first, pair % len(points), threads=threads)
    heading = np.arctan2(away[:, 1], away[:, 0])
    half = np.where(np.isfinite(length), 0.5 * length, 0)
    return trace(surface, points.taken(first), heading, half, threads=threads).end, side.reshape(-1, 4)


def _beyond(
    surface: Surface, centre: SurfacePoints, corners: CellCorners, index: NDArray[np.int64],
    corner: NDArray[np.float64], threads: int | None,
) -> NDArray[np.float64]:  # fmt: skip
    """Directions (c, 4, 2) that leave the surface at corners on its border, in the log map at each centre; 0 at others."""
    result = np.zeros(corner.shape)
    cell, which = np.nonzero(corners.free[index])
    if len(cell):
        own = index[cell, which]
        back = near_logs(surface, corners.points, centre, own, cell, threads=threads)[0]
        leaving = np.arctan2(corner[cell, which, 1], corner[cell, which, 0])
        arriving = np.arctan2(-back[:, 1], -back[:, 0])
        outward = leaving - arriving + corners.outward[own]
        result[cell, which] = np.stack([np.cos(outward), np.sin(outward)], axis=1)
    return result
