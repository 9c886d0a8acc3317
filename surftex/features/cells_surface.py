"""Triangles between particles of a surface: the dual of their exact Voronoi graph, with a rim at borders.

At a border, the regions of two neighbours part at a point of it. Those points become corners too: `a`, the point and `b`,
and `b` with the two points that end its own piece of the border. So cells reach the border everywhere.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.features.cell_mesh import Triangles, twins_of
from surftex.features.cells_plane import stretch
from surftex.features.near_logs import near_logs
from surftex.features.poisson import Sites
from surftex.features.voronoi_graph import VoronoiGraph
from surftex.geodesics.pieces import barycentric_of
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_SPACING = 1.1
"""Radius of the first search, in diameters."""


@dataclass(frozen=True, eq=False)
class CellCorners:
    """Triangles, and where their corners are.

    Attributes
    ----------
    triangles : Triangles
        Corners 0 to n - 1 are the particles, the rest points of the rim.
    points : SurfacePoints
        All corners.
    outward : (p,) float64
        The direction that leaves the surface, in the frame of the face, where `free`.
    free : (p,) bool
        Whether a corner is on a border.
    dual : int
        Triangles that join three particles.
    """

    triangles: Triangles
    points: SurfacePoints
    outward: NDArray[np.float64]
    free: NDArray[np.bool_]
    dual: int


def surface_triangles(
    surface: Surface,
    particles: SurfacePoints,
    scale: NDArray[np.float64],
    aspect: NDArray[np.float64],
    angle: NDArray[np.float64],
    *,
    threads: int | None = None,
) -> CellCorners:
    """Join particles whose regions touch.

    Parameters
    ----------
    surface : Surface
        Where they lie.
    particles : SurfacePoints
        n particles.
    scale : (n,) float64
        Diameter of the largest thereabouts.
    aspect : (n,) float64
        Length over width.
    angle : (n,) float64
        Of the long axes, in the frames of the faces.
    threads : int, optional
        None means every core; cannot change the result.

    Returns
    -------
    corners : CellCorners
        Where particles are dense enough, 2 n - 4 triangles on a closed surface without handles.
    """
    count = len(particles)
    sites = Sites(particles, np.stack([_SPACING * scale, 0.5 * scale], axis=1), angle)
    graph = VoronoiGraph.of(surface, sites, threads=threads)
    corner, border = _dual(graph)
    dual = len(corner)
    rim = _rim(surface, graph)
    face = np.concatenate([particles.face, rim.face])
    weights = np.concatenate([particles.barycentric, rim.barycentric])
    points = SurfacePoints.trusted(frozen(face), frozen(weights))
    corner, border = (
        np.concatenate([corner, rim.triangles(count)]),
        np.concatenate([border, rim.borders(len(graph.edge_vertex))]),
    )
    outward, free = _outward(surface, points, 0.25 * scale, rim)
    kept = (corner != np.roll(corner, 1, axis=1)).all(axis=1)
    kept &= ~(
        free[corner].all(axis=1) & (corner >= count).any(axis=1)
    )  # where particles have reached the border
    dual = int(kept[:dual].sum())
    corner, border = corner[kept], border[kept]
    # a side and its twin run between the same two corners, across the same border of the graph
    limit = len(points) + 1
    onward = np.roll(corner, -1, axis=1)
    twin = twins_of((border * limit + corner) * limit + onward, (border * limit + onward) * limit + corner)
    length = _lengths(surface, points, corner, aspect, angle, count, threads)
    triangles = Triangles(frozen(corner), frozen(twin), frozen(length))
    if (aspect != 1).any():
        triangles = triangles.flipped()
    return CellCorners(triangles, points, frozen(outward), frozen(free), dual)


def _dual(graph: VoronoiGraph) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Triangles around the vertices of the graph, and the border of the graph that each side crosses."""
    edge, side = np.nonzero(graph.edge_vertex >= 0)
    if len(edge) == 0:
        return np.zeros((0, 3), np.int64), np.zeros((0, 3), np.int64)
    vertex = graph.edge_vertex[edge, side].astype(np.int64)
    bounds = graph.edge_bounds[edge]
    row = np.where(side == 0, bounds[:, 0], bounds[:, 1] - 1)
    away = np.where(side == 0, 1.0, -1.0)[:, None] * (graph.pieces.end[row] - graph.pieces.start[row])
    order = np.lexsort((np.arctan2(away[:, 1], away[:, 0]), vertex))
    vertex, edge, side = vertex[order], edge[order], side[order]
    left = np.where(side == 0, graph.edge_region[edge, 0], graph.edge_region[edge, 1]).astype(np.int64)
    first = np.flatnonzero(np.diff(vertex, prepend=-1))
    size = np.diff(np.append(first, len(vertex)))
    corners, borders = [], []
    extra = len(graph.edge_vertex)
    for degree in np.unique(size):
        if degree < 3:
            continue
        rows = first[size == degree][:, None] + np.arange(degree)
        region, crossed = left[rows], edge[rows]
        # the border between region k and region k + 1 is the one that leaves before region k + 1
        diagonal = np.full(len(rows), -1, np.int64)
        for k in range(1, degree - 1):
            last = crossed[:, 0] if k == degree - 2 else extra + np.arange(len(rows))
            before = crossed[:, 1] if k == 1 else diagonal
            corners.append(np.stack([region[:, 0], region[:, k], region[:, k + 1]], axis=1))
            borders.append(np.stack([before, crossed[:, k + 1], last], axis=1))
            if k < degree - 2:
                diagonal = last
                extra += len(rows)
    return np.concatenate(corners), np.concatenate(borders)


