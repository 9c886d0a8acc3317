"""The GGX lobe that several models share: height-correlated Smith shadowing and Schlick's Fresnel term."""

import numpy as np
from numpy.typing import NDArray

from surftex.optics.shaders.shader import Geometry

WIDTHS = np.geomspace(0.03, 1.0, 96)
"""Widths (alpha) to try."""


def lobe(width: float, geometry: Geometry) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Reflection that no reflectance changes, and reflection per reflectance at normal incidence [1]_.

    Parameters
    ----------
    width : float
        Alpha.
    geometry : Geometry
        Pairs of directions.

    Returns
    -------
    fixed, scaled : (m,) float64
        1/sr; the lobe is ``fixed + reflectance * scaled``.

    References
    ----------
    .. [1] B. Walter and others. Microfacet Models for Refraction through Rough Surfaces. EGSR 2007.
    """
    square = width * width
    density = square / (np.pi * (geometry.half**2 * (square - 1) + 1) ** 2)
    c, o = geometry.incident, geometry.outgoing
    shadow = 0.5 / (o * np.sqrt(square + (1 - square) * c * c) + c * np.sqrt(square + (1 - square) * o * o))
    grazing = (1 - geometry.half_incident) ** 5
    return density * shadow * grazing, density * shadow * (1 - grazing)
