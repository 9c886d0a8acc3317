"""From the nearest sites to the plate a sample lies on: whose it is, how far out, how far from its border."""

import math

import numpy as np

from surftex.kernels.buckets import bucket_of
from surftex.kernels.exponential import exponential
from surftex.kernels.gather import nearest_few, room_left
from surftex.kernels.jit import kernel, part
from surftex.kernels.pairs import place_in_row
from surftex.kernels.random import uniform


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
def furrow_number(site, square, count, key, blend_mm, near):
    """Random number of the furrow nearby, blended over the pairs of the nearest sites.

    The weights are symmetric in the sites, continuous in the squared distances `square` (mm^2), and nothing for
    pairs with the farthest site: the number has no step, inside a plate, across its border, or where another
    site takes the last place. `near` (k,) float64 is scratch.
    """
    if count < 2:
        return 0.5
    smallest, second, largest = math.inf, math.inf, 0.0
    for k in range(count):
        if square[k] < smallest:
            second = smallest
            smallest = square[k]
        elif square[k] < second:
            second = square[k]
        largest = max(largest, square[k])
    per = 0.5 / (blend_mm * math.sqrt(max(second, blend_mm * blend_mm)))
    middle = 0.5 * (smallest + second)
    for k in range(count):
        near[k] = exponential((middle - square[k]) * per)
    least = exponential((second - largest) * per) if count > 2 else 0.0
    total, weighted = 1e-9, 0.5e-9
    for a in range(count):
        for b in range(a + 1, count):
            weight = near[a] * near[b] - least
            if weight > 1e-6:
                low, high = min(site[a], site[b]), max(site[a], site[b])
                pair = np.uint64(low) * np.uint64(4294967296) + np.uint64(high)
                total += weight
                weighted += weight * uniform(key, pair)
    return weighted / total


@part
def locate(
    site, distance, start, other, length, place, shift, wave_a, wave_b, polygon, rounding_mm, key, blend_mm,
    away, near, last_here, last, last_mm,
):  # fmt: skip
    """Locate one sample among the regions of its nearest sites: see `plates`; site (k,), distance (k,).

    Returns its own site, ratio, border_mm, own_mm, furrow and the site that `last` and `last_mm` are about.
    """
    best = math.inf
    slot = -1
    count = 0
    furrow = 0.5
    for k in range(len(site)):
        candidate = site[k]
        if candidate < 0:
            break
        count += 1
        square = distance[k] * distance[k]
        square += wave_a * shift[candidate, 0] + wave_b * shift[candidate, 1]
        away[k] = square
        if square < best:
            best = square
            slot = k
    if slot < 0:
        return -1, 0.0, math.inf, math.inf, furrow, last_here
    if blend_mm > 0.0:
        furrow = furrow_number(site, away, count, key, blend_mm, near)
    here = np.int64(site[slot])
    total = 0.0
    nearest = math.inf
    if here != last_here:
        for k in range(len(last)):
            last[k] = -1
    for k in range(count):
        if k == slot:
            away[k] = math.inf
            continue
        candidate = site[k]
        kept = candidate & (len(last) - 1)
        if last[kept] != candidate:
            last[kept] = candidate
            last_mm[kept] = between_sites(start, other, length, place, here, candidate)
        apart = last_mm[kept]
        if apart <= 0.0:
            away[k] = math.inf
            continue
        q = (best - away[k]) / (apart * apart) + 1.0
        if polygon:
            total = max(total, q)
        elif q > 0.0:
            total += (q * q * q) * (q * q * q)
        away[k] = 0.5 * (1.0 - q) * apart
        if away[k] < nearest:
            nearest = away[k]
    if nearest == math.inf:
        return here, 0.0, math.inf, distance[slot], furrow, here
    ratio = min(1.0, total if polygon else math.sqrt(np.cbrt(total)))
    if rounding_mm > 0.0:
        crowd = 0.0
        per_rounding = 1.0 / rounding_mm
        for k in range(count):
            beyond = (nearest - away[k]) * per_rounding
            if beyond > -16.0:
                crowd += exponential(beyond)
        nearest -= rounding_mm * math.log(crowd)
    return here, ratio, max(0.0, nearest), distance[slot], furrow, here


