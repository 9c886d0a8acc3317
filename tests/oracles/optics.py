"""Brute force for light: one photon after the other, every absorption drawn by chance, nothing reused."""

import math
import random

import numpy as np


def fresnel(cosine, here, there):
    """Unpolarised reflectance and the cosine beyond, by Snell's law."""
    sine = here / there * math.sqrt(max(0.0, 1 - cosine**2))
    if sine >= 1:
        return 1.0, 0.0
    beyond = math.sqrt(1 - sine**2)
    s = (here * cosine - there * beyond) / (here * cosine + there * beyond)
    p = (here * beyond - there * cosine) / (here * beyond + there * cosine)
    return (s * s + p * p) / 2, beyond


def turned(direction, cosine, azimuth):
    """Direction turned by an angle, through two vectors across it."""
    direction = np.asarray(direction)
    help_axis = np.array([1.0, 0, 0]) if abs(direction[0]) < 0.9 else np.array([0, 1.0, 0])
    first = np.cross(direction, help_axis)
    first /= np.linalg.norm(first)
    second = np.cross(direction, first)
    sine = math.sqrt(max(0.0, 1 - cosine**2))
    return sine * math.cos(azimuth) * first + sine * math.sin(azimuth) * second + cosine * direction


def through_border(direction, here, there, dice):
    """Whether a ray passes a flat border, and where it goes."""
    reflectance, beyond = fresnel(abs(direction[2]), here, there)
    if dice.random() < reflectance:
        return False, direction * [1, 1, -1]
    ratio = here / there
    return True, np.array([ratio * direction[0], ratio * direction[1], math.copysign(beyond, direction[2])])


def cosine_lobe(side, dice):
    up, azimuth = math.sqrt(dice.random()), 2 * math.pi * dice.random()
    sine = math.sqrt(1 - up * up)
    return np.array([sine * math.cos(azimuth), sine * math.sin(azimuth), side * up])


def crossing_albedo(index, angle, rayleigh, depth, count, seed):
    """Share of normally incident light that comes out of four layers by the crossing walk; smooth surface, white base.

    angle: two functions, uniform number -> cosine of a turn; rayleigh (2,), depth (4,): optical depths.
    """
    dice, out = random.Random(seed), 0
    for _ in range(count):
        passed, d = through_border(np.array([0.0, 0, -1]), 1.0, index[0], dice)
        layer = 0
        while passed:
            inside = True
            if layer < 2:
                while True:
                    new = turned(d, angle[layer](dice.random()), 2 * math.pi * dice.random())
                    if new[2] * d[2] > 0:
                        break
                d = new
            elif d[2] > 0:
                d = cosine_lobe(1, dice)
            elif dice.random() < 1 - math.exp(rayleigh[layer - 2] / d[2]):
                while True:
                    cosine = 2 * dice.random() - 1
                    if dice.random() < (1 + cosine**2) / 2:
                        break
                d = turned(d, cosine, 2 * math.pi * dice.random())
                inside = d[2] < 0
            else:
                d = cosine_lobe(-1, dice)
            if inside and dice.expovariate(1.0) < depth[layer] / abs(d[2]):
                break
            if layer == 3 and d[2] < 0:
                d = d * [1, 1, -1]
                continue
            there = layer + (1 if d[2] < 0 else -1)
            crossed, d = through_border(d, index[layer], index[there] if there >= 0 else 1.0, dice)
            if crossed and there < 0:
                out += 1
                break
            layer = there if crossed else layer
    return out / count


def layers_analog(index, absorption, scattering, forward, thickness, count, seed):
    """Reflected and transmitted share of light on smooth layers in air, by free paths, each ended by absorption."""
    dice, up, below = random.Random(seed), 0, 0
    bottom, layers = np.cumsum(thickness), len(index)
    for _ in range(count):
        passed, d = through_border(np.array([0.0, 0, -1]), 1.0, index[0], dice)
        if not passed:
            up += 1
            continue
        deep, layer = 0.0, 0
        while True:
            extinction = absorption[layer] + scattering[layer]
            step = dice.expovariate(extinction)
            top = bottom[layer] - thickness[layer]
            to_border = (bottom[layer] - deep) / -d[2] if d[2] < 0 else (deep - top) / d[2]
            if step < to_border:
                deep -= step * d[2]
                if dice.random() < absorption[layer] / extinction:
                    break
                g = forward[layer]
                cosine = 2 * dice.random() - 1
                if g:
                    cosine = (1 + g * g - ((1 - g * g) / (1 + g * cosine)) ** 2) / (2 * g)
                d = turned(d, cosine, 2 * math.pi * dice.random())
                continue
            deep = bottom[layer] if d[2] < 0 else top
            there = layer + (1 if d[2] < 0 else -1)
            crossed, d = through_border(d, index[layer], index[there] if 0 <= there < layers else 1.0, dice)
            if crossed and there < 0:
                up += 1
                break
            if crossed and there == layers:
                below += 1
                break
            layer = there if crossed else layer
    return up / count, below / count


def absorbed(sums, weight, bin_of, corneum, epidermis, papillary, reticular, share, bins):
    """Weights of paths under every combination of absorbers, by bin: (bins, c, e, s * d); depths beyond 30 leave nothing."""

    def left(depth):
        return np.where(depth < 30, np.exp(-depth), 0.0)

    total = np.zeros((bins, len(share), len(epidermis), len(corneum) * len(papillary)))
    for path, heavy, place in zip(sums, weight, bin_of, strict=True):
        dermis = left(papillary * path[2] + reticular * path[3])
        below = np.outer(left(corneum * path[0]), dermis).ravel()
        total[place] += share[:, None, None] * heavy * np.outer(left(epidermis * path[1]), below)
    return total
