"""From distances to the elements of a leather to its height and finish.

Samples are taken `BLOCK` at a time, so that processors compute several at once. `block` (ROWS * BLOCK,) float32 holds
numbers of them, row by row; what is beyond the last sample of a block is whatever was there.
"""

from typing import NamedTuple

import numpy as np

from surftex.kernels.jit import kernel, part

BLOCK = 128
"""Samples that are computed at once."""


class Look(NamedTuple):
    """Depths, widths and colours of a leather, all float32; names as in `surftex.materials.leather.model.Leather`.

    `mean` is that of a cell's top over the cell, `lift` is the overlap of scales in mm.
    """

    crista_height: np.float32
    variation: np.float32
    mean: np.float32
    lift: np.float32
    sulcus_depth: np.float32
    sulcus_width: np.float32
    sulcus_variation: np.float32
    pocket_depth: np.float32
    pocket_width: np.float32
    pore_depth: np.float32
    pore_width: np.float32
    crown_height: np.float32
    crown_width: np.float32
    crown_pit_depth: np.float32
    crown_pit_width: np.float32
    grain_height: np.float32
    dye: np.float32
    pore_dye: np.float32
    wear: np.float32
    mottle: np.float32
    cell_tone: np.float32
    roughness: np.float32
    furrow_roughness: np.float32
    crest_roughness: np.float32
    specular: np.float32
    color: tuple[np.float32, np.float32, np.float32]
    furrow_color: tuple[np.float32, np.float32, np.float32]
    crest_color: tuple[np.float32, np.float32, np.float32]


(
    _FALL, _CELL, _LEVEL, _TONE, _BORDER, _NUMBER, _ALONG, _CRACK, _WRINKLE, _CARVED, _POCKET, _PORE, _CROWN, _SCALE,
    _GRAIN, _MOTTLE, _FOOTPRINT, _CREST, _FURROW, _RELIEF, _HEIGHT, _PIT, _RED, _GREEN, _BLUE, _ROUGH, _SPECULAR,
) = (BLOCK * row for row in range(27))  # fmt: skip
ROWS = 27

_0, _1, _2, _3, _4 = (np.float32(number) for number in range(5))
_HALF, _TINY = np.float32(0.5), np.float32(1e-30)
_SPREAD = np.float32(1 / 12 / 0.059)
"""Variance of a box of side 1, over the second moment of a valley of width 1."""

_FLATTENED = np.float32(0.6)
"""Share of the grain that a crown takes away."""

_FOOT, _FOOT_DYE = np.float32(0.45), np.float32(0.55)
"""Width of the ring of dye around a crown, as a share of the crown's own; how much of a pore's dye it holds."""

_FURROW_GRAIN = np.float32(0.7)
_SHALLOW, _DEEP = np.float32(0.15), np.float32(1 / (0.9 - 0.15))
_LOW, _HIGH = np.float32(0.55), np.float32(1 / (0.98 - 0.55))
_WRINKLE_DYE, _EVEN_WEAR, _MOTTLED_WEAR = np.float32(0.8), np.float32(0.8), np.float32(0.9)
_TINT = np.float32(1.0), np.float32(1.05), np.float32(1.1)
_ROUGH_DRIFT, _LEAST_ROUGH = np.float32(0.08), np.float32(0.04)


@part
def _valley(distance, width, footprint):
    """Wendland's function of a distance, and how much a footprint dilutes it, as `surftex.fields.profiles.valley`."""
    wide = max(np.sqrt(width * width + _SPREAD * (footprint * footprint)), _TINY)
    t = min(distance / wide, _1)
    falloff = (_1 - t) * (_1 - t)
    return falloff * falloff * (_4 * t + _1), width / wide


@part
def _step(t):
    """Rise from 0 to 1 by a smooth cubic."""
    t = min(max(t, _0), _1)
    return t * t * (_3 - _2 * t)


@part
def _carve(look, block):
    """Sum the elements: height, and what the finish needs of them.

    A cell's top is 1 - q^n, Eq. 4 and 6 of Sakurai et al., "Procedural Modeling of Leather Texture with Structural
    Elements"; what is cut into it are the valleys of Eq. 7.
    """
    for t in range(BLOCK):
        footprint = block[_FOOTPRINT + t]
        shown = _step(_2 - np.float32(2.5) * (footprint / max(block[_CELL + t], _TINY)))
        # Where a furrow is faint its two plates run into one: they stay up at the border instead of falling to it.
        share = _1 - look.sulcus_variation * (_HALF + (block[_NUMBER + t] - _HALF) * shown)
        rise = share * (look.mean + (_1 - block[_FALL + t] - look.mean) * shown)
        variation = _1 + look.variation * (_2 * block[_LEVEL + t] - _1) * shown
        height = look.crista_height * (_1 - share + variation * rise)
        block[_HEIGHT + t] = height + look.lift * block[_ALONG + t] * rise * shown
        block[_CREST + t] = _1 - share + rise
        depth, diluted = _valley(block[_BORDER + t], look.sulcus_width * (_HALF + _HALF * share), footprint)
        furrow = max(depth * diluted * share, block[_CRACK + t])
        block[_FURROW + t] = furrow
        block[_RELIEF + t] = -look.sulcus_depth * furrow - block[_CARVED + t]
    for t in range(BLOCK):
        footprint = block[_FOOTPRINT + t]
        pocket, diluted = _valley(block[_POCKET + t], look.pocket_width, footprint)
        relief = block[_RELIEF + t] - look.pocket_depth * (pocket * (diluted * diluted))
        pore, diluted = _valley(block[_PORE + t], look.pore_width, footprint)
        block[_PORE + t] = pore * (diluted * diluted)
        block[_RELIEF + t] = relief - look.pore_depth * block[_PORE + t]
    for t in range(BLOCK):
        footprint, away, scale = block[_FOOTPRINT + t], block[_CROWN + t], block[_SCALE + t]
        width = look.crown_width * scale
        far = min(away / max(width, _TINY), _1)
        crown = _1 - far * far * far
        crown *= crown
        pit, diluted = _valley(away, look.crown_pit_width, footprint)
        pit *= diluted * diluted
        foot, diluted = _valley(abs(away - width), _FOOT * width, footprint)
        left = _1 - _FLATTENED * crown
        relief = block[_RELIEF + t] * left + look.crown_height * scale * crown - look.crown_pit_depth * pit
        grain = block[_GRAIN + t] * (_1 - _FURROW_GRAIN * block[_FURROW + t])
        block[_HEIGHT + t] = block[_HEIGHT + t] * left + relief + look.grain_height * grain
        block[_PORE + t] = max(block[_PORE + t], max(pit, _FOOT_DYE * (foot * diluted)))
        block[_CROWN + t] = crown
        block[_PIT + t] = pit


