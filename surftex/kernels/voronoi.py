"""Borders of Voronoi regions on a surface: where two sources are nearest at once, face by face.

Regions are followed along mesh edges first: the nearest source at both ends, and the NODES between, where the
nearest changes. Both faces of an edge see the same nodes, so whatever a face makes of them fits its
neighbours. Inside a face only the order of the nodes around a triangle counts: none, a border between two, a
meeting point of three, or else the triangle is cut into four, with nodes of its own along the new sides; a long one in two.

`found` = (flat (m, 3, 2), first, cells, grid: buckets; start, entry_row, entry_least; row, row_id) of a flood of
points. A region inside a triangle that shows on none of its sides holds its own site, since a region is
connected: triangles with a site that shows on no side are cut.
"""

import math

import numpy as np

from surftex.kernels.buckets import bucket_of
from surftex.kernels.evaluate import distance_to
from surftex.kernels.jit import kernel, part

DEPTH = 72
"""Halvings of a face, one inside the other, after which a triangle is cut no further."""

EVEN = 1e-11
"""Share of the scale up to which two distances are the same."""

LONG = 6.0
"""Longest side over height from which on a triangle is cut in two: four needles would be as long for their width as one."""

BEND = 2e-5
"""Share of the scale by which a straight piece of border may miss the true one."""


@part
def _nearest(found, face, x, y):
    """Nearest source of a place, -1 if none reaches it, and its distance."""
    _, first, cells, grid, start, entry_row, entry_least, row, row_id = found
    bucket = bucket_of(face, x, y, first, cells, grid)
    owner, best = -1, math.inf
    for e in range(start[bucket], start[bucket + 1]):
        if entry_least[e] > best:
            break
        r = entry_row[e]
        d = distance_to(row_id[r, 2], row, r, x, y)
        if d < best or (d == best and row_id[r, 1] < owner):
            owner, best = row_id[r, 1], d
    return owner, best


@part
def _distance(found, face, x, y, source):
    """Distance of a place from one source; inf if it does not reach it."""
    _, first, cells, grid, start, entry_row, entry_least, row, row_id = found
    bucket = bucket_of(face, x, y, first, cells, grid)
    best = math.inf
    for e in range(start[bucket], start[bucket + 1]):
        if entry_least[e] > best:
            break
        r = entry_row[e]
        if row_id[r, 1] == source:
            best = min(best, distance_to(row_id[r, 2], row, r, x, y))
    return best


@part
def _slope(found, face, x, y, source):
    """Distance from one source, and the direction in which it grows fastest."""
    _, first, cells, grid, start, entry_row, entry_least, row, row_id = found
    bucket = bucket_of(face, x, y, first, cells, grid)
    best, chosen = math.inf, -1
    for e in range(start[bucket], start[bucket + 1]):
        if entry_least[e] > best:
            break
        r = entry_row[e]
        if row_id[r, 1] == source:
            d = distance_to(row_id[r, 2], row, r, x, y)
            if d < best:
                best, chosen = d, r
    if chosen < 0:
        return best, 0.0, 0.0
    dx, dy = x - row[chosen, 0], y - row[chosen, 1]
    norm = math.sqrt(dx * dx + dy * dy)
    if norm == 0:
        return best, 0.0, 0.0
    return best, dx / norm, dy / norm


@part
def _even_share(found, face, x0, y0, x1, y1, one, two, scale):
    """Share of the way at which `one`, nearer at the start, and `two`, nearer at the end, are equally near."""
    low, high = 0.0, 1.0
    at_low = _distance(found, face, x0, y0, one) - _distance(found, face, x0, y0, two)
    at_high = _distance(found, face, x1, y1, one) - _distance(found, face, x1, y1, two)
    if not at_low < 0:
        return 0.0
    if not at_high > 0:
        return 1.0
    side = 0
    for _ in range(80):
        share = 0.5 * (low + high)
        if at_low > -math.inf and at_high < math.inf:
            share = (low * at_high - high * at_low) / (at_high - at_low)
        x, y = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
        value = _distance(found, face, x, y, one) - _distance(found, face, x, y, two)
        if abs(value) <= EVEN * scale or high - low < 1e-14:
            return share
        if value > 0:
            high, at_high = share, value
            if side == 1:
                at_low *= 0.5
            side = 1
        else:
            low, at_low = share, value
            if side == -1:
                at_high *= 0.5
            side = -1
    return 0.5 * (low + high)


