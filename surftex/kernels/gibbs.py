"""Gibbs sampling of a texture on a lattice: one class of sites at a time, read from the old picture, written apart.

A lattice is a list of sites and, for every site, the sites that its offsets lead to. On a plane these are fixed
steps in an array with a margin, on a surface a table: ``base + reach[row]``, where either the row or the base is
0. A level of `MISSING` stands for no site.

Potentials are whole numbers, so that sums are exact in every order and on every machine. A pair's potentials are
a row of 64: for differences of levels they start at ``31 - s`` for the neighbour's level s, for joint levels at
``8 s``; so each neighbour costs one addition of a row. The four potentials that a quad adds, one per class of
levels, lie side by side in 64 bits and are added at once; they are never negative and never carry over.
"""

import numpy as np

from surftex.kernels.jit import kernel, part
from surftex.kernels.random import uniform

MISSING = 255
"""Level of what is no site."""

NO_CLASS = 64
"""Class of a missing level in quads: three of them make a code of 64 or more, which has no potential."""

LEAST_SHARE = 4096
"""Entries in the table of exponentials; potentials farther than this above the least have no share."""


@part
def add_rows(total, table, start, count, levels):
    """Add `count` rows of the table, from `start` (count,) uint64 on, to total (levels,) int16."""
    e = 0
    while e + 3 < count:
        a, b, c, d = start[e], start[e + 1], start[e + 2], start[e + 3]
        for v in range(levels):
            w = np.uint64(v)
            total[w] += table[a + w] + table[b + w] + table[c + w] + table[d + w]
        e += 4
    while e < count:
        a = start[e]
        for v in range(levels):
            w = np.uint64(v)
            total[w] += table[a + w]
        e += 1


@part
def drawn(total, exponential, share, levels, number):
    """Draw a level with probability exp(-total), by a random number in [0, 1); `share` (levels,) is a buffer."""
    least = total[0]
    for v in range(1, levels):
        least = min(least, total[v])
    whole = np.float32(0.0)
    for v in range(levels):
        whole += exponential[min(np.int64(total[v]) - np.int64(least), np.int64(LEAST_SHARE - 1))]
        share[v] = whole
    goal = np.float32(number) * whole
    level = 0
    for v in range(levels - 1):
        if share[v] <= goal:
            level += 1
    return level


@kernel
def sample_sites(
    first, last, level, group, groups, site, reach, follow, pair_start, pair, rows, table, step, shift, single,
    near_start, near, role_start, role, quad, quarter, exponential, levels, key, turn, fresh,
):  # fmt: skip
    """Draw the sites ``site[first:last]`` anew, one band after the other; a site sees its own bands as drawn.

    level (c, p) uint8; group (p,) uint8, of `groups` kinds; site (n,) int32; reach (1 or p, e) int32, by row where
    `follow` is 1. Pairs of band b are ``pair[pair_start[b]:pair_start[b + 1]]``, (k, 3) uint64: neighbour's band,
    offset, row of `table`; table ((groups + 1) rows 64,) int16, the last group for pairs that join two groups;
    single (groups, c, 32) int16. Quads: near (q,) uint64 offsets whose classes are looked up; role (r,) uint64: three
    positions in that list, 16 bits each; role r has row r of quad (groups, r, 65) uint64; quarter (groups, c, 256)
    uint8. exponential (4096,) float32; `key` uint64 and `turn` of the random numbers -> fresh (c, p) uint8.
    Indices are unsigned: a signed one is tested for being negative each time, which doubled the cost of a quad.
    """
    bands = level.shape[0]
    total, share = np.zeros(64, np.int16), np.zeros(64, np.float32)
    start = np.zeros(len(pair) + 1, np.uint64)
    seen = np.zeros(len(near) + 1, np.uint64)
    places = np.uint64(level.shape[1])
    position = np.uint64(0xFFFF)
    for b in range(bands):
        begin, end = np.uint64(near_start[b]), np.uint64(near_start[b + 1])
        for i in range(first, last):
            p = np.uint64(site[i])
            base = np.int64(0 if follow else p)
            line = np.uint64(p if follow else 0)
            mine = np.uint64(group[p])
            count = 0
            for e in range(np.uint64(pair_start[b]), np.uint64(pair_start[b + 1])):
                q = np.uint64(base + reach[line, pair[e, 1]])
                band = pair[e, 0]
                s = np.int64(fresh[band, q] if q == p and band < np.uint64(b) else level[band, q])
                if s == MISSING:
                    continue
                row = np.int64(pair[e, 2])
                if groups > 1:
                    row += rows * (np.int64(mine) if np.uint64(group[q]) == mine else groups)
                start[count] = np.uint64(row * 64 + shift + step * s)
                count += 1
            for v in range(levels):
                total[v] = single[mine, b, v]
            add_rows(total, table, start, count, levels)
            if role_start[b + 1] > role_start[b]:
                for e in range(begin, end):
                    q = np.uint64(base + reach[line, near[e]])
                    seen[e - begin] = quarter[mine, b, level[b, q]]
                    if groups > 1 and np.uint64(group[q]) != mine:
                        seen[e - begin] = np.uint64(NO_CLASS)
                packed = np.uint64(0)
                for r in range(np.uint64(role_start[b]), np.uint64(role_start[b + 1])):
                    three = role[r]
                    one, two = seen[three & position], seen[(three >> np.uint64(16)) & position]
                    code = (one << np.uint64(4)) + (two << np.uint64(2)) + seen[three >> np.uint64(32)]
                    packed += quad[mine, r, min(code, np.uint64(NO_CLASS))]
                for v in range(levels):
                    lane = np.uint64(16) * np.uint64(quarter[mine, b, v])
                    total[v] += np.int16((packed >> lane) & np.uint64(0xFFFF))
            number = uniform(key, (np.uint64(turn) * np.uint64(bands) + np.uint64(b)) * places + p)
            fresh[b, p] = drawn(total, exponential, share, levels, number)


@kernel
def settle_sites(first, last, site, fresh, level):
    """Copy what was drawn for ``site[first:last]`` into the picture: fresh to level, both (c, p) uint8."""
    for b in range(level.shape[0]):
        for i in range(first, last):
            level[b, site[i]] = fresh[b, site[i]]
