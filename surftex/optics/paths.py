"""Sets of light paths through skin that knows no absorption, by either engine; `Paths` serves every absorber.

* ``crossings``: one decision per layer crossed, as BioSpec and the thesis have it; thickness of the two upper
  layers may be chosen afterwards as well. About 1e6 paths take 3 CPU-s.
* ``volume``: free paths between scatterings; needed for light skin and for how far light wanders. About 5e4
  paths take 3 CPU-s.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked_whole, frozen
from surftex.errors import InputError
from surftex.kernels.pool import slices
from surftex.optics.border import facet_tables
from surftex.optics.tissue import Tissue, baseline
from surftex.randomness import stream

ENGINES = ("biospec", "volume")
"""Names of the engines: the layer-crossing walk of the thesis, and the free-path walk."""

SURFACE, LEFT, BELOW, LOST = 0, 1, 2, 3
"""How a path ends: reflected by the surface, out of the skin, out below (or absorbed), given up."""

MOST_PATHS = 100_000_000
"""Paths of a set; this many take about 10 GB."""

_SLICE = 4096
_CROSSINGS = 2000

_ANGLE = np.array([0, 2.5, 7.5, 12.5, 17.5, 22.5, 27.5, 32.5, 37.5, 42.5, 47.5, 52.5, 57.5, 62.5])
_WITHIN = {
    365: (
        [0, 14.8, 50.1, 66.8, 76.5, 82.3, 86.3, 89.4, 92.0, 94.1, 96.0, 97.6, 98.9, 100],
        [0, 1.7, 11.9, 24.8, 37.5, 49.0, 59.8, 69.2, 77.4, 84.2, 89.8, 94.3, 97.8, 100],
    ),
    436: (
        [0, 17.6, 55.2, 70.9, 79.1, 84.1, 87.6, 90.3, 92.5, 94.4, 96.1, 97.6, 99.0, 100],
        [0, 2.6, 16.1, 30.8, 43.6, 54.5, 63.9, 71.9, 79.0, 85.0, 90.1, 94.3, 97.8, 100],
    ),
    546: (
        [0, 20.6, 60.2, 75.2, 82.3, 86.5, 89.4, 91.5, 93.4, 95.0, 96.5, 97.8, 99.0, 100],
        [0, 4.0, 22.5, 39.7, 52.2, 62.4, 70.2, 76.7, 82.4, 87.2, 91.4, 94.9, 97.9, 100],
    ),
}
"""Light within `_ANGLE` degrees behind stratum corneum and epidermis, percent, by wavelength in nm.
W. Bruls, J. van der Leun. Forward Scattering Properties of Human Epidermal Layers. Photochem. Photobiol. 40 (1984)."""


@dataclass(frozen=True, eq=False)
class Paths:
    """What n photons of one wavelength did.

    Attributes
    ----------
    lengths : (n, 4) float64
        In each layer: cm (``volume``), or in units of the layer's thickness (``biospec``).
    weight : (n,) float64
        Of each path where nothing absorbs, the base included; 0 unless `kind` is `LEFT`.
    kind : (n,) int8
        How each path ends.
    leaving : (n, 3) float64
        Its last direction, z out of the skin.
    cosine : (n,) float64
        Of incidence, along -x.
    wander_cm : (n,) float64
        How far from the point of entry it ended, along the surface; zeros from ``biospec``.
    """

    lengths: NDArray[np.float64]
    weight: NDArray[np.float64]
    kind: NDArray[np.int8]
    leaving: NDArray[np.float64]
    cosine: NDArray[np.float64]
    wander_cm: NDArray[np.float64]


@cache
def turn_tables(nm: float) -> NDArray[np.float64]:
    """Cosine of the turn in stratum corneum and epidermis by uniform number; interpolated in the angle.

    Parameters
    ----------
    nm : float
        Wavelength; beyond 546 the last measured one holds.

    Returns
    -------
    cosine : (2, 513) float64
        From 1 down.
    """
    number, known = np.linspace(0, 100, 513), list(_WITHIN)
    angle = np.array([[np.interp(number, row, _ANGLE) for row in _WITHIN[each]] for each in known])
    i = int(np.clip(np.searchsorted(known, nm) - 1, 0, len(known) - 2))
    share = np.clip((nm - known[i]) / (known[i + 1] - known[i]), 0, 1)
    return frozen(np.cos(np.radians(angle[i] + share * (angle[i + 1] - angle[i]))))


def rayleigh_scattering(tissue: Tissue, nm: float) -> NDArray[np.float64]:
    """How strongly collagen scatters in the two layers of the dermis, in the crossing walk.

    Parameters
    ----------
    tissue : Tissue
        Its collagen.
    nm : float
        Wavelength.

    Returns
    -------
    scattering : (2,) float64
        1/cm; 132 and 93 at 550 nm by default.
    """
    number = tissue.collagen_volume / (4 / 3 * np.pi * tissue.collagen_radius_cm**3)
    contrast = (tissue.collagen_index / np.array(tissue.index[2:])) ** 2 - 1
    return 8 * np.pi**3 * contrast**2 / (3 * number * (nm * 1e-7) ** 4)


def reduced_scattering(nm: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How strongly the layers scatter in the volume walk [1]_.

    Parameters
    ----------
    nm : (k,) float
        Wavelengths.

    Returns
    -------
    upper, dermis : (k,) float64
        Reduced coefficients, 1/cm.

    References
    ----------
    .. [1] S. Jacques. Optical properties of biological tissues: a review. Phys. Med. Biol. 58 (2013).
    """
    share = np.asarray(nm, np.float64) / 500
    upper = 66.7 * (0.29 * share**-4 + 0.71 * share**-0.69)
    return upper, 43.6 * (0.41 * share**-4 + 0.59 * share**-0.562)


