"""Texels around a chart: which chart edge is nearest, and where the surface goes on beyond it."""

import math

from surftex.kernels.jit import kernel, part

LARGEST_BLOCK = 4
"""Side of the largest block of gutter texels that shares a place; bands begin at multiples of it."""


@kernel
def nearest_edge_band(corner, edge_face, edge_side, candidate, radius, first_row, face, near, square, owner):
    """Find the nearest chart edge of every texel without a face, within a radius.

    corner (m, 3, 2) float64 texels; edge_face, edge_side (e,) int32: chart edges, each seen from its face;
    candidate (k,) int32: edges that may matter to the band, ascending; face (rows, width) int32, -1 where
    free; near (rows, width) float64, inf on entry: squared distance; square (rows, width) float64, -inf on
    entry: how far outside of the edge's line; owner (rows, width) int32, -1 on entry. At a corner that two
    edges share, the edge that the texel is most squarely outside of wins; then the lower one.
    """
    rows, width = face.shape
    for k in range(len(candidate)):
        e = candidate[k]
        f, i = edge_face[e], edge_side[e]
        j, o = (i + 1) % 3, (i + 2) % 3
        ax, ay = corner[f, i, 0], corner[f, i, 1] - first_row
        bx, by = corner[f, j, 0], corner[f, j, 1] - first_row
        dx, dy = bx - ax, by - ay
        squared = dx * dx + dy * dy
        length = math.sqrt(squared)
        side = dx * (corner[f, o, 1] - first_row - ay) - dy * (corner[f, o, 0] - ax)
        outward = -1.0 if side > 0.0 else 1.0
        left, right = min(ax, bx) - radius - 0.5, max(ax, bx) + radius - 0.5
        top, bottom = min(ay, by) - radius - 0.5, max(ay, by) + radius - 0.5
        if right < 0.0 or bottom < 0.0 or left > width - 1 or top > rows - 1:
            continue
        begin, end = int(max(left, 0.0)), int(min(right, width - 1.0))
        for r in range(int(max(top, 0.0)), int(min(bottom, rows - 1.0)) + 1):
            y = r + 0.5 - ay
            for c in range(begin, end + 1):
                if face[r, c] >= 0:
                    continue
                x = c + 0.5 - ax
                t = 0.0
                if squared > 0.0:
                    t = min(1.0, max(0.0, (x * dx + y * dy) / squared))
                away = (x - t * dx) ** 2 + (y - t * dy) ** 2
                if away > radius * radius or away > near[r, c] + 1e-5:
                    continue
                outside = 0.0
                if length > 0.0:
                    outside = outward * (dx * y - dy * x) / length
                if away < near[r, c] - 1e-5 or outside > square[r, c]:
                    near[r, c] = away
                    square[r, c] = outside
                    owner[r, c] = e


@part
def _side_of_block(owner, near, exact, r, c):
    """Side of the block of gutter texels that begins at (r, c) and shares one place: 4, 2, or 1 for a texel by itself.

    Two by two share where all are farther off than `exact`, four by four where all are than four times that.
    """
    rows, width = owner.shape
    for side in (4, 2):
        if r % side > 0 or c % side > 0 or r + side > rows or c + side > width:
            continue
        least = exact if side == 2 else 4.0 * exact
        far = True
        for k in range(side * side):
            y, x = r + k // side, c + k % side
            far = far and owner[y, x] >= 0 and near[y, x] > least * least
        if far:
            return side
    return 1


