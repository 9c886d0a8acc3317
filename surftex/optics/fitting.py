"""Which biology gives a measured reflectance: a fit over one set of paths, and what it leaves unexplained.

A fit, not a measurement: parameters trade against each other (melanin against the kind of melanin, blood against
its oxygen), so a spectrum leaves some of them free.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, checked_number, checked_whole, frozen
from surftex.errors import InputError
from surftex.optics.paths import MOST_PATHS, SURFACE, volume_paths
from surftex.optics.spectra import LONGEST_NM, SHORTEST_NM
from surftex.optics.tissue import PARAMETERS, Tissue, absorption

FREE = ("pheomelanin", "melanin", "blood", "oxygenation")
"""Parameters that are fitted; the two thicknesses keep their usual values."""

_EIGHT_DEGREES = float(np.cos(np.radians(8)))
_OFFSET = 0.01
_PULL = 0.008
"""How strongly what the spectrum leaves free is pulled to the usual values, in reflectance per range."""


@dataclass(frozen=True)
class Fit:
    """The biology that comes nearest to a spectrum.

    Attributes
    ----------
    biology : dict of str to float
        All parameters.
    base_albedo : float
        Of the base below the dermis.
    offset : float
        Of the surface's reflection against what was measured, -0.01 to 0.01.
    rmse : float
        Root of the mean square left, in reflectance.
    """

    biology: dict[str, float]
    base_albedo: float
    offset: float
    rmse: float


@cache
def _walked(nm: tuple[float, ...], paths: int, seed: int) -> tuple[NDArray[np.float64], ...]:
    """Lengths (k, n, 4), weight (k, n), bounces off the base (k, n), share of the surface's reflection (k,)."""
    usual = {name: each.usual for name, each in PARAMETERS.items()}
    white, gray = Tissue(base_albedo=1.0), Tissue(base_albedo=0.5)
    rows = []
    for wave in nm:
        first, second = (
            volume_paths(
                each, wave, paths, stratum_corneum_cm=usual["stratum_corneum_cm"],
                epidermis_cm=usual["epidermis_cm"], seed=seed, cosine=_EIGHT_DEGREES,
            )
            for each in (white, gray)
        )  # fmt: skip
        share = second.weight / np.maximum(first.weight, 1e-300)
        bounces = np.where(first.weight > 0, -np.log2(np.maximum(share, 1e-300)), 0.0)
        rows.append((first.lengths, first.weight, bounces, np.mean(first.kind == SURFACE)))
    return tuple(frozen(np.array(each)) for each in zip(*rows, strict=True))


def fit_reflectance(
    nm: ArrayLike,
    reflectance: ArrayLike,
    *,
    base_albedo: float | None = None,
    paths: int = 4000,
    seed: int = 0,
) -> Fit:
    """Find the biology whose reflectance comes nearest to a measured one, by free paths of light.

    Parameters
    ----------
    nm : (k,) float
        Wavelengths, 380 to 780.
    reflectance : (k,) float
        With what the surface reflects, for light at 8 degrees (a d/8 sphere, specular included).
    base_albedo : float, optional
        Held fixed; fitted without it.
    paths : int
        Photons per wavelength.
    seed : int
        Of the walk.

    Returns
    -------
    fit : Fit
        The best of four starts, from light to dark.

    Raises
    ------
    InputError
        If the two do not fit each other, there are fewer wavelengths than parameters, or one leaves the tables; and for
        an argument out of its range.
    """
    from scipy.optimize import least_squares

    nm = checked(nm, "nm", (None,), np.float64)
    measured = checked(reflectance, "reflectance", (None,), np.float64)
    if len(nm) != len(measured) or len(nm) < 8:
        raise InputError(
            f"reflectance holds {len(measured)} values at {len(nm)} wavelengths; it takes 8 or more"
        )
    beyond = (nm < SHORTEST_NM) | (nm > LONGEST_NM)
    if beyond.any():
        raise InputError(
            f"nm holds {beyond.sum()} wavelengths beyond the tables; the first is {nm[beyond][0]:g}; they go from "
            f"{SHORTEST_NM:g} to {LONGEST_NM:g}"
        )
    paths, seed = checked_whole(paths, "paths", 1, MOST_PATHS), checked_whole(seed, "seed", -np.inf)
    if base_albedo is not None:
        base_albedo = checked_number(base_albedo, "base_albedo", 0, 1)
    lengths, weight, bounces, surface = _walked(tuple(nm.tolist()), paths, seed)
    usual, tissue = {name: each.usual for name, each in PARAMETERS.items()}, Tissue()
    ranges = [(PARAMETERS[name].low, PARAMETERS[name].high) for name in FREE]
    even = np.array([PARAMETERS[name].even for name in FREE])
    low, high = np.array(ranges).T
    low, high = (np.where(even, each, np.log(np.maximum(each, 1e-9))) for each in (low, high))
    middle = np.array([PARAMETERS[name].usual for name in FREE])[[0, 3]]
    based = (0.0, 1.0) if base_albedo is None else (base_albedo - 1e-9, base_albedo + 1e-9)
    low, high = np.append(low, [based[0], -_OFFSET]), np.append(high, [based[1], _OFFSET])

    def biology(x: NDArray[np.float64]) -> dict[str, float]:
        values = np.where(even, x[:4], np.exp(x[:4]))
        return usual | {name: float(value) for name, value in zip(FREE, values, strict=True)}

    def unexplained(x: NDArray[np.float64]) -> NDArray[np.float64]:
        depth = np.einsum("kni,ik->kn", lengths, absorption(tissue, nm, biology(x)))
        light = weight * np.maximum(x[4], 1e-12) ** bounces * np.exp(-depth)
        return light.mean(1) + surface + x[5] - measured

    def left(x: NDArray[np.float64]) -> NDArray[np.float64]:
        pull = _PULL * (len(nm) ** 0.5) * (x[[0, 3]] - middle)
        return np.concatenate([unexplained(x), pull])

    tried = []
    for melanin in (0.01, 0.04, 0.12, 0.35):
        start = np.array([0.3, np.log(melanin), np.log(0.02), 0.75, 0.5, 0.0])
        start = np.clip(start, low + 1e-10, high - 1e-10)
        tried.append(least_squares(left, start, bounds=(low, high), x_scale=high - low))
    x = min(tried, key=lambda found: found.cost).x
    rmse = np.sqrt(np.mean(unexplained(x) ** 2))
    return Fit(biology(x), float(x[4]), float(x[5]), float(rmse))
