"""Height and finish of a leather from distances to its skeleton: the sum of its elements, each a profile."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import read_only_view
from surftex.fields.profiles import smoothstep, valley
from surftex.materials.grooves import Line, grooves, own_or
from surftex.materials.layers import Layers
from surftex.materials.leather.cells import Plates
from surftex.materials.leather.model import Leather

Float = NDArray[np.float32]

_WHOLE = range(2, 9)
"""Exponents that are quicker by products."""


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
    from surftex.kernels.leather import BLOCK, ROWS, leather_layers

    plates, n = skeleton.plates, len(footprint_mm)
    nothing, nowhere = np.zeros(n, np.float32), np.full(n, np.inf, np.float32)
    wrinkle = carved = nothing
    if skeleton.wrinkles:
        wrinkle, carved = grooves(
            skeleton.wrinkles, leather.wrinkle_width, leather.wrinkle_depth, footprint_mm
        )
        if leather.wrinkle_fold:
            carved = carved - _folds(leather, skeleton.wrinkles, footprint_mm)
    points = (skeleton.pocket_mm, skeleton.pore_mm, skeleton.crown_mm)
    given = (
        _fall(plates.ratio, leather.crista_exponent), skeleton.cell_mm, skeleton.level, skeleton.tone,
        plates.border_mm, plates.furrow, plates.along,
        _cracks(leather, skeleton.cracks, footprint_mm), wrinkle, carved,
        *(nowhere if away is None else away for away in points),
        nothing if skeleton.crown_scale is None else skeleton.crown_scale,
        skeleton.grain, skeleton.mottle, footprint_mm,
    )  # fmt: skip
    height, rough, specular = (np.zeros(n, np.float32) for _ in range(3))
    color = np.zeros((n, 3), np.float32)
    leather_layers(
        _look(leather), *(read_only_view(part, np.float32) for part in given),
        np.zeros(ROWS * BLOCK, np.float32), height, color, rough, specular,
    )  # fmt: skip
    return Layers(
        {
            "height_mm": height,
            "base_color": color,
            "roughness": rough,
            "specular": specular,
            "region": plates.own,
        }
    )


def _fall(ratio: Float, exponent: float) -> Float:
    """Raise to a power how far out samples lie on their cells; by products where it is a small whole one."""
    q = np.clip(ratio, 0, 1)
    if exponent not in _WHOLE:
        return q ** np.float32(exponent)
    fall = q * q
    for _ in range(int(exponent) - 2):
        fall *= q
    return fall


def _look(leather: Leather) -> Any:
    """Take the depths, widths and colours of a leather as the kernel does."""
    from surftex.kernels.leather import Look

    n = leather.crista_exponent
    numbers = {**dict(leather), "mean": n / (n + 2), "lift": leather.scale_overlap * leather.crista_height}
    return Look(*(_single(numbers[name]) for name in Look._fields))


def _single(number: Any) -> Any:
    """Round a number, or those of a colour, to single precision."""
    return tuple(map(np.float32, number)) if isinstance(number, tuple) else np.float32(number)


def _cracks(leather: Leather, cracks: tuple[Line, ...], footprint_mm: Float) -> Float:
    """Share of a furrow that cracks reach at each sample."""
    share = np.zeros(len(footprint_mm), np.float32)
    for line in cracks:
        width = leather.sulcus_width * line.share
        crack = valley(line.distance_mm, width, footprint_mm[line.at], dimension=1) * line.share
        share[line.at] = np.maximum(share[line.at], crack)
    return share


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
