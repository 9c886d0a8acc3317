"""Pictures looked up between their texels, and halved; a picture is a table (height width, c) of its texels, row by row."""

import math

from surftex.kernels.jit import kernel


@kernel
def mix_texels(image, width, height, uv, value):
    """Mix the four texels around places on the page; beyond the page those at its edge.

    image (height width, c) of any type, uv (n, 2) float64: u right, v up -> value (n, c) float64.
    """
    for i in range(len(uv)):
        column, row = uv[i, 0] * width - 0.5, (1.0 - uv[i, 1]) * height - 0.5
        left, top = math.floor(column), math.floor(row)
        across, down = column - left, row - top
        left, right = min(max(int(left), 0), width - 1), min(max(int(left) + 1, 0), width - 1)
        upper = min(max(int(top), 0), height - 1) * width
        lower = min(max(int(top) + 1, 0), height - 1) * width
        a, b = (1.0 - down) * (1.0 - across), (1.0 - down) * across
        c, d = down * (1.0 - across), down * across
        for k in range(image.shape[1]):
            value[i, k] = (
                a * image[upper + left, k]
                + b * image[upper + right, k]
                + c * image[lower + left, k]
                + d * image[lower + right, k]
            )


@kernel
def halve(image, width, result):
    """Average texels two by two: image (height width, c) float with even sides -> result (a quarter of that, c)."""
    across = width // 2
    for i in range(len(result)):
        first = 2 * (i // across) * width + 2 * (i % across)
        for k in range(image.shape[1]):
            upper, lower = image[first, k] + image[first + width, k], image[first + 1, k]
            result[i, k] = ((upper + lower) + image[first + width + 1, k]) * 0.25
