"""Light in layers, one free path after the other: where each photon leaves, and how far it went in each layer."""

import math

import numpy as np

from surftex.kernels.jit import kernel
from surftex.kernels.photons import cross_border, first_draw, fresnel, turned
from surftex.kernels.random import uniform

_ONE, _TWO = np.uint64(1), np.uint64(2)
_FAR = 1e30
_PATIENCE, _SURVIVES = 3.0, 0.05
"""Roulette: absorption depth between two draws, and the chance to go on with the weight divided by it."""


@kernel
def walk_volume(
    key, first, cosine, index, below, fold, steepness, escape, scattering, forward, border, base, least,
    paths, weight, bounces, kind, leaving, place,
):  # fmt: skip
    """Send photons `first` to `first` + n into k layers.

    cosine: of incidence, 0 draws it cosine-weighted; index (k,) against the outside; below: index under the
    last layer; scattering (k,) per length; forward (k,): mean cosine (Henyey-Greenstein); border (k + 1,):
    depths; base 1: a matt white base, else light leaves below; least (k,): a lower bound of absorption, for
    the roulette.
    -> paths (n, k): length in each layer; weight (n,) of the roulette; bounces (n,) off the base; kind (n,)
    int8: 0 reflected by the surface, 1 out of the top, 2 out below, 3 ended by roulette; leaving (n, 4):
    direction, and cosine of incidence; place (n, 2): offset along the surface.
    """
    layers = len(index)
    for i in range(len(kind)):
        draw = first_draw(first + i)
        c = cosine
        if c == 0.0:
            c = math.sqrt(max(uniform(key, draw), 1e-9))
            draw += _ONE
        paths[i, :] = 0.0
        weight[i] = 1.0
        bounces[i] = 0
        kind[i] = 0
        px, py, down, worn = 0.0, 0.0, 0.0, 0.0
        draw, outside, x, y, z = cross_border(
            key, draw, math.sqrt(max(0.0, 1.0 - c * c)), 0.0, -c, index[0], fold, steepness, escape, True
        )
        layer = 0
        ended = outside
        while not ended:
            left = -math.log(1.0 - uniform(key, draw))
            draw += _ONE
            while True:
                reach = _FAR
                if z < 0.0:
                    reach = (border[layer + 1] - down) / -z
                elif z > 0.0:
                    reach = (down - border[layer]) / z
                step = left / scattering[layer] if scattering[layer] > 0.0 else _FAR
                inside = step < reach
                step = min(step, reach)
                px += step * x
                py += step * y
                paths[i, layer] += step
                worn += step * least[layer]
                if inside:
                    down -= step * z
                    break
                left -= step * scattering[layer]
                if z > 0.0 and layer == 0:
                    down = border[0]
                    draw, outside, x, y, z = cross_border(
                        key, draw, x, y, z, index[0], fold, steepness, escape, False
                    )
                    if outside:
                        kind[i] = 1
                        ended = True
                        break
                    continue
                there = layer + 1 if z < 0.0 else layer - 1
                down = border[layer + 1] if z < 0.0 else border[layer]
                if there == layers and base == 1:
                    bounces[i] += 1
                    up = math.sqrt(max(uniform(key, draw), 1e-12))
                    azimuth = 2.0 * math.pi * uniform(key, draw + _ONE)
                    draw += _TWO
                    sine = math.sqrt(1.0 - up * up)
                    x, y, z = sine * math.cos(azimuth), sine * math.sin(azimuth), up
                    continue
                ratio = index[layer] / (below if there == layers else index[there])
                reflectance, beyond = fresnel(abs(z), ratio)
                chance = uniform(key, draw)
                draw += _ONE
                if chance < reflectance:
                    z = -z
                    continue
                x, y, z = ratio * x, ratio * y, -beyond if z < 0.0 else beyond
                if there == layers:
                    kind[i] = 2
                    ended = True
                    break
                layer = there
            if ended:
                break
            if worn > _PATIENCE:
                chance = uniform(key, draw)
                draw += _ONE
                if chance > _SURVIVES:
                    kind[i] = 3
                    break
                weight[i] /= _SURVIVES
                worn = 0.0
            g = forward[layer]
            chance = uniform(key, draw)
            turn = 2.0 * chance - 1.0
            if abs(g) > 1e-6:
                q = (1.0 - g * g) / (1.0 - g + 2.0 * g * chance)
                turn = (1.0 + g * g - q * q) / (2.0 * g)
            x, y, z = turned(x, y, z, turn, 2.0 * math.pi * uniform(key, draw + _ONE))
            draw += _TWO
        leaving[i, 0], leaving[i, 1], leaving[i, 2], leaving[i, 3] = x, y, z, c
        place[i, 0], place[i, 1] = px, py
