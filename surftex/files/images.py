"""Pictures on disk: PNG of 8 and 16 bits, EXR of 32 bits. The same pixels always give the same bytes.

Compression is set for speed: Paeth and the other slow filters win little on baked maps, so rows are told as
the difference to the row above. 16-bit normals are noise in their low bytes, where a search for repeats finds
nothing: run lengths cost half the time and 4 percent more bytes.
"""

import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError, WorkError
from surftex.files.decoding import decoded, kind_of, read_exr_channels
from surftex.paged import blocks, in_file, let_go

_UP, _RUNS, _ROWS, _EXR_TILE = 32, 3, 64, 64


def png_bytes(pixels: NDArray[Any]) -> bytes:
    """Pack pixels as PNG.

    Parameters
    ----------
    pixels : (height, width) or (height, width, 3) uint8 or uint16
        Row 0 on top. Nothing in the file says whether they are linear.

    Returns
    -------
    data : bytes
        A whole PNG file, without time stamp.

    Raises
    ------
    InputError
        If shape or type are others.
    """
    import imagecodecs

    if pixels.dtype not in (np.uint8, np.uint16) or pixels.ndim < 2 or pixels.shape[2:] not in ((), (3,)):
        raise InputError(f"PNG takes uint8 or uint16, 1 or 3 channels, not {pixels.shape} {pixels.dtype}")
    strategy = _RUNS if pixels.dtype == np.uint16 else 0
    return bytes(imagecodecs.png_encode(np.ascontiguousarray(pixels), level=1, filter=_UP, strategy=strategy))


def jpeg_bytes(pixels: NDArray[np.uint8], *, quality: int = 88) -> bytes:
    """Pack pixels as JPEG, for a picture that is looked at once.

    Parameters
    ----------
    pixels : (h, w, 3) uint8
        sRGB codes.
    quality : int
        0 to 100.

    Returns
    -------
    data : bytes
        Of a JPEG.
    """
    import imagecodecs

    return bytes(imagecodecs.jpeg_encode(np.ascontiguousarray(pixels), level=quality))


