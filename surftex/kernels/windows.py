"""Exact windows: what a source sees of a surface, face by face, as far as a radius.

A source is one primitive or several: points, in-face segments, and caps (points that send into a wedge only).
A WINDOW is the part of an edge that a straight path from the source crosses into a face; it carries the source's
image I in that face's frame, unfolded along the path. Windows leave a heap by their least distance, enter
a face, are recorded there, and go on through the two other edges. What a nearer path to a corner makes
useless is dropped (the vertex and the split rule of exact geodesics). At a corner with more than a full turn, and at a reentrant
border corner, the shadow behind it is lit by a new source at the corner, `sigma` mm farther on.

A ROW of what is found: 0, 1 the image I; 2..5 the ends X0, X1 of the visible interval; 6 sigma; 7, 8 (c, s). Kinds:

    0  image of a point; (c, s) turns the face's frame into the source's
    1  a corner behind a point; (c, s) is the unit direction in which the path leaves the source
    2, 3  a segment, seen from its left, right: I is its start, (c, s) the unit direction away from it
    4, 5  a corner behind a segment's left, right side; c is the mm from the segment's start to the foot
    6  a segment in its own face: I is its start, (c, s) its left normal
"""

import math

from surftex.kernels.jit import kernel

SLACK = 1.0 + 1e-10
"""A path must beat another by this factor before the other is dropped."""

PAD_RAD = 1e-9
"""Shadows are lit this much too wide: every path is a true one, so it costs nothing and leaves no gap."""


@kernel
def _push(key, slot, count, heap_key, heap_slot):
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


@kernel
def _pop(count, heap_key, heap_slot):
    top = heap_slot[0]
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
    return top


@kernel
def _store(
    key,
    place,
    edge,
    kind,
    side,
    primitive,
    b0,
    b1,
    Ix,
    Iy,
    sigma,
    c,
    s,
    count,
    heap_key,
    heap_slot,
    free,
    window,
    window_id,
):
    """Queue a window (or, with a negative kind, the lighting of a corner); a full queue raises count[4]."""
    if count[2] > 0:
        count[2] -= 1
        slot = free[count[2]]
    else:
        slot = count[1]
        if slot >= len(free):
            count[4] = 1
            return
        count[1] += 1
    window_id[slot, 0] = place
    window_id[slot, 1] = edge
    window_id[slot, 2] = kind
    window_id[slot, 3] = side
    window_id[slot, 4] = primitive
    window[slot, 0] = b0
    window[slot, 1] = b1
    window[slot, 2] = Ix
    window[slot, 3] = Iy
    window[slot, 4] = sigma
    window[slot, 5] = c
    window[slot, 6] = s
    _push(key, slot, count, heap_key, heap_slot)


@kernel
def _record(
    face, primitive, kind, least, Ix, Iy, X0x, X0y, X1x, X1y, sigma, c, s, count, row, row_id, row_least
):
    """Write a row; full rows raise count[5]."""
    n = count[3]
    if n >= len(row_least):
        count[5] = 1
        return
    row[n, 0] = Ix
    row[n, 1] = Iy
    row[n, 2] = X0x
    row[n, 3] = X0y
    row[n, 4] = X1x
    row[n, 5] = X1y
    row[n, 6] = sigma
    row[n, 7] = c
    row[n, 8] = s
    row_least[n] = least
    row_id[n, 0] = face
    row_id[n, 1] = primitive
    row_id[n, 2] = kind
    count[3] = n + 1


@kernel
def _reach(kind, Ix, Iy, c, s, x, y):
    """Length of the straight path from the image to (x, y)."""
    if kind == 2 or kind == 3:
        return (x - Ix) * c + (y - Iy) * s
    return math.sqrt((x - Ix) * (x - Ix) + (y - Iy) * (y - Iy))


