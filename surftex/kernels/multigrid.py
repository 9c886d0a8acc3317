"""Multigrid on the equations of a field: vertices gathered to aggregates, and sweeps that even out what is left.

Shared arguments: start (n+1,), other (e,) int32, entry (e,) complex128: the rows of a Hermitian matrix, each in the order of
its columns; middle (n,) int32, scale (n,) float64: where each diagonal stands, and one by it.
"""

import math

import numpy as np

from surftex.kernels.jit import kernel, part

STRONG = 0.15
"""Share of the largest entries beside the diagonal, of both, from which on two vertices hang together."""

DAMPING = 2 / 3
"""Of the Jacobi step that smooths the interpolation; entries of a row by its diagonal add up to 2 at most."""

HUB = 64
"""Neighbours beyond which the interpolation to a vertex, such as the apex of a fan, is not smoothed: all would join all."""


@part
def _square(number):
    """Square of the size of a complex number."""
    return number.real * number.real + number.imag * number.imag


@part
def _strong(v, e, other, entry, largest):
    """Whether entry e of row v joins the vertex to another that it hangs together with."""
    w, square = other[e], _square(entry[e])
    return w != v and square * square > STRONG**4 * (largest[v] * largest[w])


@kernel
def aggregate(start, other, entry, middle, scale, largest, owner, turn):
    """Gather each vertex that has no neighbour in an aggregate with its neighbours, then the others to the strongest beside.

    -> middle, scale; largest (n,) float64: square of the largest entry beside the diagonal; owner (n,) int32: aggregate of each
    vertex; turn (n,) complex128: unit number that carries the aggregate's value to it. Returns the number of aggregates.

    Vaněk, Mandel, Brezina. Algebraic Multigrid by Smoothed Aggregation for Second and Fourth Order Elliptic Problems (1996).
    """
    n = len(owner)
    for v in range(n):
        owner[v], turn[v] = -1, 1.0
        most = 0.0
        for e in range(start[v], start[v + 1]):
            if other[e] != v:
                most = max(most, _square(entry[e]))
            else:
                middle[v], scale[v] = e, 1 / entry[e].real
        largest[v] = most
    count = 0
    for v in range(n):
        free = owner[v] < 0
        for e in range(start[v], start[v + 1] if free else start[v]):
            if owner[other[e]] >= 0 and _strong(v, e, other, entry, largest):
                free = False
                break
        if not free:
            continue
        owner[v] = count
        for e in range(start[v], start[v + 1]):
            if _strong(v, e, other, entry, largest):
                owner[other[e]] = count
                turn[other[e]] = -entry[e].conjugate() / abs(entry[e])
        count += 1
    for v in range(n):
        if owner[v] >= 0:
            continue
        best, at = 0.0, 0
        for e in range(start[v], start[v + 1]):
            if owner[other[e]] >= 0 and _square(entry[e]) > best:
                best, at = _square(entry[e]), e
        owner[v] = -2 - owner[other[at]]  # marked as one that comes in this pass
        turn[v] = -entry[at] / math.sqrt(best) * turn[other[at]]
    for v in range(n):
        if owner[v] < 0:
            owner[v] = -2 - owner[v]
    return count


@kernel
def interpolate(start, other, entry, scale, largest, owner, turn, slot, row_start, column, value):
    """Carry the values of aggregates to their vertices, then relax them once by Jacobi among what hangs together.

    largest, owner, turn as from `aggregate`; slot (aggregates,) int32 given as -1: room to work in
    -> row_start (n+1,), column (n+e,) int32, value (n+e,) complex128: rows of the interpolation. Returns their entries.
    """
    k = 0
    for v in range(len(owner)):
        first = k
        slot[owner[v]] = k
        column[k], value[k] = owner[v], turn[v]
        k += 1
        if start[v + 1] - start[v] <= HUB:
            kept = 1 / scale[v]
            for e in range(start[v], start[v + 1]):
                if other[e] != v and not _strong(v, e, other, entry, largest):
                    kept -= abs(entry[e])
            damping = DAMPING / max(kept, 0.5 / scale[v])
            value[k - 1] -= damping * kept * turn[v]
            for e in range(start[v], start[v + 1]):
                if _strong(v, e, other, entry, largest):
                    a = owner[other[e]]
                    if slot[a] < first:
                        slot[a] = k
                        column[k], value[k] = a, 0.0
                        k += 1
                    value[slot[a]] -= damping * entry[e] * turn[other[e]]
        row_start[v + 1] = k
    return k


@kernel
def sweep_down(start, middle, other, entry, scale, right, value, left):
    """Solve for each vertex in turn, from the first to the last, beginning with 0.

    right (n,) complex128 -> value (n,) complex128; left (n,) complex128: what is left of the right-hand side.
    """
    for v in range(len(scale)):
        real, imag = right[v].real, right[v].imag
        for e in range(start[v], middle[v]):
            a, b = entry[e], value[np.uint32(other[e])]
            real -= a.real * b.real - a.imag * b.imag
            imag -= a.real * b.imag + a.imag * b.real
        value[v] = complex(real * scale[v], imag * scale[v])
    for v in range(len(scale)):
        real, imag = 0.0, 0.0
        for e in range(middle[v] + 1, start[v + 1]):
            a, b = entry[e], value[np.uint32(other[e])]
            real -= a.real * b.real - a.imag * b.imag
            imag -= a.real * b.imag + a.imag * b.real
        left[v] = complex(real, imag)


@kernel
def sweep_up(start, other, entry, scale, right, value):
    """Solve for each vertex in turn, from the last to the first, beginning with what is there: value (n,) complex128."""
    for v in range(len(scale) - 1, -1, -1):
        real, imag = right[v].real, right[v].imag
        for e in range(start[v], start[v + 1]):
            a, b = entry[e], value[np.uint32(other[e])]
            real -= a.real * b.real - a.imag * b.imag
            imag -= a.real * b.imag + a.imag * b.real
        value[v] += complex(real * scale[v], imag * scale[v])
