"""The folds of the skin's surface as facets: GGX, or the sharper law of the thesis, told as tables."""

from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import frozen
from surftex.optics.tissue import Tissue


def fold_angle(number: ArrayLike, fold: float, exponent: int = 2) -> NDArray[np.float64]:
    """Slope of a facet for a uniform random number, by projected area.

    Parameters
    ----------
    number : (...) float
        In [0, 1]: 0 is level, 1 upright.
    fold : float
        Oblateness, above 0.
    exponent : int
        2: Trowbridge and Reitz, which is GGX; 3: the formula of the thesis.

    Returns
    -------
    angle_rad : (...) float64
        Its density goes as cos t sin t / (1 + cos^2 t (fold^2 - 1))^exponent.
    """
    rest, square = 1 - np.asarray(number, np.float64), fold * fold
    if abs(square - 1) < 1e-9:
        cosine_square = rest
    elif exponent == 2:
        cosine_square = rest / (square + (1 - square) * rest)
    else:
        cosine_square = (square / np.sqrt(square**2 + (1 - square**2) * rest) - 1) / (square - 1)
    return np.arccos(np.sqrt(np.clip(cosine_square, 0, 1)))


@cache
def _tables(fold: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Cosine of a facet by uniform number, and the chance to leave by cosine, for exponent 3."""
    cosine = np.linspace(0, 1, 4097)
    density = 1 / (1 + cosine**2 * (fold**2 - 1)) ** 3
    below = np.concatenate([[0], np.cumsum(density[1:] + density[:-1])])
    steepness = np.interp(np.linspace(0, 1, 4097), below / below[-1], cosine)
    middle, turn = (np.arange(512) + 0.5) / 512, (np.arange(128) + 0.5) / 128 * np.pi
    weight = 1 / (1 + middle**2 * (fold**2 - 1)) ** 3
    weight /= (weight * middle).mean()
    seen = np.linspace(0, 1, 257)
    flat = np.sqrt(1 - middle**2)[:, None] * np.cos(turn)
    area = [
        (np.maximum(c * middle[:, None] + np.sqrt(1 - c * c) * flat, 0).mean(1) * weight).mean() for c in seen
    ]
    return frozen(steepness), frozen(np.clip(seen / np.array(area), 0, 1))


def facet_tables(tissue: Tissue) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Tell the kernels what the facets are.

    Parameters
    ----------
    tissue : Tissue
        Its `fold` and `facets`.

    Returns
    -------
    steepness, escape : (k,) float64
        Empty for GGX, which kernels know in closed form.
    """
    if tissue.facets == "ggx" or tissue.fold == 0:
        return np.zeros(0), np.zeros(0)
    return _tables(tissue.fold)
