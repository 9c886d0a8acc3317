"""A net of furrows from cells in space: where a sample lies in the section that a surface makes through them."""

import math

import numpy as np

from surftex.kernels.jit import kernel, part

_STEP, _FIRST, _SECOND = (
    np.uint64(0x9E3779B97F4A7C15),
    np.uint64(0xBF58476D1CE4E5B9),
    np.uint64(0x94D049BB133111EB),
)
_ROW, _LAYER = np.uint64(0xD6E8FEB86659FD93), np.uint64(0xA0761D6478BD642F)
_BITS = np.uint64(0x1FFFFF)
_JITTER = 0.9


@part
def _squared(stretch, x, y, z, xx, xy, xz, yy, yz, zz):
    """Squared length of (x, y, z), shortened along the tension."""
    return (
        x * x + y * y + z * z
        - stretch * (xx * x * x + yy * y * y + zz * z * z + 2.0 * (xy * x * y + xz * x * z + yz * y * z))
    )  # fmt: skip


@part
def _apart(ax, ay, az, bx, by, bz, nx, ny, nz):
    """Length of b - a along the surface, and its direction across the normal."""
    x, y, z = bx - ax, by - ay, bz - az
    up = x * nx + y * ny + z * nz
    x, y, z = x - up * nx, y - up * ny, z - up * nz
    return max(math.sqrt(x * x + y * y + z * z), 1e-6), x, y, z


@part
def _across(stretch, length, x, y, z, xx, xy, xz, yy, yz, zz):
    """How well a border across (x, y, z) lies along the tension, 0 to 1; how much the border's distance shrinks."""
    along = xx * x * x + yy * y * y + zz * z * z + 2.0 * (xy * x * y + xz * x * z + yz * y * z)
    share = min(max(along / (length * length), 0.0), 1.0)
    return 1.0 - share, length * math.sqrt(1.0 - stretch * (2.0 - stretch) * share)


@kernel
def furrow_net(begin, end, place, normal, tension, spacing, stretch, key, border, along, inner):
    """Locate samples [begin, end) in a net of cells with one random site per cube of the side `spacing`.

    place, normal (n, 3) float64; tension (n, 6) float64: entries xx, xy, xz, yy, yz, zz of t t^T for the unit direction t of
    tension, shorter where it is not clear. stretch: 0 for round cells, 1 - 1/s^2 for cells s times as long along it.
    -> border (n, 2) float32: mm to the borders with the two nearest neighbours; along (n, 2) float32: how well those lie
    along the tension, 0 to 1; inner (n,) float32: mm to the border between these neighbours.
    """
    for i in range(begin, end):
        px, py, pz = place[i, 0] / spacing, place[i, 1] / spacing, place[i, 2] / spacing
        nx, ny, nz = normal[i, 0], normal[i, 1], normal[i, 2]
        xx, xy, xz = tension[i, 0], tension[i, 1], tension[i, 2]
        yy, yz, zz = tension[i, 3], tension[i, 4], tension[i, 5]
        cx, cy, cz = math.floor(px), math.floor(py), math.floor(pz)
        px, py, pz = px - cx, py - cy, pz - cz
        d1, d2, d3 = math.inf, math.inf, math.inf
        ax, ay, az, bx, by, bz, gx, gy, gz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for u in range(-1, 2):
            for v in range(-1, 2):
                for w in range(-1, 2):
                    mixed = (
                        key
                        + np.uint64(np.int64(cx) + u) * _STEP
                        + np.uint64(np.int64(cy) + v) * _ROW
                        + np.uint64(np.int64(cz) + w) * _LAYER
                    )
                    mixed = (mixed ^ (mixed >> np.uint64(30))) * _FIRST
                    mixed = (mixed ^ (mixed >> np.uint64(27))) * _SECOND
                    mixed = mixed ^ (mixed >> np.uint64(31))
                    scale = _JITTER * 2.0**-21
                    x = u + 0.05 + scale * np.float64(mixed & _BITS) - px
                    y = v + 0.05 + scale * np.float64((mixed >> np.uint64(21)) & _BITS) - py
                    z = w + 0.05 + scale * np.float64((mixed >> np.uint64(42)) & _BITS) - pz
                    d = _squared(stretch, x, y, z, xx, xy, xz, yy, yz, zz)
                    if d < d1:
                        d3, gx, gy, gz = d2, bx, by, bz
                        d2, bx, by, bz = d1, ax, ay, az
                        d1, ax, ay, az = d, x, y, z
                    elif d < d2:
                        d3, gx, gy, gz = d2, bx, by, bz
                        d2, bx, by, bz = d, x, y, z
                    elif d < d3:
                        d3, gx, gy, gz = d, x, y, z
        long, x, y, z = _apart(ax, ay, az, bx, by, bz, nx, ny, nz)
        share, slope = _across(stretch, long, x, y, z, xx, xy, xz, yy, yz, zz)
        border[i, 0] = spacing * (d2 - d1) / (2.0 * slope)
        along[i, 0] = share
        long, x, y, z = _apart(ax, ay, az, gx, gy, gz, nx, ny, nz)
        share, slope = _across(stretch, long, x, y, z, xx, xy, xz, yy, yz, zz)
        border[i, 1] = spacing * (d3 - d1) / (2.0 * slope)
        along[i, 1] = share
        long, x, y, z = _apart(bx, by, bz, gx, gy, gz, nx, ny, nz)
        share, slope = _across(stretch, long, x, y, z, xx, xy, xz, yy, yz, zz)
        inner[i] = spacing * (d3 - d2) / (2.0 * slope)
