"""What each sample finds in the rows of its bucket: nearest sources, all sources, tangent vectors, nearest curve.

Shared arguments: face (n,) int32, barycentric (n, 3); flat (m, 3, 2); first, cells, grid as in `surftex.kernels.buckets`;
start (b+1,) int64, entry_row (e,) int32, entry_least (e,) sorted within each bucket; row (r, 9), row_id (r, 3) int32;
source_of and limit (p,): source and radius of each primitive.
"""

import math

import numpy as np

from surftex.kernels.buckets import bucket_of
from surftex.kernels.evaluate import distance_to, leaving_direction, place_on_curve
from surftex.kernels.jit import kernel, part


@part
def nearest_few(
    x, y, bucket, bound, start, entry_row, entry_least, row, row_id, source_of, limit, source, distance, found
):
    """Find the k nearest sources of the place (x, y) below `bound` -> source (k,), distance (k,) and found (k,), the row."""
    k = len(source)
    for q in range(k):
        source[q], distance[q], found[q] = -1, math.inf, -1
    worst = bound
    for e in range(start[bucket], start[bucket + 1]):
        if entry_least[e] >= worst:
            break
        r = entry_row[e]
        kind = row_id[r, 2]
        if kind <= 1:
            dx, dy, left = x - row[r, 0], y - row[r, 1], worst - row[r, 6]
            if left <= 0.0 or dx * dx + dy * dy > left * left * (1.0 + 1e-12):
                continue
        d = distance_to(kind, row, r, x, y)
        if d >= worst or d > limit[row_id[r, 1]]:
            continue
        who = source_of[row_id[r, 1]]
        at = k - 1
        for q in range(k):
            if source[q] == who:
                at = q
                break
        if d >= distance[at]:
            continue
        while at > 0 and distance[at - 1] > d:
            distance[at] = distance[at - 1]
            source[at] = source[at - 1]
            found[at] = found[at - 1]
            at -= 1
        distance[at] = d
        source[at] = who
        found[at] = r
        worst = min(bound, distance[k - 1])


@part
def room_left(row_id, limit, distance, found):
    """How far the place may move without leaving the radius of what `nearest_few` found; 0 where it found fewer than k."""
    room = math.inf
    if found[len(found) - 1] < 0:
        return 0.0
    for q in range(len(found)):
        room = min(room, limit[row_id[found[q], 1]] - distance[q])
    return room


@kernel
def nearest_sources(
    begin, end, face, barycentric, flat, first, cells, grid, start, entry_row, entry_least, row, row_id,
    source_of, limit, source, distance, found,
):  # fmt: skip
    """Find the k nearest sources of samples [begin, end).

    -> source (n, k) int32, -1 for none, distance (n, k), inf for none, and found (n, k) int32, the row, -1 for none.

    The k-th distance grows by no more than a step does, so a sample in the bucket of the one before begins with a
    bound, unless the step may leave the radius of what was found.
    """
    k = source.shape[1]
    last_bucket, last_x, last_y, last_worst, room = np.int64(-1), 0.0, 0.0, math.inf, 0.0
    for i in range(begin, end):
        f = face[i]
        x = barycentric[i, 1] * flat[f, 1, 0] + barycentric[i, 2] * flat[f, 2, 0]
        y = barycentric[i, 2] * flat[f, 2, 1]
        bucket = bucket_of(f, x, y, first, cells, grid)
        bound = math.inf
        if bucket == last_bucket:
            step = math.sqrt((x - last_x) ** 2 + (y - last_y) ** 2)
            if step < room:
                bound = (last_worst + step) * (1.0 + 1e-9)
        nearest_few(
            x, y, bucket, bound, start, entry_row, entry_least, row, row_id, source_of, limit, source[i],
            distance[i], found[i],
        )  # fmt: skip
        last_bucket, last_x, last_y, last_worst = bucket, x, y, distance[i, k - 1]
        room = room_left(row_id, limit, distance[i], found[i])


