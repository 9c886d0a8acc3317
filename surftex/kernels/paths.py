"""Shortest ways between two points: a strip of faces, pulled tight, and flipped over corners until it is straight.

A strip is a list of half-edges 3 face + edge, each crossed from its face. A* over the middles of faces finds the
first one; a funnel over the unfolded strip finds the shortest way inside it; where that way bends about a corner
with less than a half turn on its other side, the strip is led around the corner the other way. Each flip makes
the way shorter, so that it ends at a way that is shortest among all near it.
"""

import math

from surftex.kernels.jit import kernel, part

ROOM, NOWHERE = -1, -2
"""The strip is longer than its arrays; no strip leads there."""

_STRAIGHT = 1e-9
_HAIR = 1e-11
"""Least weight of a corner at either end of a way."""


@kernel
def push(heap_key, heap_face, size, key, face):
    """Put an entry on the heap; returns its new size."""
    hole = size
    while hole > 0:
        above = (hole - 1) // 2
        if heap_key[above] <= key:
            break
        heap_key[hole], heap_face[hole] = heap_key[above], heap_face[above]
        hole = above
    heap_key[hole], heap_face[hole] = key, face
    return size + 1


@kernel
def pop(heap_key, heap_face, size):
    """Take the least entry off the heap; returns its face."""
    face = heap_face[0]
    last = size - 1
    key, moved = heap_key[last], heap_face[last]
    hole = 0
    while True:
        below = 2 * hole + 1
        if below >= last:
            break
        if below + 1 < last and heap_key[below + 1] < heap_key[below]:
            below += 1
        if heap_key[below] >= key:
            break
        heap_key[hole], heap_face[hole] = heap_key[below], heap_face[below]
        hole = below
    heap_key[hole], heap_face[hole] = key, moved
    return face


