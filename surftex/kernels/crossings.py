"""Light in four layers, one decision per crossing (BioSpec): what each path crossed, with no absorption."""

import math

import numpy as np

from surftex.kernels.jit import kernel, part
from surftex.kernels.photons import cross_border, first_draw, fresnel, turned
from surftex.kernels.random import uniform

_ONE, _TWO = np.uint64(1), np.uint64(2)
_TRIES = 64


@part
def _forward(key, draw, x, y, z, angle):
    """Turn by an angle of the table, keeping the sense of travel; angle (k,): cosine by uniform number."""
    for _ in range(_TRIES):
        place = uniform(key, draw) * (len(angle) - 1)
        i = int(place)
        cosine = angle[i] + (place - i) * (angle[i + 1] - angle[i])
        a, b, c = turned(x, y, z, cosine, 2.0 * math.pi * uniform(key, draw + _ONE))
        draw += _TWO
        if (c < 0.0) == (z < 0.0) and abs(c) > 1e-4:
            return draw, a, b, c
    return draw, x, y, z


@part
def _spread(key, draw, side):
    """Direction of a cosine lobe about the layer's normal; side 1 up, -1 down."""
    cosine = math.sqrt(max(uniform(key, draw), 1e-12))
    azimuth = 2.0 * math.pi * uniform(key, draw + _ONE)
    sine = math.sqrt(1.0 - cosine * cosine)
    return draw + _TWO, sine * math.cos(azimuth), sine * math.sin(azimuth), side * cosine


@part
def _rayleigh(key, draw, x, y, z):
    """Turn by Rayleigh's law, 3/8 (1 + cos^2), inverted by Cardano's formula."""
    q = 4.0 * uniform(key, draw) - 2.0
    root = (q + math.sqrt(q * q + 1.0)) ** (1.0 / 3.0)
    a, b, c = turned(x, y, z, root - 1.0 / root, 2.0 * math.pi * uniform(key, draw + _ONE))
    return draw + _TWO, a, b, c


@kernel
def walk_crossings(
    key,
    first,
    cosine,
    index,
    fold,
    steepness,
    escape,
    angle,
    depth,
    absorption,
    limit,
    sums,
    bounces,
    kind,
    leaving,
):
    """Send photons `first` to `first` + n into the skin.

    cosine: of incidence, 0 draws it cosine-weighted; index (4,); angle (2, k): cosine of the turn in the two
    upper layers by uniform number; depth (2,): Rayleigh depth of the two lower ones; absorption (4,): depth of
    absorption per unit of `sums`, to end paths at once, or zeros to keep all; limit: crossings.
    -> sums (n, 4): 1/|cos| summed over the crossings of each layer; bounces (n,) off the base; kind (n,) int8:
    0 reflected by the surface, 1 out of the skin, 2 lost; leaving (n, 4): direction, and cosine of incidence.
    """
    for i in range(len(kind)):
        draw = first_draw(first + i)
        c = cosine
        if c == 0.0:
            c = math.sqrt(max(uniform(key, draw), 1e-9))
            draw += _ONE
        sums[i, :] = 0.0
        bounces[i] = 0
        kind[i] = 2
        draw, outside, x, y, z = cross_border(
            key, draw, math.sqrt(max(0.0, 1.0 - c * c)), 0.0, -c, index[0], fold, steepness, escape, True
        )
        if outside:
            kind[i] = 0
        layer, crossings = 0, 0
        while not outside and crossings < limit:
            crossings += 1
            path = 0.0
            if layer < 2:
                draw, x, y, z = _forward(key, draw, x, y, z, angle[layer])
                path = 1.0 / abs(z)
            elif z > 0.0:
                draw, x, y, z = _spread(key, draw, 1.0)
                path = 1.0 / max(z, 1e-4)
            else:
                chance = uniform(key, draw)
                draw += _ONE
                if chance < 1.0 - math.exp(depth[layer - 2] / z):
                    draw, x, y, z = _rayleigh(key, draw, x, y, z)
                else:
                    draw, x, y, z = _spread(key, draw, -1.0)
                if z < 0.0:
                    path = 1.0 / max(-z, 1e-4)
            sums[i, layer] += path
            if absorption[layer] > 0.0 and path > 0.0:
                chance = uniform(key, draw)
                draw += _ONE
                if -math.log(1.0 - chance) <= absorption[layer] * path:
                    break
            if z > 0.0 and layer == 0:
                draw, outside, x, y, z = cross_border(
                    key, draw, x, y, z, index[0], fold, steepness, escape, False
                )
                if outside:
                    kind[i] = 1
            elif z < 0.0 and layer == 3:
                z = -z
                bounces[i] += 1
            else:
                there = layer + 1 if z < 0.0 else layer - 1
                ratio = index[layer] / index[there]
                reflectance, beyond = fresnel(abs(z), ratio)
                chance = uniform(key, draw)
                draw += _ONE
                if chance < reflectance:
                    z = -z
                else:
                    x, y, z = ratio * x, ratio * y, -beyond if z < 0.0 else beyond
                    layer = there
        leaving[i, 0], leaving[i, 1], leaving[i, 2], leaving[i, 3] = x, y, z, c
