"""Gradient noise in space: random slopes on a lattice, blended with a quintic; several octaves side by side.

`block` (ROWS * LANES,) float64 and `near` (NEAR_ROWS * LANES,) float32 hold all of LANES octaves: rows of numbers that
processors take LANES at a time. Places are found in double precision, far from the origin; what is blended lies near.
"""

import numpy as np

from surftex.kernels.jit import kernel, part

LANES = 8
"""Octaves that are computed at once."""

_FRAME, _OFFSET, _CELL, _PLACE, _AMOUNT, _MOVED = 0, 9, 12, 15, 18, 19
ROWS = 20
"""Nine of the frames, three each of offsets, cells of the lattice and places in them; amounts, and whether the cell is new."""

_SLOPE, _VALUE, _NEAR, _SHARE = 0, 24, 25, 28
NEAR_ROWS = 29
"""24 of slopes, values, three of places in a cell, amounts."""

_NO_CELL = 1e300
_1, _6, _10, _15 = (np.float32(number) for number in (1, 6, 10, 15))


def _slopes(count: int) -> np.ndarray:
    """Spread unit vectors evenly over the sphere (a Fibonacci spiral)."""
    z = 1 - (2 * np.arange(count) + 1) / count
    turn = np.arange(count) * np.pi * (3 - 5**0.5)
    return np.stack([np.sqrt(1 - z * z) * np.cos(turn), np.sqrt(1 - z * z) * np.sin(turn), z], axis=1)


_SLOPES = _slopes(128).astype(np.float32)
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
def _draw(block, near, k, key):
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
            near[(_SLOPE + 3 * corner + axis) * LANES + k] = _SLOPES[slope, axis]


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
def _enter(block, px, py, pz):
    """Find the place (px, py, pz) in all lattices, and which octaves that show are in a new cell."""
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
        moved = (
            (cx != block[_CELL * LANES + k])
            | (cy != block[(_CELL + 1) * LANES + k])
            | (cz != block[(_CELL + 2) * LANES + k])
        )
        block[_MOVED * LANES + k] = block[_AMOUNT * LANES + k] if moved else 0.0
        block[_CELL * LANES + k] = cx
        block[(_CELL + 1) * LANES + k] = cy
        block[(_CELL + 2) * LANES + k] = cz


@part
def _fade(block, footprint, weight, wavelength):
    """Find by how much each octave of a block shows at a footprint; whether any does.

    Octaves that did not show have no slopes: they are in no cell.
    """
    left = 0
    for k in range(LANES):
        hidden = block[_AMOUNT * LANES + k] == 0.0
        for axis in range(3):
            block[(_CELL + axis) * LANES + k] = _NO_CELL if hidden else block[(_CELL + axis) * LANES + k]
    for k in range(LANES):
        fade = min(max(2.0 - 4.0 * footprint / wavelength[k], 0.0), 1.0)
        block[_AMOUNT * LANES + k] = weight[k] * fade * fade * (3.0 - 2.0 * fade)
        left |= np.int64(fade > 0.0)
    return left


@part
def _come_near(block, near):
    """Take the places in the cells, and the amounts, to single precision."""
    for k in range(4 * LANES):
        near[_NEAR * LANES + k] = np.float32(block[_PLACE * LANES + k])


@part
def _lift(near, k, corner, x, y, z):
    """Height that the slope of a corner has at an offset (x, y, z) from it, in octave k."""
    row = (_SLOPE + 3 * corner) * LANES + k
    return near[row] * x + near[row + LANES] * y + near[row + 2 * LANES] * z


@part
def _blend(near):
    """Blend the slopes around the place in each octave."""
    for k in range(LANES):
        x, y, z = (
            near[_NEAR * LANES + k],
            near[(_NEAR + 1) * LANES + k],
            near[(_NEAR + 2) * LANES + k],
        )
        u = x * x * x * (x * (x * _6 - _15) + _10)
        v = y * y * y * (y * (y * _6 - _15) + _10)
        w = z * z * z * (z * (z * _6 - _15) + _10)
        a = _lift(near, k, 0, x, y, z)
        b = _lift(near, k, 1, x - _1, y, z)
        c = _lift(near, k, 2, x, y - _1, z)
        d = _lift(near, k, 3, x - _1, y - _1, z)
        a, c = a + u * (b - a), c + u * (d - c)
        low = a + v * (c - a)
        a = _lift(near, k, 4, x, y, z - _1)
        b = _lift(near, k, 5, x - _1, y, z - _1)
        c = _lift(near, k, 6, x, y - _1, z - _1)
        d = _lift(near, k, 7, x - _1, y - _1, z - _1)
        a, c = a + u * (b - a), c + u * (d - c)
        high = a + v * (c - a)
        near[_VALUE * LANES + k] = near[_SHARE * LANES + k] * (low + w * (high - low))


@kernel
def gradient_noise(position, footprint, key, weight, wavelength, noise, last, block, near, value):
    """Add LANES octaves of gradient noise, of one noise or several, at n points; quicker where these follow closely.

    position (n, 3) float64, footprint (n,) float; for each octave key uint64, weight, wavelength float64, noise int64:
    whose octave it is, ascending, and last bool: whether it is the last of its noise here, all (LANES,). block
    (ROWS * LANES,) float64: frames (mm to lattice cells) and offsets are given, the rest as 0; near (NEAR_ROWS * LANES,)
    float32: scratch -> value (c, n) float32.
    An octave fades as the footprint goes from 1/4 to 1/2 of its wavelength.
    """
    end = 0
    while end < len(position):
        begin = end
        while end < len(position) and footprint[end] == footprint[begin]:
            end += 1
        if _fade(block, footprint[begin], weight, wavelength) == 0:
            continue
        _enter(block, position[begin, 0], position[begin, 1], position[begin, 2])
        for i in range(begin, end):
            for k in range(LANES):
                if block[_MOVED * LANES + k] != 0.0:
                    _draw(block, near, k, key[k])
            _come_near(block, near)
            after = min(i + 1, end - 1)  # found while this one is blended
            _enter(block, position[after, 0], position[after, 1], position[after, 2])
            _blend(near)
            total = value[noise[0], i]  # in the order of the octaves, whichever are computed at once
            for k in range(LANES):
                total += near[_VALUE * LANES + k]
                if last[k]:
                    value[noise[k], i] = total
                    total = value[noise[min(k + 1, LANES - 1)], i]
