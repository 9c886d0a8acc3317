"""Tangents per corner, as every shader expects them: the MikkTSpace basis, from positions, normals and UV.

Corners that share position, normal and UV, and whose faces hang together along edges with UV of one
handedness, share one tangent: the faces' tangents, projected into the plane of the normal and weighted by
corner angle [1]_. Faces whose UV have no area give no tangent; they take the one of the corners that they
share.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, read_only_view
from surftex.surface.weld import equal_rows


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
    from surftex.kernels.tangents import TINY, adopt_tangents, lay_in_planes, sum_groups, weigh_tangents

    weld = equal_rows(np.concatenate([position, normal, uv], axis=2).reshape(-1, 8).astype(np.float32))
    other = _opposite(weld.reshape(-1, 3))
    doubled, weighted = np.zeros(count), np.zeros((3 * count, 3))
    position, normal, uv = (read_only_view(part, np.float64) for part in (position, normal, uv))
    weigh_tangents(position, normal, uv, doubled, weighted.reshape(-1, 3, 3))
    upright = _handedness(doubled > 0, np.abs(doubled) > TINY, other)
    total, tangent = np.zeros((3 * count, 3)), np.ones((3 * count, 4))
    sum_groups(other, upright, weighted, np.zeros(3 * count, np.int64), total)
    adopt_tangents(weld, np.full(int(weld.max()) + 1, -1), total)
    lay_in_planes(total, normal.reshape(-1, 3), tangent)
    tangent = tangent.reshape(-1, 3, 4)
    tangent[~upright, :, 3] = -1
    return tangent


def _opposite(corner: NDArray[np.int64]) -> NDArray[np.int64]:
    """(3 m,) first half-edge that runs along the edge of half-edge 3 f + i from its upper point to its lower, else -1."""
    start, end = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    edge = equal_rows(np.stack([np.minimum(start, end), np.maximum(start, end)], axis=1).astype(np.int32))
    back = np.full(int(edge.max()) + 1, -1)
    falling = np.flatnonzero(start > end)[::-1]
    back[edge[falling]] = falling
    return np.where(start < end, back[edge], -1)


def _handedness(
    upright: NDArray[np.bool_], known: NDArray[np.bool_], other: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Give each face without UV area the handedness of a neighbour, ring by ring."""
    if known.all():
        return upright
    upright, known = upright.copy(), known.copy()
    edge = np.flatnonzero(other >= 0)
    face, beyond = edge // 3, other[edge] // 3
    here, there = np.concatenate([face, beyond]), np.concatenate([beyond, face])
    while True:
        step = np.flatnonzero(known[here] & ~known[there])
        if len(step) == 0:
            upright[~known] = True
            return upright
        taker, first = np.unique(there[step], return_index=True)
        upright[taker] = upright[here[step[first]]]
        known[taker] = True