def write_png(path: Path, codes: Callable[..., NDArray[Any]], *images: NDArray[Any]) -> None:
    """Write a large picture as PNG, a block of rows at a time: neither its codes nor its file are ever held whole.

    Parameters
    ----------
    path : Path
        Of the file.
    codes : callable
        ``codes(*rows)`` turns rows of the images into codes: (k, width) or (k, width, 3) uint8 or uint16.
    *images : (height, width) or (height, width, 3) array
        Row 0 on top; they may lie in files, see `surftex.paged`.

    Raises
    ------
    WorkError
        If the file cannot be written.
    """
    height, width = images[0].shape[:2]
    first = codes(*(image[:1] for image in images))
    wide = first.dtype.itemsize
    pack = zlib.compressobj(1, zlib.DEFLATED, 15, 9, zlib.Z_RLE if wide == 2 else zlib.Z_DEFAULT_STRATEGY)
    kind = struct.pack(">IIBBBBB", width, height, 8 * wide, 2 if first.ndim == 3 else 0, 0, 0, 0)
    above = np.zeros((1, first.nbytes), np.uint8)
    try:
        with path.open("wb") as file:
            file.write(b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", kind))
            for rows in blocks(images[0]):
                part = codes(*(image[rows] for image in images))
                line = part.astype(part.dtype.newbyteorder(">")).view(np.uint8).reshape(len(part), -1)
                told = np.full((len(line), line.shape[1] + 1), 2, np.uint8)  # 2: less the row above
                told[:, 1:] = line - np.concatenate([above, line[:-1]])
                above = line[-1:]
                file.write(_chunk(b"IDAT", pack.compress(told.data)))
                for image in images:
                    let_go(image)
            file.write(_chunk(b"IDAT", pack.flush()) + _chunk(b"IEND", b""))
    except OSError as problem:
        raise WorkError(f"{path.name}: cannot write: {problem.strerror or problem}") from None


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def read_png(path: str | Path) -> NDArray[Any]:
    """Read a PNG as it is.

    Parameters
    ----------
    path : path
        Of the file.

    Returns
    -------
    pixels : (height, width) or (height, width, c) uint8 or uint16
        Codes, not light.

    Raises
    ------
    InputError
        If there is no such file, or it is no PNG.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as problem:
        raise InputError(f"{path}: no readable PNG: {problem.strerror}") from None
    if kind_of(data) != "PNG":
        raise InputError(f"{path}: no readable PNG")
    return decoded(data, str(path))


def srgb_codes(linear: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Encode linear light for a screen, by 8-bit sRGB.

    Parameters
    ----------
    linear : (height, width, ...) float
        0 to 1; clipped.

    Returns
    -------
    codes : (height, width, ...) uint8
        Within 0.54 of the exact curve, before and after rounding.
    """
    share = np.linspace(0, 1, 65536)
    curve = np.where(share <= 0.0031308, 12.92 * share, 1.055 * share ** (1 / 2.4) - 0.055)
    codes = np.rint(255 * curve).astype(np.uint8)
    return _by_rows(linear, np.uint8, lambda rows: codes[_scaled(rows, 65535).astype(np.uint16)])


def unit_codes(values: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Encode numbers from 0 to 1 evenly in 8 bits.

    Parameters
    ----------
    values : (height, width, ...) float
        Clipped to 0 to 1.

    Returns
    -------
    codes : (height, width, ...) uint8
        0 to 255.
    """
    return _by_rows(values, np.uint8, lambda rows: _scaled(rows, 255))


def normal_codes(normal: NDArray[np.floating]) -> NDArray[np.uint16]:
    """Encode unit vectors evenly in 16 bits.

    Parameters
    ----------
    normal : (height, width, 3) float
        Components from -1 to 1.

    Returns
    -------
    codes : (height, width, 3) uint16
        0 for -1, 65535 for 1; 0 lies between 32767 and 32768.
    """
    return _by_rows(normal, np.uint16, lambda rows: _scaled(0.5 * rows + np.float32(0.5), 65535))


def _scaled(rows: NDArray[Any], top: int) -> NDArray[Any]:
    """Clip to 0..1 and scale so that cutting the fraction off rounds."""
    return np.clip(rows, 0, 1) * np.float32(top) + np.float32(0.5)


def _by_rows(values: NDArray[Any], dtype: Any, code: Callable[[NDArray[Any]], NDArray[Any]]) -> NDArray[Any]:
    """Encode a few rows at a time: the copies in between stay small."""
    result = np.zeros(values.shape, dtype)
    for first in range(0, len(values), _ROWS):
        result[first : first + _ROWS] = code(values[first : first + _ROWS])
    return result


def write_exr(path: str | Path, image: NDArray[np.floating], *, channel: str = "Y") -> None:
    """Write numbers as they are, in an EXR of 32-bit floats, compressed without loss (ZIP).

    A page that lies in a file (`surftex.paged`) is written in tiles of 64 x 64, so that a reader may take a part of it.

    Parameters
    ----------
    path : path
        Of the file.
    image : (height, width) or (height, width, 3) float
        Row 0 on top.
    channel : str
        Name of the only channel; three are called R, G, B.

    Raises
    ------
    InputError
        If the shape is another.
    WorkError
        If the file cannot be written.
    """
    import OpenEXR

    if image.ndim < 2 or image.shape[2:] not in ((), (3,)):
        raise InputError(f"EXR takes (h, w) or (h, w, 3), not {image.shape}")
    pixels = np.ascontiguousarray(image, np.float32)
    header: dict[str, Any] = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    if in_file(pixels.shape):
        tiles = OpenEXR.TileDescription()
        tiles.xSize = tiles.ySize = _EXR_TILE
        header |= {"type": OpenEXR.tiledimage, "tiles": tiles}
    try:
        with OpenEXR.File(header, {channel if pixels.ndim == 2 else "RGB": pixels}) as file:
            file.write(str(path))
        let_go(pixels)
    except (RuntimeError, OSError) as problem:
        raise WorkError(f"{path}: cannot write: {str(problem).splitlines()[0]}") from None


def read_exr(path: str | Path) -> dict[str, NDArray[Any]]:
    """Read all channels of an EXR.

    Parameters
    ----------
    path : path
        Of the file.

    Returns
    -------
    channels : dict of str to (height, width) or (height, width, 3) array
        R, G and B come together as ``"RGB"``.

    Raises
    ------
    InputError
        If there is no such file, or it is no EXR.
    """
    if not Path(path).is_file():
        raise InputError(f"{path}: no such file")
    channels = read_exr_channels(path)
    if {"R", "G", "B"} <= set(channels):
        color = [channels.pop(name) for name in "RGB"]
        channels["RGB"] = np.stack(color, axis=-1)
    return channels
