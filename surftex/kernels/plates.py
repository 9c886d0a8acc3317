"""From the nearest sites to the plate a sample lies on: whose it is, how far out, how far from its border.

Samples are taken `BLOCK` at a time, so that processors compute several at once. `block` (ROWS * BLOCK,) float64 holds
numbers of them, row by row; `who` (MOST * BLOCK,) int64 their nearest sites, by rank. What is beyond the last sample
of a block is whatever was there.
"""

import math

import numpy as np

from surftex.kernels.exponential import exponential, logarithm_of_sum
from surftex.kernels.gather import nearest_on_face
from surftex.kernels.jit import kernel, part
from surftex.kernels.pairs import place_in_row
from surftex.kernels.random import uniform

BLOCK = 128
"""Samples that are located at once."""

MOST = 8
"""Most sites that decide a plate; a power of 2."""

PAIRS = 256
"""Pairs of sites whose distance is kept at hand; a power of 2."""

_OWN, _BEST, _SECOND, _LARGEST, _SEVERAL, _PER, _MIDDLE, _LEAST, _TOTAL, _WEIGHTED, _RATIO, _BORDER = (
    BLOCK * row for row in range(12)
)
_DISTANCE, _SQUARE, _WEIGHT, _APART = (BLOCK * (12 + MOST * table) for table in range(4))
ROWS = 12 + 4 * MOST


@part
def _row(first, rank):
    """First number of a rank's row; the mask tells the compiler that it is none below 0."""
    return first + (rank & (MOST - 1)) * BLOCK


@part
def between_sites(start, other, length, place, first, second):
    """Distance between two sites from rows of neighbours (`other` ascends in each); straight where they have none."""
    at = place_in_row(start, other, first, second)
    if at >= 0:
        return length[at]
    return math.sqrt(
        (place[first, 0] - place[second, 0]) ** 2
        + (place[first, 1] - place[second, 1]) ** 2
        + (place[first, 2] - place[second, 2]) ** 2
    )


@part
def _rank_squares(k, block):
    """Rank of the own site, least, second and largest squared distance; whether there are more than two sites."""
    for t in range(BLOCK):
        block[_OWN + t] = -1.0
        block[_BEST + t] = math.inf
        block[_SECOND + t] = math.inf
        block[_LARGEST + t] = 0.0
        block[_SEVERAL + t] = 0.0
    for rank in range(k):
        at = _row(_SQUARE, rank)
        number = float(rank)
        for t in range(BLOCK):
            square, best = block[at + t], block[_BEST + t]
            block[_OWN + t] = number if square < best else block[_OWN + t]
            block[_SECOND + t] = min(block[_SECOND + t], max(best, square))
            block[_BEST + t] = min(best, square)
            block[_LARGEST + t] = max(block[_LARGEST + t], square if square < math.inf else 0.0)
            block[_SEVERAL + t] += 1.0 if square < math.inf else 0.0


@part
def _number_furrows(k, key, blend_mm, block, who):
    """Random number of the furrow nearby, blended over the pairs of the nearest sites.

    The weights are symmetric in the sites, continuous in the squared distances (mm^2), and nothing for pairs with the
    farthest site: the number has no step, inside a plate, across its border, or where another site takes the last place.
    """
    for t in range(BLOCK):
        second = min(block[_SECOND + t], 1e300)
        per = 0.5 / (blend_mm * math.sqrt(max(second, blend_mm * blend_mm)))
        least = exponential((second - block[_LARGEST + t]) * per)
        block[_PER + t] = per
        block[_MIDDLE + t] = 0.5 * (min(block[_BEST + t], 1e300) + second)
        block[_LEAST + t] = least if block[_SEVERAL + t] > 2.0 else 0.0
        block[_TOTAL + t] = 1e-9
        block[_WEIGHTED + t] = 0.5e-9
    for rank in range(k):
        at, to = _row(_SQUARE, rank), _row(_WEIGHT, rank)
        for t in range(BLOCK):
            square = block[at + t]
            near = exponential((block[_MIDDLE + t] - min(square, 1e300)) * block[_PER + t])
            block[to + t] = near if square < math.inf else 0.0
    for a in range(k):
        for b in range(a + 1, k):
            one, two = _row(_WEIGHT, a), _row(_WEIGHT, b)
            site, other = _row(0, a), _row(0, b)
            for t in range(BLOCK):
                weight = block[one + t] * block[two + t] - block[_LEAST + t]
                weight = weight if weight > 1e-6 else 0.0
                low, high = min(who[site + t], who[other + t]), max(who[site + t], who[other + t])
                pair = np.uint64(low) * np.uint64(4294967296) + np.uint64(high)
                block[_TOTAL + t] += weight
                block[_WEIGHTED + t] += weight * uniform(key, pair)
    for t in range(BLOCK):
        number = block[_WEIGHTED + t] / block[_TOTAL + t]
        block[_WEIGHTED + t] = number if block[_SEVERAL + t] > 1.0 else 0.5


