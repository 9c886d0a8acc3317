"""The finest detail that a mesh carries itself, to be told apart from what is placed on it."""

import numpy as np

from surftex.fields.curvature import Bending
from surftex.surface.surface import Surface

MOST_FACES = 300_000
"""Larger meshes are not measured: it would take longer than their bake."""

_OCTAVES = 7
_FIRST = 0.35
"""Radius of the finest average, in mean edges."""

_WAVELENGTHS = 5.3
"""Wavelength that an average loses half of, in its standard deviations."""

_TOLERANCE = 1e-2
"""Of the averages: slopes are told to a hundredth of theirs."""

_SLOPE, _SHARE = 0.09, 0.99
"""A wavelength counts as detail where slopes of five degrees are exceeded on a hundredth of the surface."""

_MOST = 0.5
"""Of the longest side: a longer wave is the shape itself, no relief on it."""


def finest_detail_mm(surface: Surface) -> float | None:
    """Find the smallest wavelength of a mesh's own relief.

    The mean curvature is averaged over ever larger neighbourhoods; what one average has and the next has not is an octave
    of the surface's spectrum, and curvature times wavelength over 2 pi is the slope of its waves.

    Parameters
    ----------
    surface : Surface
        Any.

    Returns
    -------
    wavelength_mm : float or None
        Of the finest octave with waves steep enough to see somewhere; None where the mesh is smooth but for bends as large
        as itself, or has more than `MOST_FACES` faces.
    """
    if len(surface.faces) > MOST_FACES:
        return None
    area = np.bincount(
        surface.faces.ravel(), np.repeat(surface.face_area_mm2 / 3, 3), minlength=len(surface.vertices)
    )
    radius = _FIRST * surface.mean_edge_mm
    bending = Bending.of(surface)
    finer = bending.mean_curvature(radius, tolerance=_TOLERANCE)
    for _ in range(_OCTAVES):
        coarser = bending.mean_curvature(2 * radius, tolerance=_TOLERANCE)
        wavelength = _WAVELENGTHS * np.sqrt(2) * radius
        if wavelength > _MOST * surface.longest_side_mm:
            return None
        bends = np.abs(finer - coarser)
        order = np.argsort(bends)
        bend = bends[order][np.searchsorted(np.cumsum(area[order]), _SHARE * area.sum())]
        if bend * wavelength / (2 * np.pi) > _SLOPE:
            return wavelength
        finer, radius = coarser, 2 * radius
    return None
