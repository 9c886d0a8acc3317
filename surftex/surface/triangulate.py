"""Polygons cut into triangles that cover them: quads at the better diagonal, concave ones by their ears."""

import numpy as np
from numpy.typing import NDArray

from surftex.errors import SurfaceError

MOST_CONCAVE_CORNERS = 2048
"""Concave polygons with more corners are refused; ear clipping takes the square of their number."""


def triangulate(
    vertices: NDArray[np.float64], corner: NDArray[np.int64], start: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cut polygons into triangles.

    Parameters
    ----------
    vertices : (n, 3) float64
        Positions.
    corner : (c,) int64
        Vertices of the polygons, one after another.
    start : (p+1,) int64
        Where each polygon begins; each has at least three corners.

    Returns
    -------
    triangles : (t, 3) int64
        Indices into `corner`, wound as their polygons, in the order of the polygons.
    polygon : (t,) int64
        Which polygon each comes from.

    Raises
    ------
    SurfaceError
        If a concave polygon has more than `MOST_CONCAVE_CORNERS`.
    """
    sizes = np.diff(start)
    if (sizes == 3).all():
        return start[:-1, None] + np.arange(3), np.arange(len(sizes))
    first = np.concatenate([[0], np.cumsum(sizes - 2)])
    triangles = np.zeros((first[-1], 3), np.int64)
    simple = sizes == 3
    triangles[first[:-1][simple]] = start[:-1][simple, None] + np.arange(3)
    quads = np.flatnonzero(sizes == 4)
    if len(quads):
        cut = _quads(vertices[corner[start[quads, None] + np.arange(4)]])
        triangles[first[quads, None] + np.arange(2)] = start[quads, None, None] + cut
    many = np.flatnonzero(sizes > 4)
    fans = np.zeros(len(sizes), bool)
    for size in np.unique(sizes[many]).tolist():
        alike = many[sizes[many] == size]
        fan = _sees_all(vertices, corner, start[alike], size)
        fans[alike[fan]] = True
        steps = np.arange(size - 2)
        table = np.column_stack([0 * steps, steps + 1, steps + 2])
        triangles[first[alike[fan], None] + steps] = start[alike[fan], None, None] + table
    for polygon in many[~fans[many]].tolist():
        places = vertices[corner[start[polygon] : start[polygon + 1]]]
        triangles[first[polygon] : first[polygon + 1]] = start[polygon] + _many(places, polygon)
    return triangles, np.repeat(np.arange(len(sizes)), sizes - 2)


def _quads(places: NDArray[np.float64]) -> NDArray[np.int64]:
    """(q, 2, 3) corners: along the diagonal whose worse triangle is better; the first diagonal in a tie."""
    diagonal = np.cross(places[:, 2] - places[:, 0], places[:, 3] - places[:, 1])

    def worse(a: tuple[int, int, int], b: tuple[int, int, int]) -> NDArray[np.float64]:
        signed = [
            np.einsum(
                "qi,qi->q", np.cross(places[:, j] - places[:, i], places[:, k] - places[:, i]), diagonal
            )
            for i, j, k in (a, b)
        ]
        return np.minimum(*signed)

    size = np.einsum("qi,qi->q", diagonal, diagonal)
    other = worse((1, 2, 3), (1, 3, 0)) > worse((0, 1, 2), (0, 2, 3)) + 1e-6 * size
    cuts = np.array([[[0, 1, 2], [0, 2, 3]], [[1, 2, 3], [1, 3, 0]]])
    return cuts[other.astype(int)]


def _sees_all(
    vertices: NDArray[np.float64], corner: NDArray[np.int64], start: NDArray[np.int64], size: int
) -> NDArray[np.bool_]:
    """Whether the first corner of each polygon sees all of it, so that a fan covers it."""
    result = np.zeros(len(start), bool)
    batch = max(1, 1_000_000 // size)
    for low in range(0, len(start), batch):
        begin = start[low : low + batch]
        places = vertices[corner[begin[:, None] + np.arange(size)]]
        spokes = places[:, 1:] - places[:, :1]
        cross = np.cross(spokes[:, :-1], spokes[:, 1:])
        normal = cross.sum(axis=1, keepdims=True)
        along = (cross * normal).sum(axis=2) / np.maximum(
            np.linalg.norm(normal, axis=2), np.finfo(float).tiny
        )
        extent = np.abs(spokes).max(axis=(1, 2))
        result[low : low + batch] = (along > 1e-12 * extent[:, None] ** 2).all(axis=1)
    return result


def _many(places: NDArray[np.float64], polygon: int) -> NDArray[np.int64]:
    """(k-2, 3) corners of one polygon with k of them."""
    count = len(places)
    fan = np.column_stack([np.zeros(count - 2, np.int64), np.arange(1, count - 1), np.arange(2, count)])
    centred = places - places[0]
    normal = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
    length = np.linalg.norm(normal)
    extent = float(np.abs(centred).max())
    if not length > 1e-14 * extent**2:
        return fan
    x_axis = np.cross(np.eye(3)[np.argmin(np.abs(normal))], normal)
    x_axis /= np.linalg.norm(x_axis)
    flat = np.column_stack([centred @ x_axis, centred @ np.cross(normal / length, x_axis)]) / extent
    if count > MOST_CONCAVE_CORNERS:
        raise SurfaceError(
            f"polygon {polygon} is concave and has {count} corners, more than the {MOST_CONCAVE_CORNERS} "
            "that are triangulated; cut it up in the modelling program"
        )
    return _ears(flat)


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _ears(flat: NDArray[np.float64]) -> NDArray[np.int64]:
    """Cut off ears of a counter-clockwise polygon, the best first; corners that coincide block no ear."""
    left = np.arange(len(flat))
    triangles = []
    while len(left) > 3:
        place = flat[left]
        before, after = np.roll(place, 1, axis=0), np.roll(place, -1, axis=0)
        turn = _cross(place - before, after - place)
        reflex = place[turn < 0]
        longest = np.maximum(
            ((after - before) ** 2).sum(1),
            np.maximum(((place - before) ** 2).sum(1), ((after - place) ** 2).sum(1)),
        )
        quality = np.where(longest > 0, turn / np.maximum(longest, 1e-300), 0)
        chosen = int(np.argmin(np.abs(turn)))
        for ear in np.argsort(-quality, kind="stable").tolist():
            if turn[ear] <= 0:
                break
            a, b, c = before[ear], place[ear], after[ear]
            inside = (
                (_cross(b - a, reflex - a) >= 0)
                & (_cross(c - b, reflex - b) >= 0)
                & (_cross(a - c, reflex - c) >= 0)
            )
            at_corner = (reflex == a).all(1) | (reflex == b).all(1) | (reflex == c).all(1)
            if not (inside & ~at_corner).any():
                chosen = ear
                break
        triangles.append([left[chosen - 1], left[chosen], left[(chosen + 1) % len(left)]])
        left = np.delete(left, chosen)
    triangles.append(left.tolist())
    return np.array(triangles, np.int64)