def crossing_paths(
    tissue: Tissue,
    nm: float,
    count: int,
    *,
    seed: int = 0,
    cosine: float = 0.0,
    depth: ArrayLike = (0.0, 0.0, 0.0, 0.0),
    threads: int | None = None,
) -> Paths:
    """Send photons through the layers by the walk of the thesis.

    Parameters
    ----------
    tissue : Tissue
        What stays fixed.
    nm : float
        Wavelength.
    count : int
        Photons.
    seed : int
        Of the walk; a photon's path depends on seed, wavelength and its number alone.
    cosine : float
        Of incidence; 0 lights from everywhere, evenly.
    depth : (4,) float
        Optical depth of absorption across each layer, to end paths by chance; zeros keep every path whole.
    threads : int, optional
        None means every core.

    Returns
    -------
    paths : Paths
        `lengths` in thicknesses.
    """
    from surftex.kernels.crossings import walk_crossings

    steepness, escape = facet_tables(tissue)
    key = np.uint64(stream(seed, "optics", "biospec", f"{nm:g}").key)
    layers = np.array([tissue.papillary_cm, tissue.reticular_cm])
    index, angle = np.array(tissue.index), turn_tables(float(nm))
    rayleigh, absorbing = rayleigh_scattering(tissue, nm) * layers, np.array(depth, np.float64)
    lengths, bounces, kind, leaving = _room(count)

    def work(first: int, last: int) -> None:
        part = slice(first, last)
        walk_crossings(
            key, first, float(cosine), index, tissue.fold, steepness, escape, angle, rayleigh, absorbing,
            _CROSSINGS, lengths[part], bounces[part], kind[part], leaving[part],
        )  # fmt: skip

    slices(work, count, size=_SLICE, threads=threads)
    weight = np.where(kind == LEFT, float(tissue.base_albedo) ** bounces, 0.0)
    return Paths(lengths, weight, kind, leaving[:, :3], leaving[:, 3], np.zeros(count))