@part
def _look_up_lengths(n, k, start, other, length, place, pair, pair_mm, block, who):
    """Distance of the own site of each sample to the others; 0 to itself, and where there is no other."""
    for t in range(n):
        own = np.int64(block[_OWN + t])
        here = who[_row(0, own) + t]
        for rank in range(k):
            there = who[_row(0, rank) + t]
            apart = 0.0
            if there >= 0 and rank != own and own >= 0:
                name = here * 4294967296 + there
                kept = (here * 31 + there) & (PAIRS - 1)
                if pair[kept] != name:
                    pair[kept] = name
                    pair_mm[kept] = between_sites(start, other, length, place, here, there)
                apart = pair_mm[kept]
            block[_row(_APART, rank) + t] = apart


@part
def _measure_borders(k, polygon, rounding_mm, block):
    """How far out each sample lies on its plate, 0 to 1 or a little more, and how far it is to the border, inf for none."""
    for t in range(BLOCK):
        block[_RATIO + t] = 0.0
        block[_BORDER + t] = math.inf
        block[_TOTAL + t] = 0.0
    for rank in range(k):
        square, away, share = _row(_SQUARE, rank), _row(_APART, rank), _row(_WEIGHT, rank)
        for t in range(BLOCK):
            apart = block[away + t]
            q = (block[_BEST + t] - block[square + t]) / (apart * apart) + 1.0
            q = q if apart > 0.0 else -math.inf
            far = 0.5 * (1.0 - q) * apart if apart > 0.0 else math.inf
            block[share + t] = q
            block[away + t] = far
            block[_RATIO + t] = max(block[_RATIO + t], q)
            block[_BORDER + t] = min(block[_BORDER + t], far)
    if polygon == 0:
        for t in range(BLOCK):
            block[_PER + t] = 1.0 / max(block[_RATIO + t], 1e-30)
        for rank in range(k):
            share = _row(_WEIGHT, rank)
            for t in range(BLOCK):
                q = max(block[share + t], 0.0) * block[_PER + t]
                block[_TOTAL + t] += (q * q * q) * (q * q * q)
        for t in range(BLOCK):
            block[_RATIO + t] *= exponential(logarithm_of_sum(max(block[_TOTAL + t], 1.0)) * (1.0 / 6.0))
    if rounding_mm > 0.0:
        per_rounding = 1.0 / rounding_mm
        for t in range(BLOCK):
            block[_TOTAL + t] = 0.0
        for rank in range(k):
            away = _row(_APART, rank)
            for t in range(BLOCK):
                beyond = (block[_BORDER + t] - block[away + t]) * per_rounding
                block[_TOTAL + t] += exponential(beyond) if beyond > -16.0 else 0.0
        for t in range(BLOCK):
            block[_BORDER + t] -= rounding_mm * logarithm_of_sum(max(block[_TOTAL + t], 1.0))


