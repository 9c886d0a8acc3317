"""Reading a table of six parameters at many samples: linear in every direction, or its logarithm; ends held."""

import math

import numpy as np

from surftex.kernels.jit import kernel

_WIDTH = 8
_LESS, _MORE = np.float32(1 - 1e-6), np.float32(1 + 1e-6)


@kernel
def read_table(grid, size, bounds, value, out, beyond):
    """Look up n samples.

    grid (k,) float32: rows of eight numbers, the first and the last three as logarithms; last parameter fastest;
    size (6,) int64: steps of each; bounds (6, 3) float32: low, high (the same where the size is 1), and 1 where the
    steps are even, else their logarithms are; value (6, n) float32
    -> out (n, 8) float32; adds to beyond (6,) int64 how many samples left the range, by more than
    rounding.
    """
    low, scale = np.zeros(6, np.float32), np.zeros(6, np.float32)
    stride = np.zeros(6, np.int64)
    step = _WIDTH
    for d in range(5, -1, -1):
        even = bounds[d, 2] == 1.0
        low[d] = bounds[d, 0] if even else math.log(bounds[d, 0])
        high = bounds[d, 1] if even else math.log(bounds[d, 1])
        scale[d] = (size[d] - 1) / (high - low[d]) if size[d] > 1 else 0.0
        stride[d] = step if size[d] > 1 else 0
        step *= size[d]
    pair, place = np.zeros((3, 4), np.float32), np.zeros((3, 4), np.int64)
    share, first = np.zeros(6, np.float32), np.zeros(6, np.int64)
    one = np.float32(1.0)
    for q in range(len(out)):
        for d in range(6):
            v = value[d, q]
            if v < bounds[d, 0] or v > bounds[d, 1]:
                if v < bounds[d, 0] * _LESS or v > bounds[d, 1] * _MORE:
                    beyond[d] += 1
                v = min(max(v, bounds[d, 0]), bounds[d, 1])
            if bounds[d, 2] != 1.0:
                v = np.float32(math.log(v))
            v = (v - low[d]) * scale[d]
            i = min(max(np.int64(v), 0), max(size[d] - 2, 0))
            share[d] = v - np.float32(i)
            first[d] = i * stride[d]
        for h in range(3):
            a, b = 2 * h, 2 * h + 1
            pair[h, 0] = (one - share[a]) * (one - share[b])
            pair[h, 1] = (one - share[a]) * share[b]
            pair[h, 2] = share[a] * (one - share[b])
            pair[h, 3] = share[a] * share[b]
            place[h, 0] = first[a] + first[b]
            place[h, 1] = place[h, 0] + stride[b]
            place[h, 2] = place[h, 0] + stride[a]
            place[h, 3] = place[h, 2] + stride[b]
        for c in range(_WIDTH):
            out[q, c] = 0.0
        for i in range(4):
            for j in range(4):
                outer, there = pair[0, i] * pair[1, j], place[0, i] + place[1, j]
                for k in range(4):
                    weight, at = outer * pair[2, k], there + place[2, k]
                    for c in range(_WIDTH):
                        out[q, c] += weight * grid[at + c]
        for c in range(3):
            out[q, c] = min(np.float32(math.exp(out[q, c])), one)
            out[q, 5 + c] = math.exp(out[q, 5 + c])
        for c in range(3, 5):
            out[q, c] = min(out[q, c], one)
