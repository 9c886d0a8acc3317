"""Slow, obvious twins of the fields' kernels, in Python integers and floats."""

import math

_MASK = (1 << 64) - 1


def _slope(mixed):
    mixed = ((mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
    mixed = ((mixed ^ (mixed >> 27)) * 0x94D049BB133111EB) & _MASK
    i, count = mixed >> 57, 128
    z = 1 - (2 * i + 1) / count
    turn = i * math.pi * (3 - math.sqrt(5))
    ring = math.sqrt(1 - z * z)
    return ring * math.cos(turn), ring * math.sin(turn), z


def gradient_noise(position, footprint, key, frame, offset, weight, wavelength):
    """One value per point: for each octave, the eight corners' slopes blended with products of quintics."""
    steps = (0x9E3779B97F4A7C15, 0xD6E8FEB86659FD93, 0xA0761D6478BD642F)
    values = []
    for point, side in zip(position, footprint, strict=True):
        total = 0.0
        for k in range(len(key)):
            at = [sum(frame[k][i][j] * point[j] for j in range(3)) + offset[k][i] for i in range(3)]
            cell = [math.floor(a) for a in at]
            noise = 0.0
            for corner in range(8):
                step = [(corner >> i) & 1 for i in range(3)]
                mixed = int(key[k]) + sum((cell[i] + step[i]) * steps[i] for i in range(3))
                slope = _slope(mixed & _MASK)
                away = [at[i] - cell[i] - step[i] for i in range(3)]
                blend = math.prod(6 * t**5 - 15 * t**4 + 10 * t**3 for t in (1 - abs(a) for a in away))
                noise += blend * sum(s * a for s, a in zip(slope, away, strict=True))
            fade = min(max(2 - 4 * side / wavelength[k], 0), 1)
            total += weight[k] * fade * fade * (3 - 2 * fade) * noise
        values.append(total)
    return values
