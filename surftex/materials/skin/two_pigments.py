"""Colour of skin from two pigments: melanin that filters above, blood that absorbs below.

Stands in for a table of light transport.

Light passes an epidermis of melanosomes twice, and is reflected diffusely by a deep dermis with blood in it: absorption of
melanin, pheomelanin and bare skin as in [1]_, scattering as in [2]_, the dipole's diffuse albedo of [3]_, the daylight of
CIE D65 seen with the colour matching of [4]_. Thickness of the stratum corneum only scatters a little more.

References
----------
.. [1] Donner, Jensen. A Spectral BSSRDF for Shading Human Skin. EGSR (2006).
.. [2] Jacques. Optical properties of biological tissues: a review. Phys. Med. Biol. 58 (2013).
.. [3] Jensen, Marschner, Levoy, Hanrahan. A Practical Model for Subsurface Light Transport. SIGGRAPH (2001).
.. [4] Wyman, Sloan, Shirley. Simple Analytic Approximations to the CIE XYZ Color Matching Functions. JCGT 2 (2013).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float32]

_NM = np.arange(400.0, 701.0, 20.0)
_DAYLIGHT = np.array([82.75, 93.43, 104.86, 117.81, 115.92, 109.35, 104.79, 104.41, 100.0, 95.79, 90.01, 87.70,
                      83.70, 80.21, 78.28, 71.61])  # fmt: skip
_OXYGENATED = np.array([266232, 480360, 102580, 44480, 26629, 20933, 24202, 53236, 32613, 50104, 3200, 942, 442, 320,
                        278, 290.0])  # fmt: skip
_DEOXYGENATED = np.array([223296, 407560, 413280, 23389, 14550, 20862, 31590, 46592, 53788, 37020, 14677, 6510, 4345,
                          3227, 2408, 1794.0])  # fmt: skip
_BLOOD_PER_CM = 2.303 * 150 / 64500
_PATHS = 2.4
"""Mean way through the epidermis, down and up, in thicknesses."""

_SURFACE = 0.012
"""Light that the uppermost cells scatter back, whatever lies below."""

_MELANIN, _BLOOD = np.geomspace(1e-5, 1e-2, 49), np.geomspace(1e-3, 0.3, 33)
"""Nodes: melanosome share times centimetres of epidermis; blood share of the dermis."""


@dataclass(frozen=True)
class SkinAppearance:
    """What a renderer is told of skin at n samples.

    Attributes
    ----------
    base_color : (n, 3) float32
        Linear sRGB.
    roughness, specular : (n,) float32
        0 to 1.
    subsurface_weight : (n,) float32
        0 to 1.
    subsurface_radius_mm : (n, 3) float32
        Mean distance at which red, green and blue light leaves the skin again.
    """

    base_color: Float
    roughness: Float
    specular: Float
    subsurface_weight: Float
    subsurface_radius_mm: Float


def lookup(parameters: Mapping[str, NDArray[np.floating]]) -> SkinAppearance:
    """Look up how skin looks.

    Parameters
    ----------
    parameters : mapping of str to (n,) float32
        ``pheomelanin``, ``blood``, ``melanin``, ``oxygenation`` (shares), ``stratum_corneum_cm``, ``epidermis_cm``.

    Returns
    -------
    appearance : SkinAppearance
        Of the n samples.
    """
    depth = np.clip(parameters["melanin"] * parameters["epidermis_cm"], _MELANIN[0], _MELANIN[-1])
    blood = np.clip(parameters["blood"], _BLOOD[0], _BLOOD[-1])
    row = np.log(depth / _MELANIN[0]) * ((len(_MELANIN) - 1) / np.log(_MELANIN[-1] / _MELANIN[0]))
    column = np.log(blood / _BLOOD[0]) * ((len(_BLOOD) - 1) / np.log(_BLOOD[-1] / _BLOOD[0]))
    i = np.minimum(row.astype(np.int64), len(_MELANIN) - 2)
    j = np.minimum(column.astype(np.int64), len(_BLOOD) - 2)
    a, b = (row - i).astype(np.float32), (column - j).astype(np.float32)
    c, d = (np.clip(parameters[name], 0, 1).astype(np.float32) for name in ("pheomelanin", "oxygenation"))
    table = _table()
    color = np.zeros((len(i), 3), np.float32)
    for di, wa in ((0, 1 - a), (1, a)):
        for dj, wb in ((0, 1 - b), (1, b)):
            for k, wc in ((0, 1 - c), (1, c)):
                for m, wd in ((0, 1 - d), (1, d)):
                    color += (wa * wb * wc * wd)[:, None] * table[k, m, i + di, j + dj]
    count = len(color)
    rough = 0.43 + 20 * (np.asarray(parameters["stratum_corneum_cm"], np.float32) - 0.002)
    color = np.clip(color, _SURFACE, 1)
    radius = np.array([3.0, 1.1, 0.6], np.float32) * np.sqrt(color)
    return SkinAppearance(
        color,
        np.clip(rough, 0.3, 0.7).astype(np.float32),
        np.full(count, 0.35, np.float32),
        np.ones(count, np.float32),
        radius,
    )


@cache
def _table() -> Float:
    """Linear sRGB by pheomelanin, oxygenation (both 0 and 1), melanin and blood: (2, 2, m, b, 3)."""
    melanin = np.stack([6.6e11 * _NM**-3.33, 2.9e15 * _NM**-4.75])
    filtered = np.exp(-_PATHS * melanin[:, None] * _MELANIN[:, None])
    bare = 0.0244 + 8.53 * np.exp(-(_NM - 154) / 66.2)
    haemoglobin = np.stack([_DEOXYGENATED, _OXYGENATED]) * _BLOOD_PER_CM
    absorbed = bare + _BLOOD[:, None] * haemoglobin[:, None]
    scattered = 43.6 * (0.41 * (_NM / 500) ** -4 + 0.59 * (_NM / 500) ** -0.562)
    root = np.sqrt(3 * absorbed / (absorbed + scattered))
    index = 1.4
    inner = -1.440 / index**2 + 0.710 / index + 0.668 + 0.0636 * index
    bounce = 4 / 3 * (1 + inner) / (1 - inner)
    dermis = 0.5 * (1 - root**2 / 3) * (1 + np.exp(-bounce * root)) * np.exp(-root)
    spectrum = filtered[:, None, :, None, :] * dermis[None, :, None]
    return (spectrum @ _color_matching().T).astype(np.float32)


def _color_matching() -> NDArray[np.float64]:
    """(3, wavelengths): linear sRGB of a reflectance under D65."""

    def bump(middle: float, below: float, above: float) -> NDArray[np.float64]:
        t = (_NM - middle) * np.where(middle > _NM, below, above)
        return np.exp(-0.5 * t * t)

    xyz = np.stack(
        [
            0.362 * bump(442.0, 0.0624, 0.0374) + 1.056 * bump(599.8, 0.0264, 0.0323)
            - 0.065 * bump(501.1, 0.0490, 0.0382),
            0.821 * bump(568.8, 0.0213, 0.0247) + 0.286 * bump(530.9, 0.0613, 0.0322),
            1.217 * bump(437.0, 0.0845, 0.0278) + 0.681 * bump(459.0, 0.0385, 0.0725),
        ]
    ) * _DAYLIGHT  # fmt: skip
    rgb = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
    rows = rgb @ (xyz / xyz[1].sum())
    return rows / rows.sum(axis=1, keepdims=True)
