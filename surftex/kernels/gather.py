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

RUN = 64
"""Most samples of one face that are asked together; a power of 2, and of `LANES`."""

LANES = 8
"""Samples that processors compute at once."""

PLAN = 64
"""Most rows that a run is asked of together."""

MOST = 8
"""Most sources of which a run is asked together; a power of 2."""

LANE = (5 + MOST) * RUN
"""Numbers of scratch, in rows of `RUN`: places x and y of a run, distances to one source, those to the k nearest, and
places of the samples of a face."""

RANK = (3 + MOST) * RUN + 2 * PLAN
"""Whole numbers of scratch: where in the plan those distances came from; samples of a run, and buckets, of the samples
of a face; the plan itself, rows and sources."""

_X, _Y, _NEW, _PLACE = 0, RUN, 2 * RUN, (3 + MOST) * RUN
_SAMPLE, _BUCKET, _PLANNED, _OWNER = (
    (1 + MOST) * RUN,
    (2 + MOST) * RUN,
    (3 + MOST) * RUN,
    (3 + MOST) * RUN + PLAN,
)


@part
def nearest_few(
    x, y, bucket, start, entry_row, entry_least, row, row_id, source_of, limit, i, source, distance, found
):
    """Find the k nearest sources of the place (x, y) into row i of source, distance and found, the rows of records.

    Of sources that are equally far the lower number comes first.
    """
    k = source.shape[1]
    for q in range(k):
        source[i, q], distance[i, q], found[i, q] = -1, math.inf, -1
    for e in range(start[bucket], start[bucket + 1]):
        worst = distance[i, k - 1]
        if entry_least[e] > worst * (1.0 + 1e-9):
            break
        r = entry_row[e]
        kind = row_id[r, 2]
        if kind <= 1:
            dx, dy, left = x - row[r, 0], y - row[r, 1], worst - row[r, 6]
            if left < 0.0 or dx * dx + dy * dy > left * left * (1.0 + 1e-12):
                continue
        d = distance_to(kind, row, r, x, y)
        if d > worst or d > limit[row_id[r, 1]]:
            continue
        who = source_of[row_id[r, 1]]
        at = k - 1
        for q in range(k):
            if source[i, q] == who:
                at = q
                break
        if d > distance[i, at] or (d == distance[i, at] and who >= source[i, at]):
            continue
        while at > 0 and (distance[i, at - 1] > d or (distance[i, at - 1] == d and source[i, at - 1] > who)):
            distance[i, at] = distance[i, at - 1]
            source[i, at] = source[i, at - 1]
            found[i, at] = found[i, at - 1]
            at -= 1
        distance[i, at] = d
        source[i, at] = who
        found[i, at] = r


@part
def room_left(row_id, limit, i, distance, found):
    """How far the place of row i may move without leaving the radius of what was found; 0 where that is fewer than k."""
    room = math.inf
    if found[i, found.shape[1] - 1] < 0:
        return 0.0
    for q in range(found.shape[1]):
        room = min(room, limit[row_id[found[i, q], 1]] - distance[i, q])
    return room


@part
def _plan(x, y, bound, far, begin, end, entry_row, entry_least, row, row_id, source_of, rank):
    """Choose the rows among entries begin to end that come nearer than `bound`, and to (x, y) than `far`, by source.

    Returns their number, -1 if they are too many.
    """
    n = 0
    for e in range(begin, end):
        if entry_least[e] > bound:
            break
        r = entry_row[e]
        if distance_to(row_id[r, 2], row, r, x, y) > far:
            continue
        if n == PLAN:
            return -1
        who = source_of[row_id[r, 1]]
        at = n
        while at > 0 and rank[_OWNER + at - 1] > who:
            rank[_OWNER + at] = rank[_OWNER + at - 1]
            rank[_PLANNED + at] = rank[_PLANNED + at - 1]
            at -= 1
        rank[_OWNER + at] = who
        rank[_PLANNED + at] = r
        n += 1
    return n


