"""Directions that are carried along edges, and from faces to vertices.

Shared arguments: neighbor, neighbor_edge (m, 3) int32; corner_angle (m, 3) float64; first (n+1,), corner (3m,) int64, walked
(3m,) float64: the corners around each vertex as 3 face + i, and the angle before each; symmetry: arms of a direction.
"""

import math

from surftex.kernels.jit import kernel


@kernel
def edge_entries(
    neighbor, neighbor_edge, corner_angle, edge_turn, symmetry, sharpest, least, most, weight, entry
):
    """Weigh each edge by the cotangents beside it, between `least` and `most`, and carry directions along it.

    edge_turn (m, 3) float64: from the start of edge i to its end; sharpest: least angle of a corner, and from pi on its most
    -> weight (m, 3) float64; entry (m, 3) complex128: minus the weight, turned from the end back to the start.
    """
    for face in range(len(weight)):
        for i in range(3):
            other, j = neighbor[face, i], neighbor_edge[face, i]
            if 0 <= other < face:
                weight[face, i], entry[face, i] = weight[other, j], entry[other, j].conjugate()
                continue
            angle = corner_angle[face, (i + 2) % 3]
            total = 0.5 / math.tan(min(max(angle, sharpest), math.pi - sharpest))
            if other >= 0:
                angle = corner_angle[other, (j + 2) % 3]
                total += 0.5 / math.tan(min(max(angle, sharpest), math.pi - sharpest))
            total = min(max(total, least), most)
            turn = symmetry * edge_turn[face, i]
            weight[face, i] = total
            entry[face, i] = complex(-total * math.cos(turn), total * math.sin(turn))


@kernel
def laplacian_rows(faces, neighbor, first, corner, weight, entry, row_start, column, value):
    """List the entries of each vertex: of the edges around it, and on the diagonal their sum, or 1 where there are none.

    faces (m, 3) int32; weight, entry as from `edge_entries`
    -> row_start (n+1,), column (e,) int32, value (e,) complex128: rows in the order around the vertex. Returns their entries.
    """
    k = 0
    for vertex in range(len(first) - 1):
        middle = k
        total = 0.0
        k += 1
        for c in range(first[vertex], first[vertex + 1]):
            face, i = corner[c] // 3, corner[c] % 3
            total += weight[face, i]
            column[k], value[k] = faces[face, (i + 1) % 3], entry[face, i]
            k += 1
            before = (i + 2) % 3
            if neighbor[face, before] < 0:
                total += weight[face, before]
                column[k], value[k] = faces[face, before], entry[face, before].conjugate()
                k += 1
        column[middle], value[middle] = vertex, total if total > 0 else 1.0
        row_start[vertex + 1] = k
    return k


@kernel
def gather_directions(first, corner, walked, corner_angle, edge_angle, stretch, symmetry, direction, value):
    """Mean of the directions of the faces around each vertex, weighted by the angles of their corners.

    edge_angle, stretch (m, 3) float64: direction of edge i in its face, and the stretch of angles around corner i;
    direction (m,) complex128 -> value (n,) complex128: 0 where no face is.
    """
    for vertex in range(len(value)):
        total, angles = 0j, 0.0
        for c in range(first[vertex], first[vertex + 1]):
            face, i = corner[c] // 3, corner[c] % 3
            half = 0.5 * corner_angle[face, i]
            turn = symmetry * (edge_angle[face, i] + half - stretch[face, i] * (walked[c] + half))
            total += corner_angle[face, i] * (direction[face] * complex(math.cos(turn), -math.sin(turn)))
            angles += corner_angle[face, i]
        value[vertex] = total / angles if angles > 0 else 0j
