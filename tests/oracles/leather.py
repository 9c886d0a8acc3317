"""The plates of a leather, sample by sample, as the formulas read."""

import itertools

import numpy as np

from surftex.randomness import Stream


def plate(site, distance, between, shift, wave, exponent, rounding, key, blend):
    """Own site, ratio, distance to the border, distance to the site, furrow number of one sample.

    `site` and `distance` list its nearest sites; `between[i, j]` is the distance between two sites.
    """
    square = distance**2 + shift[site] @ wave
    slot = int(np.argmin(square))
    own = site[slot]
    rest = [k for k in range(len(site)) if k != slot]
    length = np.array([between[own, site[k]] for k in rest])
    q = (square[slot] - square[rest]) / length**2 + 1
    away = (1 - q) * length / 2
    ratio = max(q.max(), 0) if np.isinf(exponent) else (np.maximum(q, 0) ** exponent).sum() ** (1 / exponent)
    border = away.min()
    if rounding > 0:
        border -= rounding * np.log(np.exp((away.min() - away) / rounding).sum())
    first, second = np.sort(square)[:2]
    reach = 2 * blend * np.sqrt(max(second, blend**2))
    least = np.exp((second - square.max()) / reach) if len(site) > 2 else 0.0
    total, weighted = 1e-9, 0.5e-9
    for a, b in itertools.combinations(range(len(site)), 2):
        weight = max(np.exp((first + second - square[a] - square[b]) / reach) - least, 0.0)
        low, high = sorted((int(site[a]), int(site[b])))
        total += weight
        weighted += weight * Stream(key).at(np.array([low * 2**32 + high]))[0]
    return own, min(ratio, 1), max(border, 0), distance[slot], weighted / total


def pairs_both_ways(start, other, length):
    """Neighbours of each site, ascending, and the mean of the lengths that either end of a pair knows."""
    known = {}
    for i in range(len(start) - 1):
        for at in range(start[i], start[i + 1]):
            if other[at] != i:
                known.setdefault((min(i, other[at]), max(i, other[at])), []).append(length[at])
    rows = [[] for _ in range(len(start) - 1)]
    for (low, high), lengths in known.items():
        rows[low].append((high, np.mean(lengths)))
        rows[high].append((low, np.mean(lengths)))
    return [sorted(row) for row in rows]
