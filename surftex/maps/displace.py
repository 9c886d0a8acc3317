"""The relief as a mesh: finer triangles, moved along the smooth normal, for printing, milling and close-ups.

Edges are cut by their length alone, at their middles, again and again, so both faces of an edge cut it
alike: no cracks, no T-junctions, and what was closed stays closed. Heights are asked at places on the
surface, one place for each new vertex, so that seams of an unwrap cannot part it.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked
from surftex.errors import InputError
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.surface import Surface

HeightAt = Callable[[Samples], ArrayLike]
"""Height in mm at n samples: for a pattern, ``lambda samples: pattern.at(samples)["height_mm"]``."""

MAX_FACES = 20_000_000
"""Most faces of a displaced mesh."""

_TRIANGLES = {
    0: ((0, 1, 2),),
    1: ((0, 3, 2), (3, 1, 2)),
    2: ((1, 4, 0), (4, 2, 0)),
    4: ((2, 5, 1), (5, 0, 1)),
    7: ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
}
"""Children by which edges are cut (bits 0 to 2); 3 to 5 are the middles of edges 0 to 2."""


class DisplacedMesh(NamedTuple):
    """A mesh with its relief.

    Attributes
    ----------
    vertices : (n, 3) float64
        Millimetres, in the frame of `Surface.vertices`.
    faces : (k, 3) int32
        Turned as those of the surface.
    uv : (k, 3, 2) float64 or None
        Per corner, where an unwrap was given.
    points : SurfacePoints
        Place on the surface that each vertex was moved from.
    parent : (k,) int32
        Face of the surface that each face is a piece of.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    uv: NDArray[np.float64] | None
    points: SurfacePoints
    parent: NDArray[np.int32]


def displaced(
    surface: Surface,
    height_at: HeightAt,
    *,
    edge_mm: float,
    corner_uv: ArrayLike | None = None,
    max_faces: int = MAX_FACES,
) -> DisplacedMesh:
    """Cut a surface fine and raise it.

    Parameters
    ----------
    surface : Surface
        m faces.
    height_at : callable
        Height in mm at samples; their footprint is `edge_mm`.
    edge_mm : float
        Longest edge before the relief is added.
    corner_uv : (m, 3, 2) float, optional
        An unwrap to carry along.
    max_faces : int
        Refuse to make more.

    Returns
    -------
    mesh : DisplacedMesh
        Watertight where the surface is.

    Raises
    ------
    InputError
        If the length is none, or would take too many faces.
    """
    if not (np.isfinite(edge_mm) and edge_mm > 0):
        raise InputError(f"edge_mm is {edge_mm}; it takes a length above 0")
    expected = surface.area_mm2 / (0.25 * edge_mm**2)
    if expected > max_faces:
        raise InputError(
            f"edges of {edge_mm:g} mm take about {expected:.2g} faces; the limit is {max_faces}. "
            f"Take edges of {np.sqrt(surface.area_mm2 / (0.25 * max_faces)):.2g} mm or more"
        )
    parent, weight, faces, points, vertices = _subdivided(surface, edge_mm, max_faces)
    normal = np.einsum("pk,pki->pi", points.barycentric, surface.vertex_normal[surface.faces[points.face]])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    samples = Samples(points, np.full(len(points), edge_mm, np.float32))
    height = checked(height_at(samples), "the height", (len(points),), np.float64)
    uv = None
    if corner_uv is not None:
        unwrap = checked(corner_uv, "corner_uv", (len(surface.faces), 3, 2), np.float64)
        uv = np.einsum("fck,fki->fci", weight, unwrap[parent])
    return DisplacedMesh(vertices + normal * height[:, None], faces, uv, points, parent)


def _subdivided(
    surface: Surface, edge_mm: float, max_faces: int
) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.int32], SurfacePoints, NDArray[np.float64]]:
    """Cut every edge that is too long; parents, corner weights, faces, and the vertices with their places."""
    faces = surface.faces.astype(np.int64)
    parent = np.arange(len(faces))
    weight = np.broadcast_to(np.eye(3), (len(faces), 3, 3))
    vertices = surface.vertices
    while True:
        pairs = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        keys, index = np.unique(pairs[:, 0] * len(vertices) + pairs[:, 1], return_inverse=True)
        ends = np.stack([keys // len(vertices), keys % len(vertices)], axis=1)
        length = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)
        long = _with_longest(length, length > edge_mm, index.reshape(-1, 3))
        if not long.any():
            points = _places(faces, parent, weight, len(vertices))
            return parent.astype(np.int32), weight, faces.astype(np.int32), points, vertices
        number = np.full(len(keys), -1)
        number[long] = len(vertices) + np.arange(long.sum())
        middle = number[index.reshape(-1, 3)]
        vertices = np.concatenate([vertices, 0.5 * vertices[ends[long]].sum(axis=1)])
        faces, parent, weight = _cut(faces, parent, weight, middle)
        if len(faces) > max_faces:
            raise InputError(f"edges of {edge_mm:g} mm take over {max_faces} faces; take longer ones")


def _with_longest(
    length: NDArray[np.float64], long: NDArray[np.bool_], edges: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Spread cuts until each face that is cut is cut at its longest edge too, and none at just two others."""
    longest = edges[np.arange(len(edges)), length[edges].argmax(axis=1)]
    while True:
        cut = long[edges]
        more = long.copy()
        more[longest[cut.any(axis=1)]] = True
        cut = more[edges]
        more[edges[cut.sum(axis=1) == 2]] = True
        if (more == long).all():
            return long
        long = more


def _cut(
    faces: NDArray[np.int64],
    parent: NDArray[np.int64],
    weight: NDArray[np.float64],
    middle: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Replace each face by its children; `middle` is the new vertex of each edge, -1 where it stays."""
    corner = np.concatenate([faces, middle], axis=1)
    place = np.concatenate([weight, 0.5 * (weight + np.roll(weight, -1, axis=1))], axis=1)
    kind = (middle >= 0) @ [1, 2, 4]
    children, parents, weights, order = [], [], [], []
    for bits, triangles in _TRIANGLES.items():
        chosen = np.flatnonzero(kind == bits)
        for turn, triangle in enumerate(triangles):
            children.append(corner[chosen][:, triangle])
            weights.append(place[chosen][:, triangle])
            parents.append(parent[chosen])
            order.append(4 * chosen + turn)
    row = np.argsort(np.concatenate(order), kind="stable")
    return np.concatenate(children)[row], np.concatenate(parents)[row], np.concatenate(weights)[row]


def _places(
    faces: NDArray[np.int64], parent: NDArray[np.int64], weight: NDArray[np.float64], count: int
) -> SurfacePoints:
    """Choose one place on the surface for each vertex: that of the first face that has it."""
    used = np.full(count, -1)
    corner = faces.ravel()[::-1]
    used[corner] = np.arange(len(corner))[::-1]
    face, barycentric = np.zeros(count, np.int32), np.tile([1.0, 0.0, 0.0], (count, 1))
    known = used >= 0
    face[known] = parent[used[known] // 3]
    barycentric[known] = weight.reshape(-1, 3)[used[known]]
    return SurfacePoints.trusted(face, barycentric)
