"""Pictures looked up between their texels, and halved; a picture is a table (height width, c) of its texels, row by row."""

import math

from surftex.kernels.jit import kernel, part


@kernel
def mix_texels(image, width, height, uv, value):
    """Mix the four texels around places on the page; beyond the page those at its edge.

    image (height width, c) of any type, uv (n, 2) float64: u right, v up -> value (n, c) float64.
    """
    for i in range(len(uv)):
        left, right, upper, lower, a, b, c, d = _around(uv[i, 0], uv[i, 1], width, height)
        upper, lower = upper * width, lower * width
        for k in range(image.shape[1]):
            value[i, k] = (
                a * image[upper + left, k]
                + b * image[upper + right, k]
                + c * image[lower + left, k]
                + d * image[lower + right, k]
            )


@kernel
def mix_mip(image, width, height, side, uv, known, mean, work, value):
    """Mix as `mix_texels` the texels of a mip, each the mean of side by side texels as `halve` makes it, bit for bit.

    image (height width, c) float, side a power of two, uv (n, 2) float64; room for the means made last, with s a power of
    two from 2 on: known (s, s) int64 of -1, of the picture's type mean (s s, c), work (side side,) -> value (n, c)
    float64.
    """
    for i in range(len(uv)):
        left, right, upper, lower, a, b, c, d = _around(uv[i, 0], uv[i, 1], width // side, height // side)
        p = _kept(image, width, side, left, upper, known, mean, work)
        q = _kept(image, width, side, right, upper, known, mean, work)
        r = _kept(image, width, side, left, lower, known, mean, work)
        s = _kept(image, width, side, right, lower, known, mean, work)
        for k in range(image.shape[1]):
            value[i, k] = a * mean[p, k] + b * mean[q, k] + c * mean[r, k] + d * mean[s, k]


@part
def _around(u, v, width, height):
    """Columns and rows of the four texels around a place, and the shares of upper left to lower right."""
    column, row = u * width - 0.5, (1.0 - v) * height - 0.5
    left, top = math.floor(column), math.floor(row)
    across, down = column - left, row - top
    first, second = min(max(int(left), 0), width - 1), min(max(int(left) + 1, 0), width - 1)
    upper, lower = min(max(int(top), 0), height - 1), min(max(int(top) + 1, 0), height - 1)
    a, b = (1.0 - down) * (1.0 - across), (1.0 - down) * across
    return first, second, upper, lower, a, b, down * (1.0 - across), down * across


@part
def _kept(image, width, side, column, row, known, mean, work):
    """Place among the means of a texel of the mip."""
    i, j, first = row & (len(known) - 1), column & (len(known) - 1), (row * width + column) * side
    place = i * len(known) + j
    if known[i, j] != first:
        known[i, j] = first
        for k in range(image.shape[1]):
            mean[place, k] = _mean(image, first, width, side, k, work)
    return place


@part
def _mean(image, first, width, side, k, work):
    """Mean of channel k of side by side texels from `first` on, halved again and again."""
    for i in range(side):
        for j in range(side):
            work[i * side + j] = image[first + i * width + j, k]
    while side > 1:
        row = side
        side //= 2
        for i in range(side):
            for j in range(side):
                at = 2 * (i * row + j)
                upper, lower = work[at] + work[at + row], work[at + 1]
                work[i * side + j] = ((upper + lower) + work[at + row + 1]) * 0.25
    return work[0]


@kernel
def halve(image, width, result):
    """Average texels two by two: image (height width, c) float with even sides -> result (a quarter of that, c)."""
    across = width // 2
    for i in range(len(result)):
        first = 2 * (i // across) * width + 2 * (i % across)
        for k in range(image.shape[1]):
            upper, lower = image[first, k] + image[first + width, k], image[first + 1, k]
            result[i, k] = ((upper + lower) + image[first + width + 1, k]) * 0.25
