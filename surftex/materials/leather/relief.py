"""Height and finish of a leather from distances to its skeleton: the sum of its elements, each a profile."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.fields.profiles import dome, smoothstep, valley, visible
from surftex.materials.grooves import Line, grooves, own_or
from surftex.materials.layers import Layers
from surftex.materials.leather.cells import Plates
from surftex.materials.leather.model import Leather

Float = NDArray[np.float32]
Part = NDArray[np.floating] | np.float32

_FOOT = 0.45
"""Width of the ring of dye around a crown, as a share of the crown's own."""

_FOOT_DYE = 0.55
"""How much of a pore's dye that ring holds."""


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Distances of n samples to the nearest elements of each kind; None where a leather has none of the kind.

    Attributes
    ----------
    plates : Plates
        Place among the cells.
    cell_mm : (n,) float32
        Size of the sample's cell.
    level, tone : (n,) float32
        Random numbers of the cell, 0 to 1.
    cracks, wrinkles : tuple of Line
        The samples near some, and what they find of them.
    pocket_mm, pore_mm, crown_mm, crown_scale : (n,) float32
        Distances; and the size of the nearest crown, 1 on average.
    grain, mottle : (n,) float32
        Noise, about -1 to 1.
    """

    plates: Plates
    cell_mm: Float
    level: Float
    tone: Float
    cracks: tuple[Line, ...]
    wrinkles: tuple[Line, ...]
    pocket_mm: Float | None
    pore_mm: Float | None
    crown_mm: Float | None
    crown_scale: Float | None
    grain: Float
    mottle: Float


def layers(leather: Leather, skeleton: Skeleton, footprint_mm: Float) -> Layers:
    """Turn distances into channels.

    Parameters
    ----------
    leather : Leather
        Depths, widths, colours.
    skeleton : Skeleton
        Distances of n samples.
    footprint_mm : (n,) float32
        Side of each sample's patch.

    Returns
    -------
    layers : Layers
        `height_mm`, `base_color`, `roughness`, `specular`, `region`.
    """
    plates = skeleton.plates
    cell_visible = visible(skeleton.cell_mm, footprint_mm)
    variation = 1 + leather.variation * (2 * skeleton.level - 1) * cell_visible
    # Where a furrow is faint its two plates run into one: they stay up at the border instead of falling to it.
    share = 1 - leather.sulcus_variation * (0.5 + (plates.furrow - 0.5) * cell_visible)
    rise = share * dome(plates.ratio, leather.crista_exponent, skeleton.cell_mm, footprint_mm)
    crest = (1 - share + rise).astype(np.float32)
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

    wrinkle: Part = np.float32(0)
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
    pore: Part = np.float32(0)
    if skeleton.pore_mm is not None:
        pore = valley(skeleton.pore_mm, leather.pore_width, footprint_mm, dimension=2)
        relief = relief - leather.pore_depth * pore

    crown: Part = np.float32(0)
    pit: Part = np.float32(0)
    if skeleton.crown_mm is not None and skeleton.crown_scale is not None:
        width = leather.crown_width * skeleton.crown_scale
        t = np.minimum(skeleton.crown_mm / width, 1)
        crown = (1 - t * t * t) ** 2
        pit = valley(skeleton.crown_mm, leather.crown_pit_width, footprint_mm, dimension=2)
        foot = valley(np.abs(skeleton.crown_mm - width), _FOOT * width, footprint_mm, dimension=1)
        height = height * (1 - 0.6 * crown)
        relief = (
            relief * (1 - 0.6 * crown)
            + leather.crown_height * skeleton.crown_scale * crown
            - leather.crown_pit_depth * pit
        )
        pore = np.maximum(pore, np.maximum(pit, _FOOT_DYE * foot))
    grain = skeleton.grain * (1 - 0.7 * furrow)
    height = height + relief + leather.grain_height * grain
    return Layers(
        {
            "height_mm": height.astype(np.float32),
            **_finish(leather, skeleton, crest, furrow, wrinkle, pore, crown, pit),
        }
    )


def _folds(leather: Leather, wrinkles: tuple[Line, ...], footprint_mm: Float) -> Float:
    """Rise of the skin on the left of each wrinkle, where it is pushed together."""
    rise = np.zeros(len(footprint_mm), np.float32)
    for line in wrinkles:
        width, depth = own_or(line, leather.wrinkle_width, leather.wrinkle_depth)
        swell = valley(
            np.abs(line.distance_mm - width), 2 * width, footprint_mm[line.at], dimension=1
        )  # fmt: skip
        thick = np.maximum(width, np.float32(1e-9)).astype(np.float32)
        near = smoothstep(0, 1, line.distance_mm / thick) * smoothstep(0, 1, line.end_mm / (2 * thick))
        lift = leather.wrinkle_fold * depth * line.share * swell * near * line.left
        rise[line.at] = np.maximum(rise[line.at], lift)
    return rise


def _finish(
    leather: Leather,
    skeleton: Skeleton,
    crest: Float,
    furrow: NDArray[np.floating],
    wrinkle: Part,
    pore: Part,
    crown: Part,
    pit: Part,
) -> dict[str, NDArray]:
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