@part
def _measure(j, n, row, r, most, lane, rank):
    """Measure row r, the j-th of the plan, at n samples; keep what is nearer than other rows of its source."""
    ix, iy, ax, ay, bx, by, sigma = (
        row[r, 0],
        row[r, 1],
        row[r, 2],
        row[r, 3],
        row[r, 4],
        row[r, 5],
        row[r, 6],
    )
    ux, uy, wx, wy = ax - ix, ay - iy, bx - ix, by - iy
    around_a, around_b = sigma + math.sqrt(ux * ux + uy * uy), sigma + math.sqrt(wx * wx + wy * wy)
    for t in range(n):
        x, y = lane[_X + t], lane[_Y + t]
        dx, dy = x - ix, y - iy
        left, right = ux * dy - uy * dx > 0, wx * dy - wy * dx < 0
        before = around_b if right else sigma
        ex, ey = bx if right else ix, by if right else iy
        before = around_a if left else before
        ex, ey = ax if left else ex, ay if left else ey
        d = before + math.sqrt((x - ex) * (x - ex) + (y - ey) * (y - ey))
        d = d if d <= most else math.inf
        nearer = d < lane[_NEW + t]
        lane[_NEW + t] = d if nearer else lane[_NEW + t]
        rank[t] = j if nearer else rank[t]


@part
def _rank(k, n, lane, rank):
    """Put what was measured of one source in its place among the k nearest of n samples."""
    for q in range(k - 1, -1, -1):
        at = RUN + (q & (MOST - 1)) * RUN
        ahead = max(at - RUN, RUN)
        for t in range(n):
            new, there, before = lane[_NEW + t], lane[_NEW + at + t], lane[_NEW + ahead + t]
            new_row, there_row, before_row = rank[t], rank[at + t], rank[ahead + t]
            moves, comes = q > 0 and new < before, new < there
            here = new if comes else there
            here_row = new_row if comes else there_row
            lane[_NEW + at + t] = before if moves else here
            rank[at + t] = before_row if moves else here_row


@part
def _ask_run(
    n,
    to,
    bucket,
    start,
    entry_row,
    entry_least,
    row,
    row_id,
    source_of,
    limit,
    lane,
    rank,
    source,
    distance,
    found,
):
    """Find the k nearest sources of a run of n samples in one bucket.

    Rows that no sample of the run needs are found by the middle of the run: no distance changes by more than a place
    moves, and nor does the k-th, unless a source's radius ends on the way.
    """
    k = source.shape[1]
    middle_x, middle_y, reach = 0.0, 0.0, 0.0
    for t in range(n):
        middle_x += lane[_X + t]
        middle_y += lane[_Y + t]
    middle_x /= n
    middle_y /= n
    for t in range(n):
        reach = max(reach, (lane[_X + t] - middle_x) ** 2 + (lane[_Y + t] - middle_y) ** 2)
    reach = math.sqrt(reach)
    first = to + rank[_SAMPLE]
    nearest_few(
        middle_x, middle_y, bucket, start, entry_row, entry_least, row, row_id, source_of, limit, first, source,
        distance, found,
    )  # fmt: skip
    if n == 1:
        return
    planned = -1
    if k <= MOST:
        bound = (distance[first, k - 1] + reach) * (1.0 + 1e-9)
        if room_left(row_id, limit, first, distance, found) <= reach:
            bound = math.inf
        planned = _plan(
            middle_x, middle_y, bound, bound + reach, start[bucket], start[bucket + 1], entry_row, entry_least, row,
            row_id, source_of, rank,
        )  # fmt: skip
    if planned < 0:
        for t in range(n):
            nearest_few(
                lane[_X + t], lane[_Y + t], bucket, start, entry_row, entry_least, row, row_id, source_of, limit,
                to + rank[_SAMPLE + t], source, distance, found,
            )  # fmt: skip
        return
    whole = (n + LANES - 1) // LANES * LANES
    for q in range(k):
        for t in range(whole):
            lane[_NEW + (1 + q) * RUN + t] = math.inf
            rank[(1 + q) * RUN + t] = -1
    j, sources = 0, 0
    while j < planned:
        who = rank[_OWNER + j]
        sources += 1
        for t in range(whole):
            lane[_NEW + t] = math.inf
        while j < planned and rank[_OWNER + j] == who:
            r = rank[_PLANNED + j]
            _measure(j, whole, row, r, limit[row_id[r, 1]], lane, rank)
            j += 1
        _rank(min(k, sources), whole, lane, rank)
    for t in range(n):
        i = to + rank[_SAMPLE + t]
        for q in range(k):
            at = rank[(1 + q) * RUN + t]
            distance[i, q] = lane[_NEW + (1 + q) * RUN + t]
            source[i, q] = rank[_OWNER + at] if at >= 0 else -1
            found[i, q] = rank[_PLANNED + at] if at >= 0 else -1


