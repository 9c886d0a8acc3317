"""Gradient noise in space: random slopes on a lattice, blended with a quintic; several octaves side by side.

`block` (ROWS * LANES,) holds all of LANES octaves: rows of numbers that processors take LANES at a time.
"""

import numpy as np

from surftex.kernels.jit import kernel, part

LANES = 8
"""Octaves that are computed at once."""

_FRAME, _OFFSET, _CELL, _PLACE, _SLOPE, _AMOUNT, _MOVED, _VALUE = 0, 9, 12, 15, 18, 42, 43, 44
ROWS = 45
"""Nine of the frames, three each of offsets, last cells of the lattice and places in them, 24 of slopes, amounts,
steps, values."""

NO_CELL = 1e300


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
def _draw(block, k, key):
    """Draw the slopes at the eight corners of the lattice cell that octave k of a block is in."""
    x = key + np.uint64(np.int64(block[_CELL * LANES + k])) * _STEP
    y = np.uint64(np.int64(block[(_CELL + 1) * LANES + k])) * _ROW
    z = np.uint64(np.int64(block[(_CELL + 2) * LANES + k])) * _LAYER
    for corner in range(8):
        slope = _slope(
            x
            + np.uint64(corner & 1) * _STEP
            + y
            + np.uint64(corner >> 1 & 1) * _ROW
            + z
            + np.uint64(corner >> 2) * _LAYER
        )
        for axis in range(3):
            block[(_SLOPE + 3 * corner + axis) * LANES + k] = _SLOPES[slope, axis]


@part
def _lattice(block, k, axis, px, py, pz):
    """Place along an axis of the lattice of octave k."""
    row = (_FRAME + 3 * axis) * LANES + k
    return (
        block[row] * px
        + block[row + LANES] * py
        + block[row + 2 * LANES] * pz
        + block[(_OFFSET + axis) * LANES + k]
    )


@part
def _lift(block, k, corner, x, y, z):
    """Height that the slope of a corner has at an offset (x, y, z) from it, in octave k."""
    row = (_SLOPE + 3 * corner) * LANES + k
    return block[row] * x + block[row + LANES] * y + block[row + 2 * LANES] * z


@part
def _enter(block, key, px, py, pz):
    """Find the place (px, py, pz) in all lattices, and draw the slopes of octaves that show and are in a new cell."""
    for k in range(LANES):
        x, y, z = (
            _lattice(block, k, 0, px, py, pz),
            _lattice(block, k, 1, px, py, pz),
            _lattice(block, k, 2, px, py, pz),
        )
        cx, cy, cz = np.floor(x), np.floor(y), np.floor(z)
        block[_PLACE * LANES + k] = x - cx
        block[(_PLACE + 1) * LANES + k] = y - cy
        block[(_PLACE + 2) * LANES + k] = z - cz
        block[_MOVED * LANES + k] = block[_AMOUNT * LANES + k] * (
            abs(cx - block[_CELL * LANES + k])
            + abs(cy - block[(_CELL + 1) * LANES + k])
            + abs(cz - block[(_CELL + 2) * LANES + k])
        )
        shows = block[_AMOUNT * LANES + k] > 0.0
        block[_CELL * LANES + k] = cx if shows else block[_CELL * LANES + k]
        block[(_CELL + 1) * LANES + k] = cy if shows else block[(_CELL + 1) * LANES + k]
        block[(_CELL + 2) * LANES + k] = cz if shows else block[(_CELL + 2) * LANES + k]
    for k in range(LANES):
        if block[_MOVED * LANES + k] != 0.0:
            _draw(block, k, key[k])


@part
def _fade(block, footprint, weight, wavelength):
    """Find by how much each octave of a block shows at a footprint; whether any does."""
    left = 0
    for k in range(LANES):
        fade = min(max(2.0 - 4.0 * footprint / wavelength[k], 0.0), 1.0)
        block[_AMOUNT * LANES + k] = weight[k] * fade * fade * (3.0 - 2.0 * fade)
        left |= np.int64(fade > 0.0)
    return left


@part
def _blend(block):
    """Blend the slopes around the place in each octave."""
    for k in range(LANES):
        x, y, z = (
            block[_PLACE * LANES + k],
            block[(_PLACE + 1) * LANES + k],
            block[(_PLACE + 2) * LANES + k],
        )
        u = x * x * x * (x * (x * 6.0 - 15.0) + 10.0)
        v = y * y * y * (y * (y * 6.0 - 15.0) + 10.0)
        w = z * z * z * (z * (z * 6.0 - 15.0) + 10.0)
        a = _lift(block, k, 0, x, y, z)
        b = _lift(block, k, 1, x - 1.0, y, z)
        c = _lift(block, k, 2, x, y - 1.0, z)
        d = _lift(block, k, 3, x - 1.0, y - 1.0, z)
        a, c = a + u * (b - a), c + u * (d - c)
        low = a + v * (c - a)
        a = _lift(block, k, 4, x, y, z - 1.0)
        b = _lift(block, k, 5, x - 1.0, y, z - 1.0)
        c = _lift(block, k, 6, x, y - 1.0, z - 1.0)
        d = _lift(block, k, 7, x - 1.0, y - 1.0, z - 1.0)
        a, c = a + u * (b - a), c + u * (d - c)
        high = a + v * (c - a)
        block[_VALUE * LANES + k] = block[_AMOUNT * LANES + k] * (low + w * (high - low))


@kernel
def gradient_noise(position, footprint, key, weight, wavelength, noise, block, value):
    """Add LANES octaves of gradient noise, of one noise or several, at n points; quicker where these follow closely.

    position (n, 3) float64, footprint (n,) float; for each octave key uint64, weight, wavelength float64, all (LANES,), and
    noise int64: whose octave it is, ascending. block (ROWS * LANES,) float64: frames (mm to lattice cells), offsets
    and cells are given, cells as NO_CELL -> value (c, n) float64.
    An octave fades as the footprint goes from 1/4 to 1/2 of its wavelength.
    """
    shown, last = 0, -1.0
    for i in range(len(position)):
        if footprint[i] != last:
            last = footprint[i]
            shown = _fade(block, last, weight, wavelength)
        if shown == 0:
            continue
        _enter(block, key, position[i, 0], position[i, 1], position[i, 2])
        _blend(block)
        for k in range(LANES):
            value[noise[k], i] += block[_VALUE * LANES + k]
