"""How far light wanders below the surface: Burley's profile fitted to where a thin beam comes out again.

The profile of width d holds ``F(r) = 1 - exp(-r/d)/4 - 3 exp(-r/3d)/4`` of the light within r [1]_. Renderers
take a mean free path that goes with it, ``d s(A)`` for an albedo A.

References
----------
.. [1] P. Christensen, B. Burley. Approximate Reflectance Profiles for Efficient Subsurface Scattering. Pixar
   Technical Memo 15-04 (2015).
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

EDGES_MM = np.geomspace(0.005, 20.0, 97)
"""Radii at which the light within is known; light beyond the last counts for the whole alone."""

_WIDTHS_MM = np.geomspace(0.002, 10.0, 240)


def rings(wander_cm: NDArray[np.float64]) -> NDArray[np.int64]:
    """Ring that a path ends in.

    Parameters
    ----------
    wander_cm : (n,) float64
        Distance from the beam.

    Returns
    -------
    ring : (n,) int64
        0 within the first edge, 97 beyond the last.
    """
    return np.searchsorted(EDGES_MM, wander_cm * 10)


def burley_within(radius_mm: ArrayLike, width_mm: ArrayLike) -> NDArray[np.float64]:
    """Share of the light that Burley's profile holds within a radius.

    Parameters
    ----------
    radius_mm, width_mm : (...) float
        Broadcast against each other.

    Returns
    -------
    share : (...) float64
        0 to 1.
    """
    x = np.asarray(radius_mm, np.float64) / np.asarray(width_mm, np.float64)
    return 1 - 0.25 * np.exp(-x) - 0.75 * np.exp(-x / 3)


def fit_width(light: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fit the width of Burley's profile by least squares over the share of light within each radius.

    Parameters
    ----------
    light : (..., 98) float64
        Light in each of the `rings`.

    Returns
    -------
    width_mm : (...) float64
        Best over a row of widths, refined by a parabola.
    error : (...) float64
        Largest difference of the share of light within a radius.
    """
    whole = np.maximum(light.sum(-1, keepdims=True), 1e-300)
    within = np.cumsum(light[..., :-1], axis=-1) / whole
    tried = burley_within(EDGES_MM, _WIDTHS_MM[:, None])
    cost = (tried**2).sum(1) - 2 * within @ tried.T
    best = np.clip(cost.argmin(-1), 1, len(_WIDTHS_MM) - 2)[..., None]
    a, b, c = (np.take_along_axis(cost, best + step, -1)[..., 0] for step in (-1, 0, 1))
    bend = np.maximum(a - 2 * b + c, 1e-300)
    place = best[..., 0] + np.clip((a - c) / (2 * bend), -1, 1)
    logs = np.log(_WIDTHS_MM)
    width = np.exp(logs[0] + place * (logs[1] - logs[0]))
    return width, np.abs(within - burley_within(EDGES_MM, width[..., None])).max(-1)


def mean_free_path(width_mm: ArrayLike, albedo: ArrayLike) -> NDArray[np.float64]:
    """Mean free path that renderers take for a profile; a thin beam straight from above.

    Parameters
    ----------
    width_mm : (...) float
        Of Burley's profile.
    albedo : (...) float
        Diffuse colour.

    Returns
    -------
    radius_mm : (...) float64
        ``width (1.85 - A + 7 |A - 0.8|^3)``.
    """
    return np.asarray(width_mm) * _paths_per_width(albedo)


def profile_width(radius_mm: ArrayLike, albedo: ArrayLike) -> NDArray[np.float64]:
    """Width of Burley's profile that a mean free path stands for: the inverse of `mean_free_path`.

    Parameters
    ----------
    radius_mm : (...) float
        Mean free path.
    albedo : (...) float
        Diffuse colour.

    Returns
    -------
    width_mm : (...) float64
        The d of the profile.
    """
    return np.asarray(radius_mm) / _paths_per_width(albedo)


def _paths_per_width(albedo: ArrayLike) -> NDArray[np.float64]:
    albedo = np.asarray(albedo, np.float64)
    return 1.85 - albedo + 7 * np.abs(albedo - 0.8) ** 3