@kernel
def _enter(
    face,
    edge,
    t0,
    t1,
    kind,
    side,
    primitive,
    Ix,
    Iy,
    sigma,
    c,
    s,
    limit,
    neighbor,
    neighbor_edge,
    edge_length,
    flat,
    transport,
    bound,
    count,
    heap_key,
    heap_slot,
    free,
    window,
    window_id,
):
    """Queue what passes edge `edge` of `face` between t0 and t1; image and (c, s) are given in `face`'s frame."""
    other = neighbor[face, edge]
    length = edge_length[face, edge]
    if other < 0 or not t1 - t0 > 1e-12 * length:
        return
    onward = edge + 1 if edge < 2 else 0
    px = flat[face, edge, 0]
    py = flat[face, edge, 1]
    ux = (flat[face, onward, 0] - px) / length
    uy = (flat[face, onward, 1] - py) / length
    if kind == 2 or kind == 3:
        key = sigma + min(
            _reach(kind, Ix, Iy, c, s, px + ux * t0, py + uy * t0),
            _reach(kind, Ix, Iy, c, s, px + ux * t1, py + uy * t1),
        )
    else:
        t = min(max((Ix - px) * ux + (Iy - py) * uy, t0), t1)
        key = sigma + _reach(kind, Ix, Iy, c, s, px + ux * t, py + uy * t)
    if key >= limit or key >= bound[other]:
        return
    tc = transport[face, edge, 0]
    ts = transport[face, edge, 1]
    if kind == 0:
        c, s = c * tc + s * ts, s * tc - c * ts
    elif kind == 2 or kind == 3:
        c, s = tc * c - ts * s, ts * c + tc * s
    _store(
        max(key, 0.0),
        other,
        neighbor_edge[face, edge],
        kind,
        side,
        primitive,
        length - t1,
        length - t0,
        tc * Ix - ts * Iy + transport[face, edge, 2],
        ts * Ix + tc * Iy + transport[face, edge, 3],
        sigma,
        c,
        s,
        count,
        heap_key,
        heap_slot,
        free,
        window,
        window_id,
    )


@kernel
def _clip(lo, hi, value, slope):
    """The part of [lo, hi] where value + slope t >= 0."""
    if value + slope * lo < 0 and value + slope * hi < 0:
        return lo, lo
    if slope > 0:
        lo = max(lo, -value / slope)
    elif slope < 0:
        hi = min(hi, -value / slope)
    return lo, hi


@kernel
def _foot(ax, ay, bx, by, x, y):
    """Share of the segment a b, in [0, 1], at which it is nearest to (x, y); 0 for a point."""
    dx = bx - ax
    dy = by - ay
    square = dx * dx + dy * dy
    if square <= 0:
        return 0.0
    return min(max(((x - ax) * dx + (y - ay) * dy) / square, 0.0), 1.0)


