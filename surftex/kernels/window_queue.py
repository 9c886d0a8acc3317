"""What exact windows share: the arrays of a mesh and of a worker, the heap of windows, and the step across an edge.

Mesh, read-only, made by `surftex.geodesics.packed`:

    ids (m, 3, 3) int32      vertex of corner i, neighbour across edge i, the neighbour's edge
    shape (m, 3, 9)          corner x, y; length of edge i; transport c, s, x, y across it; corner angle; angle in the fan
                             of its vertex before the corner
    turning (n,)             0, or the angle around a vertex that straight paths may bend at, negative on a border
    fan_start (n+1,) int64, fan_corner (3m,) int64      corners 3 f + i around each vertex, counter-clockwise
    wanted (m,) uint8        faces that need rows
    bound (m,)               a window whose least distance is not below it never enters the face

Worker. `*_of` name the source that a value belongs to, so nothing is cleared between sources:

    near (n,), near_of (n,) int32     a path to the vertex is this long
    lit_of (n,) int32                 vertices that have sent into their shadow
    split (3m, 2)                     for edge i of a face: least distance of the corner opposite through it, and where
    edge_of (3m, 3) int32             source of `split`; source and slot of the last window that was queued there
    count (6,) int64                  waiting, slots used, slots free, rows, queue full, rows full
    heap_key (q,), links (q, 2) int32       the heap's slots, and the free ones
    window (q, 8)                     b0, b1 along the entry edge, image x, y, sigma, c, s, key
    window_id (q, 5) int32            face, entry edge, kind, branch taken before, primitive
    row (r, 10), row_id (r, 3) int32  what is found
"""

import math
from typing import NamedTuple

import numpy as np

from surftex.kernels.jit import part

DIRECT = np.int64(2)
"""In place of a branch: the window comes straight from a source or a corner. Typed, so that nothing compiles twice."""

DEAD = -9
"""Kind of a window that was merged into another."""

SAME = 1e-10
"""Images that differ by no more than this share of the distance are one: flat parts send one window, not many."""


class Light(NamedTuple):
    """What a window carries: kind, primitive, image x, y, sigma, and (c, s), all in the frame of one face."""

    kind: int | np.integer
    primitive: int | np.integer
    x: float
    y: float
    sigma: float
    c: float
    s: float


@part
def pop(count, heap_key, links):
    """Take the slot with the least key off the heap."""
    top = np.int64(links[0, 0])
    n = count[0] - 1
    count[0] = n
    key = heap_key[n]
    slot = links[n, 0]
    c = 0
    while True:
        child = 2 * c + 1
        if child >= n:
            break
        if child + 1 < n and heap_key[child + 1] < heap_key[child]:
            child += 1
        if heap_key[child] >= key:
            break
        heap_key[c] = heap_key[child]
        links[c, 0] = links[child, 0]
        c = child
    heap_key[c] = key
    links[c, 0] = slot
    links[count[2], 1] = top
    count[2] += 1
    return top


@part
def store(count, heap_key, links, window, window_id, key, place, edge, branch, b0, b1, light):
    """Queue a window, or with a negative kind the lighting of a corner; a full queue raises count[4]."""
    if count[2] > 0:
        count[2] -= 1
        slot = np.int64(links[count[2], 1])
    else:
        slot = count[1]
        if slot >= len(heap_key):
            count[4] = 1
            return np.int64(0)
        count[1] += 1
    window_id[slot, 0] = place
    window_id[slot, 1] = edge
    window_id[slot, 2] = light.kind
    window_id[slot, 3] = branch
    window_id[slot, 4] = light.primitive
    window[slot, 0] = b0
    window[slot, 1] = b1
    window[slot, 2] = light.x
    window[slot, 3] = light.y
    window[slot, 4] = light.sigma
    window[slot, 5] = light.c
    window[slot, 6] = light.s
    window[slot, 7] = key
    c = count[0]
    while c > 0:
        parent = (c - 1) >> 1
        if heap_key[parent] <= key:
            break
        heap_key[c] = heap_key[parent]
        links[c, 0] = links[parent, 0]
        c = parent
    heap_key[c] = key
    links[c, 0] = slot
    count[0] += 1
    return slot