@kernel
def find_strip(
    middle, neighbor, neighbor_edge, begin, end, round_, cost, seen, came, heap_key, heap_face, strip
):
    """Lead a strip from face `begin` to face `end` along the shortest chain of middles.

    middle (m, 3) float64; neighbor, neighbor_edge (m, 3) int32; `round_` is higher in each call with the same
    work arrays: cost (m,) float64, seen (m,) int64, came (m,) int64, heap_key float64 and heap_face int32 of
    3 m + 3 -> strip int64. Returns the number of half-edges, or a code.
    """
    gx, gy, gz = middle[end, 0], middle[end, 1], middle[end, 2]
    seen[begin] = 2 * round_
    cost[begin] = 0.0
    came[begin] = -1
    size = push(heap_key, heap_face, 0, 0.0, begin)
    while size > 0:
        face = pop(heap_key, heap_face, size)
        size -= 1
        if seen[face] == 2 * round_ + 1:
            continue
        seen[face] = 2 * round_ + 1
        if face == end:
            break
        for edge in range(3):
            other = neighbor[face, edge]
            if other < 0 or seen[other] == 2 * round_ + 1:
                continue
            x, y, z = middle[other, 0], middle[other, 1], middle[other, 2]
            step = math.sqrt(
                (x - middle[face, 0]) ** 2 + (y - middle[face, 1]) ** 2 + (z - middle[face, 2]) ** 2
            )
            if seen[other] < 2 * round_ or cost[face] + step < cost[other]:
                seen[other] = 2 * round_
                cost[other] = cost[face] + step
                came[other] = 3 * face + edge
                ahead = math.sqrt((x - gx) ** 2 + (y - gy) ** 2 + (z - gz) ** 2)
                size = push(heap_key, heap_face, size, cost[other] + ahead, other)
    if seen[end] != 2 * round_ + 1:
        return NOWHERE
    count = 0
    half = came[end]
    while half >= 0:
        if count == len(strip):
            return ROOM
        strip[count] = half
        count += 1
        half = came[half // 3]
    for k in range(count // 2):
        strip[k], strip[count - 1 - k] = strip[count - 1 - k], strip[k]
    return count


@kernel
def pull_tight(flat, transport, faces, strip, count, sx, sy, ex, ey, gate, gate_vertex, bend, bend_gate):
    """Find the shortest way through a strip, from (sx, sy) in its first face to (ex, ey) in its last.

    flat (m, 3, 2), transport (m, 3, 4) float64; faces (m, 3) int32; strip int64 of `count` half-edges -> gate
    (count + 1, 4) float64: left and right end in the frame of the first face, gate_vertex (count + 1, 2) int64;
    bend (count + 2, 2) float64 and bend_gate int64: the corners of the way, 2 gate + (1 at its right), from its
    start to its end. Returns their number.
    """
    c, s, x, y = 1.0, 0.0, 0.0, 0.0
    for k in range(count):
        face, edge = strip[k] // 3, strip[k] % 3
        onward = (edge + 1) % 3
        lx, ly, rx, ry = (
            flat[face, onward, 0],
            flat[face, onward, 1],
            flat[face, edge, 0],
            flat[face, edge, 1],
        )
        gate[k, 0], gate[k, 1] = c * lx - s * ly + x, s * lx + c * ly + y
        gate[k, 2], gate[k, 3] = c * rx - s * ry + x, s * rx + c * ry + y
        gate_vertex[k, 0], gate_vertex[k, 1] = faces[face, onward], faces[face, edge]
        tc, ts = transport[face, edge, 0], transport[face, edge, 1]
        tx, ty = transport[face, edge, 2], transport[face, edge, 3]
        c, s = c * tc + s * ts, s * tc - c * ts
        x, y = x - (c * tx - s * ty), y - (s * tx + c * ty)
    goal_x, goal_y = c * ex - s * ey + x, s * ex + c * ey + y
    gate[count, 0], gate[count, 1], gate[count, 2], gate[count, 3] = goal_x, goal_y, goal_x, goal_y
    gate_vertex[count, 0], gate_vertex[count, 1] = -2, -2
    bend[0, 0], bend[0, 1] = sx, sy
    bend_gate[0] = -1
    bends = 1
    ax, ay, apex = sx, sy, -1
    left, right = 0, 0
    left_vertex, right_vertex = gate_vertex[0, 0], gate_vertex[0, 1]
    lx, ly, rx, ry = gate[0, 0], gate[0, 1], gate[0, 2], gate[0, 3]
    k = 1
    while k <= count:
        nx, ny = gate[k, 2], gate[k, 3]
        if right_vertex == apex or (rx - ax) * (ny - ay) - (ry - ay) * (nx - ax) >= 0:
            if (
                right_vertex == apex
                or (lx - ax) * (ny - ay) - (ly - ay) * (nx - ax) <= 0
                or left_vertex == apex
            ):
                rx, ry, right, right_vertex = nx, ny, k, gate_vertex[k, 1]
            else:
                bend[bends, 0], bend[bends, 1] = lx, ly
                bend_gate[bends] = 2 * left
                bends += 1
                ax, ay, apex = lx, ly, left_vertex
                k = left + 1
                rx, ry, right, right_vertex = ax, ay, left, apex
                continue
        nx, ny = gate[k, 0], gate[k, 1]
        if left_vertex == apex or (lx - ax) * (ny - ay) - (ly - ay) * (nx - ax) <= 0:
            if (
                left_vertex == apex
                or (rx - ax) * (ny - ay) - (ry - ay) * (nx - ax) >= 0
                or right_vertex == apex
            ):
                lx, ly, left, left_vertex = nx, ny, k, gate_vertex[k, 0]
            else:
                bend[bends, 0], bend[bends, 1] = rx, ry
                bend_gate[bends] = 2 * right + 1
                bends += 1
                ax, ay, apex = rx, ry, right_vertex
                k = right + 1
                lx, ly, left, left_vertex = ax, ay, right, apex
                continue
        k += 1
    bend[bends, 0], bend[bends, 1] = goal_x, goal_y
    bend_gate[bends] = 2 * count
    return bends + 1


@kernel
def flip(neighbor, neighbor_edge, strip, count, gate_vertex, at, spare):
    """Lead a strip around the corner `at` (2 gate + 1 at its right) on the corner's other side.

    strip int64 of `count` half-edges, changed in place; spare int64 of the same length. Returns the new number
    of half-edges, or ROOM.
    """
    gate, right = at // 2, at % 2
    vertex = gate_vertex[gate, right]
    first = gate
    while first > 0 and gate_vertex[first - 1, right] == vertex:
        first -= 1
    last = gate
    while last + 1 < count and gate_vertex[last + 1, right] == vertex:
        last += 1
    half = strip[last]
    stop = 3 * neighbor[half // 3, half % 3] + neighbor_edge[half // 3, half % 3]
    onward = 2 if right else 1
    size = 0
    for k in range(first):
        spare[size] = strip[k]
        size += 1
    half = strip[first]
    half = half - half % 3 + (half % 3 + onward) % 3
    while half != stop:
        if size == len(spare):
            return ROOM
        spare[size] = half
        size += 1
        face, edge = half // 3, half % 3
        half = 3 * neighbor[face, edge] + (neighbor_edge[face, edge] + onward) % 3
    if size + count - last - 1 > len(spare):
        return ROOM
    for k in range(last + 1, count):
        spare[size] = strip[k]
        size += 1
    kept = 0
    for k in range(size):
        half = spare[k]
        if kept > 0:
            before = strip[kept - 1]
            if 3 * neighbor[before // 3, before % 3] + neighbor_edge[before // 3, before % 3] == half:
                kept -= 1
                continue
        strip[kept] = half
        kept += 1
    return kept


@kernel
def to_flip(bend, bend_gate, bends, gate_vertex, vertex_angle, on_border, blocked, blocks):
    """First corner of a way that has less than a half turn on its other side; -1 if there is none."""
    for k in range(1, bends - 1):
        vertex = gate_vertex[bend_gate[k] // 2, bend_gate[k] % 2]
        if on_border[vertex]:
            continue
        skip = False
        for i in range(blocks):
            if blocked[i] == vertex:
                skip = True
        if skip:
            continue
        ax, ay = bend[k, 0] - bend[k - 1, 0], bend[k, 1] - bend[k - 1, 1]
        bx, by = bend[k + 1, 0] - bend[k, 0], bend[k + 1, 1] - bend[k, 1]
        turn = abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))
        if turn > vertex_angle[vertex] - 2 * math.pi + _STRAIGHT:
            return k
    return -1


@kernel
def way_length(bend, bends):
    """Length of a way from its corners."""
    total = 0.0
    for k in range(1, bends):
        total += math.hypot(bend[k, 0] - bend[k - 1, 0], bend[k, 1] - bend[k - 1, 1])
    return total


@part
def _inside(flat, face, x, y):
    """Move a place on the rim of a face a hair inside: from a corner, a funnel cannot tell left from right."""
    far = max(y / flat[face, 2, 1], _HAIR)
    onward = max((x - y / flat[face, 2, 1] * flat[face, 2, 0]) / flat[face, 1, 0], _HAIR)
    near = max(
        1.0 - (x - y / flat[face, 2, 1] * flat[face, 2, 0]) / flat[face, 1, 0] - y / flat[face, 2, 1], _HAIR
    )
    if far > _HAIR and onward > _HAIR and near > _HAIR:
        return x, y
    total = near + onward + far
    return (onward * flat[face, 1, 0] + far * flat[face, 2, 0]) / total, far * flat[face, 2, 1] / total


@kernel
def shortest_way(
    flat, transport, faces, neighbor, neighbor_edge, vertex_angle, on_border, middle,
    begin, sx, sy, end, ex, ey, round_, cost, seen, came, heap_key, heap_face,
    strip, spare, kept, gate, gate_vertex, bend, bend_gate, blocked, share,
):  # fmt: skip
    """Shortest way from (sx, sy) in face `begin` to (ex, ey) in face `end`.

    Work arrays as for the kernels above; kept int64 as strip; blocked (b,) int64 -> strip and share float64: the
    half-edges crossed and where along each. Returns their number, or a code.
    """
    if begin == end:
        return 0
    sx, sy = _inside(flat, begin, sx, sy)
    ex, ey = _inside(flat, end, ex, ey)
    count = find_strip(
        middle, neighbor, neighbor_edge, begin, end, round_, cost, seen, came, heap_key, heap_face, strip
    )
    if count < 0:
        return count
    blocks = 0
    bends = pull_tight(
        flat, transport, faces, strip, count, sx, sy, ex, ey, gate, gate_vertex, bend, bend_gate
    )
    length = way_length(bend, bends)
    while blocks < len(blocked):
        k = to_flip(bend, bend_gate, bends, gate_vertex, vertex_angle, on_border, blocked, blocks)
        if k < 0:
            break
        vertex = gate_vertex[bend_gate[k] // 2, bend_gate[k] % 2]
        before = count
        for i in range(count):
            kept[i] = strip[i]
        count = flip(neighbor, neighbor_edge, strip, count, gate_vertex, bend_gate[k], spare)
        if count == ROOM:
            return ROOM
        if count == 0:
            return 0
        bends = pull_tight(
            flat, transport, faces, strip, count, sx, sy, ex, ey, gate, gate_vertex, bend, bend_gate
        )
        flipped = way_length(bend, bends)
        if flipped < length * (1 - 1e-14):
            length = flipped
            continue
        blocked[blocks] = vertex
        blocks += 1
        count = before
        for i in range(count):
            strip[i] = kept[i]
        bends = pull_tight(
            flat, transport, faces, strip, count, sx, sy, ex, ey, gate, gate_vertex, bend, bend_gate
        )
    k = 1
    for i in range(count):
        while k < bends - 1 and bend_gate[k] // 2 < i:
            k += 1
        px, py = bend[k - 1, 0], bend[k - 1, 1]
        dx, dy = bend[k, 0] - px, bend[k, 1] - py
        left = dx * (gate[i, 1] - py) - dy * (gate[i, 0] - px)
        right = dx * (gate[i, 3] - py) - dy * (gate[i, 2] - px)
        along = right / (right - left) if right != left else 0.0
        share[i] = min(max(along, 0.0), 1.0)
    return count


@kernel
def middle_of_way(flat, neighbor, neighbor_edge, begin, sx, sy, end, ex, ey, strip, share, count):
    """Place half-way along a way: face, x, y."""
    total = 0.0
    for turn in range(2):
        walked = 0.0
        face, x, y = begin, sx, sy
        for k in range(count + 1):
            to_x, to_y = ex, ey
            edge, onward = 0, 0
            if k < count:
                edge = strip[k] % 3
                onward = (edge + 1) % 3
                to_x = flat[face, edge, 0] + share[k] * (flat[face, onward, 0] - flat[face, edge, 0])
                to_y = flat[face, edge, 1] + share[k] * (flat[face, onward, 1] - flat[face, edge, 1])
            step = math.hypot(to_x - x, to_y - y)
            if turn == 1 and (walked + step >= 0.5 * total or k == count):
                along = min(max((0.5 * total - walked) / step, 0.0), 1.0) if step > 0 else 0.0
                return face, x + along * (to_x - x), y + along * (to_y - y)
            walked += step
            if k < count:
                other = neighbor[face, edge]
                entry = neighbor_edge[face, edge]
                onward = (entry + 1) % 3
                x = flat[other, onward, 0] + share[k] * (flat[other, entry, 0] - flat[other, onward, 0])
                y = flat[other, onward, 1] + share[k] * (flat[other, entry, 1] - flat[other, onward, 1])
                face = other
        total = walked
    return end, ex, ey


@kernel
def write_way(
    flat, neighbor, neighbor_edge, begin, sx, sy, ex, ey, strip, share, count, line, walked,
    piece_face, piece_place, piece_line, piece_start, at,
):  # fmt: skip
    """Write the pieces of a way from row `at` on; returns the next row (ROOM if none is left) and the length."""
    face, x, y = begin, sx, sy
    for k in range(count + 1):
        to_x, to_y = ex, ey
        edge = 0
        if k < count:
            edge = strip[k] % 3
            onward = (edge + 1) % 3
            to_x = flat[face, edge, 0] + share[k] * (flat[face, onward, 0] - flat[face, edge, 0])
            to_y = flat[face, edge, 1] + share[k] * (flat[face, onward, 1] - flat[face, edge, 1])
        step = math.hypot(to_x - x, to_y - y)
        if step > 0:
            if at == len(piece_face):
                return ROOM, walked
            piece_face[at] = face
            piece_line[at] = line
            piece_place[at, 0], piece_place[at, 1] = x, y
            piece_place[at, 2], piece_place[at, 3] = to_x, to_y
            piece_start[at] = walked
            at += 1
            walked += step
        if k < count:
            other = neighbor[face, edge]
            entry = neighbor_edge[face, edge]
            onward = (entry + 1) % 3
            x = flat[other, onward, 0] + share[k] * (flat[other, entry, 0] - flat[other, onward, 0])
            y = flat[other, onward, 1] + share[k] * (flat[other, entry, 1] - flat[other, onward, 1])
            face = other
    return at, walked


@kernel
def ways(
    flat, transport, faces, neighbor, neighbor_edge, vertex_angle, on_border, middle,
    first, last, begin, start, end, goal, line, state, cost, seen, came, heap_key, heap_face,
    strip, spare, kept, gate, gate_vertex, bend, bend_gate, blocked, share,
    halves, half_face, half_place, piece_face, piece_place, piece_line, piece_start, length,
):  # fmt: skip
    """Shortest ways of legs `first` to `last`; a leg with the line of the leg before it continues its length.

    begin, end, line (n,) int32; start, goal (n, 2) float64; state int64: round, pieces written. With `halves` not
    0 -> half_face (n,) int32 and half_place (n, 2) float64, the middle of each way, and else its pieces, and
    length (n,) float64 of each leg, inf where no way leads. Returns the first leg that found no room, or `last`.
    """
    for leg in range(first, last):
        state[0] += 1
        sx, sy, ex, ey = start[leg, 0], start[leg, 1], goal[leg, 0], goal[leg, 1]
        count = shortest_way(
            flat, transport, faces, neighbor, neighbor_edge, vertex_angle, on_border, middle,
            begin[leg], sx, sy, end[leg], ex, ey, state[0], cost, seen, came, heap_key, heap_face,
            strip, spare, kept, gate, gate_vertex, bend, bend_gate, blocked, share,
        )  # fmt: skip
        if count == ROOM:
            return leg
        if count == NOWHERE:
            length[leg] = math.inf
            half_face[leg] = -1
            continue
        if halves != 0:
            half_face[leg], half_place[leg, 0], half_place[leg, 1] = middle_of_way(
                flat, neighbor, neighbor_edge, begin[leg], sx, sy, end[leg], ex, ey, strip, share, count
            )
            continue
        walked = 0.0
        before = leg - 1
        while before >= 0 and line[before] == line[leg]:
            walked += length[before]
            before -= 1
        row, total = write_way(
            flat, neighbor, neighbor_edge, begin[leg], sx, sy, ex, ey, strip, share, count, line[leg], walked,
            piece_face, piece_place, piece_line, piece_start, state[1],
        )  # fmt: skip
        if row == ROOM:
            return leg
        state[1] = row
        length[leg] = total - walked
    return last
