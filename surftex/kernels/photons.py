"""What both walks of light share: turning a direction, Fresnel's law, and the walk over the rough border of skin.

Directions are unit vectors with z out of the skin. Random numbers are draws of `surftex.kernels.random`; a
photon owns the counters from ``photon << 24`` on, so that its path never depends on the others.
"""

import math

import numpy as np

from surftex.kernels.jit import kernel, part
from surftex.kernels.random import uniform

_ONE = np.uint64(1)
_OWN = np.uint64(24)
_LAST_FACET = 32
"""Facets after which a ray is let go; one in 1e6 gets there at a fold of 0.9."""


@part
def first_draw(photon):
    """Counter of the first draw of a photon (int64)."""
    return np.uint64(photon) << _OWN


@part
def fresnel(cosine, ratio):
    """Unpolarised reflectance and the cosine beyond, for the ratio of the index here to the index there."""
    square = 1.0 - ratio * ratio * (1.0 - cosine * cosine)
    if square <= 0.0:
        return 1.0, 0.0
    beyond = math.sqrt(square)
    s = (ratio * cosine - beyond) / (ratio * cosine + beyond)
    p = (ratio * beyond - cosine) / (ratio * beyond + cosine)
    return 0.5 * (s * s + p * p), beyond


@part
def turned(x, y, z, cosine, azimuth):
    """Turn a unit direction (x, y, z) by an angle, about itself by an azimuth."""
    sine = math.sqrt(max(0.0, 1.0 - cosine * cosine))
    a, b = sine * math.cos(azimuth), sine * math.sin(azimuth)
    if abs(z) > 0.99999:
        side = 1.0 if z > 0 else -1.0
        return a, side * b, side * cosine
    flat = math.sqrt(1.0 - z * z)
    u = (a * x * z - b * y) / flat + cosine * x
    v = (a * y * z + b * x) / flat + cosine * y
    w = cosine * z - a * flat
    size = 1.0 / math.sqrt(u * u + v * v + w * w)
    return u * size, v * size, w * size


@part
def visible_facet(x, y, z, fold, u, v):
    """Draw the normal of a GGX facet as seen from (x, y, z), which may lie below the horizon.

    Spherical-cap sampling: Dupuy and Benyoub, Sampling visible GGX normals with spherical caps, 2023.
    """
    x, y = fold * x, fold * y
    size = 1.0 / math.sqrt(x * x + y * y + z * z)
    x, y, z = x * size, y * size, z * size
    high = (1.0 - u) * (1.0 + z) - z
    sine, azimuth = math.sqrt(max(0.0, 1.0 - high * high)), 2.0 * math.pi * v
    a, b, c = (
        fold * (sine * math.cos(azimuth) + x),
        fold * (sine * math.sin(azimuth) + y),
        max(high + z, 1e-9),
    )
    size = 1.0 / math.sqrt(a * a + b * b + c * c)
    return a * size, b * size, c * size


@part
def _between(table, share):
    """Entry of a table at a share of its length, linear in between."""
    place = share * (len(table) - 1)
    i = min(int(place), len(table) - 2)
    return table[i] + (place - i) * (table[i + 1] - table[i])


@kernel
def cross_border(key, draw, x, y, z, index, fold, steepness, escape, outside):
    """Walk over the facets of the rough border until the ray leaves it, reflected or refracted.

    index: of the skin, air being 1; outside: whether the ray (x, y, z) comes from the air. Facets are GGX of
    width `fold` while `steepness` is empty; else the cosine of a facet is `steepness` at a uniform number, and
    `escape` is the chance to leave by the cosine of the ray.
    -> draw, outside, x, y, z: where the ray goes on.
    """
    if not outside:
        z = -z  # the side of the ray is up
    for _ in range(_LAST_FACET):
        a, b, c = 0.0, 0.0, 1.0
        if len(steepness) > 0:
            while True:
                c = _between(steepness, uniform(key, draw))
                azimuth = 2.0 * math.pi * uniform(key, draw + _ONE)
                chance = uniform(key, draw + np.uint64(2))
                draw += np.uint64(3)
                sine = math.sqrt(max(0.0, 1.0 - c * c))
                a, b = sine * math.cos(azimuth), sine * math.sin(azimuth)
                if chance < -(a * x + b * y + c * z):
                    break
        elif fold > 0.0:
            a, b, c = visible_facet(-x, -y, -z, fold, uniform(key, draw), uniform(key, draw + _ONE))
            draw += np.uint64(2)
        cosine = max(-(a * x + b * y + c * z), 1e-9)
        ratio = 1.0 / index if outside else index
        reflectance, beyond = fresnel(cosine, ratio)
        chance = uniform(key, draw)
        draw += _ONE
        if chance < reflectance:
            x, y, z = x + 2.0 * cosine * a, y + 2.0 * cosine * b, z + 2.0 * cosine * c
        else:
            along = ratio * cosine - beyond
            x, y, z = ratio * x + along * a, ratio * y + along * b, -(ratio * z + along * c)
            outside = not outside
        size = 1.0 / math.sqrt(x * x + y * y + z * z)
        x, y, z = x * size, y * size, z * size
        if z > 1e-6:
            leaves = 1.0
            if len(steepness) > 0:
                leaves = _between(escape, z)
            elif fold > 0.0:
                leaves = 2.0 / (1.0 + math.sqrt(1.0 + fold * fold * (1.0 - z * z) / (z * z)))
            if leaves >= 1.0:
                break
            chance = uniform(key, draw)
            draw += _ONE
            if chance < leaves:
                break
    z = max(z, 1e-6)
    return draw, outside, x, y, z if outside else -z


@kernel
def reflect_border(key, first, cosine, index, fold, steepness, escape, kind, direction):
    """Send n rays from one side at the border alone; cosine (n,): of incidence, negative from inside.

    -> kind (n,) int8: 0 ends in the air, 1 in the skin; direction (n, 3) float64.
    """
    for i in range(len(kind)):
        draw = first_draw(first + i)
        c = cosine[i]
        sine = math.sqrt(max(0.0, 1.0 - c * c))
        draw, outside, x, y, z = cross_border(
            key, draw, sine, 0.0, -c, index, fold, steepness, escape, c > 0.0
        )
        kind[i] = 0 if outside else 1
        direction[i, 0], direction[i, 1], direction[i, 2] = x, y, z
