"""What a camera or a lamp sees: the nearest face of each pixel, depth, and light that arrives."""

from surftex.kernels.jit import kernel


@kernel
def nearest_faces(corner, first_row, face, weight, nearness):
    """Find the nearest face behind each pixel centre of a band of rows.

    corner (m, 3, 3) float64: column, row and 1 / depth of each corner; face (rows, width) int32, -1 on entry;
    weight (rows, width, 3) float32: weights of the corners, true to perspective; nearness (rows, width) float32:
    1 / depth, 0 on entry.
    """
    rows, width = face.shape
    for f in range(len(corner)):
        ax, ay, az = corner[f, 0, 0], corner[f, 0, 1] - first_row, corner[f, 0, 2]
        bx, by, bz = corner[f, 1, 0], corner[f, 1, 1] - first_row, corner[f, 1, 2]
        cx, cy, cz = corner[f, 2, 0], corner[f, 2, 1] - first_row, corner[f, 2, 2]
        top, bottom = min(ay, by, cy) - 0.5, max(ay, by, cy) - 0.5
        left, right = min(ax, bx, cx) - 0.5, max(ax, bx, cx) - 0.5
        if bottom < 0.0 or right < 0.0 or top > rows - 1 or left > width - 1:
            continue
        twice = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if twice == 0.0:
            continue
        for r in range(int(max(top, 0.0)), int(min(bottom, rows - 1.0)) + 1):
            y = r + 0.5
            for c in range(int(max(left, 0.0)), int(min(right, width - 1.0)) + 1):
                x = c + 0.5
                one = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / twice
                two = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / twice
                zero = 1.0 - one - two
                if zero < 0.0 or one < 0.0 or two < 0.0:
                    continue
                near = zero * az + one * bz + two * cz
                if near > nearness[r, c]:
                    nearness[r, c] = near
                    face[r, c] = f
                    weight[r, c, 0], weight[r, c, 1], weight[r, c, 2] = (
                        zero * az / near,
                        one * bz / near,
                        two * cz / near,
                    )


@kernel
def lamp_depths(vertex, faces, lamp, scale, depth):
    """Draw the mesh as far parallel lamps see it.

    vertex (n, 3) float64 around the middle of the scene; faces (m, 3) int32; lamp (l, 3, 3) float64: right, up and
    towards each lamp; scale: pixels in a millimetre; depth (l, s, s) float32: millimetres towards the lamp of
    what is nearest to it, -1e30 on entry.
    """
    size = depth.shape[1]
    half = 0.5 * size
    for k in range(len(lamp)):
        for f in range(len(faces)):
            a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
            ax = half + scale * (
                vertex[a, 0] * lamp[k, 0, 0] + vertex[a, 1] * lamp[k, 0, 1] + vertex[a, 2] * lamp[k, 0, 2]
            )
            ay = half + scale * (
                vertex[a, 0] * lamp[k, 1, 0] + vertex[a, 1] * lamp[k, 1, 1] + vertex[a, 2] * lamp[k, 1, 2]
            )
            az = vertex[a, 0] * lamp[k, 2, 0] + vertex[a, 1] * lamp[k, 2, 1] + vertex[a, 2] * lamp[k, 2, 2]
            bx = half + scale * (
                vertex[b, 0] * lamp[k, 0, 0] + vertex[b, 1] * lamp[k, 0, 1] + vertex[b, 2] * lamp[k, 0, 2]
            )
            by = half + scale * (
                vertex[b, 0] * lamp[k, 1, 0] + vertex[b, 1] * lamp[k, 1, 1] + vertex[b, 2] * lamp[k, 1, 2]
            )
            bz = vertex[b, 0] * lamp[k, 2, 0] + vertex[b, 1] * lamp[k, 2, 1] + vertex[b, 2] * lamp[k, 2, 2]
            cx = half + scale * (
                vertex[c, 0] * lamp[k, 0, 0] + vertex[c, 1] * lamp[k, 0, 1] + vertex[c, 2] * lamp[k, 0, 2]
            )
            cy = half + scale * (
                vertex[c, 0] * lamp[k, 1, 0] + vertex[c, 1] * lamp[k, 1, 1] + vertex[c, 2] * lamp[k, 1, 2]
            )
            cz = vertex[c, 0] * lamp[k, 2, 0] + vertex[c, 1] * lamp[k, 2, 1] + vertex[c, 2] * lamp[k, 2, 2]
            twice = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
            if twice == 0.0:
                continue
            left, right = max(int(min(ax, bx, cx) - 0.5), 0), min(int(max(ax, bx, cx) + 0.5), size - 1)
            top, bottom = max(int(min(ay, by, cy) - 0.5), 0), min(int(max(ay, by, cy) + 0.5), size - 1)
            for r in range(top, bottom + 1):
                y = r + 0.5
                for col in range(left, right + 1):
                    x = col + 0.5
                    one = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / twice
                    two = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / twice
                    zero = 1.0 - one - two
                    if zero >= 0.0 and one >= 0.0 and two >= 0.0:
                        height = zero * az + one * bz + two * cz
                        if height > depth[k, r, col]:
                            depth[k, r, col] = height


@kernel
def lamp_light(point, normal, facing, lamp, share, group, scale, depth, slack, light, seen):
    """Gather what each group of lamps sends to points, in the shadow of the mesh.

    point, normal, facing (n, 3) float32: places, the normals that shade, and those of the mesh alone; lamp (l, 3, 3)
    float64; share (l,) float64: irradiance on a plane that faces the lamp; group (l,) int32; depth as drawn by
    `lamp_depths`; slack: millimetres that a point may lie behind what the lamp sees; light (n, g) float32 and
    seen (n, g) float32, 0 on entry: irradiance, and the share of the group's lamps in sight.
    """
    size = depth.shape[1]
    half = 0.5 * size
    for i in range(len(point)):
        for k in range(len(lamp)):
            g = group[k]
            tx, ty, tz = lamp[k, 2, 0], lamp[k, 2, 1], lamp[k, 2, 2]
            front = facing[i, 0] * tx + facing[i, 1] * ty + facing[i, 2] * tz
            if front <= 0.0:
                continue
            x0, y0, z0 = point[i, 0], point[i, 1], point[i, 2]
            x = half - 0.5 + scale * (x0 * lamp[k, 0, 0] + y0 * lamp[k, 0, 1] + z0 * lamp[k, 0, 2])
            y = half - 0.5 + scale * (x0 * lamp[k, 1, 0] + y0 * lamp[k, 1, 1] + z0 * lamp[k, 1, 2])
            height = x0 * tx + y0 * ty + z0 * tz + slack * (1.0 + 2.0 * (1.0 - front))
            open_share = 1.0
            if x > 0.0 and y > 0.0 and x < size - 2 and y < size - 2:
                c, r = int(x), int(y)
                u, v = x - c, y - r
                open_share = 0.0
                if depth[k, r, c] <= height:
                    open_share += (1.0 - u) * (1.0 - v)
                if depth[k, r, c + 1] <= height:
                    open_share += u * (1.0 - v)
                if depth[k, r + 1, c] <= height:
                    open_share += (1.0 - u) * v
                if depth[k, r + 1, c + 1] <= height:
                    open_share += u * v
            seen[i, g] += open_share
            cosine = normal[i, 0] * tx + normal[i, 1] * ty + normal[i, 2] * tz
            if cosine > 0.0:
                light[i, g] += cosine * share[k] * open_share * min(1.0, 8.0 * front)
