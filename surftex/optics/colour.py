"""How colours look: CIELAB in daylight, the difference of two colours, and the angle by which skin is typed."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
"""Linear sRGB to XYZ, IEC 61966-2-1."""

TYPES = {
    "dark": -np.inf,
    "brown": -30.0,
    "tan": 10.0,
    "intermediate": 28.0,
    "light": 41.0,
    "very light": 55.0,
}
"""Least individual typology angle of each class, degrees (Chardon 1991; Del Bino 2006)."""


def lab(color: ArrayLike) -> NDArray[np.float64]:
    """Turn linear sRGB into CIELAB under D65.

    Parameters
    ----------
    color : (..., 3) float
        Linear sRGB; white is (1, 1, 1).

    Returns
    -------
    lab : (..., 3) float64
        L* 0 to 100, a*, b*.
    """
    share = np.asarray(color, np.float64) @ (_XYZ / _XYZ.sum(1, keepdims=True)).T
    root = np.where(share > (6 / 29) ** 3, np.cbrt(share), share * (29 / 6) ** 2 / 3 + 4 / 29)
    x, y, z = np.moveaxis(root, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def typology_angle(color: ArrayLike) -> NDArray[np.float64]:
    """Measure the individual typology angle (ITA) of a skin colour.

    Parameters
    ----------
    color : (..., 3) float
        Linear sRGB.

    Returns
    -------
    degrees : (...) float64
        Above 55 very light, below -30 dark; `TYPES` has the limits.
    """
    value = lab(color)
    return np.degrees(np.arctan2(value[..., 0] - 50, value[..., 2]))


def difference(first: ArrayLike, second: ArrayLike) -> NDArray[np.float64]:
    """Tell how different two colours look: CIEDE2000 [1]_.

    Parameters
    ----------
    first, second : (..., 3) float
        CIELAB.

    Returns
    -------
    difference : (...) float64
        1 is about what an eye can just see.

    References
    ----------
    .. [1] G. Sharma, W. Wu, E. Dalal. The CIEDE2000 color-difference formula. Color Res. Appl. 30 (2005).

    Examples
    --------
    >>> float(difference([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485]).round(4))
    2.0425
    """
    first, second = np.asarray(first, np.float64), np.asarray(second, np.float64)
    chroma = (np.hypot(first[..., 1], first[..., 2]) + np.hypot(second[..., 1], second[..., 2])) / 2
    stretch = 1.5 - 0.5 * np.sqrt(chroma**7 / (chroma**7 + 25.0**7))
    a1, a2 = first[..., 1] * stretch, second[..., 1] * stretch
    c1, c2 = np.hypot(a1, first[..., 2]), np.hypot(a2, second[..., 2])
    h1 = np.degrees(np.arctan2(first[..., 2], a1)) % 360
    h2 = np.degrees(np.arctan2(second[..., 2], a2)) % 360
    gray = c1 * c2 == 0
    turn = np.where(gray, 0, (h2 - h1 + 180) % 360 - 180)
    hue = np.where(gray, h1 + h2, (h1 + turn / 2) % 360)
    lightness, mean = (first[..., 0] + second[..., 0]) / 2, (c1 + c2) / 2
    t = (
        1
        - 0.17 * np.cos(np.radians(hue - 30))
        + 0.24 * np.cos(np.radians(2 * hue))
        + 0.32 * np.cos(np.radians(3 * hue + 6))
        - 0.20 * np.cos(np.radians(4 * hue - 63))
    )
    light = (second[..., 0] - first[..., 0]) / (
        1 + 0.015 * (lightness - 50) ** 2 / np.sqrt(20 + (lightness - 50) ** 2)
    )
    strong = (c2 - c1) / (1 + 0.045 * mean)
    tone = 2 * np.sqrt(c1 * c2) * np.sin(np.radians(turn) / 2) / (1 + 0.015 * mean * t)
    bend = np.radians(60 * np.exp(-(((hue - 275) / 25) ** 2)))
    mixed = -2 * np.sqrt(mean**7 / (mean**7 + 25.0**7)) * np.sin(bend)
    return np.sqrt(light**2 + strong**2 + tone**2 + mixed * strong * tone)
