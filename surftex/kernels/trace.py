"""Straight lines on a surface: unfolded across one edge after another.

The exit of each face is chosen by the side of the ray that its far corner lies on, and the crossing is kept
on the edge. So there is always one exit, even through a corner or along an edge: there the ray turns about
the corner in steps of no length until it points into a face.
"""

import math

from surftex.kernels.jit import kernel

WHOLE, BORDER, FACES = 0, 1, 2
"""Why a line ended: it has its whole length; it met a border; it crossed as many faces as it may."""


@kernel
def exit_edge(flat, face, entry, x, y, dx, dy):
    """Edge by which the ray (x, y) + t (dx, dy) leaves a face it entered by edge `entry` (-1: starts inside).

    flat (m, 3, 2) float64 -> edge (0, 1 or 2) and the share of it, 0 to 1, where the ray crosses.
    """
    if entry >= 0:
        apex = (entry + 2) % 3
        side = dx * (flat[face, apex, 1] - y) - dy * (flat[face, apex, 0] - x)
        edge = (entry + 1) % 3 if side > 0 else apex
    else:
        edge = -1
        closest = 0
        least = math.inf
        left = 0
        for i in range(3):
            j = (i + 1) % 3
            here = dx * (flat[face, i, 1] - y) - dy * (flat[face, i, 0] - x)
            there = dx * (flat[face, j, 1] - y) - dy * (flat[face, j, 0] - x)
            if here <= 0 and there > 0:
                edge = i
            if here > 0:
                left += 1
            if abs(here) < least:
                least = abs(here)
                closest = i
        if edge < 0:
            edge = closest if left == 3 else (closest + 2) % 3
    onward = (edge + 1) % 3
    before = dx * (flat[face, edge, 1] - y) - dy * (flat[face, edge, 0] - x)
    behind = dx * (flat[face, onward, 1] - y) - dy * (flat[face, onward, 0] - x)
    share = before / (before - behind) if before != behind else 0.0
    return edge, min(max(share, 0.0), 1.0)


@kernel
def trace_lines(
    flat, neighbor, neighbor_edge, transport, first, last, face, place, angle, length, most_faces,
    piece_face, piece_place, piece_line, piece_start, end_face, end_place, end_angle, reason, count,
):  # fmt: skip
    """Walk lines `first` to `last` until each has its length, meets a border, or runs out of faces.

    flat (m, 3, 2), transport (m, 3, 4) float64; neighbor, neighbor_edge (m, 3) int32; per line: face int32,
    place (n, 2), angle, length float64 -> pieces from count[0] on: piece_face, piece_line int32, piece_place
    (p, 4) float64 (start, end), piece_start float64 (length before); end_face int32, end_place (n, 2),
    end_angle float64, reason int8 per line. Returns the first line whose pieces found no room, or `last`.
    """
    room = len(piece_face)
    for line in range(first, last):
        begin = count[0]
        here = face[line]
        x, y = place[line, 0], place[line, 1]
        dx, dy = math.cos(angle[line]), math.sin(angle[line])
        entry = -1
        walked = 0.0
        crossed = 0
        code = FACES
        while crossed < most_faces:
            crossed += 1
            edge, share = exit_edge(flat, here, entry, x, y, dx, dy)
            onward = (edge + 1) % 3
            to_x = flat[here, edge, 0] + share * (flat[here, onward, 0] - flat[here, edge, 0])
            to_y = flat[here, edge, 1] + share * (flat[here, onward, 1] - flat[here, edge, 1])
            step = max((to_x - x) * dx + (to_y - y) * dy, 0.0)
            left = length[line] - walked
            inside = step >= left
            if inside:
                step = left
                to_x = x + left * dx
                to_y = y + left * dy
            if step > 0:
                if count[0] == room:
                    count[0] = begin
                    return line
                k = count[0]
                piece_face[k] = here
                piece_line[k] = line
                piece_place[k, 0], piece_place[k, 1] = x, y
                piece_place[k, 2], piece_place[k, 3] = to_x, to_y
                piece_start[k] = walked
                count[0] = k + 1
            walked += step
            x, y = to_x, to_y
            if inside:
                code = WHOLE
                break
            other = neighbor[here, edge]
            if other < 0:
                code = BORDER
                break
            cosine, sine = transport[here, edge, 0], transport[here, edge, 1]
            dx, dy = cosine * dx - sine * dy, sine * dx + cosine * dy
            entry = neighbor_edge[here, edge]
            here = other
            onward = (entry + 1) % 3
            x = flat[here, onward, 0] + share * (flat[here, entry, 0] - flat[here, onward, 0])
            y = flat[here, onward, 1] + share * (flat[here, entry, 1] - flat[here, onward, 1])
        end_face[line] = here
        end_place[line, 0], end_place[line, 1] = x, y
        end_angle[line] = math.atan2(dy, dx)
        reason[line] = code
    return last
