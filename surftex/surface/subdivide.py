"""Finer triangles for a surface: every edge cut at its middle until none is too long, without cracks.

Edges are cut by their length alone, so both faces of an edge cut it alike: no T-junctions, and what was closed
stays closed. Short edges of long thin faces are left whole.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_TRIANGLES = {
    0: ((0, 1, 2),),
    1: ((0, 3, 2), (3, 1, 2)),
    2: ((1, 4, 0), (4, 2, 0)),
    4: ((2, 5, 1), (5, 0, 1)),
    7: ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
}
"""Children by which edges are cut (bits 0 to 2); 3 to 5 are the middles of edges 0 to 2."""

_TWO_CUT = {
    (0, 1): ((0, 3, 2), (3, 1, 4), (3, 4, 2)),
    (0, 2): ((3, 1, 2), (0, 3, 5), (5, 3, 2)),
    (1, 2): ((1, 4, 0), (4, 2, 5), (4, 5, 0)),
    (1, 0): ((4, 2, 0), (1, 4, 3), (3, 4, 0)),
    (2, 0): ((2, 5, 1), (5, 0, 3), (5, 3, 1)),
    (2, 1): ((5, 0, 1), (2, 5, 4), (4, 5, 1)),
}
"""Children where two edges are cut: the longer one first, from its middle to the corner across, then the other."""


class Subdivided(NamedTuple):
    """A surface in finer triangles, each of them a piece of one face.

    Attributes
    ----------
    parent : (k,) int32
        Face of the surface that each triangle is a piece of.
    weight : (k, 3, 3) float64
        Barycentric weights, in the parent, of each triangle's corners.
    faces : (k, 3) int32
        Turned as those of the surface.
    points : SurfacePoints
        Place of each of the n vertices.
    vertices : (n, 3) float64
        Millimetres; the first ones are those of the surface.
    """

    parent: NDArray[np.int32]
    weight: NDArray[np.float64]
    faces: NDArray[np.int32]
    points: SurfacePoints
    vertices: NDArray[np.float64]


def subdivided(surface: Surface, edge_mm: float, *, max_faces: int = 20_000_000) -> Subdivided:
    """Cut every edge that is too long.

    Parameters
    ----------
    surface : Surface
        m faces.
    edge_mm : float
        Longest edge that may stay.
    max_faces : int
        Refuse to make more.

    Returns
    -------
    fine : Subdivided
        The surface itself, where no edge is too long.

    Raises
    ------
    InputError
        If it would take more than `max_faces`.
    """
    fine = Subdivided(
        np.arange(len(surface.faces), dtype=np.int32),
        np.broadcast_to(np.eye(3), (len(surface.faces), 3, 3)),
        surface.faces,
        SurfacePoints.trusted(*_first_places(surface.faces.astype(np.int64), len(surface.vertices))),
        surface.vertices,
    )
    while True:
        ends, index, length = _edges(fine)
        if not (length > edge_mm).any():
            return fine
        fine = _halved(fine, ends, index, length, length > edge_mm)
        if len(fine.faces) > max_faces:
            raise InputError(f"edges of {edge_mm:g} mm take over {max_faces} faces; take longer ones")


def _edges(fine: Subdivided) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Vertices of each edge, the edges of each face, lengths."""
    faces = fine.faces.astype(np.int64)
    pairs = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    count = len(fine.vertices)
    keys, index = np.unique(pairs[:, 0] * count + pairs[:, 1], return_inverse=True)
    ends = np.stack([keys // count, keys % count], axis=1)
    length = np.linalg.norm(fine.vertices[ends[:, 0]] - fine.vertices[ends[:, 1]], axis=1)
    return ends, index.reshape(-1, 3), length


def _halved(
    fine: Subdivided,
    ends: NDArray[np.int64],
    index: NDArray[np.int64],
    length: NDArray[np.float64],
    long: NDArray[np.bool_],
) -> Subdivided:
    """Cut the edges that are marked, once."""
    number = np.full(len(ends), -1)
    number[long] = len(fine.vertices) + np.arange(long.sum())
    vertices = np.concatenate([fine.vertices, 0.5 * fine.vertices[ends[long]].sum(axis=1)])
    longest = length[index].argmax(axis=1)
    faces, parent, weight = _cut(
        fine.faces.astype(np.int64), fine.parent, fine.weight, number[index], longest
    )
    points = _places(faces, parent, weight, len(vertices))
    return Subdivided(parent.astype(np.int32), weight, faces.astype(np.int32), points, vertices)


def _cut(
    faces: NDArray[np.int64],
    parent: NDArray[np.integer],
    weight: NDArray[np.float64],
    middle: NDArray[np.int64],
    longest: NDArray[np.integer],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Replace each face by its children; `middle` is the new vertex of each edge, -1 where it stays."""
    corner = np.concatenate([faces, middle], axis=1)
    place = np.concatenate([weight, 0.5 * (weight + np.roll(weight, -1, axis=1))], axis=1)
    kind = (middle >= 0) @ [1, 2, 4]
    ways = [(kind == bits, triangles) for bits, triangles in _TRIANGLES.items()]
    ways += [
        ((kind == (1 << first) + (1 << second)) & (longest == first), triangles)
        for (first, second), triangles in _TWO_CUT.items()
    ]
    children, parents, weights, order = [], [], [], []
    for taken, triangles in ways:
        chosen = np.flatnonzero(taken)
        for turn, triangle in enumerate(triangles):
            children.append(corner[chosen][:, triangle])
            weights.append(place[chosen][:, triangle])
            parents.append(parent[chosen])
            order.append(4 * chosen + turn)
    row = np.argsort(np.concatenate(order), kind="stable")
    return np.concatenate(children)[row], np.concatenate(parents)[row], np.concatenate(weights)[row]


def _places(
    faces: NDArray[np.int64], parent: NDArray[np.integer], weight: NDArray[np.float64], count: int
) -> SurfacePoints:
    """Choose one place on the surface for each vertex: that of the first face that has it."""
    row, barycentric = _first_places(faces, count)
    known = np.asarray(barycentric.any(axis=1))
    corner = np.argmax(barycentric, axis=1)
    face = np.where(known, parent[row], 0).astype(np.int32)
    barycentric = np.where(known[:, None], weight[row, corner], [1.0, 0.0, 0.0])
    return SurfacePoints.trusted(face, barycentric)


def _first_places(faces: NDArray[np.int64], count: int) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """First face of each vertex and its corner there, as weights; no weights for a vertex without faces."""
    used = np.full(count, -1)
    corner = faces.ravel()[::-1]
    used[corner] = np.arange(len(corner))[::-1]
    known = np.flatnonzero(used >= 0)
    face, barycentric = np.zeros(count, np.int32), np.zeros((count, 3))
    face[known] = used[known] // 3
    barycentric[known, used[known] % 3] = 1.0
    return face, barycentric
