"""Triangles between particles, known by the lengths of their sides alone: flips, and pairs that become quadrilaterals.

corner (t, 3) int64: particles, counter-clockwise; side i runs from corner i to corner i + 1; twin (t, 3) int64: 3 other + its
side, -1 at a border; length (t, 3): of the sides, in whatever metric.
"""

import math

from surftex.kernels.jit import kernel, part


@part
def _apex(length, t, i):
    """Third corner over side i of triangle t: the side runs along x from the origin."""
    base, onward, back = length[t, i], length[t, (i + 1) % 3], length[t, (i + 2) % 3]
    x = 0.5 * (base * base + back * back - onward * onward) / max(base, 1e-300)
    return x, math.sqrt(max(back * back - x * x, 0.0))


@kernel
def flip_to_delaunay(corner, twin, length, queue, waiting):
    """Flip sides until the two angles that face each sum to at most pi; queue (q,) int64, waiting (3 t,) uint8: scratch.

    A flip is left out where the two triangles are no convex quadrilateral. Returns the number of flips.
    """
    count, flips = 0, 0
    for h in range(len(waiting)):
        waiting[h] = 0
        if twin[h // 3, h % 3] > h:
            queue[count] = h
            waiting[h] = 1
            count += 1
    while count > 0 and flips < 20 * len(waiting):
        count -= 1
        h = queue[count]
        waiting[h] = 0
        t, i = h // 3, h % 3
        g = twin[t, i]
        if g < 0:
            continue
        u, j = g // 3, g % 3
        if u == t or corner[t, (i + 2) % 3] == corner[u, (j + 2) % 3]:
            continue
        cx, cy = _apex(length, t, i)
        base = length[t, i]
        ex, ey = _apex(length, u, j)
        dx, dy = base - ex, -ey
        # cotangents of the facing angles
        first = (cx * cx - cx * base + cy * cy) / max(cy * base, 1e-300)
        second = (dx * dx - dx * base + dy * dy) / max(-dy * base, 1e-300)
        if first + second >= -1e-9:
            continue
        # the new side must cross the old one
        denominator = cy - dy
        if denominator <= 0:
            continue
        cross = cx + (dx - cx) * cy / denominator
        if cross <= 1e-6 * base or cross >= (1 - 1e-6) * base:
            continue
        flips += 1
        a, b, c, d = corner[t, i], corner[t, (i + 1) % 3], corner[t, (i + 2) % 3], corner[u, (j + 2) % 3]
        outer = twin[u, (j + 1) % 3], twin[t, (i + 2) % 3], twin[u, (j + 2) % 3], twin[t, (i + 1) % 3]
        sides = length[u, (j + 1) % 3], length[t, (i + 2) % 3], length[u, (j + 2) % 3], length[t, (i + 1) % 3]
        across = math.sqrt((cx - dx) ** 2 + (cy - dy) ** 2)
        corner[t, 0], corner[t, 1], corner[t, 2] = a, d, c
        corner[u, 0], corner[u, 1], corner[u, 2] = d, b, c
        length[t, 0], length[t, 1], length[t, 2] = sides[0], across, sides[1]
        length[u, 0], length[u, 1], length[u, 2] = sides[2], sides[3], across
        twin[t, 1], twin[u, 2] = 3 * u + 2, 3 * t + 1
        for k in range(4):
            here = (3 * t, 3 * t + 2, 3 * u, 3 * u + 1)[k]
            there = outer[k]
            # a side glued to another side of the same two triangles has moved itself
            if there == 3 * u + (j + 1) % 3:
                there = 3 * t
            elif there == 3 * t + (i + 2) % 3:
                there = 3 * t + 2
            elif there == 3 * u + (j + 2) % 3:
                there = 3 * u
            elif there == 3 * t + (i + 1) % 3:
                there = 3 * u + 1
            twin[here // 3, here % 3] = there
            if there >= 0:
                twin[there // 3, there % 3] = here
            low = min(here, there) if there >= 0 else here
            if there >= 0 and waiting[low] == 0:
                waiting[low] = 1
                queue[count] = low
                count += 1
    return flips


@kernel
def pair_triangles(twin, side, worst, limit, thin, wanted, most, mate):
    """Pair triangles over sides in ascending order of their deviation: thin ones first, then until enough are used.

    side (s,) int64, worst (s,): their deviations from right angles, limit (s,): what is allowed to thin (t,) bool triangles,
    most to others -> mate (t,) int64: given as -1; 3 other + the other's side.
    """
    used = 0
    for stage in range(2):
        for k in range(len(side)):
            if stage == 1 and (worst[k] > most or used >= wanted):
                break
            t, i = side[k] // 3, side[k] % 3
            u, j = twin[t, i] // 3, twin[t, i] % 3
            if mate[t] >= 0 or mate[u] >= 0:
                continue
            if stage == 0 and (worst[k] > limit[k] or not (thin[t] or thin[u])):
                continue
            mate[t], mate[u] = 3 * u + j, 3 * t + i
            used += 2
