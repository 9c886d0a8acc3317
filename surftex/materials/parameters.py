"""Types of the parameters that materials share: lengths with units, colours, expressions."""

from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field

from surftex.errors import RecipeError
from surftex.units import length_mm


def _length(value: Any) -> Any:
    try:
        return length_mm(value) if isinstance(value, (str, int, float)) else value
    except RecipeError as problem:
        raise ValueError(str(problem)) from None


def _color(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    text = value.lstrip("#")
    if len(text) != 6 or any(letter not in "0123456789abcdefABCDEF" for letter in text):
        raise ValueError(f"{value!r} is no colour; write '#8a5a34', or three linear numbers from 0 to 1")
    return linear_from_srgb(np.array([int(text[i : i + 2], 16) for i in (0, 2, 4)]) / 255).tolist()


def _number_or_expression(value: Any) -> Any:
    if isinstance(value, str):
        try:
            return length_mm(value)
        except RecipeError:
            return value
    return value


def _rising(value: tuple[float, float]) -> tuple[float, float]:
    if value[0] > value[1]:
        raise ValueError(f"[{value[0]:g}, {value[1]:g}] falls; write the least before the greatest")
    return value


def linear_from_srgb(value: Any) -> np.ndarray:
    """Undo the sRGB curve.

    Parameters
    ----------
    value : array of float
        0 to 1, as screens and 8-bit pictures have it.

    Returns
    -------
    linear : array of float64
        0 to 1, proportional to light (IEC 61966-2-1).
    """
    value = np.asarray(value, np.float64)
    return np.where(value <= 0.04045, value / 12.92, ((np.maximum(value, 0.04045) + 0.055) / 1.055) ** 2.4)


Length = Annotated[float, BeforeValidator(_length), Field(ge=0, le=1e7, allow_inf_nan=False)]
"""Millimetres; text may carry a unit."""

PositiveLength = Annotated[float, BeforeValidator(_length), Field(gt=0, le=1e7, allow_inf_nan=False)]
"""Millimetres above 0; text may carry a unit."""

LengthField = Annotated[PositiveLength | str, BeforeValidator(_number_or_expression)]
"""Millimetres, or an expression over the recipe's fields that gives millimetres."""

Finite = Annotated[float, Field(allow_inf_nan=False)]
"""Any number."""

NumberField = Annotated[Finite | str, BeforeValidator(_number_or_expression)]
"""A number, a length with a unit, or an expression over the recipe's fields."""

LongField = Annotated[
    Annotated[float, Field(ge=1, allow_inf_nan=False)] | str, BeforeValidator(_number_or_expression)
]
"""Length over width: a number from 1, or an expression over the recipe's fields."""

RATIOS = (0.2, 5.0)
"""Length over width of particles, at the least and at the most: beyond it they would be needles."""

AspectField = Annotated[
    Annotated[float, Field(ge=RATIOS[0], le=RATIOS[1])] | str, BeforeValidator(_number_or_expression)
]
"""Length over width, either way: a number within `RATIOS`, or an expression over the recipe's fields."""

Share = Annotated[float, Field(ge=0, le=1)]
"""0 to 1."""

Amount = Annotated[float, Field(ge=0, allow_inf_nan=False)]
"""Any number from 0."""

AmountField = Annotated[Amount | str, BeforeValidator(_number_or_expression)]
"""A number from 0, a length with a unit, or an expression over the recipe's fields."""

Color = Annotated[tuple[Share, Share, Share], BeforeValidator(_color)]
"""Linear sRGB; text is '#rrggbb' as screens show it."""

LengthDraw = tuple[Length, Length]
"""Mean and standard deviation of a normal draw."""

LengthRange = Annotated[tuple[Length, Length], AfterValidator(_rising)]
"""Least and greatest length of a uniform draw."""

AmountRange = Annotated[tuple[Amount, Amount], AfterValidator(_rising)]
"""Least and greatest of a uniform draw."""
