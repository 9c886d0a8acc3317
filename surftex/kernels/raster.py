"""Triangles to texels: which face owns each texel centre, with which weights."""

from surftex.kernels.jit import kernel


@kernel
def raster_band(corner, candidate, first_row, face, weight):
    """Give every texel centre of a band of rows to the lowest face that holds it.

    corner (m, 3, 2) float64: column and row of each corner in texels, centres at one half; candidate (k,)
    int32: faces that may touch the band, ascending; face (rows, width) int32, -1 on entry; weight (rows,
    width, 3) float64. Texels on an edge belong to both its faces within 1e-9 of a weight. Faces without area
    own nothing.
    """
    rows, width = face.shape
    for k in range(len(candidate)):
        f = candidate[k]
        ax, ay = corner[f, 0, 0], corner[f, 0, 1] - first_row
        bx, by = corner[f, 1, 0], corner[f, 1, 1] - first_row
        cx, cy = corner[f, 2, 0], corner[f, 2, 1] - first_row
        twice = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if twice == 0.0:
            continue
        left, right = min(ax, bx, cx) - 0.501, max(ax, bx, cx) - 0.499
        top, bottom = min(ay, by, cy) - 0.501, max(ay, by, cy) - 0.499
        if right < 0.0 or bottom < 0.0 or left > width - 1 or top > rows - 1:
            continue
        first, last = int(max(left, 0.0)), int(min(right, width - 1.0))
        for r in range(int(max(top, 0.0)), int(min(bottom, rows - 1.0)) + 1):
            y = r + 0.5
            for c in range(first, last + 1):
                x = c + 0.5
                one = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / twice
                two = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / twice
                zero = 1.0 - one - two
                if zero >= -1e-9 and one >= -1e-9 and two >= -1e-9 and face[r, c] < 0:
                    zero, one, two = max(zero, 0.0), max(one, 0.0), max(two, 0.0)
                    total = zero + one + two
                    face[r, c] = f
                    weight[r, c, 0], weight[r, c, 1], weight[r, c, 2] = zero / total, one / total, two / total


@kernel
def overlap_band(corner, candidate, first_row, margin, count, first, second):
    """Count the faces that hold each texel centre by more than a margin.

    As `raster_band`; margin: texels that a centre must lie inside of each edge; count (rows, width) int32, 0
    on entry; first, second (rows, width) int32: the two lowest faces that hold it, -1 where there is none.
    """
    rows, width = count.shape
    for k in range(len(candidate)):
        f = candidate[k]
        ax, ay = corner[f, 0, 0], corner[f, 0, 1] - first_row
        bx, by = corner[f, 1, 0], corner[f, 1, 1] - first_row
        cx, cy = corner[f, 2, 0], corner[f, 2, 1] - first_row
        twice = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if twice == 0.0:
            continue
        sign = 1.0 if twice > 0.0 else -1.0
        ab = ((bx - ax) ** 2 + (by - ay) ** 2) ** 0.5 * margin
        bc = ((cx - bx) ** 2 + (cy - by) ** 2) ** 0.5 * margin
        ca = ((ax - cx) ** 2 + (ay - cy) ** 2) ** 0.5 * margin
        left, right = min(ax, bx, cx) - 0.501, max(ax, bx, cx) - 0.499
        top, bottom = min(ay, by, cy) - 0.501, max(ay, by, cy) - 0.499
        if right < 0.0 or bottom < 0.0 or left > width - 1 or top > rows - 1:
            continue
        begin, end = int(max(left, 0.0)), int(min(right, width - 1.0))
        for r in range(int(max(top, 0.0)), int(min(bottom, rows - 1.0)) + 1):
            y = r + 0.5
            for c in range(begin, end + 1):
                x = c + 0.5
                if (
                    sign * ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) > ab
                    and sign * ((cx - bx) * (y - by) - (cy - by) * (x - bx)) > bc
                    and sign * ((ax - cx) * (y - cy) - (ay - cy) * (x - cx)) > ca
                ):
                    if count[r, c] == 0:
                        first[r, c] = f
                    elif count[r, c] == 1:
                        second[r, c] = f
                    count[r, c] += 1