@part
def _follow(found, scale, face, x0, y0, one, x1, y1, two, todo, todo_owner, place, owner, count):
    """Write the nodes between two places with known owners: share of the way, owner before and after.

    place (c,), owner (c, 2), from `count` on. Returns the new count; -1 if it does not fit; -2 if a place has no owner.
    """
    length = math.hypot(x1 - x0, y1 - y0)
    todo[0, 0], todo[0, 1] = 0.0, 1.0
    todo_owner[0, 0], todo_owner[0, 1] = one, two
    waiting = 1
    while waiting > 0:
        waiting -= 1
        a, b = todo[waiting, 0], todo[waiting, 1]
        left, right = todo_owner[waiting, 0], todo_owner[waiting, 1]
        small = 0.5 * min(scale[left], scale[right])
        ax, ay = x0 + a * (x1 - x0), y0 + a * (y1 - y0)
        bx, by = x0 + b * (x1 - x0), y0 + b * (y1 - y0)
        far = (b - a) * length > small
        if left == right and not far:
            continue
        share = 0.5
        if not far:
            share = _even_share(found, face, ax, ay, bx, by, left, right, small)
        middle = a + share * (b - a)
        x, y = x0 + middle * (x1 - x0), y0 + middle * (y1 - y0)
        between, best = _nearest(found, face, x, y)
        if between < 0:
            return -2
        cut = far
        if not far and between != left and between != right and waiting + 2 < len(todo):
            cut = (
                best < _distance(found, face, x, y, left) - 1e-9 * small
                and min(middle - a, b - middle) > 1e-12
            )
        if cut:
            todo[waiting, 0], todo[waiting, 1] = middle, b
            todo_owner[waiting, 0], todo_owner[waiting, 1] = between, right
            todo[waiting + 1, 0], todo[waiting + 1, 1] = a, middle
            todo_owner[waiting + 1, 0], todo_owner[waiting + 1, 1] = left, between
            waiting += 2
            continue
        if count >= len(place):
            return -1
        place[count] = middle
        owner[count, 0], owner[count, 1] = left, right
        count += 1
    return count


@kernel
def edge_nodes(face, edge, faces, found, scale, vertex_owner, todo, todo_owner, edge_count, place, owner):
    """Nodes along mesh edges: edge e is edge[e] of face[e], walked in that face's sense.

    vertex_owner (n,) int32, scale (s,) float64: how small a region may be; todo (t, 2), todo_owner (t, 2): scratch
    -> edge_count (e,) int64; place (c,) share of the edge, owner (c, 2) int32, edge after edge. Returns their
    number; -1 if they do not fit; -2 if some place has no owner.
    """
    flat = found[0]
    count = 0
    for e in range(len(face)):
        f, i = np.int64(face[e]), edge[e]
        j = i + 1 if i < 2 else 0
        one, two = vertex_owner[faces[f, i]], vertex_owner[faces[f, j]]
        edge_count[e] = 0
        if one < 0 or two < 0:
            continue
        before = count
        count = _follow(found, scale, f, flat[f, i, 0], flat[f, i, 1], one, flat[f, j, 0], flat[f, j, 1], two,
                        todo, todo_owner, place, owner, count)  # fmt: skip
        if count < 0:
            return count
        edge_count[e] = count - before
    return count


@part
def _meeting(found, face, scale, x, y, ax, ay, bx, by, cx, cy, one, two, three):
    """Place in the triangle where three sources are equally near and no other is nearer: whether, x, y."""
    double = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    reach = math.sqrt(abs(double))
    for _ in range(24):
        d1, g1x, g1y = _slope(found, face, x, y, one)
        d2, g2x, g2y = _slope(found, face, x, y, two)
        d3, g3x, g3y = _slope(found, face, x, y, three)
        if not (d1 < math.inf and d2 < math.inf and d3 < math.inf):
            return False, x, y
        u, v = d1 - d2, d1 - d3
        if abs(u) + abs(v) <= 1e-10 * scale:
            if (
                (bx - ax) * (y - ay) - (by - ay) * (x - ax) < 0
                or (cx - bx) * (y - by) - (cy - by) * (x - bx) < 0
                or (ax - cx) * (y - cy) - (ay - cy) * (x - cx) < 0
            ):
                return False, x, y
            owner, best = _nearest(found, face, x, y)
            return owner in (one, two, three) or best > d1 - 1e-8 * scale, x, y
        a, b, c, d = g1x - g2x, g1y - g2y, g1x - g3x, g1y - g3y
        determinant = a * d - b * c
        if abs(determinant) < 1e-12:
            return False, x, y
        step_x, step_y = (d * u - b * v) / determinant, (a * v - c * u) / determinant
        long = math.sqrt(step_x * step_x + step_y * step_y)
        if long > reach:
            step_x, step_y = step_x * reach / long, step_y * reach / long
        x, y = x - step_x, y - step_y
    return False, x, y


