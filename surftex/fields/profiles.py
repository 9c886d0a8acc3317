"""Profiles: the height of an element as a function of the distance to its skeleton, faded by the footprint.

A sample stands for a patch of the surface. Where the patch is wider than the element, the element comes out
wider and shallower by the same measure, so that its mean over the patch stays (a box filter, to second
order); two resolutions agree wherever both can see.
"""

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float32]

_VARIANCE = 1 / 12
"""Of a box of side 1."""


def valley(distance_mm: Float, width_mm: Float | float, footprint_mm: Float, *, dimension: int) -> Float:
    """Wendland's C2 function of a distance: 1 on the skeleton, 0 from `width_mm` on.

    ``phi(t) = (1 - t)^4 (4 t + 1)`` with t = d / w, Eq. 7 of Sakurai et al., "Procedural Modeling of Leather
    Texture with Structural Elements".

    Parameters
    ----------
    distance_mm : (n,) float
        To the nearest element; inf where there is none.
    width_mm : (n,) float or float
        Distance at which the element ends.
    footprint_mm : (n,) float
        Side of each sample's patch.
    dimension : int
        1 for skeletons that are lines, 2 for points: how fast a patch dilutes them.

    Returns
    -------
    phi : (n,) float32
        0 to 1.
    """
    width = np.asarray(width_mm, np.float32)
    # the second moment of phi across a line is 0.059 w^2
    wide = np.sqrt(width**2 + (_VARIANCE / 0.059) * footprint_mm.astype(np.float32) ** 2)
    t = np.minimum(distance_mm.astype(np.float32) / np.maximum(wide, np.float32(1e-30)), 1)
    falloff = (1 - t) * (1 - t)
    dilution = np.divide(width, wide, out=np.zeros_like(wide), where=wide > 0)
    return falloff * falloff * (4 * t + 1) * (dilution if dimension == 1 else dilution * dilution)


def visible(size_mm: Float | float, footprint_mm: Float) -> Float:
    """How much of a variation of some size is left in patches of some side.

    Parameters
    ----------
    size_mm : (n,) float or float
        Wavelength of the variation.
    footprint_mm : (n,) float
        Side of each patch.

    Returns
    -------
    share : (n,) float32
        1 where the patch is small, 0 where it is larger than the variation.
    """
    t = footprint_mm.astype(np.float32) / np.maximum(np.asarray(size_mm, np.float32), np.float32(1e-30))
    fade = np.clip(2 - 2.5 * t, 0, 1).astype(np.float32, copy=False)
    return fade * fade * (3 - 2 * fade)


def smoothstep(low: float, high: float, value: Float) -> Float:
    """0 below `low`, 1 above `high`, a smooth cubic between.

    Parameters
    ----------
    low : float
        Where the rise starts.
    high : float
        Where it ends.
    value : (n,) float
        Where to evaluate.

    Returns
    -------
    step : (n,) float32
        0 to 1.
    """
    t = np.clip((value - low) / (high - low), 0, 1).astype(np.float32)
    return t * t * (3 - 2 * t)
