"""Paths that bend: what a corner with more than a full turn, or a reentrant border corner, sends into its shadow."""

import math

import numpy as np

from surftex.kernels.jit import part
from surftex.kernels.window_queue import DIRECT, Light, enter, record, store

SLACK = 1.0 + 1e-10
"""A path must beat another by this factor before the other is dropped."""

PAD_RAD = 1e-9
"""Shadows are lit this much too wide: every path is a true one, so it costs nothing and leaves no gap."""


@part
def touch(near, near_of, source, vertex):
    """Forget what an earlier source left at a vertex."""
    if near_of[vertex] != source:
        near_of[vertex] = source
        near[vertex] = math.inf


@part
def approach(
    ids, shape, turning, near, near_of, count, heap_key, links, window, window_id, source, limit, corner,
    distance, dx, dy, light,
):  # fmt: skip
    """End a straight path of length `distance` at a corner (3 face + i), (dx, dy) pointing back along it."""
    face = corner // 3
    i = corner - 3 * face
    vertex = np.int64(ids[face, i, 0])
    touch(near, near_of, source, vertex)
    if distance > near[vertex] * SLACK:
        return
    near[vertex] = min(near[vertex], distance)
    if turning[vertex] != 0 and distance < limit:
        onward = i + 1 if i < 2 else 0
        ex = shape[face, onward, 0] - shape[face, i, 0]
        ey = shape[face, onward, 1] - shape[face, i, 1]
        local = math.atan2(ex * dy - ey * dx, ex * dx + ey * dy)
        behind = Light(-light.kind, light.primitive, 0.0, 0.0, distance, light.c, light.s)
        store(count, heap_key, links, window, window_id, distance, vertex, corner, DIRECT, local, 0.0, behind)


@part
def shine(
    ids, shape, turning, fan_start, fan_corner, wanted, bound, near, near_of, edge_of, count, heap_key,
    links, window, window_id, row, row_id, source, limit, vertex, corner, local, light,
):  # fmt: skip
    """Send a corner into its shadow: the directions more than half a turn from `local`, where the path came in."""
    arrived = local + shape[corner // 3, corner % 3, 8]
    total = abs(turning[vertex])
    for k in range(fan_start[vertex], fan_start[vertex + 1]):
        face = fan_corner[k] // 3
        i = fan_corner[k] - 3 * face
        begin = shape[face, i, 8]
        end = begin + shape[face, i, 7]
        low, high = begin, begin - 1.0
        if turning[vertex] < 0:
            if end > arrived + math.pi - PAD_RAD:
                low, high = max(begin, arrived + math.pi - PAD_RAD), end
            elif begin < arrived - math.pi + PAD_RAD:
                low, high = begin, min(end, arrived - math.pi + PAD_RAD)
        else:
            for shift in range(-1, 2):
                from_ = max(begin, arrived + math.pi - PAD_RAD + shift * total)
                to = min(end, arrived - math.pi + PAD_RAD + (shift + 1) * total)
                if to - from_ > high - low:
                    low, high = from_, to
        if high < low:
            continue
        i1 = i + 1 if i < 2 else 0
        i2 = i - 1 if i > 0 else 2
        px, py = shape[face, i, 0], shape[face, i, 1]
        here = Light(light.kind, light.primitive, px, py, light.sigma, light.c, light.s)
        if wanted[face]:
            record(count, row, row_id, face, light.sigma, px, py, px, py, here)
        for side in range(2):
            if (low <= begin) if side == 0 else (high >= end):
                q = i1 if side == 0 else i2
                onward = light.sigma + shape[face, i if side == 0 else i2, 2]
                dx, dy = px - shape[face, q, 0], py - shape[face, q, 1]
                approach(
                    ids, shape, turning, near, near_of, count, heap_key, links, window, window_id, source,
                    limit, 3 * face + q, onward, dx, dy, here,
                )  # fmt: skip
        length = shape[face, i1, 2]
        bx, by = shape[face, i1, 0] - px, shape[face, i1, 1] - py
        ux, uy = (shape[face, i2, 0] - px - bx) / length, (shape[face, i2, 1] - py - by) / length
        t0, t1 = 0.0, length
        for side in range(2):
            if (low > begin) if side == 0 else (high < end):
                turn = (low if side == 0 else high) - begin
                cosine, sine = math.cos(turn), math.sin(turn)
                dx, dy = cosine * bx - sine * by, sine * bx + cosine * by
                t = min(max((dy * bx - dx * by) / (dx * uy - dy * ux), 0.0), length)
                if side == 0:
                    t0 = t
                else:
                    t1 = t
        enter(
            ids, shape, bound, edge_of, count, heap_key, links, window, window_id, source, limit, face, i1,
            t0, t1, DIRECT, here,
        )  # fmt: skip