@part
def _border(
    found, face, scale, x0, y0, node0, x1, y1, node1, left, right, todo, todo_node, counts, piece, piece_id
):
    """Write the border between two nodes in straight pieces; False if they do not fit.

    counts: pieces, meeting points, inner nodes; piece (p, 4), piece_id (p, 5): face, nodes, regions left and right.
    """
    small = min(scale[left], scale[right])
    todo[0, 0], todo[0, 1], todo[0, 2], todo[0, 3] = x0, y0, x1, y1
    todo_node[0, 0], todo_node[0, 1], todo_node[0, 2] = node0, node1, 0
    waiting = 1
    while waiting > 0:
        waiting -= 1
        ax, ay, bx, by = todo[waiting, 0], todo[waiting, 1], todo[waiting, 2], todo[waiting, 3]
        start, stop, depth = todo_node[waiting, 0], todo_node[waiting, 1], todo_node[waiting, 2]
        dx, dy = bx - ax, by - ay
        if depth < 14 and dx * dx + dy * dy > (2e-4 * small) ** 2:
            off, x, y = 0.0, ax, ay
            for k in range(3):
                px, py = ax + (0.25 + 0.25 * k) * dx, ay + (0.25 + 0.25 * k) * dy
                value = _distance(found, face, px, py, left) - _distance(found, face, px, py, right)
                if abs(value) > abs(off) and abs(value) < math.inf:
                    off, x, y = value, px, py
            if abs(off) > BEND * small:
                near, away = right if off > 0 else left, left if off > 0 else right
                share, far_x, far_y = 1.0, x, y
                swing = min(0.5, 4 * abs(off) / math.sqrt(dx * dx + dy * dy))
                while share == 1.0 and swing <= 0.5:
                    sign = swing if off > 0 else -swing
                    far_x, far_y = x - sign * dy, y + sign * dx
                    share = _even_share(found, face, x, y, far_x, far_y, near, away, small)
                    swing *= 2
                if share < 1.0:
                    x, y = x + share * (far_x - x), y + share * (far_y - y)
                    node = counts[3] + counts[2]
                    counts[2] += 1
                    todo[waiting, 0], todo[waiting, 1], todo[waiting, 2], todo[waiting, 3] = x, y, bx, by
                    todo_node[waiting, 0], todo_node[waiting, 1], todo_node[waiting, 2] = (
                        node,
                        stop,
                        depth + 1,
                    )
                    waiting += 1
                    todo[waiting, 0], todo[waiting, 1], todo[waiting, 2], todo[waiting, 3] = ax, ay, x, y
                    todo_node[waiting, 0], todo_node[waiting, 1], todo_node[waiting, 2] = (
                        start,
                        node,
                        depth + 1,
                    )
                    waiting += 1
                    continue
        n = counts[0]
        if n >= len(piece):
            return False
        piece[n, 0], piece[n, 1], piece[n, 2], piece[n, 3] = ax, ay, bx, by
        piece_id[n, 0], piece_id[n, 1], piece_id[n, 2] = face, start, stop
        piece_id[n, 3], piece_id[n, 4] = left, right
        counts[0] = n + 1
    return True


@part
def _half(node, low, high, triangle, t, begins, ends):
    """First of the nodes low to high of a side, walked from corner `begins`, that lies in its second half."""
    ax, ay = triangle[t, 2 * begins], triangle[t, 2 * begins + 1]
    dx, dy = triangle[t, 2 * ends] - ax, triangle[t, 2 * ends + 1] - ay
    square = dx * dx + dy * dy
    while low < high and (node[low, 0] - ax) * dx + (node[low, 1] - ay) * dy < 0.5 * square:
        low += 1
    return low