@part
def _locate(
    begin, n, k, site, distance, first_row, start, other, length, place, shift, wave_a, wave_b, polygon, rounding_mm,
    key, blend_mm, block, who, pair, pair_mm, own, ratio, border_mm, own_mm, furrow,
):  # fmt: skip
    """Locate n samples from `begin` on, at most a block; theirs are the rows from `first_row` on of site and distance."""
    for t in range(n):
        for rank in range(k):
            candidate = np.int64(site[first_row + t, rank])
            square = math.inf
            if candidate >= 0:
                d = distance[first_row + t, rank]
                square = d * d
                square += wave_a[begin + t] * shift[candidate, 0] + wave_b[begin + t] * shift[candidate, 1]
            who[_row(0, rank) + t] = candidate
            block[_row(_SQUARE, rank) + t] = square
    _rank_squares(k, block)
    if blend_mm > 0.0:
        _number_furrows(k, key, blend_mm, block, who)
    _look_up_lengths(n, k, start, other, length, place, pair, pair_mm, block, who)
    _measure_borders(k, polygon, rounding_mm, block)
    for t in range(n):
        i, rank = begin + t, np.int64(block[_OWN + t])
        own[i] = who[_row(0, rank) + t] if rank >= 0 else -1
        alone = block[_BORDER + t] == math.inf
        ratio[i] = 0.0 if alone else min(block[_RATIO + t], 1.0)
        border_mm[i] = max(block[_BORDER + t], 0.0)
        own_mm[i] = distance[first_row + t, rank] if rank >= 0 else math.inf
        furrow[i] = block[_WEIGHTED + t] if blend_mm > 0.0 and rank >= 0 else 0.5


@kernel
def plates(
    site, distance, start, other, length, place, shift, wave_a, wave_b, polygon, rounding_mm, key, blend_mm,
    block, who, pair, pair_mm, own, ratio, border_mm, own_mm, furrow,
):  # fmt: skip
    """Locate samples among Voronoi regions, whose borders may waver and whose corners may be round.

    site (n, k) int32, -1 for none, k at most MOST; distance (n, k) float64 mm, ascending, inf for none;
    start (s+1,) int64, other (l,) int32, length (l,) float64 mm: distances between neighbour sites; place (s, 3) float64 mm;
    shift (s, 2) float64 mm^2: how each site answers to the wavering; wave_a, wave_b (n,) float32;
    polygon: 1 for plates with corners, 0 for the sixth norm that rounds them;
    rounding_mm: of the corners of borders, 0 for none;
    key uint64, blend_mm: a random number for each furrow, and how far furrows blend where they meet;
    block, who: scratch; pair (PAIRS,) int64 given as -1, pair_mm (PAIRS,) float64: distances at hand.
    -> own (n,) int32 region, -1 for none; ratio (n,) float32: 0 at the site, 1 on the border;
    border_mm (n,) float32, inf for none; own_mm (n,) float32: distance to the own site;
    furrow (n,) float32: the random number, 0 to 1, of the furrow nearby.

    With squared distances D to the own site i and to another j, and l between the sites, q = (D_i - D_j + l^2) / l^2
    is 1 on the bisector, and (1 - q) l / 2 is the distance to the bisector (exact in the plane).
    """
    for begin in range(0, len(own), BLOCK):
        _locate(
            begin, min(BLOCK, len(own) - begin), site.shape[1], site, distance, begin, start, other, length, place, shift,
            wave_a, wave_b, polygon, rounding_mm, key, blend_mm, block, who, pair, pair_mm, own, ratio, border_mm, own_mm,
            furrow,
        )  # fmt: skip


@kernel
def nearest_plates(
    face, barycentric, flat, first, cells, grid, entry_start, entry_row, entry_least, row, row_id, source_of, limit,
    lane, rank, site, distance, found, start, other, length, place, shift, wave_a, wave_b, polygon, rounding_mm, key, blend_mm,
    block, who, pair, pair_mm, own, ratio, border_mm, own_mm, furrow,
):  # fmt: skip
    """Find the nearest sites of samples as `nearest_sources` does, and locate them as `plates` does, in one pass.

    lane (LANE,) float64, rank (RANK,) int64, site (BLOCK, k) int32, distance (BLOCK, k) float64, found (BLOCK, k) int32:
    scratch.
    """
    for begin in range(0, len(own), BLOCK):
        n = min(BLOCK, len(own) - begin)
        at = begin
        while at < begin + n:
            at = nearest_on_face(
                at, begin + n, at - begin, face, barycentric, flat, first, cells, grid, entry_start, entry_row,
                entry_least, row, row_id, source_of, limit, lane, rank, site, distance, found,
            )  # fmt: skip
        _locate(
            begin, n, site.shape[1], site, distance, 0, start, other, length, place, shift, wave_a, wave_b, polygon,
            rounding_mm, key, blend_mm, block, who, pair, pair_mm, own, ratio, border_mm, own_mm, furrow,
        )  # fmt: skip