@kernel
def _start(
    first,
    last,
    source,
    limit,
    primitive_face,
    primitive,
    faces,
    neighbor,
    neighbor_edge,
    edge_length,
    flat,
    transport,
    turning,
    wanted,
    bound,
    near,
    near_of,
    count,
    heap_key,
    heap_slot,
    free,
    window,
    window_id,
    row,
    row_id,
    row_least,
):
    """Rows in the faces of primitives [first, last), and the first windows and corners."""
    for q in range(first, last):
        face = primitive_face[q]
        ax, ay, bx, by = primitive[q, 0], primitive[q, 1], primitive[q, 2], primitive[q, 3]
        for i in range(3):
            v = faces[face, i]
            if near_of[v] != source:
                near_of[v] = source
                near[v] = math.inf
            x, y = flat[face, i, 0], flat[face, i, 1]
            share = _foot(ax, ay, bx, by, x, y)
            near[v] = min(near[v], math.hypot(ax + share * (bx - ax) - x, ay + share * (by - ay) - y))
    for q in range(first, last):
        face = primitive_face[q]
        ax, ay, bx, by = primitive[q, 0], primitive[q, 1], primitive[q, 2], primitive[q, 3]
        w0x, w0y, w1x, w1y = primitive[q, 4], primitive[q, 5], primitive[q, 6], primitive[q, 7]
        cap = w0x != 0 or w0y != 0
        long = math.hypot(bx - ax, by - ay)
        nx, ny = 1.0, 0.0
        if long > 0:
            nx, ny = -(by - ay) / long, (bx - ax) / long
        if wanted[face] and not cap:
            _record(
                face,
                q,
                6 if long > 0 else 0,
                0.0,
                ax,
                ay,
                ax,
                ay,
                bx,
                by,
                0.0,
                nx,
                ny,
                count,
                row,
                row_id,
                row_least,
            )
        for i in range(3):
            v = faces[face, i]
            onward = i + 1 if i < 2 else 0
            px, py = flat[face, i, 0], flat[face, i, 1]
            length = edge_length[face, i]
            ex, ey = (flat[face, onward, 0] - px) / length, (flat[face, onward, 1] - py) / length
            if turning[v]:
                share = _foot(ax, ay, bx, by, px, py)
                dx, dy = ax + share * (bx - ax) - px, ay + share * (by - ay) - py
                distance = math.hypot(dx, dy)
                if distance < limit and distance <= near[v] * SLACK:
                    kind, c, s = -1, 1.0, 0.0
                    if distance > 0:
                        c, s = -dx / distance, -dy / distance
                    if long > 0:
                        kind = -4 if (px - ax) * nx + (py - ay) * ny > 0 else -5
                        c, s = share * long, 0.0
                    _store(
                        distance,
                        v,
                        3 * face + i,
                        kind,
                        0,
                        q,
                        math.atan2(ex * dy - ey * dx, ex * dx + ey * dy),
                        0.0,
                        0.0,
                        0.0,
                        distance,
                        c,
                        s,
                        count,
                        heap_key,
                        heap_slot,
                        free,
                        window,
                        window_id,
                    )
            lo, hi = 0.0, length
            if cap:
                lo, hi = _clip(lo, hi, w0x * (py - ay) - w0y * (px - ax), w0x * ey - w0y * ex)
                lo, hi = _clip(lo, hi, (px - ax) * w1y - (py - ay) * w1x, ex * w1y - ey * w1x)
            if long > 0:
                tx, ty = ny, -nx
                lo, hi = _clip(lo, hi, (px - ax) * tx + (py - ay) * ty, ex * tx + ey * ty)
                lo, hi = _clip(lo, hi, long - (px - ax) * tx - (py - ay) * ty, -ex * tx - ey * ty)
                for right in range(2):
                    sign = 1.0 - 2.0 * right
                    low, high = _clip(
                        lo, hi, sign * ((px - ax) * nx + (py - ay) * ny), sign * (ex * nx + ey * ny)
                    )
                    _enter(
                        face,
                        i,
                        low,
                        high,
                        2 + right,
                        2,
                        q,
                        ax,
                        ay,
                        0.0,
                        sign * nx,
                        sign * ny,
                        limit,
                        neighbor,
                        neighbor_edge,
                        edge_length,
                        flat,
                        transport,
                        bound,
                        count,
                        heap_key,
                        heap_slot,
                        free,
                        window,
                        window_id,
                    )
            else:
                _enter(
                    face,
                    i,
                    lo,
                    hi,
                    0,
                    2,
                    q,
                    ax,
                    ay,
                    0.0,
                    1.0,
                    0.0,
                    limit,
                    neighbor,
                    neighbor_edge,
                    edge_length,
                    flat,
                    transport,
                    bound,
                    count,
                    heap_key,
                    heap_slot,
                    free,
                    window,
                    window_id,
                )