@part
def _beside(spot, i, x, y):
    """Whether (x, y) in the triangle spot[:3] lies nearer to corner i than the line through the middles."""
    j, k = (i + 1) % 3, (i + 2) % 3
    dx, dy = spot[k, 0] - spot[j, 0], spot[k, 1] - spot[j, 1]
    here = dx * (y - spot[j, 1]) - dy * (x - spot[j, 0])
    return here > 0.5 * (dx * (spot[i, 1] - spot[j, 1]) - dy * (spot[i, 0] - spot[j, 0]))


@part
def _longest(triangle, t, long):
    """Side to cut a triangle at, if it is longer than `long` times the triangle's height over it; -1 for none."""
    side, square = -1, 0.0
    for i in range(3):
        j = i + 1 if i < 2 else 0
        dx, dy = triangle[t, 2 * j] - triangle[t, 2 * i], triangle[t, 2 * j + 1] - triangle[t, 2 * i + 1]
        if dx * dx + dy * dy > square:
            side, square = i, dx * dx + dy * dy
    double = (triangle[t, 2] - triangle[t, 0]) * (triangle[t, 5] - triangle[t, 1])
    double -= (triangle[t, 3] - triangle[t, 1]) * (triangle[t, 4] - triangle[t, 0])
    return side if square > long * abs(double) else -1


@part
def _put(w, i, x, y, low, high, back, owner, triangle, triangle_id):
    """Write corner i of triangle w, and the nodes of the side that begins there."""
    triangle[w, 2 * i], triangle[w, 2 * i + 1] = x, y
    triangle_id[w, i], triangle_id[w, 3 + i], triangle_id[w, 6 + i], triangle_id[w, 9 + i] = (
        low,
        high,
        back,
        owner,
    )