@kernel
def log_map(begin, end, face, barycentric, flat, row, row_id, distance, found, vector):
    """Tangent vectors at the sources, vector (n, k, 2), of what `nearest_sources` found; 0 where nothing was."""
    for i in range(begin, end):
        f = face[i]
        x = barycentric[i, 1] * flat[f, 1, 0] + barycentric[i, 2] * flat[f, 2, 0]
        y = barycentric[i, 2] * flat[f, 2, 1]
        for q in range(found.shape[1]):
            r = found[i, q]
            vector[i, q, 0] = 0.0
            vector[i, q, 1] = 0.0
            if r >= 0:
                c, s = leaving_direction(row_id[r, 2], row, r, x, y)
                vector[i, q, 0] = distance[i, q] * c
                vector[i, q, 1] = distance[i, q] * s


@kernel
def sources_within(
    begin, end, fill, face, barycentric, flat, first, cells, grid, start, entry_row, entry_least, row,
    row_id, source_of, limit, point_start, source, distance, found,
):  # fmt: skip
    """All sources within their radius of samples [begin, end), ordered by (distance, source).

    With fill == 0 an upper bound of their number goes to point_start[i + 1]. With 1, sample i writes from
    point_start[i] on, and point_start[i + 1] stays as it is: unused places keep source -1.
    """
    for i in range(begin, end):
        f = face[i]
        x = barycentric[i, 1] * flat[f, 1, 0] + barycentric[i, 2] * flat[f, 2, 0]
        y = barycentric[i, 2] * flat[f, 2, 1]
        bucket = bucket_of(f, x, y, first, cells, grid)
        low = point_start[i]
        n = 0
        for e in range(start[bucket], start[bucket + 1]):
            r = entry_row[e]
            d = distance_to(row_id[r, 2], row, r, x, y)
            if d > limit[row_id[r, 1]]:
                continue
            if fill == 0:
                n += 1
                continue
            who = source_of[row_id[r, 1]]
            at = low + n
            for q in range(low, low + n):
                if source[q] == who:
                    at = q
                    break
            if at == low + n:
                n += 1
            elif d >= distance[at]:
                continue
            while at > low and (distance[at - 1] > d or (distance[at - 1] == d and source[at - 1] > who)):
                distance[at] = distance[at - 1]
                source[at] = source[at - 1]
                found[at] = found[at - 1]
                at -= 1
            distance[at] = d
            source[at] = who
            found[at] = r
        if fill == 0:
            point_start[i + 1] = n


@kernel
def nearest_place(
    begin, end, face, barycentric, flat, first, cells, grid, start, entry_row, entry_least, row, row_id,
    limit, piece_of, along_of, tangent, piece, distance, along, side,
):  # fmt: skip
    """Find the nearest place on a curve for samples [begin, end).

    piece_of (p,) int32, along_of (p,), tangent (p, 2): of each primitive. piece (n,) int32 is given as -1, distance (n,)
    as inf, along (n,) and side (n,) int8 as 0.
    """
    for i in range(begin, end):
        f = face[i]
        x = barycentric[i, 1] * flat[f, 1, 0] + barycentric[i, 2] * flat[f, 2, 0]
        y = barycentric[i, 2] * flat[f, 2, 1]
        bucket = bucket_of(f, x, y, first, cells, grid)
        best = math.inf
        found = -1
        for e in range(start[bucket], start[bucket + 1]):
            if entry_least[e] >= best:
                break
            r = entry_row[e]
            d = distance_to(row_id[r, 2], row, r, x, y)
            if d < best and d <= limit[row_id[r, 1]]:
                best = d
                found = r
        if found < 0:
            continue
        r = found
        q = row_id[r, 1]
        distance[i] = best
        piece[i] = piece_of[q]
        ahead, left = place_on_curve(row_id[r, 2], row, r, tangent, q, x, y)
        along[i] = along_of[q] + ahead
        side[i] = 1 if left else -1
