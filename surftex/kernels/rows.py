"""Rows of large tables, taken, put and told apart by number: in one pass what numpy does in several."""

import numpy as np

from surftex.kernels.jit import kernel, part

_ODD, _START, _SHIFT = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x9E3779B97F4A7C15), np.uint64(29)


@kernel
def take_samples(row, face, barycentric, footprint, face_taken, barycentric_taken, footprint_taken):
    """Take samples: row (k,) int32; face (n,) int32, barycentric (n, 3), footprint (n,) float32 -> the same, taken."""
    for i in range(len(row)):
        r = row[i]
        face_taken[i] = face[r]
        barycentric_taken[i, 0] = barycentric[r, 0]
        barycentric_taken[i, 1] = barycentric[r, 1]
        barycentric_taken[i, 2] = barycentric[r, 2]
        footprint_taken[i] = footprint[r]


@kernel
def put_rows(row, low, high, value, table):
    """Write value (k, c) into the rows row (k,) int64 of table (n, c), those from `low` to before `high` alone."""
    for i in range(len(row)):
        r = row[i]
        if low <= r < high:
            for c in range(table.shape[1]):
                table[r, c] = value[i, c]


@kernel
def repeat_rows(row, source, table):
    """Write into the rows row (k,) int64 of table (n, c) what its rows source (k,) int64 hold."""
    for i in range(len(row)):
        r = row[i]
        s = source[i]
        for c in range(table.shape[1]):
            table[r, c] = table[s, c]


@kernel
def index_rows(row, low, without, index):
    """Write into index (n,) int32 at row[i] - low, of row (k,) int64, the number i, but for those in without (k,) bool."""
    for i in range(len(row)):
        if not without[i]:
            index[row[i] - low] = i


@kernel
def sum_rows(row, table, total):
    """Add the rows row (k,) int64 of table (n, c) to total (c,) float64, one after another."""
    for c in range(table.shape[1]):
        value = 0.0
        for i in range(len(row)):
            value += table[row[i], c]
        total[c] += value


@kernel
def number_rows(word, slot, number):
    """Give equal rows equal numbers, in the order in which they first appear; returns how many there are.

    word (n, k) uint32; slot (s,) int64 of -1 to find rows in by their hash, s a power of two beyond n -> number (n,) int64.
    """
    count, last = 0, np.uint64(len(slot) - 1)
    for i in range(len(word)):
        key = _START
        for c in range(word.shape[1]):
            key = (key ^ np.uint64(word[i, c])) * _ODD
            key ^= key >> _SHIFT
        place = np.int64(key & last)
        while slot[place] >= 0 and not _equal(word, i, slot[place]):
            place = (place + 1) % len(slot)
        if slot[place] < 0:
            slot[place], number[i] = i, count
            count += 1
        else:
            number[i] = number[slot[place]]
    return count


@part
def _equal(word, i, j):
    same = True
    for c in range(word.shape[1]):
        same &= word[i, c] == word[j, c]
    return same