@kernel
def continue_band(
    corner,
    flat,
    neighbor,
    neighbor_edge,
    transport,
    edge_face,
    edge_side,
    first_row,
    owner,
    near,
    exact,
    face,
    weight,
    host,
    turn,
    follows,
):
    """Walk from the nearest chart edge of every gutter texel straight on over the surface.

    The texel's centre is mapped by the affine frame of the edge's face to millimetres, and the straight line
    from the edge to there is unfolded over the neighbours (transport (m, 3, 4) float64); at a border of the
    mesh it goes on along the border, and ends on it. face, host (rows, width) int32, weight (rows, width, 3)
    float64, turn (rows, width) float32 are filled where owner (rows, width) int32 names an edge: the face reached, the face
    left, and the turn from its frame into the reached one's. Where texels are far from their edges, near (rows, width)
    float64 being the squares, a block of them shares the place in its middle: see `_side_of_block`. All but the first get
    the side of the block in follows (rows, width) int8.
    """
    rows, width = owner.shape
    for r in range(rows):
        for c in range(width):
            e = owner[r, c]
            if e < 0 or follows[r, c] > 0:
                continue
            f, i = edge_face[e], edge_side[e]
            j = (i + 1) % 3
            block = _side_of_block(owner, near, exact, r, c)
            px, py = c + 0.5 * block, r + 0.5 * block + first_row
            ax, ay = corner[f, i, 0], corner[f, i, 1]
            dx, dy = corner[f, j, 0] - ax, corner[f, j, 1] - ay
            squared = dx * dx + dy * dy
            t = 0.0
            if squared > 0.0:
                t = min(1.0, max(0.0, ((px - ax) * dx + (py - ay) * dy) / squared))
            sx = (1.0 - t) * flat[f, i, 0] + t * flat[f, j, 0]
            sy = (1.0 - t) * flat[f, i, 1] + t * flat[f, j, 1]
            ex, ey = corner[f, 1, 0] - corner[f, 0, 0], corner[f, 1, 1] - corner[f, 0, 1]
            gx, gy = corner[f, 2, 0] - corner[f, 0, 0], corner[f, 2, 1] - corner[f, 0, 1]
            qx, qy = px - corner[f, 0, 0], py - corner[f, 0, 1]
            twice = ex * gy - gx * ey
            tx, ty = sx, sy
            if abs(twice) > 1e-12:
                one, two = (qx * gy - gx * qy) / twice, (ex * qy - qx * ey) / twice
                tx = one * flat[f, 1, 0] + two * flat[f, 2, 0]
                ty = two * flat[f, 2, 1]
            g, entered, cosine, sine = f, -1, 1.0, 0.0
            w0, w1, w2 = 1.0, 0.0, 0.0
            slides = 0
            stop, stop0, stop1, stop2, stop_cosine, stop_sine = f, 1.0, 0.0, 0.0, 1.0, 0.0
            for step in range(4096):
                bx, cx, cy = flat[g, 1, 0], flat[g, 2, 0], flat[g, 2, 1]
                w2 = ty / cy
                w1 = (tx - w2 * cx) / bx
                w0 = 1.0 - w1 - w2
                s2 = sy / cy
                s1 = (sx - s2 * cx) / bx
                s0 = 1.0 - s1 - s2
                leave, soonest, deepest = -1, 2.0, 0.0
                for v in range(3):
                    edge = (v + 1) % 3
                    there = w0 if v == 0 else (w1 if v == 1 else w2)
                    if edge == entered or there >= -1e-12:
                        continue
                    here = max(0.0, s0 if v == 0 else (s1 if v == 1 else s2))
                    crossing = here / (here - there)
                    if step == 0 and edge == i:
                        crossing, there = 0.0, -math.inf
                    if crossing < soonest - 1e-12 or (crossing <= soonest + 1e-12 and there < deepest):
                        leave, soonest, deepest = edge, crossing, there
                if leave < 0:
                    if slides > 0:
                        on_border = False
                        if neighbor[g, 1] < 0 and w0 < 1e-9:
                            w0, on_border = 0.0, True
                        if neighbor[g, 2] < 0 and w1 < 1e-9:
                            w1, on_border = 0.0, True
                        if neighbor[g, 0] < 0 and w2 < 1e-9:
                            w2, on_border = 0.0, True
                        if not on_border:
                            g, w0, w1, w2, cosine, sine = stop, stop0, stop1, stop2, stop_cosine, stop_sine
                    break
                other = neighbor[g, leave]
                if other < 0:
                    after = (leave + 1) % 3
                    ux, uy = flat[g, after, 0] - flat[g, leave, 0], flat[g, after, 1] - flat[g, leave, 1]
                    along = ((tx - flat[g, leave, 0]) * ux + (ty - flat[g, leave, 1]) * uy) / (
                        ux * ux + uy * uy
                    )
                    tx, ty = flat[g, leave, 0] + along * ux, flat[g, leave, 1] + along * uy
                    along = min(1.0, max(0.0, along))
                    sx, sy = flat[g, leave, 0] + along * ux, flat[g, leave, 1] + along * uy
                    w0 = along if after == 0 else (1.0 - along if leave == 0 else 0.0)
                    w1 = along if after == 1 else (1.0 - along if leave == 1 else 0.0)
                    w2 = along if after == 2 else (1.0 - along if leave == 2 else 0.0)
                    stop, stop0, stop1, stop2, stop_cosine, stop_sine = g, w0, w1, w2, cosine, sine
                    slides += 1
                    if slides == 8:
                        break
                    entered = leave
                    continue
                k, s = transport[g, leave, 0], transport[g, leave, 1]
                mx, my = transport[g, leave, 2], transport[g, leave, 3]
                sx, sy = k * sx - s * sy + mx, s * sx + k * sy + my
                tx, ty = k * tx - s * ty + mx, s * tx + k * ty + my
                cosine, sine = k * cosine - s * sine, s * cosine + k * sine
                entered = neighbor_edge[g, leave]
                g = other
            w0, w1, w2 = max(0.0, w0), max(0.0, w1), max(0.0, w2)
            total = w0 + w1 + w2
            face[r, c], host[r, c] = g, f
            weight[r, c, 0], weight[r, c, 1], weight[r, c, 2] = w0 / total, w1 / total, w2 / total
            turn[r, c] = math.atan2(sine, cosine)
            for k in range(1, block * block):
                y, x = r + k // block, c + k % block
                face[y, x], host[y, x], turn[y, x], follows[y, x] = g, f, turn[r, c], block
                weight[y, x, 0], weight[y, x, 1], weight[y, x, 2] = (
                    weight[r, c, 0],
                    weight[r, c, 1],
                    weight[r, c, 2],
                )


