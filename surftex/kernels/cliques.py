"""Counting cliques: how often two levels differ by so much, how often four classes come together.

Shared arguments: level (c, p) uint8, group (p,) uint8, site (n,) int32, reach and `follow` as in
`surftex.kernels.gibbs`. Slices of sites have counts of their own; whole numbers add up alike in any order.
"""

import numpy as np

from surftex.kernels.jit import kernel

MISSING = 255


@kernel
def count_pairs(first, last, level, group, groups, site, reach, follow, kind, step, shift, count):
    """Count pairs from ``site[first:last]`` on, by group; the last group holds those that join two groups.

    kind (k, 3) int32: band at the site, band at its neighbour, offset -> count (groups + 1, k, 64) int64, at
    ``neighbour + step * level + shift``, added to what is there.
    """
    for i in range(first, last):
        p = site[i]
        base = 0 if follow else p
        line = p if follow else 0
        mine = np.int64(group[p])
        for k in range(len(kind)):
            here = np.int64(level[kind[k, 0], p])
            q = base + reach[line, kind[k, 2]]
            there = np.int64(level[kind[k, 1], q])
            if here == MISSING or there == MISSING:
                continue
            which = 0
            if groups > 1:
                which = mine if np.int64(group[q]) == mine else groups
            count[which, k, there + step * here + shift] += 1


@kernel
def count_quads(first, last, level, group, groups, site, reach, follow, band, corner, quarter, count):
    """Count quads that lie within one group, from ``site[first:last]`` on.

    band (j,) int32; corner (j, 4) int32 offsets; quarter (groups, c, 256) uint8, above 3 for missing levels ->
    count (groups, j, 256) int64 by the classes of the four, the first most significant; added.
    """
    for i in range(first, last):
        p = site[i]
        base = 0 if follow else p
        line = p if follow else 0
        mine = np.uint64(group[p])
        for j in range(np.uint64(len(band))):
            code = np.uint64(0)
            whole = True
            b = np.uint64(band[j])
            for c in range(np.uint64(4)):
                q = np.uint64(base + reach[np.uint64(line), np.uint64(corner[j, c])])
                number = np.uint64(quarter[mine, b, level[b, q]])
                if number > 3 or (groups > 1 and np.uint64(group[q]) != mine):
                    whole = False
                    break
                code = np.uint64(4) * code + number
            if whole:
                count[mine, j, code] += 1


@kernel
def count_levels(first, last, level, group, site, count):
    """Count levels at ``site[first:last]``: count (groups, c, 256) int64, added."""
    for b in range(level.shape[0]):
        for i in range(first, last):
            count[group[site[i]], b, level[b, site[i]]] += 1
