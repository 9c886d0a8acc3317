"""Exact windows: what a source sees of a surface, face by face, as far as a radius.

A source is one primitive or several: points, in-face segments, and caps (points that send into a wedge only).
A WINDOW is the part of an edge that straight paths from the source cross into a face; it carries the source's
image I in that face's frame, unfolded along the paths. Windows leave a heap by their least distance, enter a
face, are recorded there, and go on through the two other edges. What a nearer path to a corner makes useless
is dropped (the vertex rule and the split rule of exact geodesics). At a corner with more than a full turn, and
at a reentrant border corner, the shadow behind it is lit from the corner, `sigma` mm farther on.

A ROW of what is found: 0, 1 the image I; 2 to 5 the ends X0, X1 of the visible interval; 6 sigma; 7, 8 (c, s); 9 its
least distance in the face. Kinds of rows, and what (c, s) is:

    0  image of a point; (c, s) turns the face's frame into the source's
    1  a corner behind a point; (c, s) is the unit direction in which the path leaves the source
    2, 3  a segment, seen from its left, right: I is its start, (c, s) the unit direction away from it
    4, 5  a corner behind a segment's left, right side; c is the mm from the segment's start to the foot
    6  a segment in its own face: I is its start, (c, s) its left normal
"""

import math

import numpy as np

from surftex.kernels.jit import kernel, part
from surftex.kernels.window_corners import SLACK, approach, shine, touch
from surftex.kernels.window_queue import DEAD, DIRECT, Light, enter, pop, reach, record


@part
def _clipped(lo, hi, value, slope):
    """Keep the part of [lo, hi] where value + slope t >= 0."""
    if value + slope * lo < 0 and value + slope * hi < 0:
        return lo, lo
    if slope > 0:
        lo = max(lo, -value / slope)
    elif slope < 0:
        hi = min(hi, -value / slope)
    return lo, hi


@part
def _foot(ax, ay, bx, by, x, y):
    """Find the share of the segment a b, in [0, 1], that is nearest to (x, y); 0 for a point."""
    dx = bx - ax
    dy = by - ay
    square = dx * dx + dy * dy
    if square <= 0:
        return 0.0
    return min(max(((x - ax) * dx + (y - ay) * dy) / square, 0.0), 1.0)


@part
def _stays_inside(shape, limit, face, primitive, q):
    """Tell whether nothing within `limit` of primitive q lies beyond its face."""
    for i in range(3):
        onward = i + 1 if i < 2 else 0
        px, py = shape[face, i, 0], shape[face, i, 1]
        ex, ey = shape[face, onward, 0] - px, shape[face, onward, 1] - py
        a = ex * (primitive[q, 1] - py) - ey * (primitive[q, 0] - px)
        b = ex * (primitive[q, 3] - py) - ey * (primitive[q, 2] - px)
        if min(a, b) < limit * shape[face, i, 2]:
            return False
    return True


@part
def _measure_corners(ids, shape, near, near_of, source, face, primitive, q):
    """Walk straight from primitive q to the corners of its face."""
    ax, ay, bx, by = primitive[q, 0], primitive[q, 1], primitive[q, 2], primitive[q, 3]
    for i in range(3):
        v = np.int64(ids[face, i, 0])
        touch(near, near_of, source, v)
        x, y = shape[face, i, 0], shape[face, i, 1]
        share = _foot(ax, ay, bx, by, x, y)
        near[v] = min(
            near[v], math.sqrt((ax + share * (bx - ax) - x) ** 2 + (ay + share * (by - ay) - y) ** 2)
        )


