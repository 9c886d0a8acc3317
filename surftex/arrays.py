"""The one check of shape, type and finiteness, and the one way to hand out arrays that nobody can change."""

import math
import operator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from surftex.errors import InputError


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """Forbid writing to an array, in place.

    Parameters
    ----------
    array : ndarray
        Its ``writeable`` flag is cleared; memory that others own is copied first.

    Returns
    -------
    array : ndarray
        C-contiguous, read-only.
    """
    array = np.ascontiguousarray(array)
    if array.base is not None:
        array = array.copy()
    array.flags.writeable = False
    return array


def checked(
    value: ArrayLike,
    name: str,
    shape: tuple[int | None, ...],
    dtype: DTypeLike,
    *,
    error: type[InputError] = InputError,
) -> NDArray[Any]:
    """Convert to an array of one shape and type; rank first, then shape, then values.

    Parameters
    ----------
    value : array_like
        What the caller gave.
    name : str
        What the message calls it.
    shape : tuple
        One entry per axis; None allows any length.
    dtype : dtype
        Integers refuse fractions; floats refuse NaN and infinity.
    error : type
        Which failure to raise.

    Returns
    -------
    array : ndarray
        Of `shape` and `dtype`; may share memory with `value`.

    Raises
    ------
    InputError
        Naming the argument, what it should be, and the first value that is wrong.
    """
    dtype = np.dtype(dtype)
    try:
        array = np.asarray(value)
    except ValueError as problem:
        raise error(f"{name} is ragged: {problem}") from None
    wanted = "(" + ", ".join("n" if length is None else str(length) for length in shape) + ")"
    if array.ndim != len(shape):
        raise error(f"{name} has {array.ndim} axes, shape {array.shape}; it takes {wanted}")
    if any(want is not None and have != want for have, want in zip(array.shape, shape, strict=True)):
        raise error(f"{name} has shape {array.shape}; it takes {wanted}")
    if array.dtype.kind not in "biuf":
        raise error(f"{name} holds {array.dtype}, not numbers")
    if dtype.kind in "iu":
        if array.dtype.kind == "f":
            wrong = np.argwhere(array != np.floor(array))
            if len(wrong):
                where = tuple(int(i) for i in wrong[0])
                raise error(f"{name}{list(where)} is {array[where]}, not a whole number")
        limits = np.iinfo(dtype)
        if array.size and (array.min() < limits.min or array.max() > limits.max):
            raise error(f"{name} leaves the range of {dtype}: {array.min()} to {array.max()}")
    elif array.dtype.kind == "f" and not np.isfinite(array).all():
        if not array.ndim:
            raise error(f"{name} is {array}; it takes a finite number")
        wrong = np.argwhere(~np.isfinite(array))
        where = tuple(int(i) for i in wrong[0])
        raise error(
            f"{name} holds {len(wrong)} values that are not finite, of {array.size}; the first is {list(where)}"
        )
    return array.astype(dtype, copy=False)


def checked_number(value: Any, name: str, low: float, high: float = math.inf) -> float:
    """Refuse what is no number, or leaves its range.

    Parameters
    ----------
    value : number
        What the caller gave.
    name : str
        What the message calls it.
    low, high : float
        Its range, ends included.

    Returns
    -------
    number : float
        The same.

    Raises
    ------
    InputError
        Naming the argument, and its range.
    """
    try:
        if isinstance(value, (str, bytes)) or np.ndim(value):
            raise TypeError("text or several")
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} is {' '.join(repr(value).split())[:60]}; it takes one number") from None
    if not low <= number <= high:
        limits = (
            f"goes from {low:.10g} to {high:.10g}" if math.isfinite(high) else f"takes at least {low:.10g}"
        )
        raise InputError(f"{name} is {number:.10g}; it {limits}")
    return number


def checked_whole(value: Any, name: str, low: float, high: float = math.inf) -> int:
    """Refuse what is no whole number, or leaves its range.

    Parameters
    ----------
    value : number
        What the caller gave; 3.0 is whole.
    name : str
        What the message calls it.
    low, high : float
        Its range, ends included.

    Returns
    -------
    number : int
        The same.

    Raises
    ------
    InputError
        Naming the argument, and its range.
    """
    number = checked_number(value, name, low, high)
    if not number.is_integer():
        raise InputError(f"{name} is {number:.10g}; it takes a whole number")
    return operator.index(value) if hasattr(value, "__index__") else int(number)


def read_only_view(array: NDArray[Any], dtype: DTypeLike) -> NDArray[Any]:
    """Look at an array without the right to write, as kernels take it.

    Parameters
    ----------
    array : ndarray
        Left as it is.
    dtype : dtype
        What the kernel takes.

    Returns
    -------
    view : ndarray
        C-contiguous, read-only; shares memory where it can.
    """
    view = np.ascontiguousarray(array, dtype=dtype).view()
    view.flags.writeable = False
    return view
