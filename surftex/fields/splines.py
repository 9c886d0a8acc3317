"""Profiles drawn by hand: Bézier splines, or one of a few names, as tables of equal steps.

A profile says how much is left of a feature at a share x of its radius: 1 in the middle is usual, 0 at x = 1 is not asked for
but leaves no rim.
"""

from collections.abc import Callable
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator

KNOTS = 257
"""Entries of a table."""

SIGMOID_REACH = 1.25
"""The sigmoid is 0.036 at its radius; it is drawn as far as this, less what is left there."""


def _sigmoid(x: NDArray[np.float64]) -> NDArray[np.float64]:
    value = 1 - 2 * (1 / (1 + np.exp(-4 * SIGMOID_REACH * x)) - 0.5)
    rest = 1 - 2 * (1 / (1 + np.exp(-4 * SIGMOID_REACH)) - 0.5)
    return (value - rest) / (1 - rest)


def _crater(x: NDArray[np.float64]) -> NDArray[np.float64]:
    wall = np.clip((x - 0.45) / 0.4, 0, 1)
    rim = np.exp(-(((x - 0.88) / 0.09) ** 2))
    return (1 - wall * wall * (3 - 2 * wall) - 0.18 * rim) * np.clip((1 - x) / 0.06, 0, 1)


NAMED: dict[str, Callable[[NDArray[np.float64]], NDArray[np.float64]]] = {
    "sigmoid": _sigmoid,
    "cone": lambda x: np.clip(1 - 1.2 * x, 0, 1),
    "valley": lambda x: (1 - x) ** 4 * (4 * x + 1),
    "dome": lambda x: (1 - x * x) ** 2,
    "plateau": lambda x: 1 - np.clip((x - 0.5) / 0.5, 0, 1) ** 2 * (3 - 2 * np.clip((x - 0.5) / 0.5, 0, 1)),
    "disc": lambda x: 1 - np.clip((x - 0.85) / 0.15, 0, 1) ** 2 * (3 - 2 * np.clip((x - 0.85) / 0.15, 0, 1)),
    "crease": lambda x: np.clip(1 - (x**0.2 + x) / 2, 0, 1),
    "crater": _crater,
    "fold": lambda x: 6.75 * x * (1 - x) ** 2,
}
"""Profiles that have a name; `crease` is a fold with a sharp floor, `fold` starts and ends at 0."""


def _checked(value: Any) -> Any:
    if isinstance(value, str):
        if value not in NAMED:
            raise ValueError(f"unknown profile {value!r}; known are {', '.join(NAMED)}, or [[x, y], ...]")
        return value
    try:
        points = np.asarray(value, np.float64)
    except (ValueError, TypeError):
        points = np.zeros((0, 0))
    shape = points.shape
    if len(shape) != 2 or shape[-1] != 2 or shape[0] < 4 or shape[0] % 3 != 1:
        raise ValueError("a profile is a name, or control points [[x, y], ...]: 4, 7, 10, ... of them")
    if not np.isfinite(points).all() or np.abs(points).max() > 100:
        raise ValueError("control points of a profile are numbers from -100 to 100")
    x = points[:, 0]
    if x[0] != 0 or x[-1] != 1 or (np.diff(x) < 0).any():
        raise ValueError("control points of a profile run from x = 0 to x = 1 and never go back")
    return tuple((float(point[0]), float(point[1])) for point in points)


Profile = Annotated[str | tuple[tuple[float, float], ...], BeforeValidator(_checked)]
"""A name of `NAMED`, or 3 k + 1 control points (x, y) of k cubic Bézier pieces from x = 0 to x = 1."""


def profile_table(profile: str | tuple[tuple[float, float], ...]) -> NDArray[np.float32]:
    """Tabulate a profile.

    Parameters
    ----------
    profile : Profile
        Checked.

    Returns
    -------
    table : (KNOTS,) float32
        Values at equal steps of x from 0 to 1.

    Examples
    --------
    >>> float(profile_table(((0, 1), (0.3, 1), (0.7, 0), (1, 0)))[KNOTS // 2])
    0.5
    """
    x = np.linspace(0, 1, KNOTS)
    if isinstance(profile, str):
        return NAMED[profile](x).astype(np.float32)
    points = np.asarray(profile)
    t = np.linspace(0, 1, 4 * KNOTS)[:, None]
    pieces = [
        (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t * t * c + t**3 * d
        for a, b, c, d in (points[i : i + 4] for i in range(0, len(points) - 1, 3))
    ]
    curve = np.concatenate(pieces)
    return np.interp(x, curve[:, 0], curve[:, 1]).astype(np.float32)


def disc_moments(table: NDArray[np.float32]) -> tuple[float, float]:
    """Measure a profile as a hill over a disc of radius 1.

    Parameters
    ----------
    table : (KNOTS,) float32
        From `profile_table`.

    Returns
    -------
    volume : float
        Under the hill; its mean over the disc times pi.
    variance : float
        Of its distance from the middle, along one axis; of its absolute value.
    """
    x = np.linspace(0, 1, len(table))
    y = np.asarray(table, np.float64)
    whole = np.trapezoid(np.abs(y) * x, x)
    if whole <= 0:
        return 0.0, 0.25
    return float(2 * np.pi * np.trapezoid(y * x, x)), float(np.trapezoid(np.abs(y) * x**3, x) / whole / 2)
