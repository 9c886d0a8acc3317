"""Sizes that vary over a surface: expressions that must stay positive wherever they are asked."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError
from surftex.fields.fieldset import FieldSet
from surftex.surface.points import SurfacePoints


def sized(
    names: FieldSet, value: float | str, parameter: str, *, least: float = 0.0
) -> float | Callable[[SurfacePoints], NDArray[np.float64]]:
    """Take a number as it is, an expression as a function of points.

    Parameters
    ----------
    names : FieldSet
        Named numbers.
    value : float or str
        What a user wrote.
    parameter : str
        What they call it, such as ``"leather.cell_size"``.
    least : float
        It must not fall below this; with 0 it must be more.

    Returns
    -------
    size : float or callable
        The function raises a `RecipeError` with the parameter's name where the expression is no such size.

    Raises
    ------
    RecipeError
        If the expression is wrong; the message begins with the parameter.
    """
    if not isinstance(value, str):
        return value
    try:
        field = names.scalar(value)
    except RecipeError as problem:
        raise RecipeError(f"{parameter}: {problem}") from None

    def size(points: SurfacePoints) -> NDArray[np.float64]:
        sizes = field(points)
        wrong = np.count_nonzero(~((sizes > 0) & (sizes >= least)))
        if wrong:
            limit = f"be at least {least:g}" if least else "stay above 0"
            raise RecipeError(
                f"{parameter}: {value!r} falls to {sizes.min():.4g}, at {wrong} of {len(sizes)} points; it must {limit}"
            )
        return sizes

    return size