@part
def nearest_on_face(
    begin, end, to, face, barycentric, flat, first, cells, grid, start, entry_row, entry_least, row, row_id, source_of,
    limit, lane, rank, source, distance, found,
):  # fmt: skip
    """Find the k nearest sources of the samples from `begin` on that lie on one face, before `end` and at most `RUN`.

    The last three arrays get them in rows `to` and on. Returns the end of the samples.
    """
    f = face[begin]
    n = 0
    while begin + n < end and n < RUN and face[begin + n] == f:
        x = barycentric[begin + n, 1] * flat[f, 1, 0] + barycentric[begin + n, 2] * flat[f, 2, 0]
        y = barycentric[begin + n, 2] * flat[f, 2, 1]
        lane[_PLACE + n] = x
        lane[_PLACE + RUN + n] = y
        rank[_BUCKET + n] = bucket_of(f, x, y, first, cells, grid)
        n += 1
    done = 0
    while done < n:
        bucket, run = np.int64(-1), 0
        for t in range(n):
            if rank[_BUCKET + t] >= 0 and (run == 0 or rank[_BUCKET + t] == bucket):
                bucket = rank[_BUCKET + t]
                rank[_BUCKET + t] = -1
                rank[_SAMPLE + run] = t
                lane[_X + run] = lane[_PLACE + t]
                lane[_Y + run] = lane[_PLACE + RUN + t]
                run += 1
        _ask_run(
            run, to, bucket, start, entry_row, entry_least, row, row_id, source_of, limit, lane, rank, source, distance,
            found,
        )  # fmt: skip
        done += run
    return begin + n


@kernel
def nearest_sources(
    begin, end, face, barycentric, flat, first, cells, grid, start, entry_row, entry_least, row, row_id,
    source_of, limit, lane, rank, source, distance, found,
):  # fmt: skip
    """Find the k nearest sources of samples [begin, end).

    lane (LANE,) float64, rank (RANK,) int64: scratch.
    -> source (n, k) int32, -1 for none, distance (n, k), inf for none, and found (n, k) int32, the row, -1 for none.
    """
    while begin < end:
        begin = nearest_on_face(
            begin, end, begin, face, barycentric, flat, first, cells, grid, start, entry_row, entry_least, row, row_id,
            source_of, limit, lane, rank, source, distance, found,
        )  # fmt: skip


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
def nearest_places(
    begin, end, face, barycentric, flat, first, cells, grid, start, entry_row, entry_least, row, row_id,
    source_of, limit, piece_of, along_of, tangent, piece, distance, along, side,
):  # fmt: skip
    """Find the nearest place on each of the k nearest curves for samples [begin, end).

    source_of (p,) int32: the curve of each primitive; piece_of (p,) int32, along_of (p,), tangent (p, 2): of each primitive.
    piece (n, k) int32 is given as -1, distance (n, k) as inf, along (n, k) and side (n, k) int8 as 0.
    """
    k = piece.shape[1]
    for i in range(begin, end):
        f = face[i]
        x = barycentric[i, 1] * flat[f, 1, 0] + barycentric[i, 2] * flat[f, 2, 0]
        y = barycentric[i, 2] * flat[f, 2, 1]
        bucket = bucket_of(f, x, y, first, cells, grid)
        for e in range(start[bucket], start[bucket + 1]):
            if entry_least[e] >= distance[i, k - 1]:
                break
            r = entry_row[e]
            d = distance_to(row_id[r, 2], row, r, x, y)
            if d >= distance[i, k - 1] or d > limit[row_id[r, 1]]:
                continue
            at = k - 1
            for q in range(k - 1):
                if piece[i, q] >= 0 and source_of[row_id[piece[i, q], 1]] == source_of[row_id[r, 1]]:
                    at = q
                    break
            if d >= distance[i, at]:
                continue
            while at > 0 and distance[i, at - 1] > d:
                distance[i, at] = distance[i, at - 1]
                piece[i, at] = piece[i, at - 1]
                at -= 1
            distance[i, at] = d
            piece[i, at] = r  # its row, until all are found
        for q in range(k):
            r = piece[i, q]
            if r < 0:
                break
            primitive = row_id[r, 1]
            piece[i, q] = piece_of[primitive]
            ahead, left = place_on_curve(row_id[r, 2], row, r, tangent, primitive, x, y)
            along[i, q] = along_of[primitive] + ahead
            side[i, q] = 1 if left else -1