@part
def record(count, row, row_id, face, least, X0x, X0y, X1x, X1y, light):
    """Write a row; full rows raise count[5]."""
    n = count[3]
    if n >= len(row):
        count[5] = 1
        return
    row[n, 0] = light.x
    row[n, 1] = light.y
    row[n, 2] = X0x
    row[n, 3] = X0y
    row[n, 4] = X1x
    row[n, 5] = X1y
    row[n, 6] = light.sigma
    row[n, 7] = light.c
    row[n, 8] = light.s
    row[n, 9] = least
    row_id[n, 0] = face
    row_id[n, 1] = light.primitive
    row_id[n, 2] = light.kind
    count[3] = n + 1


@part
def reach(light, x, y):
    """Walk the straight path from the image to (x, y): its length, without sigma."""
    if light.kind == 2 or light.kind == 3:
        return (x - light.x) * light.c + (y - light.y) * light.s
    return math.sqrt((x - light.x) * (x - light.x) + (y - light.y) * (y - light.y))


@part
def enter(
    ids, shape, bound, edge_of, count, heap_key, links, window, window_id, source, limit, face, edge, t0, t1, branch, light
):  # fmt: skip
    """Queue what passes edge `edge` of `face` between t0 and t1; `light` is given in the frame of `face`."""
    other = np.int64(ids[face, edge, 1])
    length = shape[face, edge, 2]
    if other < 0 or not t1 - t0 > 1e-12 * length:
        return
    onward = edge + 1 if edge < 2 else 0
    px = shape[face, edge, 0]
    py = shape[face, edge, 1]
    ux = (shape[face, onward, 0] - px) / length
    uy = (shape[face, onward, 1] - py) / length
    kind, c, s = light.kind, light.c, light.s
    least_at = t0
    if kind == 2 or kind == 3:
        if ux * c + uy * s < 0:
            least_at = t1
    else:
        least_at = min(max((light.x - px) * ux + (light.y - py) * uy, t0), t1)
    key = light.sigma + max(reach(light, px + ux * least_at, py + uy * least_at), 0.0)
    if key >= limit or key >= bound[other]:
        return
    tc = shape[face, edge, 3]
    ts = shape[face, edge, 4]
    x = tc * light.x - ts * light.y + shape[face, edge, 5]
    y = ts * light.x + tc * light.y + shape[face, edge, 6]
    if kind == 0:
        c, s = c * tc + s * ts, s * tc - c * ts
    elif kind == 2 or kind == 3:
        c, s = tc * c - ts * s, ts * c + tc * s
    entry = np.int64(ids[face, edge, 2])
    b0, b1 = length - t1, length - t0
    h = 3 * other + entry
    if edge_of[h, 1] == source:
        p = np.int64(edge_of[h, 2])
        alike = window_id[p, 0] == other and window_id[p, 1] == entry and window_id[p, 2] == kind
        alike = alike and window_id[p, 4] == light.primitive and window[p, 4] == light.sigma
        alike = alike and abs(window[p, 2] - x) <= SAME * key and abs(window[p, 3] - y) <= SAME * key
        alike = alike and abs(window[p, 5] - c) <= SAME and abs(window[p, 6] - s) <= SAME
        if alike and b0 <= window[p, 1] + 1e-9 * length and window[p, 0] <= b1 + 1e-9 * length:
            b0, b1 = min(b0, window[p, 0]), max(b1, window[p, 1])
            if key >= window[p, 7]:
                window[p, 0] = b0
                window[p, 1] = b1
                window_id[p, 3] = DIRECT
                return
            window_id[p, 2] = DEAD
            branch = DIRECT
    there = Light(kind, light.primitive, x, y, light.sigma, c, s)
    slot = store(count, heap_key, links, window, window_id, key, other, entry, branch, b0, b1, there)
    edge_of[h, 1] = source
    edge_of[h, 2] = slot
