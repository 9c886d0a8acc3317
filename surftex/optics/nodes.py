"""Where a table is sampled, and how it is read between: nodes crowded towards the ends, polynomials, a dense grid."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.optics.tissue import PARAMETERS


def straightened(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Turn a parameter into what even steps are even in: itself, or its logarithm.

    Parameters
    ----------
    name : str
        One of `PARAMETERS`.
    value : (...) float
        In its own unit.

    Returns
    -------
    straight : (...) float64
        Without a unit.
    """
    value = np.asarray(value, np.float64)
    return value if PARAMETERS[name].even else np.log(value)


def nodes(name: str, count: int, *, crowded: bool = True) -> NDArray[np.float64]:
    """Values of a parameter at which to sample it.

    Parameters
    ----------
    name : str
        One of `PARAMETERS`.
    count : int
        At least 1; 1 gives the usual value.
    crowded : bool
        Chebyshev's nodes, stretched so that the first and the last are the ends of the range; else even steps.

    Returns
    -------
    values : (count,) float64
        Ascending, in the parameter's own unit.
    """
    parameter = PARAMETERS[name]
    if count == 1:
        return np.array([parameter.usual])
    share = np.linspace(0, 1, count)
    if crowded:
        turn = np.cos((2 * np.arange(count) + 1) * np.pi / (2 * count))
        share = (1 - turn / turn[0]) / 2
    low, high = straightened(name, parameter.low), straightened(name, parameter.high)
    values = low + share * (high - low)
    values = values if parameter.even else np.exp(values)
    values[0], values[-1] = parameter.low, parameter.high
    return values


def polynomial(known: NDArray[np.float64], wanted: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights that read a polynomial through some nodes elsewhere.

    Parameters
    ----------
    known : (n,) float64
        Nodes, all different.
    wanted : (m,) float64
        Where to read.

    Returns
    -------
    weights : (m, n) float64
        ``weights @ values_at_known`` are the values at `wanted`; rows sum to 1.
    """
    step = known[:, None] - known[None, :] + np.eye(len(known))
    gap = wanted[:, None, None] - known[None, None, :]
    gap = np.where(np.eye(len(known), dtype=bool), 1.0, gap)
    return gap.prod(2) / step.prod(1)
