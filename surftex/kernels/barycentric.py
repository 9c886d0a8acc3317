"""Values of corners at points inside their faces."""

from surftex.kernels.jit import kernel


@kernel
def interpolate(face, barycentric, index, value, result):
    """Weigh the values of each point's corners.

    face (n,) int32; barycentric (n, 3) float64; index (m, 3) int32 rows of `value` for the corners of each face;
    value (v, d) float64 -> result (n, d) float64.
    """
    for point in range(len(face)):
        a, b, c = index[face[point], 0], index[face[point], 1], index[face[point], 2]
        for k in range(value.shape[1]):
            result[point, k] = (
                barycentric[point, 0] * value[a, k]
                + barycentric[point, 1] * value[b, k]
                + barycentric[point, 2] * value[c, k]
            )
