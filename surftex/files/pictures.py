"""Pictures that a recipe names: PNG, JPEG, TIFF, EXR as arrays of numbers."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError
from surftex.files.decoding import decoded, kind_of, read_exr_channels

_LARGEST_BYTES = 2**30

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Shares of red, green and blue in the luminance of linear light (Rec. 709)."""


def read_mask(path: str | Path, channel: str = "luminance") -> NDArray[np.float64]:
    """Read one number per pixel.

    Parameters
    ----------
    path : path
        A PNG, JPEG, TIFF or EXR file.
    channel : str
        ``luminance``, ``red``, ``green``, ``blue`` or ``alpha``.

    Returns
    -------
    mask : (h, w) float64
        Whole numbers become shares of their type's greatest, without undoing any gamma; row 0 is on top.

    Raises
    ------
    RecipeError
        If the file cannot be read, or has no such channel.
    """
    return _one_channel(read_picture(path), Path(path), channel)


def read_codes(path: str | Path, channel: str = "luminance") -> NDArray[np.float64]:
    """Read one whole number per pixel, as it stands in the file: labels.

    Parameters
    ----------
    path : path
        A PNG, TIFF or EXR file; JPEG does not keep numbers.
    channel : str
        As for `read_mask`; of several colours ``luminance`` takes the first.

    Returns
    -------
    codes : (h, w) float64
        Row 0 is on top.

    Raises
    ------
    RecipeError
        If the file cannot be read, or has no such channel.
    """
    return _one_channel(
        _pixels(path).astype(np.float64), Path(path), "red" if channel == "luminance" else channel
    )


def _one_channel(picture: NDArray[np.float64], path: Path, channel: str) -> NDArray[np.float64]:
    count = picture.shape[2]
    if channel == "luminance":
        return picture[..., :3] @ np.array(LUMINANCE) if count >= 3 else picture[..., 0]
    if channel == "alpha":
        if count not in (2, 4):
            raise RecipeError(f"{path.name} has no alpha channel, but {count} of color or grey")
        return picture[..., -1]
    return picture[..., 0 if count < 3 else ("red", "green", "blue").index(channel)]


def read_picture(path: str | Path) -> NDArray[np.float64]:
    """Read a picture, turned as viewers show it.

    Parameters
    ----------
    path : path
        A PNG, JPEG, TIFF or EXR file.

    Returns
    -------
    picture : (h, w, c) float64
        Whole numbers become shares of their type's greatest; row 0 is on top.

    Raises
    ------
    RecipeError
        If the file cannot be read as one of these, or is CMYK.
    """
    pixels = _pixels(path)
    if pixels.dtype.kind in "iu" and pixels.dtype.itemsize > 2:
        raise RecipeError(
            f"the picture {str(path)!r} holds whole numbers of {8 * pixels.dtype.itemsize} bits, of which nobody says "
            "what is white; save it with 16 bits, or as float"
        )
    scale = np.iinfo(pixels.dtype).max if pixels.dtype.kind in "iu" else 1
    return pixels.astype(np.float64) / scale


def _pixels(path: str | Path) -> NDArray[Any]:
    """(h, w, c) numbers as the file has them."""
    file = Path(path)
    try:
        if not file.is_file():
            raise RecipeError(
                f"the picture {str(file)!r} {'is no file' if file.exists() else 'does not exist'}"
            )
        if file.stat().st_size > _LARGEST_BYTES:
            raise RecipeError(
                f"the picture {str(file)!r} has {file.stat().st_size} bytes; at most 1 GiB is read"
            )
        data = file.read_bytes()
    except OSError as problem:
        raise RecipeError(f"the picture {str(file)!r} cannot be read: {problem.strerror}") from None
    name = f"the picture {str(file)!r}"
    if not kind_of(data):
        raise RecipeError(f"{name} is none of PNG, JPEG, TIFF and EXR; save it as PNG")
    pixels = _exr(file) if kind_of(data) == "EXR" else decoded(data, name, error=RecipeError)
    if pixels.ndim == 2:
        pixels = pixels[..., None]
    if pixels.ndim != 3 or pixels.size == 0:
        raise RecipeError(f"the picture {str(file)!r} has shape {pixels.shape}; it takes one page of pixels")
    return pixels


def _exr(file: Path) -> NDArray[np.float64]:
    channels = read_exr_channels(file, error=RecipeError)
    order = [name for name in ("R", "G", "B", "A") if name in channels] or sorted(channels)[:1]
    if not order or len({channels[name].shape for name in order}) > 1:
        raise RecipeError(f"the picture {str(file)!r} has no channels, or channels of different sizes")
    return np.stack([channels[name].astype(np.float64) for name in order], axis=-1)
