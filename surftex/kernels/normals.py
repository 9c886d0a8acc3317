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
def gradients(first, last, width, texel, index, chart, host, turn, height, stretch, axes, gradient):
    """Find the height's gradient in the frame of each texel's face, by central differences.

    texel (t,) int64 places on the page; index (pixels,) int32: its inverse, -1 = none; chart (m,) int32;
    host (t,) int32; turn (t,) float32; height (t,) float32 mm; stretch (m, 3), axes (m, 2, 2) float64
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
        hx = axes[face, 0, 0] * gx + axes[face, 0, 1] * gy
        hy = axes[face, 1, 0] * gx + axes[face, 1, 1] * gy
        if turn[i] != 0.0:
            c, s = np.cos(float(turn[i])), np.sin(float(turn[i]))
            hx, hy = c * hx - s * hy, s * hx + c * hy
        gradient[i, 0] = hx
        gradient[i, 1] = hy


@kernel
def bent_normals(first, last, gradient, face, barycentric, frame, shading, normal):
    """Bend shading normals by the gradient of a height, laid into their plane; unit length.

    gradient (t, 2) float32 in the frame of `face` (t,) int32; barycentric (t, 3) float64; frame (m, 3, 3),
    shading (m, 3, 3) float64 -> normal (t, 3) float32: rows first to last.
    """
    for i in range(first, last):
        f = face[i]
        p, q, r = barycentric[i, 0], barycentric[i, 1], barycentric[i, 2]
        nx = p * shading[f, 0, 0] + q * shading[f, 1, 0] + r * shading[f, 2, 0]
        ny = p * shading[f, 0, 1] + q * shading[f, 1, 1] + r * shading[f, 2, 1]
        nz = p * shading[f, 0, 2] + q * shading[f, 1, 2] + r * shading[f, 2, 2]
        length = np.sqrt(nx * nx + ny * ny + nz * nz)
        if length < 1e-9:
            nx, ny, nz, length = frame[f, 2, 0], frame[f, 2, 1], frame[f, 2, 2], 1.0
        nx, ny, nz = nx / length, ny / length, nz / length
        gx = gradient[i, 0] * frame[f, 0, 0] + gradient[i, 1] * frame[f, 1, 0]
        gy = gradient[i, 0] * frame[f, 0, 1] + gradient[i, 1] * frame[f, 1, 1]
        gz = gradient[i, 0] * frame[f, 0, 2] + gradient[i, 1] * frame[f, 1, 2]
        kx, ky, kz = frame[f, 2, 0], frame[f, 2, 1], frame[f, 2, 2]
        turned = (gx * nx + gy * ny + gz * nz) / max(1.0 + kx * nx + ky * ny + kz * nz, 0.1)
        nx, ny, nz = (
            nx - gx + turned * (kx + nx),
            ny - gy + turned * (ky + ny),
            nz - gz + turned * (kz + nz),
        )
        length = np.sqrt(nx * nx + ny * ny + nz * nz)
        normal[i, 0], normal[i, 1], normal[i, 2] = nx / length, ny / length, nz / length


@kernel
def encode_normals(first, last, width, texel, host, weight, shading, tangent, normal):
    """Turn normals, in place, into the interpolated tangent frame of each texel's host face.

    texel (t,) int64; host (t,) int32; weight (m, 3, 3), shading (m, 3, 3), tangent (m, 3, 4) float64; normal
    (t, 3) float32: rows first to last. Frames are not normalised before use, as in a shader. Beyond the face
    they are carried on, by at most half of a corner's weight.
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
        sign = tangent[f, 0, 3]
        bx, by, bz = sign * (ny * tz - nz * ty), sign * (nz * tx - nx * tz), sign * (nx * ty - ny * tx)
        mx, my, mz = float(normal[i, 0]), float(normal[i, 1]), float(normal[i, 2])
        ex = mx * (by * nz - bz * ny) + my * (bz * nx - bx * nz) + mz * (bx * ny - by * nx)
        ey = mx * (ny * tz - nz * ty) + my * (nz * tx - nx * tz) + mz * (nx * ty - ny * tx)
        ez = mx * (ty * bz - tz * by) + my * (tz * bx - tx * bz) + mz * (tx * by - ty * bx)
        volume = tx * (by * nz - bz * ny) + ty * (bz * nx - bx * nz) + tz * (bx * ny - by * nx)
        length = np.sqrt(ex * ex + ey * ey + ez * ez)
        if length < 1e-12:
            ex, ey, ez, length = 0.0, 0.0, 1.0, 1.0
        elif volume < 0.0:
            length = -length
        normal[i, 0], normal[i, 1], normal[i, 2] = ex / length, ey / length, ez / length
