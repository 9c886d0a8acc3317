"""Neighbours on a surface: straight walks from the sites of a lattice, and the sites that they end on."""

import math

from surftex.kernels.jit import kernel
from surftex.kernels.trace import exit_edge

_MOST_FACES = 4096


@kernel
def walk_offsets(
    flat, neighbor, neighbor_edge, transport, to_page, page, face, place, angle, shift, offset, first, last, found
):  # fmt: skip
    """Walk every offset from sites ``first`` to ``last``, and look up the site where each walk ends.

    flat (m, 3, 2), transport (m, 3, 4) float64, neighbor, neighbor_edge (m, 3) int32; to_page (m, 2, 3) float64:
    column and row of a place in a face's frame; page (h, w) int32: the site nearest to each texel; per site: face
    int32, place (n, 2) mm, angle of the page's up, shift (n, 2) in texels, added before the texel is taken; offset
    (e, 2) float64: mm to the right and up -> found (n + 1, e) int32; n where a walk leaves the surface or does not
    leave the site.
    """
    none = len(face)
    height, width = page.shape
    for i in range(first, last):
        up_x, up_y = math.cos(angle[i]), math.sin(angle[i])
        for k in range(len(offset)):
            right, up = offset[k, 0], offset[k, 1]
            length = math.sqrt(right * right + up * up)
            found[i, k] = none
            if length == 0.0:
                found[i, k] = i
                continue
            dx = (right * up_y + up * up_x) / length
            dy = (up * up_y - right * up_x) / length
            here, x, y = face[i], place[i, 0], place[i, 1]
            left, entry, arrived = length, -1, False
            for _ in range(_MOST_FACES):
                edge, share = exit_edge(flat, here, entry, x, y, dx, dy)
                onward = (edge + 1) % 3
                to_x = flat[here, edge, 0] + share * (flat[here, onward, 0] - flat[here, edge, 0])
                to_y = flat[here, edge, 1] + share * (flat[here, onward, 1] - flat[here, edge, 1])
                step = max((to_x - x) * dx + (to_y - y) * dy, 0.0)
                if step >= left:
                    x += left * dx
                    y += left * dy
                    arrived = True
                    break
                left -= step
                other = neighbor[here, edge]
                if other < 0:
                    break
                cosine, sine = transport[here, edge, 0], transport[here, edge, 1]
                dx, dy = cosine * dx - sine * dy, sine * dx + cosine * dy
                entry = neighbor_edge[here, edge]
                here = other
                onward = (entry + 1) % 3
                x = flat[here, onward, 0] + share * (flat[here, entry, 0] - flat[here, onward, 0])
                y = flat[here, onward, 1] + share * (flat[here, entry, 1] - flat[here, onward, 1])
            if not arrived:
                continue
            column = to_page[here, 0, 0] * x + to_page[here, 0, 1] * y + to_page[here, 0, 2] + shift[i, 0]
            row = to_page[here, 1, 0] * x + to_page[here, 1, 1] * y + to_page[here, 1, 2] + shift[i, 1]
            c = min(max(math.floor(column), 0), width - 1)
            r = min(max(math.floor(row), 0), height - 1)
            site = page[r, c]
            if site != i:
                found[i, k] = site
