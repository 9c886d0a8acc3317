"""Tangents at the corners of faces, and normals that are told along them."""

import numpy as np

from surftex.kernels.jit import kernel, part

_TINY = np.finfo(np.float64).tiny


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
        length = max(np.sqrt(x * x + y * y + z * z), _TINY)
        normal[i, 0], normal[i, 1], normal[i, 2] = x / length, y / length, z / length


@part
def _at(corner, f, k, p, q, r):
    """Component k of what three corners have, weighed."""
    return p * corner[f, 0, k] + q * corner[f, 1, k] + r * corner[f, 2, k]
