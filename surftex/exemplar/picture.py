"""Pictures at the door: arrays of any common type become 0..255 in float, or an error that says what to do."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked
from surftex.errors import InputError

SMALLEST = 32
"""Least side of a picture to learn from."""

MOST_PIXELS = 2**26
"""Most pixels of a picture to learn from."""


def checked_picture(
    image: ArrayLike,
    *,
    mask: ArrayLike | None = None,
    height: ArrayLike | None = None,
    roughness: ArrayLike | None = None,
) -> tuple[NDArray[np.float32], tuple[str, ...], NDArray[np.bool_]]:
    """Bring a picture and the maps aligned with it together.

    Parameters
    ----------
    image : (h, w) or (h, w, 3) uint8, uint16 or float
        Floats run from 0 to 1. A fourth band must be opaque.
    mask : (h, w) bool or number, optional
        Pixels to learn from; all without it.
    height : (h, w) number, optional
        Aligned height, 0 to 1 or whole numbers.
    roughness : (h, w) number, optional
        Aligned roughness.

    Returns
    -------
    picture : (h, w, c) float32
        0 to 255.
    names : tuple of str
        Of its bands.
    inside : (h, w) bool
        Pixels that count.

    Raises
    ------
    InputError
        If shapes or types do not fit, the picture is too small or too large, or partly transparent.
    """
    first = _numbers(image, "the picture")
    if first.shape[2] in (2, 4):
        if (first[..., -1] < 255).any():
            raise InputError(
                "the picture is partly transparent; flatten it, or hand its opaque part in as the mask"
            )
        first = first[..., :-1]
    if first.shape[2] not in (1, 3):
        raise InputError(f"the picture has {first.shape[2]} bands; it takes grey, or red, green and blue")
    rows, columns = first.shape[:2]
    if min(rows, columns) < SMALLEST:
        raise InputError(
            f"the picture has {columns} x {rows} pixels; a texture is learnt from {SMALLEST} x {SMALLEST} at least, "
            "and well from 150 x 150"
        )
    if rows * columns > MOST_PIXELS:
        raise InputError(f"the picture has {columns} x {rows} pixels; scale it down to {MOST_PIXELS} in all")
    names = ("grey",) if first.shape[2] == 1 else ("red", "green", "blue")
    parts = [first]
    for name, extra in (("height", height), ("roughness", roughness)):
        if extra is not None:
            numbers = _numbers(extra, f"the {name} map")
            if numbers.shape[:2] != (rows, columns):
                raise InputError(
                    f"the {name} map has {numbers.shape[1]} x {numbers.shape[0]} pixels, the picture "
                    f"{columns} x {rows}; they must be aligned"
                )
            parts.append(numbers[..., :1])
            names = (*names, name)
    inside = np.ones((rows, columns), bool)
    if mask is not None:
        given = np.asarray(mask)
        if given.ndim == 3:
            given = given[..., 0]
        if given.shape != (rows, columns):
            raise InputError(f"the mask has shape {given.shape}, the picture ({rows}, {columns})")
        inside = checked(given, "the mask", (rows, columns), np.float64) > 0.5 * max(1.0, float(given.max()))
        if inside.sum() < SMALLEST**2:
            raise InputError(f"the mask leaves {int(inside.sum())} pixels; it takes at least {SMALLEST**2}")
    return np.concatenate(parts, axis=2), names, inside


def shrunk(picture: NDArray[Any], by: int) -> NDArray[Any]:
    """Make one pixel of each square of pixels.

    Parameters
    ----------
    picture : (h, w) or (h, w, c) number
        Any picture.
    by : int
        Pixels of each side of a square; what is left over at the right and below is cut off.

    Returns
    -------
    small : (h // by, w // by) or (h // by, w // by, c) number
        Means, rounded.
    """
    if by == 1:
        return picture
    rows, columns = (length // by for length in picture.shape[:2])
    cut = picture[: rows * by, : columns * by].reshape(rows, by, columns, by, -1)
    mean = cut.mean(axis=(1, 3)).round().astype(picture.dtype)
    return mean if picture.ndim == 3 else mean[..., 0]


def spread(label: NDArray[np.uint8], labels: int) -> NDArray[np.uint8]:
    """Show labels as tones from black to white.

    Parameters
    ----------
    label : (h, w) uint8
        From 0 on.
    labels : int
        How many there can be.

    Returns
    -------
    tone : (h, w) uint8
        0 to 255.
    """
    return (label.astype(np.int64) * 255 // max(1, labels - 1)).astype(np.uint8)


def _numbers(image: ArrayLike, name: str) -> NDArray[np.float32]:
    array = np.asarray(image)
    if array.ndim == 2:
        array = array[..., None]
    if array.ndim != 3 or array.size == 0:
        raise InputError(f"{name} has shape {array.shape}; it takes (height, width) or (height, width, 3)")
    array = checked(array, name, (None, None, None), array.dtype if array.dtype.kind in "uf" else np.float64)
    if array.dtype == np.uint16:
        return (array / np.float32(257)).astype(np.float32)
    if array.dtype.kind == "f":
        if array.min() < 0 or array.max() > 1:
            raise InputError(
                f"{name} runs from {array.min():g} to {array.max():g}; numbers with a point run 0 to 1"
            )
        return (255 * array).astype(np.float32)
    if array.min() < 0 or array.max() > 255:
        raise InputError(
            f"{name} runs from {array.min()} to {array.max()}; whole numbers of 8 bits run 0 to 255"
        )
    return array.astype(np.float32)