@kernel
def face_borders(
    begin, end, faces, found, scale, vertex_owner, face_edge, face_back, edge_start, place, edge_owner, site_start,
    site, site_flat, inside, spot, cut, triangle, triangle_id, node, node_id, node_owner, share, todo, todo_id, counts,
    piece, piece_id, meeting, meeting_id,
):  # fmt: skip
    """Borders and meeting points of regions inside faces [begin, end).

    face_edge (m, 3) int64, face_back (m, 3) uint8: mesh edge of each side, and whether it runs against the face;
    edge_start, place, edge_owner: from `edge_nodes`; site_start (m+1,), site (s,), site_flat (s, 2): sites by face;
    scratch: inside (most sites in a face,), spot (6, 2), cut (3, 9), triangle (t, 6), triangle_id (t, 15), node (c, 2),
    node_id (c,), node_owner (c, 2), share (c,), todo (u, 4), todo_id (u, 3); counts (4,): pieces, meeting points, inner
    nodes so far, number of the first inner node
    -> piece (p, 4), piece_id (p, 5): places of both ends, face, nodes, region on the left and right; meeting (q, 2),
    meeting_id (q, 2): place, face, node. Returns (face, code): 0 done, 1 pieces full, 2 meeting points full, 3 nodes
    full, and 4 for a place without an owner; with 1 to 3 the face was not begun.
    """
    flat = found[0]
    for f in range(begin, end):
        pieces, meetings, inner = counts[0], counts[1], counts[2]
        used = 0
        if vertex_owner[faces[f, 0]] < 0 or vertex_owner[faces[f, 1]] < 0 or vertex_owner[faces[f, 2]] < 0:
            continue
        room = 0
        for i in range(3):
            room += edge_start[face_edge[f, i] + 1] - edge_start[face_edge[f, i]]
        if room == 0 and site_start[f] == site_start[f + 1]:
            continue
        if room > len(node):
            return f, 3
        for i in range(3):
            j = i + 1 if i < 2 else 0
            e = face_edge[f, i]
            low = used
            for k in range(edge_start[e + 1] - edge_start[e]):
                n = edge_start[e] + k
                t = place[n]
                one, two = edge_owner[n, 0], edge_owner[n, 1]
                if face_back[f, i]:
                    n = edge_start[e + 1] - 1 - k
                    t = 1 - place[n]
                    one, two = edge_owner[n, 1], edge_owner[n, 0]
                node[used, 0] = flat[f, i, 0] + t * (flat[f, j, 0] - flat[f, i, 0])
                node[used, 1] = flat[f, i, 1] + t * (flat[f, j, 1] - flat[f, i, 1])
                node_id[used] = n
                node_owner[used, 0], node_owner[used, 1] = one, two
                used += 1
            triangle_id[0, i], triangle_id[0, 3 + i], triangle_id[0, 6 + i] = low, used, 0
            triangle_id[0, 9 + i] = vertex_owner[faces[f, i]]
            triangle[0, 2 * i], triangle[0, 2 * i + 1] = flat[f, i, 0], flat[f, i, 1]
        triangle_id[0, 12], triangle_id[0, 13] = 0, 0
        triangle_id[0, 14] = site_start[f + 1] - site_start[f]
        for k in range(triangle_id[0, 14]):
            inside[k] = site_start[f] + k
        waiting = 1
        code = 0
        while waiting > 0 and code == 0:
            waiting -= 1
            t = waiting
            ax, ay, bx, by, cx, cy = (triangle[t, 0], triangle[t, 1], triangle[t, 2], triangle[t, 3],
                                      triangle[t, 4], triangle[t, 5])  # fmt: skip
            depth = triangle_id[t, 12]
            size = 0
            for i in range(3):
                size += triangle_id[t, 3 + i] - triangle_id[t, i]
            n0, n1, n2 = -1, -1, -1
            one, two, three = triangle_id[t, 9], triangle_id[t, 9], triangle_id[t, 9]
            small = scale[one]
            if size == 2 or size == 3:
                at = 0
                for i in range(3):
                    low, high, back = triangle_id[t, i], triangle_id[t, 3 + i], triangle_id[t, 6 + i]
                    for k in range(low, high):
                        n = high - 1 - (k - low) if back else k
                        before = node_owner[n, 1] if back else node_owner[n, 0]
                        if at == 0:
                            n0, one = n, before
                        elif at == 1:
                            n1, two = n, before
                        else:
                            n2, three = n, before
                        at += 1
                small = min(scale[one], scale[two])
                if size == 3:
                    small = min(small, scale[three])
            hidden = False
            for k in range(triangle_id[t, 13], triangle_id[t, 14]):
                s = site[inside[k]]
                hidden |= s != one and s != two and (s != three or size != 3)
            if size == 0 and not hidden:
                continue
            last = (
                depth >= DEPTH or max(abs(bx - ax) + abs(by - ay), abs(cx - ax) + abs(cy - ay)) < 1e-8 * small
            )
            if size == 2 and (last or not hidden):
                if not _border(found, f, scale, node[n0, 0], node[n0, 1], node_id[n0], node[n1, 0], node[n1, 1],
                               node_id[n1], one, two, todo, todo_id, counts, piece, piece_id):  # fmt: skip
                    code = 1
                continue
            if size >= 2 and (last or (size == 3 and not hidden)):
                good, x, y = last, (ax + bx + cx) / 3, (ay + by + cy) / 3
                if size == 3:
                    met, mx, my = _meeting(
                        found, f, small, (node[n0, 0] + node[n1, 0] + node[n2, 0]) / 3,
                        (node[n0, 1] + node[n1, 1] + node[n2, 1]) / 3, ax, ay, bx, by, cx, cy, one, two, three,
                    )  # fmt: skip
                    if met:
                        good, x, y = True, mx, my
                if good:
                    if counts[1] >= len(meeting):
                        code = 2
                        continue
                    number = counts[3] + counts[2]
                    counts[2] += 1
                    meeting[counts[1], 0], meeting[counts[1], 1] = x, y
                    meeting_id[counts[1], 0], meeting_id[counts[1], 1] = f, number
                    counts[1] += 1
                    for i in range(3):
                        low, high, back = triangle_id[t, i], triangle_id[t, 3 + i], triangle_id[t, 6 + i]
                        for n in range(low, high):
                            left = node_owner[n, 1] if back else node_owner[n, 0]
                            right = node_owner[n, 0] if back else node_owner[n, 1]
                            if code == 0 and not _border(
                                found, f, scale, node[n, 0], node[n, 1], node_id[n], x, y, number, left, right, todo,
                                todo_id, counts, piece, piece_id,
                            ):  # fmt: skip
                                code = 1
                    continue
            if last:
                continue
            side = _longest(triangle, t, LONG)
            if side >= 0:
                # Cut in two, from the middle of the longest side to the corner across from it.
                i, j, k = side, (side + 1) % 3, (side + 2) % 3
                for c in range(3):
                    spot[c, 0], spot[c, 1] = triangle[t, 2 * c], triangle[t, 2 * c + 1]
                    for column in range(4):
                        cut[c, column] = triangle_id[t, 3 * column + c]
                low, high, back = cut[i, 0], cut[i, 1], cut[i, 2]
                begins, ends = (j, i) if back else (i, j)
                split = _half(node, low, high, triangle, t, begins, ends)
                between = node_owner[split - 1, 1] if split > low else cut[begins, 3]
                mx, my = 0.5 * (spot[i, 0] + spot[j, 0]), 0.5 * (spot[i, 1] + spot[j, 1])
                made = _follow(
                    found, scale, f, mx, my, between, spot[k, 0], spot[k, 1], cut[k, 3], todo, todo_id, share, node_owner,
                    used,
                )  # fmt: skip
                if made < 0:
                    code = 3 if made == -1 else 4
                    break
                for n in range(used, made):
                    node[n, 0], node[n, 1] = (
                        mx + share[n] * (spot[k, 0] - mx),
                        my + share[n] * (spot[k, 1] - my),
                    )
                    node_id[n] = counts[3] + counts[2]
                    counts[2] += 1
                moved, held = triangle_id[t, 13], triangle_id[t, 14]
                first_low, first_high = (split, high) if back else (low, split)
                last_low, last_high = (low, split) if back else (split, high)
                for w in range(t, t + 2):
                    triangle_id[w, 12], triangle_id[w, 13] = depth + 1, moved
                    for n in range(moved, held):
                        place_x, place_y = site_flat[inside[n], 0] - mx, site_flat[inside[n], 1] - my
                        if w > t or (spot[k, 0] - mx) * place_y - (spot[k, 1] - my) * place_x > 0:
                            kept = inside[n]
                            inside[n] = inside[moved]
                            inside[moved] = kept
                            moved += 1
                    triangle_id[w, 14] = moved
                _put(
                    t,
                    0,
                    spot[i, 0],
                    spot[i, 1],
                    first_low,
                    first_high,
                    back,
                    cut[i, 3],
                    triangle,
                    triangle_id,
                )
                _put(t, 1, mx, my, used, made, 0, between, triangle, triangle_id)
                _put(
                    t,
                    2,
                    spot[k, 0],
                    spot[k, 1],
                    cut[k, 0],
                    cut[k, 1],
                    cut[k, 2],
                    cut[k, 3],
                    triangle,
                    triangle_id,
                )
                _put(t + 1, 0, mx, my, last_low, last_high, back, between, triangle, triangle_id)
                _put(
                    t + 1,
                    1,
                    spot[j, 0],
                    spot[j, 1],
                    cut[j, 0],
                    cut[j, 1],
                    cut[j, 2],
                    cut[j, 3],
                    triangle,
                    triangle_id,
                )
                _put(t + 1, 2, spot[k, 0], spot[k, 1], used, made, 1, cut[k, 3], triangle, triangle_id)
                used = made
                waiting += 2
                continue
            # Cut into four: corner i with the middles of the sides beside it, and the triangle of the middles.
            for i in range(3):
                j = i + 1 if i < 2 else 0
                for axis in range(2):
                    spot[i, axis] = triangle[t, 2 * i + axis]
                    spot[3 + i, axis] = 0.5 * (triangle[t, 2 * i + axis] + triangle[t, 2 * j + axis])
                low, high, back = triangle_id[t, i], triangle_id[t, 3 + i], triangle_id[t, 6 + i]
                begins, ends = (j, i) if back else (i, j)
                split = _half(node, low, high, triangle, t, begins, ends)
                cut[i, 0], cut[i, 1], cut[i, 2], cut[i, 3] = low, split, split, high
                if back:
                    cut[i, 0], cut[i, 1], cut[i, 2], cut[i, 3] = split, high, low, split
                cut[i, 4], cut[i, 5] = back, triangle_id[t, 9 + i]
                cut[i, 6] = node_owner[split - 1, 1] if split > low else triangle_id[t, 9 + begins]
            moved, held = triangle_id[t, 13], triangle_id[t, 14]
            for i in range(3):
                before = i - 1 if i > 0 else 2
                made = _follow(
                    found, scale, f, spot[3 + i, 0], spot[3 + i, 1], cut[i, 6], spot[3 + before, 0],
                    spot[3 + before, 1], cut[before, 6], todo, todo_id, share, node_owner, used,
                )  # fmt: skip
                if made < 0:
                    code = 3 if made == -1 else 4
                    break
                for n in range(used, made):
                    for axis in range(2):
                        node[n, axis] = spot[3 + i, axis] + share[n] * (
                            spot[3 + before, axis] - spot[3 + i, axis]
                        )
                    node_id[n] = counts[3] + counts[2]
                    counts[2] += 1
                cut[i, 7], cut[i, 8] = used, made
                used = made
            if code != 0:
                break
            for i in range(4):
                w = waiting
                waiting += 1
                triangle_id[w, 12], triangle_id[w, 13] = depth + 2, moved
                for k in range(moved, held):
                    if i == 3 or _beside(spot, i, site_flat[inside[k], 0], site_flat[inside[k], 1]):
                        kept = inside[k]
                        inside[k] = inside[moved]
                        inside[moved] = kept
                        moved += 1
                triangle_id[w, 14] = moved
                before = i - 1 if i > 0 else 2
                for k in range(3):
                    onward = k + 1 if k < 2 else 0
                    at, side = 3 + k, onward
                    triangle_id[w, 6 + k], triangle_id[w, 9 + k] = 1, cut[k, 6]
                    if i < 3:
                        at, side = i, i
                        triangle_id[w, 6 + k], triangle_id[w, 9 + k] = cut[i, 4], cut[i, 5]
                        if k == 1:
                            at = 3 + i
                            triangle_id[w, 6 + k], triangle_id[w, 9 + k] = 0, cut[i, 6]
                        elif k == 2:
                            at, side = 3 + before, before
                            triangle_id[w, 6 + k], triangle_id[w, 9 + k] = cut[before, 4], cut[before, 6]
                    first = 7 if i == 3 or k == 1 else k
                    triangle_id[w, k], triangle_id[w, 3 + k] = cut[side, first], cut[side, first + 1]
                    triangle[w, 2 * k], triangle[w, 2 * k + 1] = spot[at, 0], spot[at, 1]
        if code != 0:
            counts[0], counts[1], counts[2] = pieces, meetings, inner
            return f, code
    return end, 0


