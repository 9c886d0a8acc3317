"""Outlines of cells: polygons that are shrunk by their groove, with rounded corners; and blobs scattered on their tops.

A cell lives in a plane of its own: the log map at its centre. Its gauge at a place p is rho = max over k of
edge[k] . (p - middle): 0 in the middle, 1 on the outline, and between them the outline shrunk towards the middle.
"""

import math

import numpy as np

from surftex.kernels.jit import kernel, part
from surftex.kernels.random import uniform

BEND, EDGES = 6, 24
"""Points of a rounded corner, and sides of an outline: fewer points where there are more corners."""

OFF, SHARE = 0.03, 0.5
"""Sides that bend by less than this share of the diameter are straight; this share of what bends inward is taken off."""


@part
def _clip(polygon, count, nx, ny, offset, spare):
    """Keep what lies inside nx x + ny y <= offset; returns the number of corners left in `polygon`."""
    kept = 0
    for k in range(count):
        onward = (k + 1) % count
        here = nx * polygon[k, 0] + ny * polygon[k, 1] - offset
        there = nx * polygon[onward, 0] + ny * polygon[onward, 1] - offset
        if here <= 0:
            spare[kept, 0], spare[kept, 1] = polygon[k, 0], polygon[k, 1]
            kept += 1
        if (here < 0 and there > 0) or (here > 0 and there < 0):
            share = here / (here - there)
            spare[kept, 0] = polygon[k, 0] + share * (polygon[onward, 0] - polygon[k, 0])
            spare[kept, 1] = polygon[k, 1] + share * (polygon[onward, 1] - polygon[k, 1])
            kept += 1
    for k in range(kept):
        polygon[k, 0], polygon[k, 1] = spare[k, 0], spare[k, 1]
    return kept


@part
def _convex(corner, bend, c, sides, off, polygon, inset):
    """Corners of cell c, and middles of sides that bend outward; inset: by how much the side after each is to be moved in.

    What would be dented is left out, so that the polygon is convex. Returns the number of its corners.
    """
    count = 0
    for k in range(sides):
        onward = (k + 1) % sides
        middle = 3 if k == sides - 1 else k
        ax, ay, bx, by = corner[c, k, 0], corner[c, k, 1], corner[c, onward, 0], corner[c, onward, 1]
        polygon[count, 0], polygon[count, 1] = ax, ay
        inset[count] = 0.0
        count += 1
        x, y = bx - ax, by - ay
        size = math.sqrt(x * x + y * y)
        if size <= 0:
            continue
        mx, my = bend[c, middle, 0], bend[c, middle, 1]
        out = (y * (mx - ax) - x * (my - ay)) / size
        if out > off:
            polygon[count, 0], polygon[count, 1] = mx, my
            inset[count] = 0.0
            count += 1
        elif out < -off:
            inset[count - 1] = -SHARE * out
    k, straight = 0, 0
    while count > 3 and straight < count:
        before, onward = (k + count - 1) % count, (k + 1) % count
        cross = (polygon[k, 0] - polygon[before, 0]) * (polygon[onward, 1] - polygon[k, 1])
        cross -= (polygon[k, 1] - polygon[before, 1]) * (polygon[onward, 0] - polygon[k, 0])
        if cross > 0:
            straight += 1
            k = onward
            continue
        inset[before] = 0.0
        for j in range(k, count - 1):
            polygon[j, 0], polygon[j, 1], inset[j] = polygon[j + 1, 0], polygon[j + 1, 1], inset[j + 1]
        count -= 1
        k, straight = (k + count - 1) % count, 0
    return count