@part
def _finish(look, block):
    """Dye pools in furrows, wrinkles, pores and around crowns; crests are worn, polished, paler; the tone drifts."""
    for t in range(BLOCK):
        drift = block[_MOTTLE + t]
        deep = max(_step((block[_FURROW + t] - _SHALLOW) * _DEEP), _WRINKLE_DYE * block[_WRINKLE + t])
        dye = min(max(look.dye * deep + look.pore_dye * block[_PORE + t], _0), _1)
        high = _step((block[_CREST + t] - _LOW) * _HIGH) * (_1 - deep)
        high = max(high, block[_CROWN + t]) * (_1 - block[_PIT + t])
        worn = look.wear * min(max(high * (_EVEN_WEAR + _MOTTLED_WEAR * drift), _0), _1)
        tone = _2 * look.mottle * drift + look.cell_tone * (_2 * block[_TONE + t] - _1)
        for channel in range(3):
            value = look.color[channel] * (_1 + tone * _TINT[channel])
            value += dye * (look.furrow_color[channel] - value)
            value += worn * (look.crest_color[channel] - value)
            block[_RED + channel * BLOCK + t] = min(max(value, _0), _1)
        rough = look.roughness + _ROUGH_DRIFT * drift
        rough += deep * (look.furrow_roughness - rough)
        rough += (high * (_1 - dye)) * (look.crest_roughness - look.roughness)
        block[_ROUGH + t] = min(max(rough, _LEAST_ROUGH), _1)
        block[_SPECULAR + t] = look.specular * (_1 - _HALF * dye)


@kernel
def leather_layers(
    look, fall, cell_mm, level, tone, border_mm, number, along, crack, wrinkle, carved_mm, pocket_mm, pore_mm, crown_mm,
    crown_scale, grain, mottle, footprint_mm, block, height_mm, color, roughness, specular,
):  # fmt: skip
    """Turn distances to elements into channels; all arrays are (n,) float32 but for color (n, 3).

    look: Look; fall: of a cell's top from its middle, 0 to 1; cell_mm: size of the cell; level, tone, number: random
    numbers of the cell, and of the furrow; border_mm, pocket_mm, pore_mm, crown_mm: distances, inf for none; along: place
    on a scale, -1 to 1; crack, wrinkle: shares of lines; carved_mm: depth of lines; crown_scale: size of the nearest crown.
    -> height_mm, color, roughness, specular.
    """
    for begin in range(0, len(height_mm), BLOCK):
        count = min(BLOCK, len(height_mm) - begin)
        for t in range(count):
            block[_FALL + t] = fall[begin + t]
            block[_CELL + t] = cell_mm[begin + t]
            block[_LEVEL + t] = level[begin + t]
            block[_TONE + t] = tone[begin + t]
            block[_BORDER + t] = border_mm[begin + t]
            block[_NUMBER + t] = number[begin + t]
            block[_ALONG + t] = along[begin + t]
            block[_CRACK + t] = crack[begin + t]
            block[_WRINKLE + t] = wrinkle[begin + t]
            block[_CARVED + t] = carved_mm[begin + t]
            block[_POCKET + t] = pocket_mm[begin + t]
            block[_PORE + t] = pore_mm[begin + t]
            block[_CROWN + t] = crown_mm[begin + t]
            block[_SCALE + t] = crown_scale[begin + t]
            block[_GRAIN + t] = grain[begin + t]
            block[_MOTTLE + t] = mottle[begin + t]
            block[_FOOTPRINT + t] = footprint_mm[begin + t]
        _carve(look, block)
        _finish(look, block)
        for t in range(count):
            height_mm[begin + t], roughness[begin + t] = block[_HEIGHT + t], block[_ROUGH + t]
            specular[begin + t] = block[_SPECULAR + t]
            for channel in range(3):
                color[begin + t, channel] = block[_RED + channel * BLOCK + t]
