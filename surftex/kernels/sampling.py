"""Exclusive regions of sites: which darts hit one, and which pieces of faces lie wholly inside one.

A site's exclusive region is the ellipse in its log map that `whiten` turns into the unit disc; the log
vector is that of the shortest path. Rows and entries are those of `surftex.kernels.windows` and `gather`;
kernels read one flood, and callers go through several.
"""

import math

import numpy as np

from surftex.kernels.evaluate import distance_to, leaving_direction
from surftex.kernels.jit import kernel, part


@kernel
def _norm(kind, row, r, x, y, distance, s, whiten, axis):
    """Norm, 1 on the border of the region of source s, of the log vector of (x, y) through row r."""
    if axis[s, 0] == axis[s, 1]:
        return distance / axis[s, 1]
    c, d = leaving_direction(kind, row, r, x, y)
    return distance * math.hypot(whiten[s, 0] * c + whiten[s, 1] * d, whiten[s, 2] * c + whiten[s, 3] * d)


@part
def _beyond(kind, row, r, x, y, far):
    """Whether even the straight line through row r, that of a point source, is longer than `far`."""
    if kind > 1:
        return False
    dx, dy, left = x - row[r, 0], y - row[r, 1], far - row[r, 6]
    return left <= 0.0 or dx * dx + dy * dy > left * left * (1.0 + 1e-12)


@kernel
def excluded_darts(begin, end, bucket, flat, start, entry_row, row, row_id, source_of, whiten, axis, out):
    """Mark those of the darts [begin, end) that lie in an exclusive region.

    bucket (n,) int64, flat (n, 2): darts in the frame of their face; whiten (s, 4), axis (s, 2): the map that
    makes a source's region the unit disc, and its semi-axes; out (n,) uint8: set to 1, never cleared.
    """
    for i in range(begin, end):
        if out[i]:
            continue
        first, last = start[bucket[i]], start[bucket[i] + 1]
        x, y = flat[i, 0], flat[i, 1]
        for e in range(first, last):
            r = entry_row[e]
            s = source_of[row_id[r, 1]]
            if _beyond(row_id[r, 2], row, r, x, y, axis[s, 0]):
                continue
            distance = distance_to(row_id[r, 2], row, r, x, y)
            if distance >= axis[s, 0]:
                continue
            if distance >= axis[s, 1]:
                if _norm(row_id[r, 2], row, r, x, y, distance, s, whiten, axis) >= 1:
                    continue
                shortest = True
                for other in range(first, last):
                    q = entry_row[other]
                    if source_of[row_id[q, 1]] == s and q != r:
                        shortest &= distance_to(row_id[q, 2], row, q, x, y) >= distance
                if not shortest:
                    continue
            out[i] = 1
            break


@kernel
def _outside(row, r, x, y):
    """Distance of (x, y) from the sides of the wedge that row r sees; 0 inside."""
    dx, dy = x - row[r, 0], y - row[r, 1]
    ux, uy = row[r, 2] - row[r, 0], row[r, 3] - row[r, 1]
    beyond = ux * dy - uy * dx
    if beyond > 0:
        return beyond / math.sqrt(ux * ux + uy * uy)
    ux, uy = row[r, 4] - row[r, 0], row[r, 5] - row[r, 1]
    beyond = uy * dx - ux * dy
    if beyond > 0:
        return beyond / math.sqrt(ux * ux + uy * uy)
    return 0.0


@kernel
def _straight_log(kind, row, r, x, y):
    """Length and log vector of (x, y) through row r as if the interval did not end: an isometry."""
    dx, dy = x - row[r, 0], y - row[r, 1]
    length = row[r, 6] + math.sqrt(dx * dx + dy * dy)
    c, s = row[r, 7], row[r, 8]
    if kind == 1:
        return length, length * c, length * s
    return length, c * dx - s * dy, s * dx + c * dy


