"""From the triangles of a file to a surface to walk on: welded, wound alike, at most two faces at an edge.

Nothing is moved, but for vertices that merge. What is dropped, cut or turned is counted, a line each.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from surftex.arrays import checked
from surftex.errors import SurfaceError
from surftex.surface.glue import Glue, glue
from surftex.surface.orient import orient
from surftex.surface.weld import weld
from surftex.words import by_count

LARGEST = 1e100
"""Coordinates beyond this are refused: areas and volumes would overflow."""

_FLAT = 1e-12


@dataclass(frozen=True, eq=False)
class Repaired:
    """What `repair` returns: arrays for `Surface.from_arrays`, and what was done.

    Attributes
    ----------
    vertices : (n, 3) float64
        All of them in use.
    faces : (m, 3) int64
        Consistently wound; closed components face outward.
    corner_uv : (m, 3, 2) float64 or None
        As given, corner by corner.
    corner_normal : (m, 3, 3) float64 or None
        As given, of unit length; None where any was missing or against its face.
    part : (m,) int32
        As given.
    source_face : (m,) int64
        The given face that each comes from.
    attributes : dict of str to (m, 3) or (m, 3, k) float64
        As given, corner by corner.
    warnings : tuple of str
        What was mended.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    corner_uv: NDArray[np.float64] | None
    corner_normal: NDArray[np.float64] | None
    part: NDArray[np.int32]
    source_face: NDArray[np.int64]
    attributes: dict[str, NDArray[np.float64]]
    warnings: tuple[str, ...]


def repair(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    corner_uv: ArrayLike | None = None,
    corner_normal: ArrayLike | None = None,
    part: ArrayLike | None = None,
    attributes: Mapping[str, NDArray[np.float64]] | None = None,
    weld_tolerance: float = 1e-6,
) -> Repaired:
    """Mend triangles until they are a surface.

    Parameters
    ----------
    vertices : (n, 3) float
        Any unit; all thresholds are relative to the size of the mesh.
    faces : (m, 3) int
        Triangles of any winding.
    corner_uv : (m, 3, 2) float, optional
        Carried along.
    corner_normal : (m, 3, 3) float, optional
        Carried along; NaN or zero where missing.
    part : (m,) int, optional
        Carried along; decides which faces belong together where more than two meet at an edge.
    attributes : mapping of str to (m, 3) or (m, 3, k) float, optional
        Carried along, corner by corner.
    weld_tolerance : float
        Vertices closer than this share of the bounding box's diagonal merge.

    Returns
    -------
    repaired : Repaired
        The surface's arrays and the warnings.

    Raises
    ------
    SurfaceError
        If there is nothing with an area, an index is wrong, or numbers overflow.
    """
    places = checked(vertices, "vertices", (None, 3), np.float64, error=SurfaceError)
    file_faces = checked(faces, "faces", (None, 3), np.int64, error=SurfaceError)
    if len(file_faces) == 0:
        raise SurfaceError("the mesh has no faces; surftex textures surfaces, not points or lines")
    if file_faces.min() < 0 or file_faces.max() >= len(places):
        raise SurfaceError(
            f"faces use vertices {file_faces.min()} to {file_faces.max()}, but there are {len(places)}"
        )
    labels = np.zeros(len(file_faces), np.int32) if part is None else np.asarray(part, np.int32)
    warnings: list[str] = []

    used = np.zeros(len(places), bool)
    used[file_faces] = True
    if not used.all():
        compact = np.cumsum(used) - 1
        places, file_faces = places[used], compact[file_faces]
    size = extent(places)
    points, group = weld(places, weld_tolerance * float(np.linalg.norm(size)))
    triangles = group[file_faces]

    keep = _solid(points, triangles)
    if not keep.all():
        warnings.append(
            by_count(int((~keep).sum()), "{} degenerate face dropped", "{} degenerate faces dropped")
        )
        if not keep.any():
            raise SurfaceError("the mesh has no area: all of its faces are degenerate")
    source = np.flatnonzero(keep)
    unique = _first_copies(triangles[source])
    if len(unique) < len(source):
        warnings.append(
            by_count(len(source) - len(unique), "{} duplicate face dropped", "{} duplicate faces dropped")
        )
        source = source[unique]
    triangles, labels = triangles[source], labels[source]

    pairs = glue(points, triangles, file_faces[source], labels)
    if pairs.crowded_edges:
        warnings.append(
            by_count(
                pairs.crowded_edges,
                "{} edge with more than two faces (non-manifold) was split into sheets",
                "{} edges with more than two faces (non-manifold) were split into sheets",
            )
        )
    turned, pairs, notes = orient(points, triangles, pairs)
    warnings.extend(notes)
    triangles[turned] = triangles[turned][:, [0, 2, 1]]
    pairs = _turned(pairs, turned)
    triangles, kept, split = _vertices_of_fans(points, triangles, pairs)
    if split:
        warnings.append(
            by_count(
                split,
                "{} vertex where sheets touch only at a point (non-manifold) was split",
                "{} vertices where sheets touch only at a point (non-manifold) were split",
            )
        )

    count = len(file_faces)
    uv = None if corner_uv is None else _carried(corner_uv, "corner_uv", (count, 3, 2), source, turned)
    normal = (
        None
        if corner_normal is None
        else _carried(corner_normal, "corner_normal", (count, 3, 3), source, turned)
    )
    numbers = {
        name: _carried(value, name, (count, 3, *np.shape(value)[2:]), source, turned)
        for name, value in (attributes or {}).items()
    }
    if normal is not None:
        normal = _sound_normals(points[kept], triangles, normal, warnings)
    return Repaired(points[kept], triangles, uv, normal, labels, source, numbers, tuple(warnings))


