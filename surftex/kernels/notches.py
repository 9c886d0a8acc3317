"""Notches: places of one chart that lie near each other on the page, and far apart on the surface."""

import math

from surftex.kernels.jit import kernel, part


@kernel
def mark_notches(page, place, face, chart, area, near, apart, head, chain, marked):
    """Mark the smaller face of each two samples of a chart within `near` on the page and beyond `apart` in space.

    page (n, 2), place (n, 3) float64, face (n,) int64 of the samples; chart (m,) int32, area (m,) float64 of the faces; room
    to find samples in by the hash of their cell: head (s,) int64 of -1, s a power of two, and chain (n,) int64 -> marked
    (m,) bool; of two faces as large that of the later sample. Returns whether there are any.
    """
    found = False
    for i in range(len(page)):
        f = face[i]
        column, row = math.floor(page[i, 0] / near), math.floor(page[i, 1] / near)
        for cell in range(9):
            j = head[_slot(chart[f], int(column) + cell % 3 - 1, int(row) + cell // 3 - 1, len(head))]
            while j >= 0:
                g = face[j]
                x, y = page[i, 0] - page[j, 0], page[i, 1] - page[j, 1]
                if chart[f] == chart[g] and x * x + y * y <= near * near:
                    x, y, z = place[i, 0] - place[j, 0], place[i, 1] - place[j, 1], place[i, 2] - place[j, 2]
                    if x * x + y * y + z * z > apart * apart:
                        marked[g if area[g] < area[f] else f] = True
                        found = True
                j = chain[j]
        slot = _slot(chart[f], int(column), int(row), len(head))
        chain[i], head[slot] = head[slot], i
    return found


@part
def _slot(chart, column, row, slots):
    return (chart * 73856093 ^ column * 19349663 ^ row * 83492791) & (slots - 1)