@kernel
def covered_pieces(begin, end, bucket, corner, start, entry_row, row, row_id, source_of, whiten, axis, out):
    """Classify pieces [begin, end) of faces: 0 no region touches it, 1 one may, 2 it is surely inside one.

    bucket (n,) int64; corner (n, 3, 2): in the frame of the face, none leaves its bucket; whiten, axis as for
    `excluded_darts`; out (n,) uint8: raised, never lowered.

    The log vector moves by no more than the point does as long as one row is the shortest, so a region
    holds a piece if it holds the middle, with a margin of the piece's radius, through every row of its
    source that sees some of the piece and may be the shortest there.
    """
    for i in range(begin, end):
        if out[i] == 2:
            continue
        first, last = start[bucket[i]], start[bucket[i] + 1]
        if first == last:
            continue
        x = (corner[i, 0, 0] + corner[i, 1, 0] + corner[i, 2, 0]) / 3
        y = (corner[i, 0, 1] + corner[i, 1, 1] + corner[i, 2, 1]) / 3
        square = 0.0
        for j in range(3):
            square = max(square, (corner[i, j, 0] - x) ** 2 + (corner[i, j, 1] - y) ** 2)
        radius = math.sqrt(square)
        for e in range(first, last):
            r = entry_row[e]
            s = source_of[row_id[r, 1]]
            if _beyond(row_id[r, 2], row, r, x, y, axis[s, 0] + radius):
                continue
            distance = distance_to(row_id[r, 2], row, r, x, y)
            if distance >= axis[s, 0] + radius:
                continue
            out[i] = max(out[i], 1)
            if distance + radius <= axis[s, 1]:
                out[i] = 2
                break
            margin = 1 - radius / axis[s, 1]
            if distance + radius > axis[s, 0] or _outside(row, r, x, y) > 0:
                continue
            inside = True
            for other in range(first, last):
                q = entry_row[other]
                if inside and source_of[row_id[q, 1]] == s and _outside(row, q, x, y) <= radius:
                    length, u, v = _straight_log(row_id[q, 2], row, q, x, y)
                    if length < distance + 2 * radius:
                        inside = math.hypot(whiten[s, 0] * u + whiten[s, 1] * v,
                                            whiten[s, 2] * u + whiten[s, 3] * v) <= margin  # fmt: skip
            if inside:
                out[i] = 2
                break


