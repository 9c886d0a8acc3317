"""Gradient noise in space: random slopes on a lattice, blended with a quintic."""

import numpy as np

from surftex.kernels.jit import kernel, part


def _slopes(count: int) -> np.ndarray:
    """Spread unit vectors evenly over the sphere (a Fibonacci spiral)."""
    z = 1 - (2 * np.arange(count) + 1) / count
    turn = np.arange(count) * np.pi * (3 - 5**0.5)
    return np.stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z], axis=1)


_SLOPES = _slopes(128)
_STEP, _FIRST, _SECOND = (
    np.uint64(0x9E3779B97F4A7C15),
    np.uint64(0xBF58476D1CE4E5B9),
    np.uint64(0x94D049BB133111EB),
)
_ROW, _LAYER = np.uint64(0xD6E8FEB86659FD93), np.uint64(0xA0761D6478BD642F)


@part
def _slope(corner):
    """Draw the slope of a lattice corner."""
    mixed = (corner ^ (corner >> np.uint64(30))) * _FIRST
    mixed = (mixed ^ (mixed >> np.uint64(27))) * _SECOND
    return np.int64(mixed >> np.uint64(57))


@part
def _lift(slope, x, y, z):
    """Height that a slope has at an offset (x, y, z) from its corner."""
    return _SLOPES[slope, 0] * x + _SLOPES[slope, 1] * y + _SLOPES[slope, 2] * z


@kernel
def gradient_noise(position, footprint, key, frame, offset, weight, wavelength, value):
    """Sum octaves of gradient noise at n points; quicker where points follow one another closely.

    position (n, 3) float64, footprint (n,) float64; for each of k octaves: key (k,) uint64, frame (k, 3, 3)
    float64 (mm to lattice cells), offset (k, 3) float64, weight (k,) float64, wavelength (k,) float64
    -> value (n,) float32. An octave fades as the footprint goes from 1/4 to 1/2 of its wavelength.
    """
    last = np.full((len(key), 3), np.inf)
    slopes = np.zeros((len(key), 8), np.int64)
    for i in range(len(position)):
        px, py, pz = position[i, 0], position[i, 1], position[i, 2]
        total = 0.0
        for k in range(len(key)):
            fade = min(max(2.0 - 4.0 * footprint[i] / wavelength[k], 0.0), 1.0)
            if fade == 0.0:
                continue
            x = frame[k, 0, 0] * px + frame[k, 0, 1] * py + frame[k, 0, 2] * pz + offset[k, 0]
            y = frame[k, 1, 0] * px + frame[k, 1, 1] * py + frame[k, 1, 2] * pz + offset[k, 1]
            z = frame[k, 2, 0] * px + frame[k, 2, 1] * py + frame[k, 2, 2] * pz + offset[k, 2]
            cx, cy, cz = np.floor(x), np.floor(y), np.floor(z)
            x, y, z = x - cx, y - cy, z - cz
            if cx != last[k, 0] or cy != last[k, 1] or cz != last[k, 2]:
                last[k, 0], last[k, 1], last[k, 2] = cx, cy, cz
                x0, y0, z0 = (
                    key[k] + np.uint64(np.int64(cx)) * _STEP,
                    np.uint64(np.int64(cy)) * _ROW,
                    np.uint64(np.int64(cz)) * _LAYER,
                )
                x1, y1, z1 = x0 + _STEP, y0 + _ROW, z0 + _LAYER
                slopes[k, 0], slopes[k, 1] = _slope(x0 + y0 + z0), _slope(x1 + y0 + z0)
                slopes[k, 2], slopes[k, 3] = _slope(x0 + y1 + z0), _slope(x1 + y1 + z0)
                slopes[k, 4], slopes[k, 5] = _slope(x0 + y0 + z1), _slope(x1 + y0 + z1)
                slopes[k, 6], slopes[k, 7] = _slope(x0 + y1 + z1), _slope(x1 + y1 + z1)
            u = x * x * x * (x * (x * 6.0 - 15.0) + 10.0)
            v = y * y * y * (y * (y * 6.0 - 15.0) + 10.0)
            w = z * z * z * (z * (z * 6.0 - 15.0) + 10.0)
            a = _lift(slopes[k, 0], x, y, z)
            b = _lift(slopes[k, 1], x - 1.0, y, z)
            c = _lift(slopes[k, 2], x, y - 1.0, z)
            d = _lift(slopes[k, 3], x - 1.0, y - 1.0, z)
            a, c = a + u * (b - a), c + u * (d - c)
            low = a + v * (c - a)
            a = _lift(slopes[k, 4], x, y, z - 1.0)
            b = _lift(slopes[k, 5], x - 1.0, y, z - 1.0)
            c = _lift(slopes[k, 6], x, y - 1.0, z - 1.0)
            d = _lift(slopes[k, 7], x - 1.0, y - 1.0, z - 1.0)
            a, c = a + u * (b - a), c + u * (d - c)
            high = a + v * (c - a)
            total += weight[k] * fade * fade * (3.0 - 2.0 * fade) * (low + w * (high - low))
        value[i] = total
