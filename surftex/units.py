"""Lengths with units: everything inside surftex is a millimetre, everything a user types may say otherwise."""

import math
import re

from surftex.errors import RecipeError
from surftex.words import sort_of

MM_PER_UNIT = {"um": 1e-3, "µm": 1e-3, "mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
"""Millimetres in one of each unit that a recipe may name."""

_LENGTH = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Zµ]*)\s*")


def length_mm(value: str | float | int) -> float:
    """Read a length: a bare number is millimetres, text may carry a unit.

    Parameters
    ----------
    value : str or float
        For example ``0.9``, ``"0.9 mm"``, ``"2.5cm"`` or ``"1/1"`` (an error).

    Returns
    -------
    length : float
        Millimetres.

    Raises
    ------
    RecipeError
        If the text is no number, its unit is unknown, or the length is not finite.

    Examples
    --------
    >>> length_mm("2.5 cm")
    25.0
    """
    if isinstance(value, bool):
        raise RecipeError(f"{value!r} is not a length; write a number with a unit, such as '0.9 mm'")
    if isinstance(value, (int, float)):
        try:
            return _finite(float(value), value)
        except OverflowError:
            return _finite(math.inf, value)
    if not isinstance(value, str):
        raise RecipeError(f"{sort_of(value)} is not a length; write a number with a unit, such as '0.9 mm'")
    match = _LENGTH.fullmatch(value)
    if not match:
        raise RecipeError(f"{value!r} is not a length; write a number with a unit, such as '0.9 mm'")
    unit = match[2] or "mm"
    if unit not in MM_PER_UNIT:
        raise RecipeError(f"{value!r}: unknown unit {unit!r}; known are {', '.join(MM_PER_UNIT)}")
    return _finite(float(match[1]) * MM_PER_UNIT[unit], value)


def _finite(length: float, value: str | float) -> float:
    if not math.isfinite(length):
        raise RecipeError(f"{value!r:.60} is not a length: it is not finite")
    return length
