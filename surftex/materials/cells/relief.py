"""Height and finish of grown cells, from where a sample lies in its cell."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.fields.profiles import smoothstep, visible
from surftex.materials.cells.model import Cells
from surftex.materials.grooves import Line, grooves
from surftex.materials.layers import Layers

Float = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Place:
    """Where n samples lie.

    Attributes
    ----------
    owner : (n,) int32
        Cell of each; -1 where there is none.
    rho : (n,) float32
        0 in the middle of the cell, 1 on its outline, more in the groove.
    border_mm : (n,) float32
        To the outline, away from the middle; below 0 in the groove.
    swelling_mm : (n,) float32
        Height of the metaballs, in lengths of their radius.
    scale_mm : (n,) float32
        Cell size thereabouts.
    rise : (n,) float32
        How far its cell rises, as a share of the full rise.
    mean_rise : float
        Of all cells.
    level, tone : (n,) float32
        Random numbers of the cell, 0 to 1.
    wrinkles : tuple of Line
        The samples near some, and what they find of them.
    shallow, grain, mottle : (n,) float32
        Noise, about -1 to 1.
    """

    owner: NDArray[np.int32]
    rho: Float
    border_mm: Float
    swelling_mm: Float
    scale_mm: Float
    rise: Float
    mean_rise: np.float32
    level: Float
    tone: Float
    wrinkles: tuple[Line, ...]
    shallow: Float
    grain: Float
    mottle: Float


def side_profile(rho: Float, taper: float, shoulder: float, groove: float) -> Float:
    """Hermite curve from the top of a cell down to its groove.

    Parameters
    ----------
    rho : (n,) float
        Gauge.
    taper : float
        The top is rho <= 1 - taper.
    shoulder : float
        Slope at the top.
    groove : float
        Slope at the bottom.

    Returns
    -------
    height : (n,) float32
        1 on the top, 0 from the outline on.
    """
    u = np.clip((rho - (1 - taper)) / taper, 0, 1).astype(np.float32)
    square, cube = u * u, u * u * u
    height = 2 * cube - 3 * square + 1 + shoulder * (cube - 2 * square + u) + groove * (cube - square)
    return height.astype(np.float32, copy=False)


def layers(cells: Cells, place: Place, footprint_mm: Float) -> Layers:
    """Turn places into channels.

    Parameters
    ----------
    cells : Cells
        Heights, widths, colours.
    place : Place
        Of n samples.
    footprint_mm : (n,) float32
        Side of each sample's patch.

    Returns
    -------
    layers : Layers
        `height_mm`, `base_color`, `roughness`, `specular`, `region`.
    """
    scale = place.scale_mm
    rise = cells.relief * scale
    fine = visible(0.45 * cells.taper * scale, footprint_mm)
    coarse = visible(0.8 * scale, footprint_mm)
    side = side_profile(place.rho, cells.taper, cells.shoulder, cells.groove)
    mean = np.float32(1 - 0.6 * cells.taper)
    side = mean + (side - mean) * fine
    inside = np.clip(1 - place.rho**2, 0, 1)
    crest = np.float32(0.5) + (inside - np.float32(0.5)) * coarse
    floor = cells.shallows * smoothstep(-0.5, 0.7, place.shallow)
    own = place.mean_rise + (place.rise - place.mean_rise) * coarse
    own = own * (1 + cells.relief_variation * (2 * place.level - 1) * coarse)
    # the floor is that of all cells, so that neighbours meet on it without a step
    height = rise * (floor * place.mean_rise + own * ((1 - floor) * side + cells.dome * crest))
    fade = np.clip((1 - place.rho) / np.float32(cells.taper), 0, 1)
    blobs = place.swelling_mm * fade * visible(2 * cells.blob_size * scale, footprint_mm)
    height = height + cells.blob_height * rise * own * blobs
    furrow = np.clip(1 - side, 0, 1) * (1 - floor)

    wrinkle, groove = grooves(place.wrinkles, cells.wrinkle_width, cells.wrinkle_depth, footprint_mm)
    height = height - groove
    height = height + cells.grain_height * place.grain * (1 - 0.6 * furrow)
    return Layers(
        {
            "height_mm": height.astype(np.float32),
            **_finish(cells, place, furrow.astype(np.float32), (crest * side).astype(np.float32), wrinkle),
        }
    )


def _finish(cells: Cells, place: Place, furrow: Float, crest: Float, wrinkle: Float) -> dict[str, NDArray]:
    """Dye pools in grooves and wrinkles; crests are worn, polished and paler; the tone drifts."""
    drift = place.mottle
    deep = np.maximum(smoothstep(0.3, 0.95, furrow), 0.7 * wrinkle)
    dye = np.clip(cells.dye * deep, 0, 1)
    high = smoothstep(0.5, 0.95, crest) * (1 - deep)
    worn = cells.wear * np.clip(high * (0.8 + 0.9 * drift), 0, 1)
    tone = 1 + 2 * cells.mottle * drift + cells.cell_tone * (2 * place.tone - 1)
    tint = np.array([1.0, 1.05, 1.1], np.float32)
    color = np.array(cells.color, np.float32) * (1 + (tone - 1)[:, None] * tint)
    color += dye[:, None] * (np.array(cells.furrow_color, np.float32) - color)
    color += worn[:, None] * (np.array(cells.crest_color, np.float32) - color)
    rough = cells.roughness + 0.08 * drift
    rough = rough + deep * (cells.furrow_roughness - rough)
    rough = rough + high * (1 - dye) * (cells.crest_roughness - cells.roughness)
    return {
        "base_color": np.clip(color, 0, 1).astype(np.float32),
        "roughness": np.clip(rough, 0.04, 1).astype(np.float32),
        "specular": (cells.specular * (1 - 0.5 * dye)).astype(np.float32),
        "region": place.owner,
    }
