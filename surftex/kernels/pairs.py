"""Rows of neighbours with their distances: sorted, and made the same seen from both ends."""

from surftex.kernels.jit import kernel, part


@kernel
def sort_rows(start, other, length):
    """Sort each row, start[i] to start[i + 1], of other (e,) int32 and with it length (e,) by other; rows are short."""
    for i in range(len(start) - 1):
        for at in range(start[i] + 1, start[i + 1]):
            who, far = other[at], length[at]
            to = at
            while to > start[i] and other[to - 1] > who:
                other[to] = other[to - 1]
                length[to] = length[to - 1]
                to -= 1
            other[to] = who
            length[to] = far


@part
def place_in_row(start, other, i, who):
    """Place of `who` in the sorted row i; -1 where it is not there."""
    low, last = start[i], start[i + 1]
    high = last
    while low < high:
        middle = (low + high) // 2
        if other[middle] < who:
            low = middle + 1
        else:
            high = middle
    return low if low < last and other[low] == who else -1


@kernel
def both_ways(start, other, length, fill, place, both_other, both_length):
    """Join rows of pairs with their mirror images: a pair known in both directions gets the mean of its lengths.

    start (s+1,) int64, other (e,) int32 sorted in each row, length (e,): a row i may list itself, which is left out.
    With fill == 0 it counts the pairs of row i into place[i + 1]; with 1, place[i] is where row i of both_other and
    both_length begins, and ends as where it ends: the rows are not sorted.
    """
    for i in range(len(start) - 1):
        for at in range(start[i], start[i + 1]):
            j = other[at]
            if j == i:
                continue
            back = place_in_row(start, other, j, i)
            if fill == 0:
                place[i + 1] += 1
                if back < 0:
                    place[j + 1] += 1
                continue
            far = length[at] if back < 0 else (length[at] + length[back]) / 2
            both_other[place[i]] = j
            both_length[place[i]] = far
            place[i] += 1
            if back < 0:
                both_other[place[j]] = i
                both_length[place[j]] = far
                place[j] += 1