@part
def _leave(
    ids, shape, turning, wanted, bound, near, near_of, edge_of, count, heap_key, links, window, window_id,
    row, row_id, source, limit, face, primitive, q, inside,
):  # fmt: skip
    """Record primitive q in its own face, and send it through the edges and to the corners."""
    ax, ay, bx, by = primitive[q, 0], primitive[q, 1], primitive[q, 2], primitive[q, 3]
    w0x, w0y, w1x, w1y = primitive[q, 4], primitive[q, 5], primitive[q, 6], primitive[q, 7]
    cap = w0x != 0 or w0y != 0
    long = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
    nx, ny = 1.0, 0.0
    if long > 0:
        nx, ny = -(by - ay) / long, (bx - ax) / long
    if wanted[face] and not cap:
        record(
            count, row, row_id, face, 0.0, ax, ay, bx, by, Light(6 if long > 0 else 0, q, ax, ay, 0.0, nx, ny)
        )
    if inside:
        return
    for i in range(3):
        px, py = shape[face, i, 0], shape[face, i, 1]
        share = _foot(ax, ay, bx, by, px, py)
        dx, dy = ax + share * (bx - ax) - px, ay + share * (by - ay) - py
        distance = math.sqrt(dx * dx + dy * dy)
        kind, c, s = 1, 1.0, 0.0
        if long > 0:
            kind, c = 4 if (px - ax) * nx + (py - ay) * ny > 0 else 5, share * long
        elif distance > 0:
            c, s = -dx / distance, -dy / distance
        approach(
            ids, shape, turning, near, near_of, count, heap_key, links, window, window_id, source, limit, 3
            * face + i, distance, dx, dy, Light(kind, q, 0.0, 0.0, 0.0, c, s),
        )  # fmt: skip
        length = shape[face, i, 2]
        onward = i + 1 if i < 2 else 0
        ex, ey = (shape[face, onward, 0] - px) / length, (shape[face, onward, 1] - py) / length
        lo, hi = 0.0, length
        if cap:
            lo, hi = _clipped(lo, hi, w0x * (py - ay) - w0y * (px - ax), w0x * ey - w0y * ex)
            lo, hi = _clipped(lo, hi, (px - ax) * w1y - (py - ay) * w1x, ex * w1y - ey * w1x)
        if long > 0:
            foot, step = (px - ax) * ny - (py - ay) * nx, ex * ny - ey * nx
            lo, hi = _clipped(lo, hi, foot, step)
            lo, hi = _clipped(lo, hi, long - foot, -step)
        for right in range(2 if long > 0 else 1):
            low, high, sign = lo, hi, 1.0 - 2.0 * right
            if long > 0:
                low, high = _clipped(
                    lo, hi, sign * ((px - ax) * nx + (py - ay) * ny), sign * (ex * nx + ey * ny)
                )
            light = Light(2 + right if long > 0 else 0, q, ax, ay, 0.0, sign * nx, sign * ny)
            enter(
                ids, shape, bound, edge_of, count, heap_key, links, window, window_id, source, limit, face,
                i, low, high, DIRECT, light,
            )  # fmt: skip


