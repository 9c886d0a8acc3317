"""Pictures that textures are learnt from: PNG and JPEG at the door, each fault told in a line before it costs memory."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.files.decoding import claimed, decoded
from surftex.files.heads import segments
from surftex.files.reading import printable, read_bytes

MOST_PIXELS = 2**26
"""Pixels of a picture beyond which it is not decoded."""

MOST_LABELS = 8
"""Labels of a label map."""

_GREY, _COLOR = 1, 3
_SCAN = 0xDA


def read_exemplar(path: str | Path) -> NDArray[Any]:
    """Read a photograph or a map aligned with it.

    Parameters
    ----------
    path : path
        A PNG of 8 or 16 bits, or a JPEG; grey or colour.

    Returns
    -------
    picture : (h, w) or (h, w, 3) uint8 or uint16
        Row 0 on top, turned as viewers show it; what was opaque loses its alpha.

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
        raise InputError(f"{name}: is neither PNG nor JPEG; save it as PNG")
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
    _check_size(data, name)
    if b"IEND" not in data[-64:]:
        raise InputError(f"{name}: is cut off; save the picture again")
    return decoded(data, name)


def _jpeg(data: bytes, name: str) -> NDArray[Any]:
    bands = _check_size(data, name)
    if bands not in (_GREY, _COLOR):
        raise InputError(f"{name}: has {bands} bands; a picture is grey, or red, green and blue")
    (scan,) = [at for at, marker in segments(data) if marker == _SCAN] or [len(data)]
    if b"\xff\xd9" not in data[scan:]:
        raise InputError(f"{name}: is cut off; save the picture again")
    return decoded(data, name)


def _check_size(data: bytes, name: str) -> int:
    """Refuse what would take too long to learn from; the number of channels."""
    width, height, channels = claimed(data, name)
    if width * height > MOST_PIXELS:
        raise InputError(
            f"{name}: has {width} x {height} pixels; scale it down to {MOST_PIXELS} in all, or cut a part out"
        )
    return channels