@kernel
def plates(
    site, distance, start, other, length, place, shift, wave_a, wave_b, polygon, rounding_mm,
    key, blend_mm, away, near, last, last_mm, own, ratio, border_mm, own_mm, furrow,
):  # fmt: skip
    """Locate samples among Voronoi regions, whose borders may waver and whose corners may be round.

    site (n, k) int32, -1 for none; distance (n, k) float64 mm, ascending, inf for none;
    start (s+1,) int64, other (l,) int32, length (l,) float64 mm: distances between neighbour sites; place (s, 3) float64 mm;
    shift (s, 2) float64 mm^2: how each site answers to the wavering; wave_a, wave_b (n,) float32;
    polygon: 1 for plates with corners, 0 for the sixth norm that rounds them;
    rounding_mm: of the corners of borders, 0 for none;
    key uint64, blend_mm: a random number for each furrow, and how far furrows blend where they meet;
    away, near (k,) float64: scratch; last (c,) int32, last_mm (c,) float64: what neighbouring samples share, c a power of 2.
    -> own (n,) int32 region, -1 for none; ratio (n,) float32: 0 at the site, 1 on the border;
    border_mm (n,) float32, inf for none; own_mm (n,) float32: distance to the own site;
    furrow (n,) float32: the random number, 0 to 1, of the furrow nearby.

    With squared distances D to the own site i and to another j, and l between the sites, q = (D_i - D_j + l^2) / l^2
    is 1 on the bisector, and (1 - q) l / 2 is the distance to the bisector (exact in the plane).
    """
    here = np.int64(-1)
    for i in range(site.shape[0]):
        own[i], ratio[i], border_mm[i], own_mm[i], furrow[i], here = locate(
            site[i], distance[i], start, other, length, place, shift, wave_a[i], wave_b[i], polygon, rounding_mm,
            key, blend_mm, away, near, here, last, last_mm,
        )  # fmt: skip


@kernel
def nearest_plates(
    face, barycentric, flat, first, cells, grid, entry_start, entry_row, entry_least, row, row_id, source_of, limit,
    site, distance, found, start, other, length, place, shift, wave_a, wave_b, polygon, rounding_mm, key, blend_mm,
    away, near, last, last_mm, own, ratio, border_mm, own_mm, furrow,
):  # fmt: skip
    """Find the nearest sites of samples as `nearest_sources` does, and locate them as `plates` does, in one pass.

    site (k,) int32, distance (k,) float64, found (k,) int32: scratch.
    """
    k = len(site)
    here = np.int64(-1)
    last_bucket, last_x, last_y, last_worst, room = np.int64(-1), 0.0, 0.0, math.inf, 0.0
    for i in range(len(face)):
        f = face[i]
        x = barycentric[i, 1] * flat[f, 1, 0] + barycentric[i, 2] * flat[f, 2, 0]
        y = barycentric[i, 2] * flat[f, 2, 1]
        bucket = bucket_of(f, x, y, first, cells, grid)
        bound = math.inf
        if bucket == last_bucket:
            step = math.sqrt((x - last_x) ** 2 + (y - last_y) ** 2)
            if step < room:
                bound = (last_worst + step) * (1.0 + 1e-9)
        nearest_few(
            x,
            y,
            bucket,
            bound,
            entry_start,
            entry_row,
            entry_least,
            row,
            row_id,
            source_of,
            limit,
            site,
            distance,
            found,
        )
        last_bucket, last_x, last_y, last_worst = bucket, x, y, distance[k - 1]
        room = room_left(row_id, limit, distance, found)
        own[i], ratio[i], border_mm[i], own_mm[i], furrow[i], here = locate(
            site, distance, start, other, length, place, shift, wave_a[i], wave_b[i], polygon, rounding_mm,
            key, blend_mm, away, near, here, last, last_mm,
        )  # fmt: skip
