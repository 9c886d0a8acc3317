"""Tangents per corner, as every shader expects them: the MikkTSpace basis, from positions, normals and UV.

Corners that share position, normal and UV, and whose faces hang together along edges with UV of one
handedness, share one tangent: the faces' tangents, projected into the plane of the normal and weighted by
corner angle [1]_. Faces whose UV have no area give no tangent; they take the one of the corners that they
share.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from surftex.arrays import checked, equal_rows

_TINY = float(np.finfo(np.float32).tiny)


def corner_tangents(
    corner_position: ArrayLike, corner_normal: ArrayLike, corner_uv: ArrayLike
) -> NDArray[np.float64]:
    """MikkTSpace tangent of every corner of every face.

    Parameters
    ----------
    corner_position : (m, 3, 3) float
        Any unit; corners weld where they are equal in float32, as a reader of the exported file sees them.
    corner_normal : (m, 3, 3) float
        Unit shading normals.
    corner_uv : (m, 3, 2) float
        u right, v up.

    Returns
    -------
    tangent : (m, 3, 4) float64
        Unit vector at right angles to the normal, along rising u, and the sign w of the bitangent
        ``w cross(normal, tangent)``: +1 where the UV run counter-clockwise, -1 where they are mirrored.

    References
    ----------
    .. [1] Mikkelsen. Simulation of Wrinkled Surfaces Revisited. Master's thesis, Copenhagen (2008).

    Examples
    --------
    >>> square = [[[0, 0, 0], [1, 0, 0], [1, 1, 0]]]
    >>> corner_tangents(square, [[[0, 0, 1]] * 3], [[[0, 0], [1, 0], [1, 1]]])[0, 0].tolist()
    [1.0, 0.0, 0.0, 1.0]
    """
    position = checked(corner_position, "corner_position", (None, 3, 3), np.float64)
    count = len(position)
    normal = checked(corner_normal, "corner_normal", (count, 3, 3), np.float64)
    uv = checked(corner_uv, "corner_uv", (count, 3, 2), np.float64)
    if count == 0:
        return np.zeros((0, 3, 4))
    face_tangent, doubled_area = _face_tangents(position, uv)
    known = np.abs(doubled_area) > _TINY
    weld = equal_rows(np.concatenate([position, normal, uv], axis=2).reshape(-1, 8).astype(np.float32))
    edge, other = _edge_pairs(weld.reshape(-1, 3))
    upright = _handedness(doubled_area > 0, known, edge // 3, other // 3)
    group = _groups(edge, other, upright, count)
    weighted = _projected(face_tangent[:, None], normal) * _corner_angles(position, normal)[..., None]
    weighted[~known] = 0
    total = _sum_by(group, weighted.reshape(-1, 3))[group]
    total = _adopt(total, weld).reshape(count, 3, 3)
    tangent = np.concatenate([_unit_in_plane(total, normal), np.ones((count, 3, 1))], axis=2)
    tangent[~upright, :, 3] = -1
    return tangent


def _face_tangents(
    position: NDArray[np.float64], uv: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Direction of rising u of each face, and twice its signed UV area."""
    side, far = position[:, 1] - position[:, 0], position[:, 2] - position[:, 0]
    side_uv, far_uv = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    doubled_area = side_uv[:, 0] * far_uv[:, 1] - side_uv[:, 1] * far_uv[:, 0]
    tangent = side * far_uv[:, 1:] - far * side_uv[:, 1:]
    return _unit(tangent) * np.where(doubled_area > 0, 1.0, -1.0)[:, None], doubled_area


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """Scale to unit length; zero where there is no length."""
    length = np.sqrt(np.einsum("...i,...i->...", vector, vector))[..., None]
    return np.divide(vector, length, out=np.zeros_like(vector), where=length > _TINY)


def _projected(vector: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lay vectors into the plane of the normal, at unit length."""
    return _unit(vector - normal * np.einsum("...i,...i->...", vector, normal)[..., None])


def _corner_angles(position: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m, 3) angle of each corner, measured in the plane of its normal."""
    onward = _projected(np.roll(position, -1, axis=1) - position, normal)
    back = _projected(np.roll(position, 1, axis=1) - position, normal)
    return np.arccos(np.clip(np.einsum("fci,fci->fc", onward, back), -1, 1))


def _edge_pairs(corner: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Half-edges 3 f + i that run along one edge in opposite senses, two and two."""
    start, end = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    size = int(corner.max()) + 1
    forward, backward = start * size + end, end * size + start
    order = np.argsort(forward, kind="stable")
    ordered = forward[order]
    found = np.minimum(np.searchsorted(ordered, backward), len(order) - 1)
    edge = np.flatnonzero((ordered[found] == backward) & (start < end))
    return edge, order[found[edge]]


def _handedness(
    upright: NDArray[np.bool_], known: NDArray[np.bool_], face: NDArray[np.int64], other: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Give each face without UV area the handedness of a neighbour, ring by ring."""
    upright, known = upright.copy(), known.copy()
    here, there = np.concatenate([face, other]), np.concatenate([other, face])
    while True:
        step = np.flatnonzero(known[here] & ~known[there])
        if len(step) == 0:
            upright[~known] = True
            return upright
        taker, first = np.unique(there[step], return_index=True)
        upright[taker] = upright[here[step[first]]]
        known[taker] = True


def _groups(
    edge: NDArray[np.int64], other: NDArray[np.int64], upright: NDArray[np.bool_], count: int
) -> NDArray[np.int64]:
    """(3 m,) number of the group of each corner: joined across edges between faces of one handedness."""
    same = upright[edge // 3] == upright[other // 3]
    edge, other = edge[same], other[same]
    here = np.concatenate([edge, _next_corner(edge)])
    there = np.concatenate([_next_corner(other), other])
    graph = coo_array((np.ones(len(here), np.int8), (here, there)), shape=(3 * count, 3 * count))
    return connected_components(graph, directed=False)[1].astype(np.int64)


def _next_corner(corner: NDArray[np.int64]) -> NDArray[np.int64]:
    """Step to the corner after 3 f + i in its face."""
    return corner - corner % 3 + (corner + 1) % 3


def _sum_by(group: NDArray[np.int64], vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sum of the vectors of each group, in the order of the rows."""
    return np.stack([np.bincount(group, vector[:, k]) for k in range(3)], axis=1).astype(np.float64)


def _adopt(total: NDArray[np.float64], weld: NDArray[np.int64]) -> NDArray[np.float64]:
    """Corners without a tangent take the one of the first equal corner that has one."""
    bare = ~(np.abs(total).max(axis=1) > _TINY)
    if not bare.any():
        return total
    giver = np.full(int(weld.max()) + 1, -1)
    holders = np.flatnonzero(~bare)[::-1]
    giver[weld[holders]] = holders
    source = giver[weld[bare]]
    result = total.copy()
    result[bare] = np.where(source[:, None] >= 0, total[source], 0)
    return result


def _unit_in_plane(total: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lay sums into the plane of the normal; any direction in it where the sum has none."""
    tangent = _projected(total, normal)
    bare = np.flatnonzero(np.abs(tangent.reshape(-1, 3)).max(axis=1) == 0)
    if len(bare):
        upward = normal.reshape(-1, 3)[bare]
        axis = np.zeros_like(upward)
        axis[np.arange(len(bare)), np.abs(upward).argmin(axis=1)] = 1
        tangent.reshape(-1, 3)[bare] = _projected(axis, upward)
    return tangent
