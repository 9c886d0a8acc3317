"""Untying stars: where many sharp corners of cells meet at a particle, pairs of triangles are broken and tied anew.

A lone triangle x takes a mate y from its mate v; v stays alone, or takes a lone neighbour w. Of all such moves around a
star the one is made that lowers the cost of all particles and cells it touches most, until none lowers it.

corner, twin (t, 3) int64, angle (t, 3) and mate (t,) int64 as in `surftex.kernels.triangulation`; worst (t, 3): deviation of
the pair across each side from right angles, limit (t, 3): what is allowed there; start (p + 1,), spoke (3 t,) int64: corners
3 t + i at particle p are spoke[start[p]] to spoke[start[p + 1]].
"""

import math

import numpy as np

from surftex.kernels.jit import kernel, part

SHARP, SPAN = math.radians(50.0), math.radians(20.0)
"""A corner of a cell below `SHARP` counts, in full `SPAN` below it; the first one at a particle is free."""

MANY, LONE = 6, 3
"""More cells, or more lone triangles, around a particle count as well."""

THIN, SKEWED, SLOPE = math.radians(30.0), math.radians(45.0), math.radians(30.0)
"""Angles beyond which lone triangles are too thin and pairs too skewed."""

LEAST_GAIN, ROUNDS = 0.05, 6


@part
def _star(p, start, spoke, angle, mate):
    """How much the corners of the cells at particle p are a star; 0 where they are none."""
    sharp, cells, lone = 0.0, 0, 0
    for e in range(start[p], start[p + 1]):
        t, i = spoke[e] // 3, spoke[e] % 3
        here = angle[t, i]
        if mate[t] < 0:
            lone += 1
        else:
            u, j, side = mate[t] // 3, mate[t] % 3, mate[mate[t] // 3] % 3
            if i == side or i == (side + 1) % 3:
                if u < t:
                    continue
                here += angle[u, (j + 1) % 3 if i == side else j]
        cells += 1
        sharp += min(max(0.0, (SHARP - here) / SPAN), 1.5)
    return max(0.0, sharp - 1) ** 2 + 0.5 * max(0, cells - MANY) ** 2 + 0.15 * max(0, lone - LONE) ** 2


@part
def _shape(t, angle, worst, mate):
    """How far triangle t, or its half of a pair, is from a good cell."""
    if mate[t] < 0:
        least = min(angle[t, 0], min(angle[t, 1], angle[t, 2]))
        return 0.5 * max(0.0, 2 * (THIN - least) / SLOPE) ** 2
    side = mate[mate[t] // 3] % 3
    return 0.25 * max(0.0, (worst[t, side] - SKEWED) / SLOPE) ** 2


@kernel
def _cost(move, corner, angle, worst, mate, start, spoke, seen):
    """Cost of the triangles x, y, v, w of a move (-1: none), and of the particles at their corners, each once."""
    total, count = 0.0, 0
    for which in range(4):
        t = move[which]
        if t < 0:
            continue
        total += _shape(t, angle, worst, mate)
        for i in range(3):
            known = False
            for k in range(count):
                known = known or seen[k] == corner[t, i]
            if not known:
                seen[count] = corner[t, i]
                count += 1
                total += _star(corner[t, i], start, spoke, angle, mate)
    return total


@part
def _make(move, mate):
    """Make a move: x, y, v, w, the side of x that y lies across, and the side of v that w lies across, with their twins."""
    x, y, v, w = move[0], move[1], move[2], move[3]
    mate[x], mate[y] = 3 * y + move[5], 3 * x + move[4]
    if v >= 0:
        mate[v] = -1
    if w >= 0:
        mate[v], mate[w] = 3 * w + move[7], 3 * v + move[6]


@part
def _gain(move, corner, angle, worst, mate, start, spoke, seen):
    """By how much a move lowers the cost; mate is left as it was."""
    y, v = move[1], move[2]
    of_y, of_v = mate[y], mate[v] if v >= 0 else -1
    before = _cost(move, corner, angle, worst, mate, start, spoke, seen)
    _make(move, mate)
    after = _cost(move, corner, angle, worst, mate, start, spoke, seen)
    mate[move[0]], mate[y] = -1, of_y
    if move[3] >= 0:
        mate[move[3]] = -1
    if v >= 0:
        mate[v] = of_v
    return before - after


@part
def _best_move(p, corner, twin, angle, worst, limit, mate, start, spoke, seen, move, best):
    """Find the move around particle p that gains most; returns its gain, 0 where none gains enough."""
    most = LEAST_GAIN
    for e in range(start[p], start[p + 1]):
        for own in range(6):
            x, side = spoke[e] // 3, own % 3
            far = twin[x, side]
            if far < 0:
                continue
            y, back = far // 3, far % 3
            if own >= 3:
                x, side, y, back = y, back, x, side
            if x == y or mate[x] >= 0 or worst[x, side] > limit[x, side]:
                continue
            move[0], move[1], move[2], move[3], move[4], move[5] = x, y, mate[y] // 3, -1, side, back
            v = move[2] if mate[y] >= 0 else -1
            move[2] = v
            for onward in range(-1, 3 if v >= 0 else 0):
                move[3], move[6], move[7] = -1, 0, 0
                if onward >= 0:
                    far = twin[v, onward]
                    w = far // 3
                    if far < 0 or w in (x, v) or mate[w] >= 0 or worst[v, onward] > limit[v, onward]:
                        continue
                    move[3], move[6], move[7] = w, onward, far % 3
                gain = _gain(move, corner, angle, worst, mate, start, spoke, seen)
                if gain > most:
                    most = gain
                    for k in range(8):
                        best[k] = move[k]
    return most if most > LEAST_GAIN else 0.0


@kernel
def untie_stars(corner, twin, angle, worst, limit, mate, start, spoke):
    """Break and tie pairs around stars; mate is changed. Returns the number of moves."""
    seen, move, best = np.zeros(12, np.int64), np.zeros(8, np.int64), np.zeros(8, np.int64)
    moves = 0
    for _ in range(ROUNDS):
        before = moves
        for p in range(len(start) - 1):
            for _ in range(4):
                if _star(p, start, spoke, angle, mate) < LEAST_GAIN:
                    break
                if (
                    _best_move(p, corner, twin, angle, worst, limit, mate, start, spoke, seen, move, best)
                    == 0
                ):
                    break
                _make(best, mate)
                moves += 1
        if moves == before:
            break
    return moves