def volume_paths(
    tissue: Tissue,
    nm: float,
    count: int,
    *,
    stratum_corneum_cm: float,
    epidermis_cm: float,
    seed: int = 0,
    cosine: float = 0.0,
    threads: int | None = None,
) -> Paths:
    """Send photons through the layers by free paths.

    Parameters
    ----------
    tissue : Tissue
        What stays fixed.
    nm : float
        Wavelength.
    count : int
        Photons.
    stratum_corneum_cm, epidermis_cm : float
        Thickness of the upper layers.
    seed : int
        Of the walk.
    cosine : float
        Of incidence; 0 lights from everywhere, evenly.
    threads : int, optional
        None means every core.

    Returns
    -------
    paths : Paths
        `lengths` in cm.
    """
    upper, dermis = (float(each) for each in reduced_scattering(nm))
    forward = np.array([0.8, 0.8, 0.0, 0.0])
    border = np.cumsum([0, stratum_corneum_cm, epidermis_cm, tissue.papillary_cm, tissue.reticular_cm])
    walked = walk_layers(
        np.array(tissue.index),
        np.array([upper, upper, dermis, dermis]) / (1 - forward),
        forward,
        border,
        np.full(4, 0.9 * float(baseline(nm))),
        count,
        key=stream(seed, "optics", "volume", f"{nm:g}").key,
        cosine=cosine,
        fold=tissue.fold,
        facets=facet_tables(tissue),
        white_base=True,
        threads=threads,
    )
    lengths, weight, bounces, kind, leaving, place = walked
    weight = np.where(kind == LEFT, weight * float(tissue.base_albedo) ** bounces, 0.0)
    return Paths(lengths, weight, kind, leaving[:, :3], leaving[:, 3], np.hypot(place[:, 0], place[:, 1]))


def walk_layers(
    index: NDArray[np.float64],
    scattering: NDArray[np.float64],
    forward: NDArray[np.float64],
    border: NDArray[np.float64],
    least: NDArray[np.float64],
    count: int,
    *,
    key: int,
    cosine: float = 1.0,
    fold: float = 0.0,
    facets: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None,
    white_base: bool = False,
    threads: int | None = None,
) -> tuple[NDArray, ...]:
    """Send photons through k layers by free paths; the outside and what is below have index 1.

    Parameters
    ----------
    index, scattering, forward, least : (k,) float64
        Refractive index, scattering coefficient, mean cosine, and a lower bound of absorption for the roulette.
    border : (k + 1,) float64
        Depths, in the unit of one over the coefficients.
    count : int
        Photons.
    key : int
        Of the stream of random numbers.
    cosine : float
        Of incidence; 0 lights from everywhere, evenly.
    fold : float
        Width of the facets of the upper border; 0 is smooth.
    facets : pair of arrays, optional
        As `facet_tables`.
    white_base : bool
        Whether a matt white base ends the last layer.
    threads : int, optional
        None means every core.

    Returns
    -------
    lengths, weight, bounces, kind, leaving, place : arrays
        As `surftex.kernels.volume.walk_volume` has them.
    """
    from surftex.kernels.volume import walk_volume

    steepness, escape = facets or (np.zeros(0), np.zeros(0))
    _, bounces, kind, leaving = _room(count)
    lengths, weight, place = np.zeros((count, len(index))), np.zeros(count), np.zeros((count, 2))

    def work(first: int, last: int) -> None:
        part = slice(first, last)
        walk_volume(
            np.uint64(key), first, float(cosine), index, 1.0, float(fold), steepness, escape, scattering, forward,
            border, int(white_base), least, lengths[part], weight[part], bounces[part], kind[part],
            leaving[part], place[part],
        )  # fmt: skip

    slices(work, count, size=_SLICE, threads=threads)
    return lengths, weight, bounces, kind, leaving, place


def check_engine(engine: str) -> str:
    """Refuse an engine that is not there.

    Parameters
    ----------
    engine : str
        As given.

    Returns
    -------
    engine : str
        The same.

    Raises
    ------
    InputError
        Listing the known engines.
    """
    if engine not in ENGINES:
        raise InputError(f"there is no engine {engine!r}; known are {', '.join(ENGINES)}")
    return engine


def _room(count: int) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    count = checked_whole(count, "paths", 1, MOST_PATHS)
    return np.zeros((count, 4)), np.zeros(count, np.int32), np.zeros(count, np.int8), np.zeros((count, 4))
