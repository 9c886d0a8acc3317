"""Upper bounds of the distance to the k nearest sources, at every vertex, by walks along edges."""

import math

import numpy as np

from surftex.kernels.jit import kernel, part


@part
def _offer(label, length, first, waiting, way, item, vertex, source, distance):
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
    if waiting < len(way):
        at = (first + waiting) % len(way)
        way[at] = distance
        item[at, 0] = vertex
        item[at, 1] = source
    return waiting + 1


@kernel
def nearest_labels(
    face, place, faces, flat, neighbor, corner_start, corner_of, edge_length, step, way, item, label, length,
):  # fmt: skip
    """Walk from sources along edges until every vertex knows the k nearest of them.

    face (s,) int32, place (s, 2) in the frame of the face; corner_start (n+1,), corner_of (3m,): corners 3 f + i
    around each vertex. way (h,), item (h, 2) int32: a ring of room for the walks under way. Those that end within a
    reach go on, first come first served; the reach grows by `step` when none is left. Lengths do not depend on the order.
    -> label (n, k) int32, given as -1, length (n, k) ascending, given as inf.
    Returns 1 if the room was too small, else 0.
    """
    first, waiting = 0, 0
    for source in range(len(face)):
        f = face[source]
        x, y = place[source, 0], place[source, 1]
        for i in range(3):
            dx, dy = flat[f, i, 0] - x, flat[f, i, 1] - y
            d = math.sqrt(dx * dx + dy * dy)
            waiting = _offer(label, length, first, waiting, way, item, faces[f, i], source, d)
            if waiting > len(way):
                return 1
    reach, passed, least = step, 0, math.inf
    while waiting > 0:
        d = way[first]
        v = item[first, 0]
        source = np.int64(item[first, 1])
        if d > reach:
            at = (first + waiting) % len(way)
            way[at] = d
            item[at, 0] = v
            item[at, 1] = source
            first = first + 1 if first + 1 < len(way) else 0
            least = min(least, d)
            passed += 1
            if passed >= waiting:
                reach, passed, least = least + step, 0, math.inf
            continue
        first = first + 1 if first + 1 < len(way) else 0
        waiting -= 1
        passed, least = 0, math.inf
        current = False
        for q in range(label.shape[1]):
            current = current or (label[v, q] == source and length[v, q] == d)
        if not current:
            continue
        for at in range(corner_start[v], corner_start[v + 1]):
            corner = corner_of[at]
            f = corner // 3
            i = corner - 3 * f
            after, before = i + 1 if i < 2 else 0, i - 1 if i > 0 else 2
            u = faces[f, after]
            waiting = _offer(label, length, first, waiting, way, item, u, source, d + edge_length[f, i])
            if neighbor[f, before] < 0:  # on a border the edge back is no other corner's
                u = faces[f, before]
                waiting = _offer(
                    label, length, first, waiting, way, item, u, source, d + edge_length[f, before]
                )
            if waiting > len(way):
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