@dataclass(frozen=True, eq=False)
class _Rim:
    """Points of the surface's borders at which regions part, in walking order."""

    face: NDArray[np.int32]
    side: NDArray[np.int64]
    barycentric: NDArray[np.float64]
    border: NDArray[np.int64]
    before: NDArray[np.int64]
    after: NDArray[np.int64]
    onward: NDArray[np.int64]

    def triangles(self, count: int) -> NDArray[np.int64]:
        """Two for each point; the point itself has the number count + its row."""
        own = count + np.arange(len(self.face))
        gate = np.stack([self.before, own, self.after], axis=1)
        strip = np.stack([self.after, own, count + self.onward], axis=1)
        return np.concatenate([gate, strip])

    def borders(self, graph_borders: int) -> NDArray[np.int64]:
        """Border that each side of those crosses; spokes of the rim have numbers beyond those of the graph."""
        # far beyond the diagonals of meetings of more than three
        spoke = 8 * graph_borders + 64 + 2 * np.arange(len(self.face))
        gate = np.stack([spoke, spoke + 1, self.border], axis=1)
        outside = 8 * graph_borders + 64 + 2 * len(self.face) + np.arange(len(self.face))
        strip = np.stack([spoke + 1, outside, spoke[self.onward]], axis=1)
        return np.concatenate([gate, strip])