@kernel
def disputed_darts(position, reach, key, dart, stride, out):
    """Mark the darts that an earlier one may reach: position (n, 3), reach (n,), ascending in time.

    key (n,) int64: sorted numbers of cells, no smaller than any reach, of a grid in which neighbours along
    x, y, z differ by stride[0], stride[1] and 1; dart (n,) int64: the dart of each; out (n,) uint8: 0 or 1.
    """
    for k in range(len(key)):
        i = dart[k]
        for column in range(9):
            corner = key[k] + (column // 3 - 1) * stride[0] + (column % 3 - 1) * stride[1] - 1
            if out[i]:
                break
            for other in range(np.searchsorted(key, corner), len(key)):
                if key[other] > corner + 2:
                    break
                j = dart[other]
                if j < i:
                    x, y = position[i, 0] - position[j, 0], position[i, 1] - position[j, 1]
                    z = position[i, 2] - position[j, 2]
                    if x * x + y * y + z * z <= reach[j] * reach[j]:
                        out[i] = 1
                        break


@kernel
def measure_pieces(corner, area, radius):
    """Area of each piece, and how far its corners lie from its middle: (n, 3, 2) -> (n,), (n,)."""
    for i in range(len(corner)):
        x = (corner[i, 0, 0] + corner[i, 1, 0] + corner[i, 2, 0]) / 3
        y = (corner[i, 0, 1] + corner[i, 1, 1] + corner[i, 2, 1]) / 3
        square = 0.0
        for j in range(3):
            square = max(square, (corner[i, j, 0] - x) ** 2 + (corner[i, j, 1] - y) ** 2)
        radius[i] = math.sqrt(square)
        ax, ay = corner[i, 1, 0] - corner[i, 0, 0], corner[i, 1, 1] - corner[i, 0, 1]
        bx, by = corner[i, 2, 0] - corner[i, 0, 0], corner[i, 2, 1] - corner[i, 0, 1]
        area[i] = 0.5 * abs(ax * by - ay * bx)


@kernel
def split_pieces(corner, child_corner):
    """Cut every piece into four at the middles of its sides: corner (n, 3, 2) -> child_corner (4n, 3, 2)."""
    for i in range(len(corner)):
        for axis in range(2):
            a, b, c = corner[i, 0, axis], corner[i, 1, axis], corner[i, 2, axis]
            ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
            child_corner[4 * i, 0, axis] = a
            child_corner[4 * i, 1, axis] = ab
            child_corner[4 * i, 2, axis] = ca
            child_corner[4 * i + 1, 0, axis] = ab
            child_corner[4 * i + 1, 1, axis] = b
            child_corner[4 * i + 1, 2, axis] = bc
            child_corner[4 * i + 2, 0, axis] = ca
            child_corner[4 * i + 2, 1, axis] = bc
            child_corner[4 * i + 2, 2, axis] = c
            child_corner[4 * i + 3, 0, axis] = ab
            child_corner[4 * i + 3, 1, axis] = bc
            child_corner[4 * i + 3, 2, axis] = ca


@kernel
def _cut(polygon, count, target, nx, ny, offset):
    """Part of a convex polygon where nx x + ny y >= offset; returns its number of corners."""
    kept = 0
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        here = nx * polygon[i, 0] + ny * polygon[i, 1] - offset
        there = nx * polygon[j, 0] + ny * polygon[j, 1] - offset
        if here >= 0:
            target[kept, 0] = polygon[i, 0]
            target[kept, 1] = polygon[i, 1]
            kept += 1
        if (here > 0 and there < 0) or (here < 0 and there > 0):
            share = here / (here - there)
            target[kept, 0] = polygon[i, 0] + share * (polygon[j, 0] - polygon[i, 0])
            target[kept, 1] = polygon[i, 1] + share * (polygon[j, 1] - polygon[i, 1])
            kept += 1
    return kept


@kernel
def cell_pieces(flat, first, cells, grid, fill, polygon, other, bucket, face, corner):
    """Cut every face into triangles that leave no bucket; returns their number.

    flat (m, 3, 2); first, cells, grid as in `surftex.kernels.buckets`; polygon, other (8, 2): scratch. With
    fill 1 they go to bucket (n,) int64, face (n,) int32 and corner (n, 3, 2).
    """
    count = 0
    for f in range(len(cells)):
        for line in range(cells[f, 1]):
            for column in range(cells[f, 0]):
                for i in range(3):
                    polygon[i, 0] = flat[f, i, 0]
                    polygon[i, 1] = flat[f, i, 1]
                size = 3
                if cells[f, 0] * cells[f, 1] > 1:
                    ux, uy = grid[f, 2], grid[f, 3]
                    a = ux * grid[f, 0] + uy * grid[f, 1]
                    b = ux * grid[f, 1] - uy * grid[f, 0]
                    size = _cut(polygon, size, other, ux, uy, a + column / grid[f, 4])
                    size = _cut(other, size, polygon, -ux, -uy, -a - (column + 1) / grid[f, 4])
                    size = _cut(polygon, size, other, -uy, ux, b + line / grid[f, 5])
                    size = _cut(other, size, polygon, uy, -ux, -b - (line + 1) / grid[f, 5])
                for i in range(2, size):
                    if fill == 1:
                        bucket[count] = first[f] + line * cells[f, 0] + column
                        face[count] = f
                        for axis in range(2):
                            corner[count, 0, axis] = polygon[0, axis]
                            corner[count, 1, axis] = polygon[i - 1, axis]
                            corner[count, 2, axis] = polygon[i, axis]
                    count += 1
    return count
