"""What exact windows share: the arrays of a mesh and of a worker, the heap of windows, and the step across an edge."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from surftex.kernels.jit import part


DIRECT = np.int64(2)
"""In place of a branch: the window comes straight from a source or a corner. Typed, so that nothing compiles twice."""


class Mesh(NamedTuple):
    """The surface, read-only; see `surftex.surface.Surface`."""

    faces: NDArray[np.int32]
    neighbor: NDArray[np.int32]
    neighbor_edge: NDArray[np.int32]
    edge_length: NDArray[np.float64]
    flat: NDArray[np.float64]
    transport: NDArray[np.float64]
    corner_angle: NDArray[np.float64]
    vertex_angle: NDArray[np.float64]
    on_border: NDArray[np.bool_]
    turning: NDArray[np.bool_]  # corners that straight paths may bend around
    fan_start: NDArray[np.int64]
    fan_corner: NDArray[np.int64]
    fan_angle: NDArray[np.float64]
    wanted: NDArray[np.uint8]  # faces that need rows
    bound: NDArray[np.float64]  # a window whose least distance is not below it never enters the face


class Room(NamedTuple):
    """What one worker writes. `*_of` name the source that a value belongs to, so nothing is cleared between sources."""

    near: NDArray[np.float64]  # a path to each vertex is this long
    near_of: NDArray[np.int32]
    lit_of: NDArray[np.int32]  # vertices that have sent into their shadow
    split_near: NDArray[
        np.float64
    ]  # for each edge of a face: the least distance of the corner opposite, through it
    split_at: NDArray[np.float64]  # and where on the edge that path crosses
    split_of: NDArray[np.int32]
    count: NDArray[np.int64]  # waiting, slots used, slots free, rows, queue full, rows full
    heap_key: NDArray[np.float64]
    heap_slot: NDArray[np.int32]
    free: NDArray[np.int32]
    window: NDArray[np.float64]  # (q, 7): b0, b1 along the entry edge, image x, y, sigma, c, s
    window_id: NDArray[np.int32]  # (q, 5): face, entry edge, kind, branch taken before, primitive
    row: NDArray[np.float64]
    row_id: NDArray[np.int32]
    row_least: NDArray[np.float64]


class Light(NamedTuple):
    """What a window carries: kind, primitive, image x, y, sigma, and (c, s), all in the frame of one face."""

    kind: int
    primitive: int
    x: float
    y: float
    sigma: float
    c: float
    s: float


@part
def pop(room):
    """Take the slot with the least key off the heap."""
    heap_key, heap_slot, count = room.heap_key, room.heap_slot, room.count
    top = np.int64(heap_slot[0])
    n = count[0] - 1
    count[0] = n
    key = heap_key[n]
    slot = heap_slot[n]
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
        heap_slot[c] = heap_slot[child]
        c = child
    heap_key[c] = key
    heap_slot[c] = slot
    room.free[count[2]] = top
    count[2] += 1
    return top


@part
def store(room, key, place, edge, branch, b0, b1, light):
    """Queue a window, or with a negative kind the lighting of a corner; a full queue raises count[4]."""
    heap_key, heap_slot, count = room.heap_key, room.heap_slot, room.count
    if count[2] > 0:
        count[2] -= 1
        slot = np.int64(room.free[count[2]])
    else:
        slot = count[1]
        if slot >= len(room.free):
            count[4] = 1
            return
        count[1] += 1
    window_id, window = room.window_id, room.window
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
    c = count[0]
    while c > 0:
        parent = (c - 1) >> 1
        if heap_key[parent] <= key:
            break
        heap_key[c] = heap_key[parent]
        heap_slot[c] = heap_slot[parent]
        c = parent
    heap_key[c] = key
    heap_slot[c] = slot
    count[0] += 1


@part
def record(room, face, least, X0x, X0y, X1x, X1y, light):
    """Write a row; full rows raise count[5]."""
    n = room.count[3]
    if n >= len(room.row_least):
        room.count[5] = 1
        return
    row = room.row
    row[n, 0] = light.x
    row[n, 1] = light.y
    row[n, 2] = X0x
    row[n, 3] = X0y
    row[n, 4] = X1x
    row[n, 5] = X1y
    row[n, 6] = light.sigma
    row[n, 7] = light.c
    row[n, 8] = light.s
    room.row_least[n] = least
    room.row_id[n, 0] = face
    room.row_id[n, 1] = light.primitive
    room.row_id[n, 2] = light.kind
    room.count[3] = n + 1


@part
def reach(light, x, y):
    """Walk the straight path from the image to (x, y): its length, without sigma."""
    if light.kind == 2 or light.kind == 3:
        return (x - light.x) * light.c + (y - light.y) * light.s
    return math.sqrt((x - light.x) * (x - light.x) + (y - light.y) * (y - light.y))


@part
def enter(mesh, room, limit, face, edge, t0, t1, branch, light):
    """Queue what passes edge `edge` of `face` between t0 and t1; `light` is given in the frame of `face`."""
    other = np.int64(mesh.neighbor[face, edge])
    length = mesh.edge_length[face, edge]
    if other < 0 or not t1 - t0 > 1e-12 * length:
        return
    onward = edge + 1 if edge < 2 else 0
    px = mesh.flat[face, edge, 0]
    py = mesh.flat[face, edge, 1]
    ux = (mesh.flat[face, onward, 0] - px) / length
    uy = (mesh.flat[face, onward, 1] - py) / length
    kind, c, s = light.kind, light.c, light.s
    least_at = t0
    if kind == 2 or kind == 3:
        if ux * c + uy * s < 0:
            least_at = t1
    else:
        least_at = min(max((light.x - px) * ux + (light.y - py) * uy, t0), t1)
    key = light.sigma + max(reach(light, px + ux * least_at, py + uy * least_at), 0.0)
    if key >= limit or key >= mesh.bound[other]:
        return
    tc = mesh.transport[face, edge, 0]
    ts = mesh.transport[face, edge, 1]
    x = tc * light.x - ts * light.y + mesh.transport[face, edge, 2]
    y = ts * light.x + tc * light.y + mesh.transport[face, edge, 3]
    if kind == 0:
        c, s = c * tc + s * ts, s * tc - c * ts
    elif kind == 2 or kind == 3:
        c, s = tc * c - ts * s, ts * c + tc * s
    there = Light(kind, light.primitive, x, y, light.sigma, c, s)
    store(room, key, other, np.int64(mesh.neighbor_edge[face, edge]), branch, length - t1, length - t0, there)
