"""Everything that reaches a sample, feature by feature: points that change its state, curves that crease it.

Shared arguments are those of `surftex.kernels.gather`, without least distances: the entries of a bucket are in the order of
their features (of their rows within one), so that all windows of a feature stand together and the order of blending is
the features' own.
"""

import math

import numpy as np

from surftex.kernels.buckets import bucket_of
from surftex.kernels.evaluate import distance_to, leaving_direction, place_on_curve
from surftex.kernels.jit import kernel, part

ADD, LESSEN, COVER = 1, 2, 3
"""What a feature does to a number of the state by a value v: adds it, takes that share off, or fills up to 1 by it."""


@part
def _read(table, line, x):
    """Look up a profile at x in [0, 1), between its knots."""
    last = table.shape[1] - 1
    place = x * last
    knot = min(np.int64(place), last - 1)
    share = np.float32(place - knot)
    return table[line, knot] + share * (table[line, knot + 1] - table[line, knot])


@part
def _outline(outline, who, c, s):
    """Radius of an irregular outline in the direction (c, s), as a share of the mean one: waves of 2, 3 and 5 turns."""
    c2, s2 = c * c - s * s, 2.0 * c * s
    c3, s3 = c2 * c - s2 * s, s2 * c + c2 * s
    c5, s5 = c3 * c2 - s3 * s2, s3 * c2 + c3 * s2
    wave = outline[who, 0] * c2 + outline[who, 1] * s2 + outline[who, 2] * c3 + outline[who, 3] * s3
    return max(1.0 + wave + outline[who, 4] * c5 + outline[who, 5] * s5, 0.2)


@kernel
def blend_points(
    begin, end, face, barycentric, flat, first, cells, grid, start, entry_row, row, row_id, limit, footprint,
    size, outline, amount, channel, rule, line, turned, spread, finest, table, state,
):  # fmt: skip
    """Let every point feature of one kind that reaches samples [begin, end) change their state, in order.

    limit (f,); footprint (n,) float32. Of each feature: size (f, 4) float32: radius, length over width, cosine and sine of its
    long axis; outline (f, 6) float32; amount (f, c) float32. Of the c changes: channel, rule and line (c,) int64: column of
    `state`, one of `ADD`, `LESSEN`, `COVER`, row of `table` (t, p) float32. turned: 1 where directions matter. spread: squared
    radius that a squared footprint adds. finest: footprint at which single features begin to fade.
    -> state (n, s) float32, changed in place.
    """
    for i in range(begin, end):
        wide = np.float64(footprint[i])
        shown = min(2.0 - wide / finest, 1.0)
        if shown <= 0.0:
            continue
        shown = shown * shown * (3.0 - 2.0 * shown)
        f = face[i]
        x = barycentric[i, 1] * flat[f, 1, 0] + barycentric[i, 2] * flat[f, 2, 0]
        y = barycentric[i, 2] * flat[f, 2, 1]
        bucket = bucket_of(f, x, y, first, cells, grid)
        e, last = start[bucket], start[bucket + 1]
        while e < last:
            who = row_id[entry_row[e], 1]
            best = math.inf
            found = -1
            while e < last and row_id[entry_row[e], 1] == who:
                r = entry_row[e]
                d = distance_to(row_id[r, 2], row, r, x, y)
                if d < best:
                    best = d
                    found = r
                e += 1
            if best > limit[who]:
                continue
            radius = np.float64(size[who, 0])
            if turned == 1:
                c, s = leaving_direction(row_id[found, 2], row, found, x, y)
                along = c * size[who, 2] + s * size[who, 3]
                long = size[who, 1]
                best *= math.sqrt(along * along / long + (1.0 - along * along) * long)
                radius *= _outline(outline, who, c, s)
            dull = radius * radius + spread * wide * wide
            square = best * best / dull
            if square >= 1.0:
                continue
            away = math.sqrt(square)
            strength = np.float32(shown * radius * radius / dull)
            for j in range(len(channel)):
                v = strength * amount[who, j] * _read(table, line[j], away)
                k = channel[j]
                if rule[j] == ADD:
                    state[i, k] += v
                elif rule[j] == LESSEN:
                    state[i, k] *= np.float32(1.0) - v
                else:
                    state[i, k] += (np.float32(1.0) - state[i, k]) * v


@kernel
def blend_curves(
    begin, end, face, barycentric, flat, first, cells, grid, start, entry_row, row, row_id, source_of, limit,
    along_of, tangent, footprint, curve, table, crease, lift, fade, spread, depth, raised,
):  # fmt: skip
    """Let every curve that reaches samples [begin, end) crease them; where several do, the result is smooth.

    source_of (p,) int32, limit (p,), along_of (p,), tangent (p, 2): of each primitive. curve (c, 6) float64: length, greatest
    half width, depth, height of the fold and its side, 1 or -1; 1 where it is closed, so that it has no ends. table (t, p)
    float32: rows `crease` and `lift` are profiles of the groove and of the fold, the latter three times as wide. fade: power
    of the taper by which the depth shrinks with the width. spread: squared width that a squared footprint adds.
    -> depth (n,), raised (n,) float32: root of the sum of fourth powers over the curves.
    """
    for i in range(begin, end):
        f = face[i]
        x = barycentric[i, 1] * flat[f, 1, 0] + barycentric[i, 2] * flat[f, 2, 0]
        y = barycentric[i, 2] * flat[f, 2, 1]
        bucket = bucket_of(f, x, y, first, cells, grid)
        wide = spread * np.float64(footprint[i]) ** 2
        down, up = 0.0, 0.0
        e, last = start[bucket], start[bucket + 1]
        while e < last:
            who = source_of[row_id[entry_row[e], 1]]
            best = math.inf
            found = -1
            while e < last and source_of[row_id[entry_row[e], 1]] == who:
                r = entry_row[e]
                d = distance_to(row_id[r, 2], row, r, x, y)
                if d < best:
                    best = d
                    found = r
                e += 1
            q = row_id[found, 1]
            if best > limit[q]:
                continue
            ahead, left = place_on_curve(row_id[found, 2], row, found, tangent, q, x, y)
            t = 0.5 if curve[who, 5] > 0 else (along_of[q] + ahead) / curve[who, 0]
            width = 2.0 * curve[who, 1] * max(min(t, 1.0 - t), 0.0)
            if width <= 0.0:
                continue
            taper = width / curve[who, 1]
            deep = taper**fade
            dull = math.sqrt(width * width + wide)
            if best < dull:
                value = curve[who, 2] * deep * width / dull * np.float64(_read(table, crease, best / dull))
                down += value * value * value * value
            dull = math.sqrt(9.0 * width * width + wide)
            if left == (curve[who, 4] > 0) and best < dull and curve[who, 3] > 0:
                share = 3.0 * width / dull * np.float64(_read(table, lift, best / dull))
                value = curve[who, 3] * share * deep * taper
                up += value * value * value * value
        depth[i] = math.sqrt(math.sqrt(down))
        raised[i] = math.sqrt(math.sqrt(up))