@kernel
def chain(start, incident, piece_id, node_vertex, visited, order, flipped, curve, curve_vertex):
    """Join pieces into curves that end at meeting points, at borders of the surface, or nowhere.

    start (n+1,) int64, incident (2p,) int32: pieces at each node; piece_id (p, 5) int32: its nodes are columns 1 and 2;
    node_vertex (n,) int32: meeting point at a node or -1; visited (p,) uint8: zeros -> order (p,) int32: pieces in walking
    order, flipped (p,) uint8, curve (p,) int32 of each, curve_vertex (c, 2) int32: meeting points at the ends, -1 for
    none. Returns the number of curves.
    """
    done, curves = 0, 0
    for phase in range(3):
        for node in range(len(node_vertex)):
            degree = start[node + 1] - start[node]
            if (phase == 0 and node_vertex[node] < 0) or (
                phase == 1 and (degree != 1 or node_vertex[node] >= 0)
            ):
                continue
            for k in range(start[node], start[node + 1]):
                at, here = incident[k], node
                if visited[at]:
                    continue
                curve_vertex[curves, 0] = node_vertex[node]
                while at >= 0:
                    visited[at] = 1
                    order[done] = at
                    flipped[done] = 1 if piece_id[at, 1] != here else 0
                    curve[done] = curves
                    done += 1
                    here = piece_id[at, 1] if piece_id[at, 1] != here else piece_id[at, 2]
                    at = -1
                    if node_vertex[here] < 0:
                        for q in range(start[here], start[here + 1]):
                            if not visited[incident[q]]:
                                at = incident[q]
                curve_vertex[curves, 1] = node_vertex[here]
                curves += 1
    return curves


@kernel
def lay_out(piece, piece_id, order, flipped, first, backwards, face, start, end):
    """Lay pieces out in the walking order of `chain`, curve by curve.

    piece (p, 4), piece_id (p, 5) int32: places of both ends, and face first; order (p,), flipped (p,): from `chain`; first
    (c,) int64: place of each curve's first piece in the order; backwards (c,) uint8: whether a curve is walked from its
    other end -> face (p,) int32, start (p, 2), end (p, 2).
    """
    for c in range(len(first)):
        low = first[c]
        high = first[c + 1] if c + 1 < len(first) else len(order)
        for i in range(low, high):
            at = low + high - 1 - i if backwards[c] else i
            p = order[at]
            face[i] = piece_id[p, 0]
            turned = flipped[at] != backwards[c]
            for k in range(2):
                start[i, k] = piece[p, k + 2 if turned else k]
                end[i, k] = piece[p, k if turned else k + 2]
