"""Buckets: square cells over large faces, one bucket for a small face, and the rows that reach each of them.

grid (m, 6): lower left corner x, y of the cells in the frame of the face, unit direction x, y of their first axis, and
cells per mm along each axis. cells (m, 2) int32: how many along each axis. first (m+1,) int64: bucket of a face's first cell.
"""

import math

from surftex.kernels.evaluate import distance_to
from surftex.kernels.jit import kernel, part


@part
def bucket_of(face, x, y, first, cells, grid):
    """Bucket of the place (x, y) in the frame of `face`."""
    columns = cells[face, 0]
    rows = cells[face, 1]
    if columns * rows == 1:
        return first[face]
    dx = x - grid[face, 0]
    dy = y - grid[face, 1]
    column = min(max(int((dx * grid[face, 2] + dy * grid[face, 3]) * grid[face, 4]), 0), columns - 1)
    line = min(max(int((dy * grid[face, 2] - dx * grid[face, 3]) * grid[face, 5]), 0), rows - 1)
    return first[face] + line * columns + column


@kernel
def buckets_of(face, barycentric, flat, first, cells, grid, bucket):
    """Bucket of each point: face (n,) int32, barycentric (n, 3) -> bucket (n,) int64."""
    for i in range(len(bucket)):
        f = face[i]
        x = barycentric[i, 1] * flat[f, 1, 0] + barycentric[i, 2] * flat[f, 2, 0]
        y = barycentric[i, 2] * flat[f, 2, 1]
        bucket[i] = bucket_of(f, x, y, first, cells, grid)


@kernel
def _lower(kind, row, r, x, y):
    """Lower bound of the row's distances, slower than (x, y): the middle of a cell may lie off the face.

    In front of the interval that is the distance itself. Behind it, where the distance jumps at the sides of
    what the interval shows, it is the length of the straight line.
    """
    front = (row[r, 4] - row[r, 2]) * (y - row[r, 3]) - (row[r, 5] - row[r, 3]) * (x - row[r, 2])
    if front >= 0 or kind == 6:
        return distance_to(kind, row, r, x, y)
    dx, dy = x - row[r, 0], y - row[r, 1]
    if kind == 2 or kind == 3:
        return abs(dx * row[r, 7] + dy * row[r, 8])
    return row[r, 6] + math.sqrt(dx * dx + dy * dy)


@kernel
def distribute(row, row_id, limit, bound, first, cells, grid, fill, entry_start, entry_row, entry_least):
    """Tell each bucket which rows come nearer to it than `limit` (of the row's primitive) and `bound` (of its face).

    With fill == 0 it counts into entry_start[bucket + 1]; with 1 it writes the entries and moves entry_start[bucket] on.
    """
    for r in range(len(row)):
        face = row_id[r, 0]
        least = row[r, 9]
        if least >= bound[face]:
            continue
        columns = cells[face, 0]
        lines = cells[face, 1]
        if columns * lines == 1:
            bucket = first[face]
            if fill == 0:
                entry_start[bucket + 1] += 1
            else:
                e = entry_start[bucket]
                entry_row[e] = r
                entry_least[e] = least
                entry_start[bucket] = e + 1
            continue
        far = limit[row_id[r, 1]]
        ox, oy, ux, uy = grid[face, 0], grid[face, 1], grid[face, 2], grid[face, 3]
        per_x, per_y = grid[face, 4], grid[face, 5]
        x0, y0 = row[r, 2] - ox, row[r, 3] - oy
        x1, y1 = row[r, 4] - ox, row[r, 5] - oy
        a0, b0 = x0 * ux + y0 * uy, y0 * ux - x0 * uy
        a1, b1 = x1 * ux + y1 * uy, y1 * ux - x1 * uy
        low_a, high_a = min(a0, a1) - (far - least), max(a0, a1) + (far - least)
        low_b, high_b = min(b0, b1) - (far - least), max(b0, b1) + (far - least)
        kind = row_id[r, 2]
        if kind <= 1 or kind == 4 or kind == 5:
            x0, y0 = row[r, 0] - ox, row[r, 1] - oy
            a0, b0 = x0 * ux + y0 * uy, y0 * ux - x0 * uy
            rest = far - row[r, 6]
            low_a, high_a = max(low_a, a0 - rest), min(high_a, a0 + rest)
            low_b, high_b = max(low_b, b0 - rest), min(high_b, b0 + rest)
        half = 0.5 * math.hypot(1.0 / per_x, 1.0 / per_y)
        for line in range(
            max(0, int(max(low_b * per_y, 0.0))), min(lines - 1, int(min(high_b * per_y, lines + 0.0))) + 1
        ):
            for column in range(
                int(max(low_a * per_x, 0.0)), min(columns - 1, int(min(high_a * per_x, columns + 0.0))) + 1
            ):
                a, b = (column + 0.5) / per_x, (line + 0.5) / per_y
                x, y = ox + a * ux - b * uy, oy + a * uy + b * ux
                nearest = max(least, _lower(kind, row, r, x, y) - half)
                if nearest < far:
                    bucket = first[face] + line * columns + column
                    if fill == 0:
                        entry_start[bucket + 1] += 1
                    else:
                        e = entry_start[bucket]
                        entry_row[e] = r
                        entry_least[e] = nearest
                        entry_start[bucket] = e + 1


@kernel
def sort_buckets(start, entry_row, entry_least):
    """Sort the entries of each bucket, start[b] to start[b+1], by (least distance, row)."""
    for b in range(len(start) - 1):
        low = start[b]
        n = start[b + 1] - low
        gap = 1
        while 9 * gap < 4 * n:
            gap = (9 * gap + 3) // 4
        while gap > 0:
            for i in range(low + gap, low + n):
                key = entry_least[i]
                item = entry_row[i]
                j = i
                while j >= low + gap and (
                    entry_least[j - gap] > key or (entry_least[j - gap] == key and entry_row[j - gap] > item)
                ):
                    entry_least[j] = entry_least[j - gap]
                    entry_row[j] = entry_row[j - gap]
                    j -= gap
                entry_least[j] = key
                entry_row[j] = item
            gap = (4 * gap) // 9
