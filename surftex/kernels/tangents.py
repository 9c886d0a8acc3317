"""Tangents at the corners of faces, and normals that are told along them."""

import math

import numpy as np

from surftex.kernels.jit import kernel, part

TINY = float(np.finfo(np.float32).tiny)
"""Shorter vectors have no direction, smaller areas no tangent."""

_LEAST = np.finfo(np.float64).tiny


@kernel
def weigh_tangents(position, normal, uv, doubled, weighted):
    """Tangents of faces in the planes of their corners' normals, times the angles of the corners seen there.

    position, normal (m, 3, 3), uv (m, 3, 2) -> doubled (m,): twice the area on the page, with its sign; weighted (m, 3, 3):
    zero where it has none.
    """
    for f in range(len(position)):
        u, v = uv[f, 1, 0] - uv[f, 0, 0], uv[f, 1, 1] - uv[f, 0, 1]
        far_u, far_v = uv[f, 2, 0] - uv[f, 0, 0], uv[f, 2, 1] - uv[f, 0, 1]
        doubled[f] = u * far_v - v * far_u
        if not abs(doubled[f]) > TINY:
            continue
        side, far = _between(position, f, 0, 1), _between(position, f, 0, 2)
        tx, ty, tz = side[0] * far_v - far[0] * v, side[1] * far_v - far[1] * v, side[2] * far_v - far[2] * v
        tx, ty, tz = _unit(tx, ty, tz)
        sign = 1.0 if doubled[f] > 0.0 else -1.0
        tx, ty, tz = tx * sign, ty * sign, tz * sign
        for i in range(3):
            nx, ny, nz = normal[f, i, 0], normal[f, i, 1], normal[f, i, 2]
            x, y, z = _between(position, f, i, (i + 1) % 3)
            x, y, z = _laid(x, y, z, nx, ny, nz)
            p, q, r = _between(position, f, i, (i + 2) % 3)
            p, q, r = _laid(p, q, r, nx, ny, nz)
            angle = math.acos(min(max(x * p + y * q + z * r, -1.0), 1.0))
            x, y, z = _laid(tx, ty, tz, nx, ny, nz)
            weighted[f, i, 0], weighted[f, i, 1], weighted[f, i, 2] = x * angle, y * angle, z * angle


@kernel
def sum_groups(other, upright, weighted, leader, total):
    """Add up what the corners of each group have: those that meet across edges between faces of one handedness.

    other (3 m,) int64: half-edge 3 f + i that runs back along each, or -1; upright (m,) bool, weighted (3 m, 3), leader
    (3 m,) int64 -> total (3 m, 3) of zeros: the sum of each corner's group, in the order of its corners.
    """
    for c in range(len(leader)):
        leader[c] = c
    for h in range(len(other)):
        back = other[h]
        if back >= 0 and upright[h // 3] == upright[back // 3]:
            _join(leader, h, _next(back))
            _join(leader, _next(h), back)
    for c in range(len(leader)):
        leader[c] = leader[leader[c]]
        for k in range(3):
            total[leader[c], k] += weighted[c, k]
    for c in range(len(leader)):
        for k in range(3):
            total[c, k] = total[leader[c], k]


@kernel
def adopt_tangents(weld, giver, total):
    """Give corners without a tangent that of the first equal corner that has one, and zero where none has, in place.

    weld (n,) int64 number of each corner's equals, giver (k,) int64 of -1 for each number, total (n, 3).
    """
    for c in range(len(weld) - 1, -1, -1):
        if _has(total, c):
            giver[weld[c]] = c
    for c in range(len(weld)):
        if not _has(total, c):
            for k in range(3):
                total[c, k] = total[giver[weld[c]], k] if giver[weld[c]] >= 0 else 0.0


@kernel
def lay_in_planes(total, normal, tangent):
    """Lay vectors into the planes of normals: total, normal (n, 3) -> tangent (n, 4): unit vectors, beside what it had.

    Where a vector has no direction in the plane, the axis has that lies closest to it.
    """
    for c in range(len(total)):
        nx, ny, nz = normal[c, 0], normal[c, 1], normal[c, 2]
        x, y, z = _laid(total[c, 0], total[c, 1], total[c, 2], nx, ny, nz)
        if x == 0.0 and y == 0.0 and z == 0.0:
            least = min(abs(nx), abs(ny), abs(nz))
            x, y, z = 0.0, 0.0, 0.0
            if abs(nx) == least:
                x = 1.0
            elif abs(ny) == least:
                y = 1.0
            else:
                z = 1.0
            x, y, z = _laid(x, y, z, nx, ny, nz)
        tangent[c, 0], tangent[c, 1], tangent[c, 2] = x, y, z


@part
def _between(position, f, i, j):
    """Way from a corner of a face to another."""
    return (
        position[f, j, 0] - position[f, i, 0],
        position[f, j, 1] - position[f, i, 1],
        position[f, j, 2] - position[f, i, 2],
    )


@part
def _unit(x, y, z):
    """Scale to unit length; zero where there is no length."""
    length = math.sqrt(x * x + y * y + z * z)
    return (x / length, y / length, z / length) if length > TINY else (0.0, 0.0, 0.0)


@part
def _laid(x, y, z, nx, ny, nz):
    """Lay a vector into the plane of a normal, at unit length."""
    rise = x * nx + y * ny + z * nz
    return _unit(x - nx * rise, y - ny * rise, z - nz * rise)


@part
def _next(corner):
    """Step to the corner after 3 f + i in its face."""
    return corner - corner % 3 + (corner + 1) % 3


@part
def _join(leader, one, other):
    """Make one group of two; the lowest of a group leads it."""
    while leader[one] != one:
        leader[one] = leader[leader[one]]
        one = leader[one]
    while leader[other] != other:
        leader[other] = leader[leader[other]]
        other = leader[other]
    leader[max(one, other)] = min(one, other)


@part
def _has(total, c):
    return max(abs(total[c, 0]), abs(total[c, 1]), abs(total[c, 2])) > TINY


@kernel
def decode_normals(face, barycentric, encoded, shading, tangent, normal):
    """Turn normals told along tangent, bitangent and normal of their places into directions in space.

    face (n,) int32, barycentric (n, 3), encoded (n, 3); of corners shading (m, 3, 3) and tangent (m, 3, 4), float64 ->
    normal (n, 3) float64. Frames are not normalised before use, as in a shader.
    """
    for i in range(len(face)):
        f, p, q, r = face[i], barycentric[i, 0], barycentric[i, 1], barycentric[i, 2]
        nx, ny, nz = _at(shading, f, 0, p, q, r), _at(shading, f, 1, p, q, r), _at(shading, f, 2, p, q, r)
        tx, ty, tz = _at(tangent, f, 0, p, q, r), _at(tangent, f, 1, p, q, r), _at(tangent, f, 2, p, q, r)
        sign, s, t, u = tangent[f, 0, 3], encoded[i, 0], encoded[i, 1], encoded[i, 2]
        x = s * tx + t * (sign * (ny * tz - nz * ty)) + u * nx
        y = s * ty + t * (sign * (nz * tx - nx * tz)) + u * ny
        z = s * tz + t * (sign * (nx * ty - ny * tx)) + u * nz
        length = max(np.sqrt(x * x + y * y + z * z), _LEAST)
        normal[i, 0], normal[i, 1], normal[i, 2] = x / length, y / length, z / length


@part
def _at(corner, f, k, p, q, r):
    """Component k of what three corners have, weighed."""
    return p * corner[f, 0, k] + q * corner[f, 1, k] + r * corner[f, 2, k]
