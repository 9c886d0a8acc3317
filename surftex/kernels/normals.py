"""From height at texels to normals in the tangent frames of an exported mesh."""

import numpy as np

from surftex.kernels.jit import kernel


@kernel
def _step(i, other, chart, host, height, stretch, along):
    """Measure a step from texel i to another: mm along page x, along page y, rise; zero where there is none.

    The step is made half in the metric of the one host face, half in the other's.
    """
    if other < 0:
        return 0.0, 0.0, 0.0
    here, there = host[i], host[other]
    if chart[here] != chart[there]:
        return 0.0, 0.0, 0.0
    x = 0.5 * (stretch[here, along] + stretch[there, along])
    y = 0.5 * (stretch[here, along + 1] + stretch[there, along + 1])
    return x, y, float(height[other]) - float(height[i])


@kernel
def gradients(first, last, width, texel, index, chart, host, height, stretch, axes, gradient):
    """Find the height's gradient in the frame of each texel's host face, by central differences.

    texel (t,) int64 places on the page; index (pixels,) int32: its inverse, -1 = none; chart (m,) int32;
    host (t,) int32; height (t,) float32 mm; stretch (m, 3), axes (m, 2, 2) float64
    -> gradient (t, 2) float32: rows first to last.
    """
    pixels = len(index)
    for i in range(first, last):
        place = texel[i]
        column = place % width
        right = index[place + 1] if column + 1 < width else -1
        left = index[place - 1] if column > 0 else -1
        up = index[place - width] if place >= width else -1
        down = index[place + width] if place + width < pixels else -1
        rx, ry, rise = _step(i, right, chart, host, height, stretch, 0)
        lx, ly, fall = _step(i, left, chart, host, height, stretch, 0)
        ax, ay, a = rx + lx, ry + ly, rise - fall
        ux, uy, rise = _step(i, up, chart, host, height, stretch, 1)
        dx, dy, fall = _step(i, down, chart, host, height, stretch, 1)
        bx, by, b = ux + dx, uy + dy, rise - fall
        face = host[i]
        if ax == 0.0 and ay == 0.0:
            ax, ay = stretch[face, 0], stretch[face, 1]
        if bx == 0.0 and by == 0.0:
            bx, by = stretch[face, 1], stretch[face, 2]
        determinant = ax * by - ay * bx
        gx, gy = 0.0, 0.0
        if determinant != 0.0:
            gx, gy = (a * by - b * ay) / determinant, (b * ax - a * bx) / determinant
        gradient[i, 0] = axes[face, 0, 0] * gx + axes[face, 0, 1] * gy
        gradient[i, 1] = axes[face, 1, 0] * gx + axes[face, 1, 1] * gy


@kernel
def encode_slopes(first, last, width, texel, gradient, host, weight, frame, shading, tangent, normal):
    """Bend the shading normal of each texel's host face by a gradient, told in the host's own tangent frame.

    The gradient is tilted from the plane of the face into that of the shading normal. texel (t,) int64; gradient
    (t, 2) float32 in the frame of `host` (t,) int32; weight (m, 3, 3), frame (m, 3, 3), shading (m, 3, 3), tangent
    (m, 3, 4) float64 -> normal (t, 3) float32: rows first to last. Frames are not normalised before use, as in a
    shader. Beyond the face they are carried on, by at most half of a corner's weight.
    """
    for i in range(first, last):
        f = host[i]
        x, y = texel[i] % width + 0.5, texel[i] // width + 0.5
        p = weight[f, 0, 0] + weight[f, 0, 1] * x + weight[f, 0, 2] * y - 1 / 3
        q = weight[f, 1, 0] + weight[f, 1, 1] * x + weight[f, 1, 2] * y - 1 / 3
        r = weight[f, 2, 0] + weight[f, 2, 1] * x + weight[f, 2, 2] * y - 1 / 3
        low = min(p, q, r)
        shrink = min(1.0, -0.8333333333333334 / low) if low < 0.0 else 1.0
        p, q, r = 1 / 3 + shrink * p, 1 / 3 + shrink * q, 1 / 3 + shrink * r
        nx = p * shading[f, 0, 0] + q * shading[f, 1, 0] + r * shading[f, 2, 0]
        ny = p * shading[f, 0, 1] + q * shading[f, 1, 1] + r * shading[f, 2, 1]
        nz = p * shading[f, 0, 2] + q * shading[f, 1, 2] + r * shading[f, 2, 2]
        tx = p * tangent[f, 0, 0] + q * tangent[f, 1, 0] + r * tangent[f, 2, 0]
        ty = p * tangent[f, 0, 1] + q * tangent[f, 1, 1] + r * tangent[f, 2, 1]
        tz = p * tangent[f, 0, 2] + q * tangent[f, 1, 2] + r * tangent[f, 2, 2]
        nn, tt, tn = nx * nx + ny * ny + nz * nz, tx * tx + ty * ty + tz * tz, tx * nx + ty * ny + tz * nz
        area = nn * tt - tn * tn
        ex, ey, ez = 0.0, 0.0, 1.0
        if area > 1e-12:
            length = np.sqrt(nn)
            ux, uy, uz = nx / length, ny / length, nz / length
            kx, ky, kz = frame[f, 2, 0], frame[f, 2, 1], frame[f, 2, 2]
            gx = gradient[i, 0] * frame[f, 0, 0] + gradient[i, 1] * frame[f, 1, 0]
            gy = gradient[i, 0] * frame[f, 0, 1] + gradient[i, 1] * frame[f, 1, 1]
            gz = gradient[i, 0] * frame[f, 0, 2] + gradient[i, 1] * frame[f, 1, 2]
            tilt = (gx * ux + gy * uy + gz * uz) / max(1.0 + kx * ux + ky * uy + kz * uz, 0.1)
            gx, gy, gz = gx - tilt * (kx + ux), gy - tilt * (ky + uy), gz - tilt * (kz + uz)
            gt, gn = gx * tx + gy * ty + gz * tz, gx * nx + gy * ny + gz * nz
            bx, by, bz = ny * tz - nz * ty, nz * tx - nx * tz, nx * ty - ny * tx
            ex = (tn * gn - nn * gt) / area
            ey = -tangent[f, 0, 3] * (gx * bx + gy * by + gz * bz) / area
            ez = 1.0 / length - (tt * gn - tn * gt) / area
        length = np.sqrt(ex * ex + ey * ey + ez * ez)
        normal[i, 0], normal[i, 1], normal[i, 2] = ex / length, ey / length, ez / length