@kernel
def close_up(first, face, host, weight, turn, core, follows, texel):
    """Move texels with a face to the front, in place and in their order; tell their places on the page.

    face (p,) int32, -1 where there is none, and what `raster_band` and `continue_band` found: host (p,) int32, weight (p, 3)
    float64, turn (p,) float32, core (p,) bool, follows (p,) int8; the first texel is `first` of the page -> texel (t,) int64.
    """
    to = 0
    for i in range(len(face)):
        if face[i] >= 0:
            face[to], host[to], turn[to], core[to], follows[to] = (
                face[i],
                host[i],
                turn[i],
                core[i],
                follows[i],
            )
            weight[to, 0], weight[to, 1], weight[to, 2] = weight[i, 0], weight[i, 1], weight[i, 2]
            texel[to] = first + i
            to += 1


@kernel
def find_leaders(texel, width, follows, source):
    """Find the first texel of the block that each follows, for texel (t,) int64 ascending, follows (t,) int8: its side.

    -> source (t,) int32: its row; a texel's own where it follows none, or none of the block before it is there.
    """
    above = 0
    for i in range(len(texel)):
        source[i] = i
        side = follows[i]
        if side == 0:
            continue
        place = texel[i]
        row, column = place // width, place % width
        if column % side > 0:
            source[i] = source[i - 1]
        elif row % side > 0:
            while texel[above] < place - width:
                above += 1
            if texel[above] == place - width:
                source[i] = source[above]


@kernel
def nearest_in_columns(mapped, row):
    """Find the nearest mapped texel of the same column; the upper one of two.

    mapped (height, width) bool -> row (height, width) int32, -1 where the column is empty.
    """
    height, width = mapped.shape
    for c in range(width):
        row[0, c] = 0 if mapped[0, c] else -1
    for r in range(1, height):
        for c in range(width):
            row[r, c] = r if mapped[r, c] else row[r - 1, c]
    for r in range(height - 2, -1, -1):
        for c in range(width):
            below = row[r + 1, c]
            if below > r and (row[r, c] < 0 or below - r < r - row[r, c]):
                row[r, c] = below


@kernel
def nearest_in_rows(row, first, last, site, reach, place, source):
    """Find the nearest mapped texel of those of rows [first, last) that are not: the lower envelope of a gap's parabolas.

    row (height, width) int32 of `nearest_in_columns`, of a page where some texel is mapped; site (width,) int64 and reach
    (width + 1,) float64: room to work in; place, source (as many as they may be,) int64: flat indices of the texel and of
    the nearest mapped one. Returns how many there are.
    """
    width, found = row.shape[1], 0
    for r in range(first, last):
        c = 0
        while c < width:
            left = c
            while c < width and row[r, c] != r:
                c += 1
            count = 0
            for right in range(max(left - 1, 0), min(c + 1, width) if c > left else 0):
                if row[r, right] < 0:
                    continue
                rise = float(row[r, right] - r) ** 2
                while True:
                    if count == 0:
                        start = -math.inf
                        break
                    b = site[count - 1]
                    start = rise + float(right) * right - (float(row[r, b] - r) ** 2 + float(b) * b)
                    start /= 2.0 * (right - b)
                    if start > reach[count - 1]:
                        break
                    count -= 1
                site[count] = right
                reach[count] = start
                count += 1
            k = 0
            for middle in range(left, c):
                while k + 1 < count and reach[k + 1] < middle:
                    k += 1
                place[found], source[found] = r * width + middle, row[r, site[k]] * width + site[k]
                found += 1
            c += 1
    return found