def _rim(surface: Surface, graph: VoronoiGraph) -> _Rim:
    """Find the ends of the graph's borders on those of the surface, each with the next along its loop."""
    end, side = np.nonzero(graph.edge_vertex < 0)
    bounds = graph.edge_bounds[end]
    row = np.where(side == 0, bounds[:, 0], bounds[:, 1] - 1)
    face = graph.pieces.face[row] if len(row) else np.zeros(0, np.int32)
    place = (
        np.where((side == 0)[:, None], graph.pieces.start[row], graph.pieces.end[row])
        if len(row)
        else np.zeros((0, 2))
    )
    weights = barycentric_of(surface, face, place)
    # the weight of the corner that faces a border side is its height over it
    open_side = surface.neighbor[face] < 0
    height = np.where(open_side, np.roll(weights, -2, axis=1), np.inf)
    edge = np.argmin(height, axis=1) if len(row) else np.zeros(0, np.int64)
    on_border = np.isfinite(height).any(axis=1) & (height.min(axis=1, initial=np.inf) < 1e-6)
    end, side, face, edge, weights = (
        end[on_border], side[on_border], face[on_border], edge[on_border], weights[on_border]
    )  # fmt: skip
    left = np.where(side == 1, graph.edge_region[end, 0], graph.edge_region[end, 1]).astype(np.int64)
    right = np.where(side == 1, graph.edge_region[end, 1], graph.edge_region[end, 0]).astype(np.int64)
    loop, place_in_loop = _loops(surface)
    along = weights[np.arange(len(face)), (edge + 1) % 3]
    order = np.lexsort((along, place_in_loop[face, edge], loop[face, edge]))
    number = loop[face, edge][order]
    first = np.flatnonzero(np.diff(number, prepend=-1))
    onward = np.arange(1, len(order) + 1)
    if len(order):
        onward[np.append(first[1:], len(order)) - 1] = first
    return _Rim(
        np.ascontiguousarray(face[order]), edge[order], weights[order], end[order].astype(np.int64), right[order],
        left[order], onward,
    )  # fmt: skip


def _loops(surface: Surface) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Loop of each border side, and its place in the loop's walk; -1 inside."""
    face, edge = np.nonzero(surface.neighbor < 0)
    loop, place = np.full(surface.neighbor.shape, -1, np.int64), np.full(surface.neighbor.shape, -1, np.int64)
    start, stop = surface.faces[face, edge], surface.faces[face, (edge + 1) % 3]
    leaving = {int(vertex): row for row, vertex in enumerate(start)}
    seen = np.zeros(len(face), bool)
    number = 0
    for begin in range(len(face)):
        row, step = begin, 0
        while not seen[row]:
            seen[row] = True
            loop[face[row], edge[row]], place[face[row], edge[row]] = number, step
            row, step = leaving[int(stop[row])], step + 1
        number += step > 0
    return loop, place


def _lengths(
    surface: Surface, points: SurfacePoints, corner: NDArray, aspect: NDArray, angle: NDArray, count: int,
    threads: int | None,
) -> NDArray[np.float64]:  # fmt: skip
    """Lengths of the sides, in the metric of the particles at their ends."""
    onward = np.roll(corner, -1, axis=1)
    low, high = np.minimum(corner, onward).ravel(), np.maximum(corner, onward).ravel()
    pair, index = np.unique(low * len(points) + high, return_inverse=True)
    first, second = pair // max(len(points), 1), pair % max(len(points), 1)
    away, length = near_logs(surface, points, points, first, second, threads=threads)
    if (aspect != 1).any() and len(pair):
        back = near_logs(surface, points, points, second, first, threads=threads)[0]
        square = np.zeros(len(pair))
        for who, step in ((first, away), (second, back)):
            own = np.minimum(who, count - 1)
            heading = np.arctan2(step[:, 1], step[:, 0])
            square += np.where(who < count, stretch(aspect[own], heading - angle[own]), 0)
        length = length * np.sqrt(square / np.maximum((first < count) + (second < count).astype(int), 1))
    return length[index].reshape(corner.shape)


def _outward(
    surface: Surface, points: SurfacePoints, near: NDArray[np.float64], rim: _Rim
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Direction that leaves the surface, at the points of the rim and at particles nearer to a border than `near`."""
    face = points.face
    open_side = surface.neighbor[face] < 0
    height = (
        2
        * surface.face_area_mm2[face, None]
        * np.roll(points.barycentric, -2, axis=1)
        / surface.edge_length[face]
    )
    height = np.where(open_side, height, np.inf)
    edge = np.argmin(height, axis=1)
    free = height[np.arange(len(face)), edge] < np.concatenate([near, np.full(len(rim.face), np.inf)])
    edge[len(near) :] = rim.side
    step = surface.flat[face, (edge + 1) % 3] - surface.flat[face, edge]
    return np.arctan2(-step[:, 0], step[:, 1]), free
