"""The plates of a leather, sample by sample, as the formulas read."""

import itertools

import numpy as np

from surftex.fields.profiles import smoothstep, valley, visible
from surftex.materials.grooves import grooves
from surftex.materials.leather.relief import _folds
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


def dome(ratio, exponent, cell_mm, footprint_mm):
    """Convex top of a cell, 1 at its middle, 0 on its border; patches near its size see only the mean."""
    shape = 1 - np.power(np.clip(ratio, 0, 1), np.float32(exponent))
    mean = np.float32(exponent / (exponent + 2))
    return mean + (shape - mean) * visible(cell_mm, footprint_mm)


def layers(leather, skeleton, footprint_mm):
    """Channels of samples from distances to the elements of a leather."""
    plates = skeleton.plates
    cell_visible = visible(skeleton.cell_mm, footprint_mm)
    variation = 1 + leather.variation * (2 * skeleton.level - 1) * cell_visible
    # Where a furrow is faint its two plates run into one: they stay up at the border instead of falling to it.
    share = 1 - leather.sulcus_variation * (0.5 + (plates.furrow - 0.5) * cell_visible)
    rise = share * dome(plates.ratio, leather.crista_exponent, skeleton.cell_mm, footprint_mm)
    crest = 1 - share + rise
    height = leather.crista_height * (1 - share + variation * rise)
    if leather.scale_overlap:
        height += leather.scale_overlap * leather.crista_height * plates.along * rise * cell_visible
    furrow = valley(
        plates.border_mm, leather.sulcus_width * (0.5 + 0.5 * share), footprint_mm, dimension=1
    ) * share  # fmt: skip
    for line in skeleton.cracks:
        width = leather.sulcus_width * line.share
        crack = valley(line.distance_mm, width, footprint_mm[line.at], dimension=1) * line.share
        furrow[line.at] = np.maximum(furrow[line.at], crack)
    relief = -leather.sulcus_depth * furrow

    wrinkle = np.float32(0)
    if skeleton.wrinkles:
        wrinkle, groove = grooves(
            skeleton.wrinkles, leather.wrinkle_width, leather.wrinkle_depth, footprint_mm
        )
        relief = relief - groove
        if leather.wrinkle_fold:
            relief = relief + _folds(leather, skeleton.wrinkles, footprint_mm)
    if skeleton.pocket_mm is not None:
        relief = relief - leather.pocket_depth * valley(
            skeleton.pocket_mm, leather.pocket_width, footprint_mm, dimension=2
        )
    pore = np.float32(0)
    if skeleton.pore_mm is not None:
        pore = valley(skeleton.pore_mm, leather.pore_width, footprint_mm, dimension=2)
        relief = relief - leather.pore_depth * pore

    crown = np.float32(0)
    pit = np.float32(0)
    if skeleton.crown_mm is not None and skeleton.crown_scale is not None:
        width = leather.crown_width * skeleton.crown_scale
        t = np.minimum(skeleton.crown_mm / width, 1)
        crown = (1 - t * t * t) ** 2
        pit = valley(skeleton.crown_mm, leather.crown_pit_width, footprint_mm, dimension=2)
        foot = valley(np.abs(skeleton.crown_mm - width), 0.45 * width, footprint_mm, dimension=1)
        height = height * (1 - 0.6 * crown)
        relief = (
            relief * (1 - 0.6 * crown)
            + leather.crown_height * skeleton.crown_scale * crown
            - leather.crown_pit_depth * pit
        )
        pore = np.maximum(pore, np.maximum(pit, 0.55 * foot))
    grain = skeleton.grain * (1 - 0.7 * furrow)
    height = height + relief + leather.grain_height * grain
    return {"height_mm": height, **_finish(leather, skeleton, crest, furrow, wrinkle, pore, crown, pit)}


def _finish(leather, skeleton, crest, furrow, wrinkle, pore, crown, pit):
    """Dye pools in furrows, wrinkles, pores and around crowns; crests are worn, polished and paler; the tone drifts."""
    drift = skeleton.mottle
    deep = np.maximum(smoothstep(0.15, 0.9, furrow), 0.8 * wrinkle)
    dye = np.clip(leather.dye * deep + leather.pore_dye * pore, 0, 1)
    high = np.maximum(smoothstep(0.55, 0.98, crest) * (1 - deep), crown) * (1 - pit)
    worn = leather.wear * np.clip(high * (0.8 + 0.9 * drift), 0, 1)
    tone = 1 + 2 * leather.mottle * drift + leather.cell_tone * (2 * skeleton.tone - 1)
    color = np.zeros((len(drift), 3), np.float32)
    for channel, tint in enumerate((1.0, 1.05, 1.1)):
        value = leather.color[channel] * (1 + (tone - 1) * np.float32(tint))
        value += dye * (leather.furrow_color[channel] - value)
        value += worn * (leather.crest_color[channel] - value)
        color[:, channel] = np.clip(value, 0, 1)
    rough = leather.roughness + 0.08 * drift
    rough = rough + deep * (leather.furrow_roughness - rough)
    rough = rough + (high * (1 - dye)) * (leather.crest_roughness - leather.roughness)
    return {
        "base_color": color,
        "roughness": np.clip(rough, 0.04, 1).astype(np.float32),
        "specular": (leather.specular * (1 - 0.5 * dye)).astype(np.float32),
        "region": skeleton.plates.own,
    }
