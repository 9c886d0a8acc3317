"""Walks over faces: the ordered fan of corners at each vertex, and the parts that faces hang together in."""

from surftex.kernels.jit import kernel


@kernel
def vertex_fans(corner_start, corner_of, neighbor, neighbor_edge, corner_angle, fan_corner, fan_angle):
    """Order the corners at each vertex counter-clockwise; a boundary fan starts at its boundary edge.

    corner_start (n+1,) int64 and corner_of (3m,) int64: the corners 3 f + i at each vertex, in any order;
    neighbor, neighbor_edge (m, 3) int32; corner_angle (m, 3) float64
    -> fan_corner (3m,) int64: the same corners in order; fan_angle (3m,) float64: the angle walked before
    each. Returns the first vertex whose corners are no single fan, or -1.
    """
    for vertex in range(len(corner_start) - 1):
        first, last = corner_start[vertex], corner_start[vertex + 1]
        if first == last:
            continue
        corner = corner_of[first]
        for k in range(first, last):
            face, i = corner_of[k] // 3, corner_of[k] % 3
            if neighbor[face, i] < 0:
                corner = corner_of[k]
        start = corner
        angle = 0.0
        k = first
        while k < last:
            face, i = corner // 3, corner % 3
            fan_corner[k] = corner
            fan_angle[k] = angle
            angle += corner_angle[face, i]
            k += 1
            edge = (i + 2) % 3
            other = neighbor[face, edge]
            if other < 0:
                break
            corner = 3 * other + neighbor_edge[face, edge]
            if corner == start:
                break
        if k < last:
            return vertex
    return -1


@kernel
def label_parts(neighbor, apart, waiting, label):
    """Give numbers to the parts that faces hang together in, in the order of their first faces.

    neighbor (m, 3) int32, -1 where there is none; apart (m, 3) bool: edges that part faces; waiting (m,) int32 room ->
    label (m,) int32.
    """
    label[:] = -1
    count = 0
    for first in range(len(neighbor)):
        if label[first] >= 0:
            continue
        label[first], waiting[0], left = count, first, 1
        while left > 0:
            left -= 1
            face = waiting[left]
            for i in range(3):
                other = neighbor[face, i]
                if other >= 0 and not apart[face, i] and label[other] < 0:
                    label[other], waiting[left] = count, other
                    left += 1
        count += 1