@part
def _cross(
    ids, shape, turning, wanted, bound, near, near_of, split, edge_of, count, heap_key, links, window,
    window_id, row, row_id, source, limit, face, j, branch, b0, b1, least, light,
):  # fmt: skip
    """Take a window into its face through edge j: record it, measure the corner opposite, and go on."""
    j1 = j + 1 if j < 2 else 0
    j2 = j - 1 if j > 0 else 2
    length = shape[face, j, 2]
    ax, ay = shape[face, j, 0], shape[face, j, 1]
    bx, by = shape[face, j1, 0], shape[face, j1, 1]
    cx, cy = shape[face, j2, 0], shape[face, j2, 1]
    ex, ey = (bx - ax) / length, (by - ay) / length
    X0x, X0y = ax + ex * b0, ay + ey * b0
    X1x, X1y = ax + ex * b1, ay + ey * b1
    A, B, C = np.int64(ids[face, j, 0]), np.int64(ids[face, j1, 0]), np.int64(ids[face, j2, 0])
    touch(near, near_of, source, A)
    touch(near, near_of, source, B)
    touch(near, near_of, source, C)
    d0 = light.sigma + reach(light, X0x, X0y)
    d1 = light.sigma + reach(light, X1x, X1y)
    if (near[A] + b1) * SLACK < d1 or (near[B] + (length - b0)) * SLACK < d0:
        return
    if branch < 2:
        back = ids[face, j, 1]
        k0 = ids[face, j, 2]
        k1 = k0 + 1 if k0 < 2 else 0
        k2 = k0 - 1 if k0 > 0 else 2
        share = (length - b1 if branch == 0 else length - b0) / length
        dx = shape[back, k0, 0] + (shape[back, k1, 0] - shape[back, k0, 0]) * share - shape[back, k2, 0]
        dy = shape[back, k0, 1] + (shape[back, k1, 1] - shape[back, k0, 1]) * share - shape[back, k2, 1]
        around = near[ids[back, k2, 0]] + math.sqrt(dx * dx + dy * dy)
        if around * SLACK < (d1 if branch == 0 else d0):
            return
    if wanted[face]:
        record(count, row, row_id, face, least, X0x, X0y, X1x, X1y, light)
    linear = light.kind == 2 or light.kind == 3
    r0x, r0y, r1x, r1y, rcx, rcy = light.c, light.s, light.c, light.s, light.c, light.s
    if not linear:
        r0x, r0y, r1x, r1y = X0x - light.x, X0y - light.y, X1x - light.x, X1y - light.y
        rcx, rcy = cx - light.x, cy - light.y
    beyond_left = r0x * (cy - X0y) - r0y * (cx - X0x) > 0
    beyond_right = r1x * (cy - X1y) - r1y * (cx - X1x) < 0
    first_side, last_side = 0, 2
    near[C] = min(near[C], near[A] + shape[face, j2, 2], near[B] + shape[face, j1, 2])
    straight = light.sigma + reach(light, cx, cy)
    distance = straight
    if beyond_left:
        last_side = 1
        distance = d0 + math.sqrt((cx - X0x) * (cx - X0x) + (cy - X0y) * (cy - X0y))
    elif beyond_right:
        first_side = 1
        distance = d1 + math.sqrt((cx - X1x) * (cx - X1x) + (cy - X1y) * (cy - X1y))
    else:
        across = rcx * ey - rcy * ex
        at = 0.5 * (b0 + b1)
        if across != 0:
            at = (rcx * (cy - ay) - rcy * (cx - ax)) / across
        h = 3 * face + j
        if edge_of[h, 0] != source or distance < split[h, 0]:
            edge_of[h, 0] = source
            split[h, 0] = distance
            split[h, 1] = at
        elif distance > split[h, 0] * SLACK:
            if at < split[h, 1]:
                first_side = 1
            else:
                last_side = 1
    near[C] = min(near[C], distance)
    if (
        distance <= straight * SLACK
    ):  # a corner on the very rim is seen, or two windows that part there both miss it
        kind, c, s = light.kind, light.c, light.s
        if kind == 0:
            norm = math.sqrt(rcx * rcx + rcy * rcy)
            kind, c, s = 1, (c * rcx - s * rcy) / norm, (s * rcx + c * rcy) / norm
        elif kind == 2:
            kind, c = 4, (cx - light.x) * s - (cy - light.y) * c
        elif kind == 3:
            kind, c = 5, (cy - light.y) * c - (cx - light.x) * s
        bent, corner = Light(kind, light.primitive, 0.0, 0.0, 0.0, c, s), 3 * face + j2
        approach(
            ids, shape, turning, near, near_of, count, heap_key, links, window, window_id, source, limit, corner,
            distance, -rcx, -rcy, bent,
        )  # fmt: skip
    for side in range(first_side, last_side):
        e = j1 if side == 0 else j2
        e1 = e + 1 if e < 2 else 0
        whole = shape[face, e, 2]
        px, py = shape[face, e, 0], shape[face, e, 1]
        ux, uy = (shape[face, e1, 0] - px) / whole, (shape[face, e1, 1] - py) / whole
        t0, t1 = 0.0, whole
        if side == 0 or beyond_right:
            slope = r1x * uy - r1y * ux
            if slope != 0:
                t0 = min(max(-(r1x * (py - X1y) - r1y * (px - X1x)) / slope, 0.0), whole)
        if side == 1 or beyond_left:
            slope = r0x * uy - r0y * ux
            if slope != 0:
                t1 = min(max(-(r0x * (py - X0y) - r0y * (px - X0x)) / slope, 0.0), whole)
        Y0x, Y0y, Y1x, Y1y = px + ux * t0, py + uy * t0, px + ux * t1, py + uy * t1
        d0 = light.sigma + reach(light, Y0x, Y0y)
        d1 = light.sigma + reach(light, Y1x, Y1y)
        if (near[ids[face, e, 0]] + t1) * SLACK < d1 or (near[ids[face, e1, 0]] + (whole - t0)) * SLACK < d0:
            continue
        if side == 0:
            if (near[A] + math.sqrt((Y0x - ax) * (Y0x - ax) + (Y0y - ay) * (Y0y - ay))) * SLACK < d0:
                continue
        elif (near[B] + math.sqrt((Y1x - bx) * (Y1x - bx) + (Y1y - by) * (Y1y - by))) * SLACK < d1:
            continue
        enter(
            ids, shape, bound, edge_of, count, heap_key, links, window, window_id, source, limit, face, e,
            t0, t1, side, light,
        )  # fmt: skip


