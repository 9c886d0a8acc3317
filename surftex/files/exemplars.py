"""Pictures that textures are learnt from: PNG and JPEG at the door, each fault told in a line before it costs memory."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.files.reading import printable, read_bytes

MOST_PIXELS = 2**26
"""Pixels of a picture beyond which it is not decoded."""

MOST_LABELS = 8
"""Labels of a label map."""

_GREY, _COLOR, _CMYK = 1, 3, 4
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""Markers of a JPEG that are followed by the size of the picture."""


def read_exemplar(path: str | Path) -> NDArray[Any]:
    """Read a photograph or a map aligned with it.

    Parameters
    ----------
    path : path
        A PNG of 8 or 16 bits, or a JPEG; grey or colour.

    Returns
    -------
    picture : (h, w) or (h, w, 3) uint8 or uint16
        Row 0 on top; what was opaque loses its alpha.

    Raises
    ------
    InputError
        If there is no such file, or it is none of these, cut off, CMYK, partly transparent, or has too many pixels.
    """
    name = printable(str(path))
    data = read_bytes(path, purpose="picture")
    if data.startswith(b"\x89PNG\r\n\x1a\n"):
        pixels = _png(data, name)
    elif data.startswith(b"\xff\xd8"):
        pixels = _jpeg(data, name)
    else:
        raise InputError(f"{name}: is neither PNG nor JPEG; convert the picture to one of them")
    if pixels.ndim == 3 and pixels.shape[2] in (2, 4):
        if (pixels[..., -1] < np.iinfo(pixels.dtype).max).any():
            raise InputError(
                f"{name}: is partly transparent; flatten it, or hand its opaque part in as the mask (--mask)"
            )
        pixels = pixels[..., :-1]
    if pixels.ndim == 3 and pixels.shape[2] == 1:
        pixels = pixels[..., 0]
    return np.ascontiguousarray(pixels)


def read_label_map(path: str | Path) -> NDArray[np.uint8]:
    """Read a label map: each number or colour of it is a label.

    Parameters
    ----------
    path : path
        A PNG; JPEG blurs labels.

    Returns
    -------
    label : (h, w) uint8
        From 0 on, in the order of the numbers or colours.

    Raises
    ------
    InputError
        As `read_exemplar`, or if there are more than `MOST_LABELS` labels.
    """
    pixels = read_exemplar(path).astype(np.int64)
    if pixels.ndim == 3:
        pixels = (pixels[..., 0] << 32) + (pixels[..., 1] << 16) + pixels[..., 2]
    kinds, label = np.unique(pixels, return_inverse=True)
    if len(kinds) > MOST_LABELS:
        raise InputError(
            f"{printable(str(path))}: holds {len(kinds)} different values; a label map has at most {MOST_LABELS}. "
            "Paint it without soft edges and save it as PNG"
        )
    return label.reshape(pixels.shape).astype(np.uint8)


def _png(data: bytes, name: str) -> NDArray[Any]:
    import imagecodecs

    if len(data) < 33 or data[12:16] != b"IHDR":
        raise InputError(f"{name}: is cut off within its head; save the picture again")
    width, height = (int.from_bytes(data[at : at + 4], "big") for at in (16, 20))
    _check_size(width, height, name)
    if b"IEND" not in data[-64:]:
        raise InputError(f"{name}: is cut off; save the picture again")
    try:
        return imagecodecs.png_decode(data)
    except (imagecodecs.PngError, ValueError) as problem:
        raise InputError(f"{name}: is a damaged PNG ({_reason(problem)}); save it again") from None


def _jpeg(data: bytes, name: str) -> NDArray[Any]:
    import imagecodecs

    width, height, bands, scan = _jpeg_head(data, name)
    _check_size(width, height, name)
    if bands == _CMYK:
        raise InputError(f"{name}: is CMYK, for printers; convert it to RGB")
    if bands not in (_GREY, _COLOR):
        raise InputError(f"{name}: has {bands} bands; a picture is grey, or red, green and blue")
    if b"\xff\xd9" not in data[scan:]:
        raise InputError(f"{name}: is cut off; save the picture again")
    try:
        return imagecodecs.jpeg_decode(data)
    except (imagecodecs.JpegError, ValueError, NotImplementedError) as problem:
        raise InputError(f"{name}: is a damaged JPEG ({_reason(problem)}); save it again") from None


def _jpeg_head(data: bytes, name: str) -> tuple[int, int, int, int]:
    """Width, height and bands of a JPEG, and where its first scan starts."""
    at, found = 2, None
    while at + 4 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == 0xFF or 0xD0 <= marker <= 0xD8:
            at += 1 if marker == 0xFF else 2
            continue
        length = int.from_bytes(data[at + 2 : at + 4], "big")
        if marker in _FRAMES and at + 10 <= len(data):
            height, width = (int.from_bytes(data[at + k : at + k + 2], "big") for k in (5, 7))
            found = width, height, data[at + 9]
        if marker == 0xDA and found:
            return *found, at
        at += 2 + max(2, length)
    raise InputError(f"{name}: is cut off within its head; save the picture again")


def _check_size(width: int, height: int, name: str) -> None:
    if width * height > MOST_PIXELS:
        raise InputError(
            f"{name}: has {width} x {height} pixels; scale it down to {MOST_PIXELS} in all, or cut a part out"
        )


def _reason(problem: Exception) -> str:
    return printable(str(problem).splitlines()[0]) if str(problem) else type(problem).__name__
