"""One set of paths, every absorber: weights of all combinations of absorbers, summed by bin."""

import math

import numpy as np

from surftex.kernels.jit import kernel

_NOTHING = 30.0
"""Depth of absorption beyond which a path counts as nothing (1e-13), so that no denormal number appears."""


@kernel
def absorb(
    first, last, start, order, sums, weight, corneum, epidermis, papillary, reticular, share, row, total
):
    """Sum the weights of paths in bins [first, last).

    Bin b owns the paths order[start[b]:start[b + 1]] (int64); sums (n, 4), weight (n,) of each path; depth of
    absorption per unit of `sums`: corneum (s,), epidermis (e,), papillary and reticular (d,); share (c,): what
    a path gives to each channel; row (e, s * d): scratch. Adds to total (bins, c, e, s * d) float64.
    """
    s, e, d = len(corneum), len(epidermis), len(papillary)
    above, below = np.zeros(e), np.zeros(s * d)
    for b in range(first, last):
        if start[b] == start[b + 1]:
            continue
        row[:] = 0.0
        for k in range(start[b], start[b + 1]):
            i = order[k]
            a0, a1, a2, a3 = sums[i, 0], sums[i, 1], sums[i, 2], sums[i, 3]
            for q in range(e):
                depth = epidermis[q] * a1
                above[q] = math.exp(-depth) if depth < _NOTHING else 0.0
            for q in range(d):
                depth = papillary[q] * a2 + reticular[q] * a3
                value = weight[i] * math.exp(-depth) if depth < _NOTHING else 0.0
                for r in range(s):
                    below[r * d + q] = value
            for r in range(s):
                value = math.exp(-corneum[r] * a0)
                for q in range(d):
                    below[r * d + q] *= value
            for q in range(e):
                value = above[q]
                if value > 0.0:
                    for r in range(s * d):
                        row[q, r] += value * below[r]
        for c in range(len(share)):
            for q in range(e):
                for r in range(s * d):
                    total[b, c, q, r] += share[c] * row[q, r]
