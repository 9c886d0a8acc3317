"""Upper bounds of the distance to the k nearest sources, at every vertex, by walks along edges."""

import math

import numpy as np

from surftex.kernels.jit import kernel, part


@part
def _offer(label, length, waiting, heap_key, heap_item, vertex, source, distance):
    """Note a walk to a vertex if it is among the k shortest from different sources, and queue it; the queue's length."""
    k = label.shape[1]
    if distance >= length[vertex, k - 1]:
        return waiting
    at = k - 1
    for q in range(k):
        if label[vertex, q] == source:
            if length[vertex, q] <= distance:
                return waiting
            at = q
            break
    while at > 0 and length[vertex, at - 1] > distance:
        length[vertex, at] = length[vertex, at - 1]
        label[vertex, at] = label[vertex, at - 1]
        at -= 1
    length[vertex, at] = distance
    label[vertex, at] = source
    if waiting >= len(heap_key):
        return waiting + 1
    c = waiting
    while c > 0:
        parent = (c - 1) >> 1
        if heap_key[parent] <= distance:
            break
        heap_key[c] = heap_key[parent]
        heap_item[c, 0] = heap_item[parent, 0]
        heap_item[c, 1] = heap_item[parent, 1]
        c = parent
    heap_key[c] = distance
    heap_item[c, 0] = vertex
    heap_item[c, 1] = source
    return waiting + 1


@kernel
def nearest_labels(
    face, place, faces, flat, corner_start, corner_of, edge_length, heap_key, heap_item, label, length,
):  # fmt: skip
    """Walk from sources along edges until every vertex knows the k nearest of them.

    face (s,) int32, place (s, 2) in the frame of the face; corner_start (n+1,), corner_of (3m,): corners 3 f + i
    around each vertex. heap_key (h,), heap_item (h, 2) int32: room for the walks under way.
    -> label (n, k) int32, given as -1, length (n, k) ascending, given as inf.
    Returns 1 if the room was too small, else 0.
    """
    waiting = 0
    for source in range(len(face)):
        f = face[source]
        for i in range(3):
            dx, dy = flat[f, i, 0] - place[source, 0], flat[f, i, 1] - place[source, 1]
            waiting = _offer(
                label, length, waiting, heap_key, heap_item, faces[f, i], source, math.sqrt(dx * dx + dy * dy)
            )
            if waiting > len(heap_key):
                return 1
    while waiting > 0:
        d = heap_key[0]
        v = heap_item[0, 0]
        source = np.int64(heap_item[0, 1])
        waiting -= 1
        key = heap_key[waiting]
        item0, item1 = heap_item[waiting, 0], heap_item[waiting, 1]
        c = 0
        while True:
            child = 2 * c + 1
            if child >= waiting:
                break
            if child + 1 < waiting and heap_key[child + 1] < heap_key[child]:
                child += 1
            if heap_key[child] >= key:
                break
            heap_key[c] = heap_key[child]
            heap_item[c, 0] = heap_item[child, 0]
            heap_item[c, 1] = heap_item[child, 1]
            c = child
        heap_key[c] = key
        heap_item[c, 0] = item0
        heap_item[c, 1] = item1
        current = False
        for q in range(label.shape[1]):
            current = current or (label[v, q] == source and length[v, q] == d)
        if not current:
            continue
        for at in range(2 * corner_start[v], 2 * corner_start[v + 1]):
            corner = corner_of[at >> 1]
            f = corner // 3
            i = corner - 3 * f
            if at & 1 == 0:
                edge = i
                u = faces[f, i + 1 if i < 2 else 0]
            else:
                edge = i - 1 if i > 0 else 2
                u = faces[f, edge]
            waiting = _offer(label, length, waiting, heap_key, heap_item, u, source, d + edge_length[f, edge])
            if waiting > len(heap_key):
                return 1
    return 0


@kernel
def face_bounds(faces, flat, length, steps, bound):
    """Bound, on each face, the least over its corners of length[corner] plus the walk there: bound (m,).

    Faces are cut into steps^2 triangles; a walk to a corner is longest at a corner of such a triangle.
    """
    for f in range(len(faces)):
        ux, uy = flat[f, 1, 0] / steps, flat[f, 1, 1] / steps
        wx, wy = flat[f, 2, 0] / steps, flat[f, 2, 1] / steps
        most = 0.0
        for i in range(steps):
            for j in range(steps - i):
                for upper in range(1 if i + j == steps - 1 else 2):
                    least = math.inf
                    for corner in range(3):
                        x, y = flat[f, corner, 0], flat[f, corner, 1]
                        far = 0.0
                        for q in range(3):
                            a = i + (q == 1) if upper == 0 else i + (q != 1)
                            b = j + (q == 2) if upper == 0 else j + (q != 0)
                            dx, dy = a * ux + b * wx - x, a * uy + b * wy - y
                            far = max(far, dx * dx + dy * dy)
                        least = min(least, length[faces[f, corner]] + math.sqrt(far))
                    most = max(most, least)
        bound[f] = most