def extent(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sides of the bounding box.

    Parameters
    ----------
    places : (n, 3) float64
        At least one point.

    Returns
    -------
    sides : (3,) float64
        Along x, y and z.

    Raises
    ------
    SurfaceError
        If they overflow, or are all zero.
    """
    if float(np.abs(places).max()) > LARGEST:
        raise SurfaceError(
            f"coordinates reach {np.abs(places).max():g}, and the bounding box overflows; scale the mesh down"
        )
    sides = places.max(axis=0) - places.min(axis=0)
    if not sides.max() > 1e-100:
        raise SurfaceError("the mesh has no area: its vertices share one place")
    return sides


def _solid(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Faces with three different corners and a height that is more than rounding."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    sides = np.stack([((b - a) ** 2).sum(1), ((c - b) ** 2).sum(1), ((a - c) ** 2).sum(1)])
    longest = sides.max(axis=0)
    doubled = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    distinct = (
        (triangles[:, 0] != triangles[:, 1])
        & (triangles[:, 1] != triangles[:, 2])
        & (triangles[:, 2] != triangles[:, 0])
    )
    return distinct & (doubled > _FLAT * longest) & (doubled > 0)


def _first_copies(triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Ascending indices of faces that no earlier face repeats, in either winding."""
    rows = np.sort(triangles, axis=1)
    order = np.lexsort([rows[:, 2], rows[:, 1], rows[:, 0]])
    same = (rows[order][1:] == rows[order][:-1]).all(axis=1)
    if not same.any():
        return np.arange(len(rows))
    return np.sort(order[np.concatenate([[True], ~same])])


def _turned(pairs: Glue, turned: NDArray[np.bool_]) -> Glue:
    """Half-edges after some faces had their last two corners swapped: edge 0 and 2 change places."""

    def moved(half_edge: NDArray[np.int64]) -> NDArray[np.int64]:
        face, i = half_edge // 3, half_edge % 3
        return np.where(turned[face], 3 * face + 2 - i, half_edge)

    return Glue(moved(pairs.first), moved(pairs.second), pairs.crowded_edges, pairs.crowded_vertex)


def _vertices_of_fans(
    points: NDArray[np.float64], triangles: NDArray[np.int64], pairs: Glue
) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """Give each fan of glued faces a vertex of its own.

    Returns the faces, the point of each new vertex, and how many vertices were split beyond the ends of
    crowded edges.
    """
    first, second = pairs.first, pairs.second
    while True:
        fan = _fans(len(triangles), first, second)
        clash = _clashes(fan, first, second)
        if len(clash) == 0:
            break
        held = np.zeros(len(triangles), bool)
        held[clash // 3] = True
        free = ~(held[first // 3] | held[second // 3])
        if free.all():
            break
        first, second = first[free], second[free]
    corner_point = triangles.ravel()
    count = int(fan.max()) + 1
    leader = np.zeros(count, np.int64)
    leader[fan[::-1]] = np.arange(len(fan))[::-1]
    order = np.lexsort([leader, corner_point[leader]])
    rank = np.zeros(count, np.int64)
    rank[order] = np.arange(count)
    point = corner_point[leader[order]]
    fans_at = np.bincount(point, minlength=len(points))
    fans_at[pairs.crowded_vertex] = 1
    return rank[fan].reshape(-1, 3), point, int((fans_at > 1).sum())


def _fans(face_count: int, first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.int64]:
    """Label of the fan that each corner belongs to."""

    def after(half_edge: NDArray[np.int64]) -> NDArray[np.int64]:
        return half_edge - half_edge % 3 + (half_edge % 3 + 1) % 3

    rows, columns = np.concatenate([first, after(first)]), np.concatenate([after(second), second])
    graph = coo_array((np.ones(len(rows), np.int8), (rows, columns)), shape=(3 * face_count,) * 2)
    return connected_components(graph, directed=False)[1].astype(np.int64)


def _clashes(
    fan: NDArray[np.int64], first: NDArray[np.int64], second: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Half-edges between the same two fans as others that they are not glued to."""
    start, end = fan, np.roll(fan.reshape(-1, 3), -1, axis=1).ravel()
    key = np.minimum(start, end) * (int(fan.max()) + 1) + np.maximum(start, end)
    mate = np.full(len(fan), -1)
    mate[first], mate[second] = second, first
    order = np.argsort(key, kind="stable")
    begin = np.flatnonzero(np.concatenate([[True], key[order][1:] != key[order][:-1]]))
    size = np.repeat(np.diff(np.append(begin, len(order))), np.diff(np.append(begin, len(order))))
    glued = mate[order] >= 0
    return order[(size > 2) | ((size == 2) & ~glued)]


def _carried(
    values: ArrayLike,
    name: str,
    shape: tuple[int, ...],
    source: NDArray[np.int64],
    turned: NDArray[np.bool_],
) -> NDArray[np.float64]:
    array = np.asarray(values, np.float64)
    if array.shape != shape:
        raise SurfaceError(f"{name} has shape {array.shape}; it takes {shape}")
    array = array[source]
    array[turned] = array[turned][:, [0, 2, 1]]
    return array


def _sound_normals(
    points: NDArray[np.float64],
    triangles: NDArray[np.int64],
    normal: NDArray[np.float64],
    warnings: list[str],
) -> NDArray[np.float64] | None:
    """Return unit normals, or None with a warning where some are missing or turn against their faces."""
    with np.errstate(over="ignore", invalid="ignore"):
        length = np.linalg.norm(normal, axis=2, keepdims=True)
    missing = ~((length > 1e-12) & (length < 1e12)).all(axis=(1, 2))
    if missing.any():
        if not missing.all():
            lack = by_count(
                int(missing.sum()), "{} face lacks shading normals", "{} faces lack shading normals"
            )
            warnings.append(f"{lack}; smooth ones are used for all")
        return None
    normal = normal / length
    a, b, c = (points[triangles[:, k]] for k in range(3))
    facing = np.cross(b - a, c - a)
    against = (np.einsum("fki,fi->fk", normal, facing) < 0).all(axis=1)
    if against.any():
        share = against.mean()
        if share > 0.01:
            warnings.append(
                by_count(
                    int(against.sum()),
                    "the shading normals of {} face point against it",
                    "the shading normals of {} faces point against them",
                )
                + "; smooth ones are used for all"
            )
            return None
        unit = facing / np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), np.finfo(float).tiny)
        normal[against] = unit[against, None]
    return normal