@kernel
def outlines(
    begin, end, corner, bend, sides, scale, gap, rounding, hull, inset, polygon, spare, bent, edge, edges, middle, area
):  # fmt: skip
    """Outline cells [begin, end).

    corner (c, 4, 2), counter-clockwise, bend (c, 4, 2): middles of the sides; sides (c,) int64: 3, 4; scale (c,): diameter;
    gap (c,): to shrink by half of.
    hull (8, 2), inset (8,), polygon, spare (16, 2), bent (32, 2): scratch -> edge (c, 24, 2), edges (c,) int64: 0 where
    nothing is left; middle (c, 2), area (c,).
    """
    for c in range(begin, end):
        first = _convex(corner, bend, c, sides[c], OFF * scale[c], hull, inset)
        count = first
        for k in range(first):
            polygon[k, 0], polygon[k, 1] = hull[k, 0], hull[k, 1]
        for k in range(first):
            onward = (k + 1) % first
            x, y = hull[onward, 0] - hull[k, 0], hull[onward, 1] - hull[k, 1]
            size = math.sqrt(x * x + y * y)
            if size > 0 and count > 0:
                offset = (y * hull[k, 0] - x * hull[k, 1]) / size - 0.5 * gap[c] - inset[k]
                count = _clip(polygon, count, y / size, -x / size, offset, spare)
        edges[c] = 0
        area[c] = 0.0
        if count < 3 or count > 8:
            continue
        steps = min(BEND, EDGES // count)
        points = 0
        for k in range(count):
            before, onward = (k + count - 1) % count, (k + 1) % count
            for q in range(steps):
                u = q / (steps - 1)
                for axis in range(2):
                    p = polygon[k, axis]
                    a = p + rounding * (polygon[before, axis] - p)
                    b = p + rounding * (polygon[onward, axis] - p)
                    bent[points, axis] = (1 - u) * (1 - u) * a + 2 * u * (1 - u) * p + u * u * b
                points += 1
        whole, mx, my = 0.0, 0.0, 0.0
        for k in range(points):
            onward = (k + 1) % points
            cross = bent[k, 0] * bent[onward, 1] - bent[onward, 0] * bent[k, 1]
            whole += 0.5 * cross
            mx += cross * (bent[k, 0] + bent[onward, 0]) / 6
            my += cross * (bent[k, 1] + bent[onward, 1]) / 6
        if whole <= 0:
            continue
        mx /= whole
        my /= whole
        found = 0
        for k in range(points):
            onward = (k + 1) % points
            nx, ny = bent[onward, 1] - bent[k, 1], bent[k, 0] - bent[onward, 0]
            reach = nx * (bent[k, 0] - mx) + ny * (bent[k, 1] - my)
            if reach > 1e-9 * whole:
                edge[c, found, 0], edge[c, found, 1] = nx / reach, ny / reach
                found += 1
        edges[c] = found if found >= 3 else 0
        middle[c, 0], middle[c, 1] = mx, my
        area[c] = whole


@part
def gauge(edge, edges, c, x, y):
    """Gauge rho of a place (x, y) from the middle of cell c."""
    rho = 0.0
    for k in range(edges[c]):
        rho = max(rho, edge[c, k, 0] * x + edge[c, k, 1] * y)
    return rho


@kernel
def scatter_blobs(
    begin, end, fill, edge, edges, extent, top_area, density, top, radius, spread, key, most, start, blob
):
    """Scatter blobs uniformly over the tops rho < top of cells [begin, end), a Poisson number in each, at most `most`.

    extent (c,): no place of the outline is farther from the middle; top_area (c,). With fill 0 their numbers go to
    start[c + 1], with 1 cell c writes from start[c] on -> blob (b, 3): place from the middle, and radius.
    """
    rows = np.uint64(64 * most)
    for c in range(begin, end):
        counter = np.uint64(c) * rows
        mean = density[c] * top_area[c]
        draw = uniform(key, counter)
        term = math.exp(-min(mean, 600.0))
        total, number = term, 0
        while draw > total and number < most:
            number += 1
            term *= mean / number
            total += term
        if edges[c] == 0:
            number = 0
        if fill == 0:
            start[c + 1] = number
            continue
        counter += np.uint64(1)
        for b in range(number):
            x, y = 0.0, 0.0
            for _ in range(14):
                x = (2 * uniform(key, counter) - 1) * extent[c] * top
                y = (2 * uniform(key, counter + np.uint64(1)) - 1) * extent[c] * top
                counter += np.uint64(2)
                if gauge(edge, edges, c, x, y) < top:
                    break
                x, y = 0.0, 0.0
            one, two = uniform(key, counter), uniform(key, counter + np.uint64(1))
            counter += np.uint64(2)
            normal = math.sqrt(-2 * math.log(1 - one)) * math.cos(2 * math.pi * two)
            at = start[c] + b
            blob[at, 0], blob[at, 1] = x, y
            blob[at, 2] = radius[c] * max(1 + spread * normal, 0.3)