@kernel
def _approach(
    vertex,
    distance,
    corner,
    kind,
    primitive,
    dx,
    dy,
    c,
    s,
    source,
    limit,
    turning,
    edge_length,
    flat,
    near,
    near_of,
    count,
    heap_key,
    heap_slot,
    free,
    window,
    window_id,
):
    """A straight path of length `distance` ends at a corner, coming from (dx, dy); light what lies behind."""
    if near_of[vertex] != source:
        near_of[vertex] = source
        near[vertex] = math.inf
    if distance > near[vertex] * SLACK:
        return
    near[vertex] = min(near[vertex], distance)
    if turning[vertex] and distance < limit:
        face = corner // 3
        i = corner % 3
        onward = i + 1 if i < 2 else 0
        ex = flat[face, onward, 0] - flat[face, i, 0]
        ey = flat[face, onward, 1] - flat[face, i, 1]
        _store(
            distance,
            vertex,
            corner,
            kind,
            0,
            primitive,
            math.atan2(ex * dy - ey * dx, ex * dx + ey * dy),
            0.0,
            0.0,
            0.0,
            distance,
            c,
            s,
            count,
            heap_key,
            heap_slot,
            free,
            window,
            window_id,
        )


@kernel
def _light(
    vertex,
    corner,
    local,
    kind,
    primitive,
    sigma,
    c,
    s,
    source,
    limit,
    faces,
    neighbor,
    neighbor_edge,
    edge_length,
    flat,
    transport,
    vertex_angle,
    on_border,
    turning,
    fan_start,
    fan_corner,
    fan_angle,
    corner_angle,
    wanted,
    bound,
    near,
    near_of,
    count,
    heap_key,
    heap_slot,
    free,
    window,
    window_id,
    row,
    row_id,
    row_least,
):
    """Send a corner into its shadow: the directions at more than half a turn from where the path came in."""
    arrived = 0.0
    for k in range(fan_start[vertex], fan_start[vertex + 1]):
        if fan_corner[k] == corner:
            arrived = fan_angle[k] + local
    total = vertex_angle[vertex]
    for k in range(fan_start[vertex], fan_start[vertex + 1]):
        face = fan_corner[k] // 3
        i = fan_corner[k] % 3
        i1 = i + 1 if i < 2 else 0
        i2 = i - 1 if i > 0 else 2
        begin = fan_angle[k]
        end = begin + corner_angle[face, i]
        low, high = begin, begin - 1.0
        if on_border[vertex]:
            if end > arrived + math.pi - PAD_RAD:
                low, high = max(begin, arrived + math.pi - PAD_RAD), end
            elif begin < arrived - math.pi + PAD_RAD:
                low, high = begin, min(end, arrived - math.pi + PAD_RAD)
        else:
            for shift in range(-1, 2):
                from_ = max(begin, arrived + math.pi - PAD_RAD + shift * total)
                to = min(end, arrived - math.pi + PAD_RAD + (shift + 1) * total)
                if to - from_ > high - low:
                    low, high = from_, to
        if high < low:
            continue
        px, py = flat[face, i, 0], flat[face, i, 1]
        if wanted[face]:
            _record(
                face,
                primitive,
                kind,
                sigma,
                px,
                py,
                px,
                py,
                px,
                py,
                sigma,
                c,
                s,
                count,
                row,
                row_id,
                row_least,
            )
        if low <= begin:
            _approach(
                faces[face, i1],
                sigma + edge_length[face, i],
                3 * face + i1,
                -kind,
                primitive,
                px - flat[face, i1, 0],
                py - flat[face, i1, 1],
                c,
                s,
                source,
                limit,
                turning,
                edge_length,
                flat,
                near,
                near_of,
                count,
                heap_key,
                heap_slot,
                free,
                window,
                window_id,
            )
        if high >= end:
            _approach(
                faces[face, i2],
                sigma + edge_length[face, i2],
                3 * face + i2,
                -kind,
                primitive,
                px - flat[face, i2, 0],
                py - flat[face, i2, 1],
                c,
                s,
                source,
                limit,
                turning,
                edge_length,
                flat,
                near,
                near_of,
                count,
                heap_key,
                heap_slot,
                free,
                window,
                window_id,
            )
        length = edge_length[face, i1]
        bx, by = flat[face, i1, 0], flat[face, i1, 1]
        ux, uy = (flat[face, i2, 0] - bx) / length, (flat[face, i2, 1] - by) / length
        ex, ey = (bx - px) / edge_length[face, i], (by - py) / edge_length[face, i]
        t0, t1 = 0.0, length
        if low > begin:
            cosine, sine = math.cos(low - begin), math.sin(low - begin)
            dx, dy = cosine * ex - sine * ey, sine * ex + cosine * ey
            t0 = min(max(-(dx * (by - py) - dy * (bx - px)) / (dx * uy - dy * ux), 0.0), length)
        if high < end:
            cosine, sine = math.cos(high - begin), math.sin(high - begin)
            dx, dy = cosine * ex - sine * ey, sine * ex + cosine * ey
            t1 = min(max(-(dx * (by - py) - dy * (bx - px)) / (dx * uy - dy * ux), 0.0), length)
        _enter(
            face,
            i1,
            t0,
            t1,
            kind,
            2,
            primitive,
            px,
            py,
            sigma,
            c,
            s,
            limit,
            neighbor,
            neighbor_edge,
            edge_length,
            flat,
            transport,
            bound,
            count,
            heap_key,
            heap_slot,
            free,
            window,
            window_id,
        )


