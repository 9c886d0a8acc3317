"""One set of paths, every absorber: weights of all combinations of absorbers, summed by bin."""

import numpy as np

from surftex.kernels.jit import kernel, part

_NOTHING = 30.0
"""Depth of absorption beyond which a path counts as nothing (1e-13), so that no denormal number appears."""

_LANES = 16
"""Rows are padded to a multiple of this: as many numbers as processors work on at once, or a few times as many."""

_TAYLOR = (
    1 / 2, 1 / 6, 1 / 24, 1 / 120, 1 / 720, 1 / 5040, 1 / 40320, 1 / 362880, 1 / 3628800, 1 / 39916800, 1 / 479001600,
    1 / 6227020800,
)  # fmt: skip
_C2, _C3, _C4, _C5, _C6, _C7, _C8, _C9, _C10, _C11, _C12, _C13 = _TAYLOR


@part
def _left(depth):
    """exp(-depth) by the Taylor series of its 64th root, relative error 4e-14; 0 beyond `_NOTHING`.

    Sums and products alone: compilers do several at once, and machines agree on the last bit.
    """
    x = depth / -64.0
    x = 1.0 + x * (1.0 + x * (_C2 + x * (_C3 + x * (_C4 + x * (_C5 + x * (_C6 + x * (
        _C7 + x * (_C8 + x * (_C9 + x * (_C10 + x * (_C11 + x * (_C12 + x * _C13))))))))))))  # fmt: skip
    x *= x
    x *= x
    x *= x
    x *= x
    x *= x
    x *= x
    return x if depth < _NOTHING else 0.0


@kernel
def absorb(first, last, start, order, sums, weight, corneum, epidermis, papillary, reticular, share, total):
    """Sum the weights of paths in bins [first, last).

    Bin b owns the paths order[start[b]:start[b + 1]] (int64); sums (n, 4), weight (n,) of each path; depth of
    absorption per unit of `sums`: corneum (s,), epidermis (e,), papillary and reticular (d,); share (c,): what
    a path gives to each channel. Adds to total (bins, c, e, s * d) float64, path by path in their order.
    """
    s, e, d = len(corneum), len(epidermis), len(papillary)
    count = (e + d + s + _LANES - 1) // _LANES * _LANES
    width = (s * d + _LANES - 1) // _LANES * _LANES
    depth, factor = np.zeros(count), np.zeros((4, count))
    below, row = np.zeros((4, width)), np.zeros((e, width))
    for b in range(first, last):
        if start[b] == start[b + 1]:
            continue
        row[:] = 0.0
        for k in range(start[b], start[b + 1], 4):
            for j in range(4):
                if k + j >= start[b + 1]:
                    factor[j, :] = 0.0
                    continue
                i = order[k + j]
                a0, a1, a2, a3 = sums[i, 0], sums[i, 1], sums[i, 2], sums[i, 3]
                for q in range(e):
                    depth[q] = epidermis[q] * a1
                for q in range(d):
                    depth[e + q] = papillary[q] * a2 + reticular[q] * a3
                for r in range(s):
                    depth[e + d + r] = corneum[r] * a0
                for q in range(count):
                    factor[j, q] = _left(depth[q])
                for r in range(s):
                    value = factor[j, e + d + r] * weight[i]
                    for q in range(d):
                        below[j, r * d + q] = factor[j, e + q] * value
            for q in range(e):
                v0, v1, v2, v3 = factor[0, q], factor[1, q], factor[2, q], factor[3, q]
                for r in range(width):
                    value = row[q, r] + v0 * below[0, r]
                    value += v1 * below[1, r]
                    value += v2 * below[2, r]
                    row[q, r] = value + v3 * below[3, r]
        for c in range(len(share)):
            for q in range(e):
                for r in range(s * d):
                    total[b, c, q, r] += share[c] * row[q, r]