@kernel
def flood(
    first, last, stamp, order, primitive_start, primitive_face, primitive, radius, most, ids, shape, turning,
    fan_start, fan_corner, wanted, bound, near, near_of, lit_of, split, edge_of, count, heap_key, links,
    window, window_id, row, row_id,
):  # fmt: skip
    """Flood sources order[first:last]: source k owns primitives primitive_start[k] to primitive_start[k + 1].

    primitive (p, 8): start and end in the frame of its face (the same for a point), then the two unit directions,
    counter-clockwise and at most half a turn apart, of a cap's wedge (0 for none). stamp + first to stamp + last must
    not be among the numbers in the `*_of`. The arrays are described in `surftex.kernels.window_queue`.
    -> row (r, 10), row_id (r, 3) (face, primitive, kind), from count[3] on, which ends as their number.
    Returns the place in the order of the source that did not fit, and what to do about it (1 grow the queue, 2 grow
    the rows, 3 nothing: it sends more than `most` windows); or last and 0.
    """
    for turn in range(first, last):
        k = order[turn]
        source = stamp + turn
        limit = radius[k]
        rows = count[3]
        count[0], count[1], count[2], count[4], count[5] = 0, 0, 0, 0, 0
        inside = True
        for q in range(primitive_start[k], primitive_start[k + 1]):
            inside = inside and _stays_inside(shape, limit, np.int64(primitive_face[q]), primitive, q)
        for q in range(primitive_start[k], primitive_start[k + 1]):
            if not inside:
                _measure_corners(ids, shape, near, near_of, source, np.int64(primitive_face[q]), primitive, q)
        for q in range(primitive_start[k], primitive_start[k + 1]):
            _leave(
                ids, shape, turning, wanted, bound, near, near_of, edge_of, count, heap_key, links, window,
                window_id, row, row_id, source, limit, np.int64(primitive_face[q]), primitive, q, inside,
            )  # fmt: skip
        popped = 0
        while count[0] > 0 and popped <= most and count[4] == 0 and count[5] == 0:
            popped += 1
            least = heap_key[0]
            w = pop(count, heap_key, links)
            place, edge, kind = (
                np.int64(window_id[w, 0]),
                np.int64(window_id[w, 1]),
                np.int64(window_id[w, 2]),
            )
            branch, q = np.int64(window_id[w, 3]), np.int64(window_id[w, 4])
            window_id[w, 0] = -1
            sigma = window[w, 4]
            light = Light(abs(kind), q, window[w, 2], window[w, 3], sigma, window[w, 5], window[w, 6])
            if kind > -1:
                _cross(
                    ids, shape, turning, wanted, bound, near, near_of, split, edge_of, count, heap_key,
                    links, window, window_id, row, row_id, source, limit, place, edge, branch, window[w, 0],
                    window[w, 1], least, light,
                )  # fmt: skip
            elif kind > DEAD and lit_of[place] != source and sigma <= near[place] * SLACK:
                lit_of[place] = source
                shine(
                    ids, shape, turning, fan_start, fan_corner, wanted, bound, near, near_of, edge_of,
                    count, heap_key, links, window, window_id, row, row_id, source, limit, place, edge,
                    window[w, 0], light,
                )  # fmt: skip
        if popped > most or count[4] > 0 or count[5] > 0:
            count[3] = rows
            return turn, 3 if popped > most else (1 if count[4] > 0 else 2)
    return last, 0