@kernel
def flood(
    first,
    last,
    stamp,
    primitive_start,
    primitive_face,
    primitive,
    radius,
    faces,
    neighbor,
    neighbor_edge,
    edge_length,
    flat,
    transport,
    vertex_angle,
    on_border,
    turning,
    fan_start,
    fan_corner,
    fan_angle,
    corner_angle,
    wanted,
    bound,
    most,
    near,
    near_of,
    lit_of,
    split_near,
    split_at,
    split_of,
    count,
    heap_key,
    heap_slot,
    free,
    window,
    window_id,
    row,
    row_id,
    row_least,
):
    """Flood sources [first, last): source k owns primitives primitive_start[k] to primitive_start[k + 1].

    primitive (p, 8): start, end (the same for a point), and the two unit directions, counter-clockwise and at most half a
    turn apart, of a cap's wedge (0 for none). wanted (m,) uint8: faces that need rows; bound (m,): a window whose least distance
    is not below it never enters the face. stamp + k must differ from every number in `*_of`.
    -> row (r, 9), row_id (r, 3) int32 (face, primitive, kind), row_least (r,), their number in count[3].
    Returns the source that did not fit, and which buffer to grow (1 queue, 2 rows, 3 more than `most` windows); or last, 0.
    """
    for k in range(first, last):
        source = stamp + k
        limit = radius[k]
        rows = count[3]
        count[0] = 0
        count[1] = 0
        count[2] = 0
        count[4] = 0
        count[5] = 0
        _start(
            primitive_start[k],
            primitive_start[k + 1],
            source,
            limit,
            primitive_face,
            primitive,
            faces,
            neighbor,
            neighbor_edge,
            edge_length,
            flat,
            transport,
            turning,
            wanted,
            bound,
            near,
            near_of,
            count,
            heap_key,
            heap_slot,
            free,
            window,
            window_id,
            row,
            row_id,
            row_least,
        )
        popped = 0
        while count[0] > 0:
            popped += 1
            if popped > most or count[4] > 0 or count[5] > 0:
                break
            least = heap_key[0]
            w = _pop(count, heap_key, heap_slot)
            free[count[2]] = w
            count[2] += 1
            face = window_id[w, 0]
            j = window_id[w, 1]
            kind = window_id[w, 2]
            primitive_id = window_id[w, 4]
            sigma = window[w, 4]
            c = window[w, 5]
            s = window[w, 6]
            b0 = window[w, 0]
            if kind < 0:
                if lit_of[face] != source and sigma <= near[face] * SLACK:
                    lit_of[face] = source
                    _light(
                        face,
                        j,
                        b0,
                        -kind,
                        primitive_id,
                        sigma,
                        c,
                        s,
                        source,
                        limit,
                        faces,
                        neighbor,
                        neighbor_edge,
                        edge_length,
                        flat,
                        transport,
                        vertex_angle,
                        on_border,
                        turning,
                        fan_start,
                        fan_corner,
                        fan_angle,
                        corner_angle,
                        wanted,
                        bound,
                        near,
                        near_of,
                        count,
                        heap_key,
                        heap_slot,
                        free,
                        window,
                        window_id,
                        row,
                        row_id,
                        row_least,
                    )
                continue
            b1 = window[w, 1]
            Ix = window[w, 2]
            Iy = window[w, 3]
            side = window_id[w, 3]
            j1 = j + 1 if j < 2 else 0
            j2 = j - 1 if j > 0 else 2
            length = edge_length[face, j]
            ax, ay = flat[face, j, 0], flat[face, j, 1]
            bx, by = flat[face, j1, 0], flat[face, j1, 1]
            cx, cy = flat[face, j2, 0], flat[face, j2, 1]
            ex, ey = (bx - ax) / length, (by - ay) / length
            X0x, X0y = ax + ex * b0, ay + ey * b0
            X1x, X1y = ax + ex * b1, ay + ey * b1
            A, B, C = faces[face, j], faces[face, j1], faces[face, j2]
            if near_of[A] != source:
                near_of[A] = source
                near[A] = math.inf
            if near_of[B] != source:
                near_of[B] = source
                near[B] = math.inf
            if near_of[C] != source:
                near_of[C] = source
                near[C] = math.inf
            d0 = sigma + _reach(kind, Ix, Iy, c, s, X0x, X0y)
            d1 = sigma + _reach(kind, Ix, Iy, c, s, X1x, X1y)
            if (near[A] + b1) * SLACK < d1 or (near[B] + (length - b0)) * SLACK < d0:
                continue
            if side < 2:
                back = neighbor[face, j]
                k0 = neighbor_edge[face, j]
                k1 = k0 + 1 if k0 < 2 else 0
                k2 = k0 - 1 if k0 > 0 else 2
                share = (length - b1 if side == 0 else length - b0) / length
                qx = flat[back, k0, 0] + (flat[back, k1, 0] - flat[back, k0, 0]) * share
                qy = flat[back, k0, 1] + (flat[back, k1, 1] - flat[back, k0, 1]) * share
                around = near[faces[back, k2]] + math.sqrt(
                    (flat[back, k2, 0] - qx) ** 2 + (flat[back, k2, 1] - qy) ** 2
                )
                if around * SLACK < (d1 if side == 0 else d0):
                    continue
            if wanted[face]:
                _record(
                    face,
                    primitive_id,
                    kind,
                    least,
                    Ix,
                    Iy,
                    X0x,
                    X0y,
                    X1x,
                    X1y,
                    sigma,
                    c,
                    s,
                    count,
                    row,
                    row_id,
                    row_least,
                )
            linear = kind == 2 or kind == 3
            r0x, r0y, r1x, r1y, rcx, rcy = c, s, c, s, c, s
            if not linear:
                r0x, r0y, r1x, r1y, rcx, rcy = X0x - Ix, X0y - Iy, X1x - Ix, X1y - Iy, cx - Ix, cy - Iy
            beyond_left = r0x * (cy - X0y) - r0y * (cx - X0x) > 0
            beyond_right = r1x * (cy - X1y) - r1y * (cx - X1x) < 0
            first_side, last_side = 0, 2
            near[C] = min(near[C], near[A] + edge_length[face, j2], near[B] + edge_length[face, j1])
            if beyond_left:
                first_side, last_side = 0, 1
                near[C] = min(near[C], d0 + math.sqrt((cx - X0x) ** 2 + (cy - X0y) ** 2))
            elif beyond_right:
                first_side, last_side = 1, 2
                near[C] = min(near[C], d1 + math.sqrt((cx - X1x) ** 2 + (cy - X1y) ** 2))
            else:
                distance = sigma + _reach(kind, Ix, Iy, c, s, cx, cy)
                across = rcx * ey - rcy * ex
                at = 0.5 * (b0 + b1)
                if across != 0:
                    at = (rcx * (cy - ay) - rcy * (cx - ax)) / across
                h = 3 * face + j
                if split_of[h] != source or distance < split_near[h]:
                    split_of[h] = source
                    split_near[h] = distance
                    split_at[h] = at
                elif distance > split_near[h] * SLACK:
                    if at < split_at[h]:
                        first_side = 1
                    else:
                        last_side = 1
                lit_kind, lc, ls = -1, c, s
                if kind == 0:
                    norm = math.sqrt(rcx * rcx + rcy * rcy)
                    lc, ls = (c * rcx - s * rcy) / norm, (s * rcx + c * rcy) / norm
                elif kind >= 2:
                    lit_kind = -4 if kind == 2 or kind == 4 else -5
                    if kind == 2:
                        lc = (cx - Ix) * s - (cy - Iy) * c
                    elif kind == 3:
                        lc = (cy - Iy) * c - (cx - Ix) * s
                _approach(
                    C,
                    distance,
                    3 * face + j2,
                    lit_kind,
                    primitive_id,
                    Ix - cx if not linear else -c,
                    Iy - cy if not linear else -s,
                    lc,
                    ls,
                    source,
                    limit,
                    turning,
                    edge_length,
                    flat,
                    near,
                    near_of,
                    count,
                    heap_key,
                    heap_slot,
                    free,
                    window,
                    window_id,
                )
            for branch in range(first_side, last_side):
                e = j1 if branch == 0 else j2
                e1 = e + 1 if e < 2 else 0
                reach = edge_length[face, e]
                px, py = flat[face, e, 0], flat[face, e, 1]
                ux, uy = (flat[face, e1, 0] - px) / reach, (flat[face, e1, 1] - py) / reach
                t0, t1 = 0.0, reach
                if branch == 0 or beyond_right:
                    slope = r1x * uy - r1y * ux
                    if slope != 0:
                        t0 = min(max(-(r1x * (py - X1y) - r1y * (px - X1x)) / slope, 0.0), reach)
                if branch == 1 or beyond_left:
                    slope = r0x * uy - r0y * ux
                    if slope != 0:
                        t1 = min(max(-(r0x * (py - X0y) - r0y * (px - X0x)) / slope, 0.0), reach)
                if not t1 > t0:
                    continue
                Y0x, Y0y, Y1x, Y1y = px + ux * t0, py + uy * t0, px + ux * t1, py + uy * t1
                d0 = sigma + _reach(kind, Ix, Iy, c, s, Y0x, Y0y)
                d1 = sigma + _reach(kind, Ix, Iy, c, s, Y1x, Y1y)
                if (near[faces[face, e]] + t1) * SLACK < d1 or (
                    near[faces[face, e1]] + (reach - t0)
                ) * SLACK < d0:
                    continue
                if branch == 0:
                    if (near[A] + math.sqrt((Y0x - ax) ** 2 + (Y0y - ay) ** 2)) * SLACK < d0:
                        continue
                elif (near[B] + math.sqrt((Y1x - bx) ** 2 + (Y1y - by) ** 2)) * SLACK < d1:
                    continue
                _enter(
                    face,
                    e,
                    t0,
                    t1,
                    kind,
                    branch,
                    primitive_id,
                    Ix,
                    Iy,
                    sigma,
                    c,
                    s,
                    limit,
                    neighbor,
                    neighbor_edge,
                    edge_length,
                    flat,
                    transport,
                    bound,
                    count,
                    heap_key,
                    heap_slot,
                    free,
                    window,
                    window_id,
                )
        if popped > most:
            count[3] = rows
            return k, 3
        if count[4] > 0 or count[5] > 0:
            count[3] = rows
            return k, 1 if count[4] > 0 else 2
    return last, 0
