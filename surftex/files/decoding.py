"""Pictures from bytes: what a file claims to unfold to is read from its head, and refused before it costs memory."""

import io
import os
import struct
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stdout, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.files.heads import TIFF, orientation, segments, tags
from surftex.files.reading import printable

MOST_NUMBERS = 2**28
"""Pixels times channels of a picture beyond which it is not decoded: 16384 x 16384 of one channel."""

_PRINTED = (b"PNG warning", b"EXR_ERR", b"Exception raised reading")
_BROKEN = ("PNG warning: IDAT", "EXR_ERR", "Exception raised reading")
"""In what decoders print, and there where they go on with pixels that are none."""

_one_at_a_time = threading.Lock()

_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""Markers of a JPEG that are followed by the size of the picture."""

_WIDTH, _HEIGHT, _INKS, _SAMPLES = 256, 257, 262, 277
_PRINTERS = 5
"""Value of the tag `_INKS` where a TIFF holds inks, not light."""

_CHANNELS = {0: 1, 2: 3, 3: 4, 4: 2, 6: 4}
"""Channels by the colour type of a PNG; a palette unfolds to as many as 4."""


def decoded(
    data: bytes, name: str, *, error: type[InputError] = InputError, as_stored: bool = False
) -> NDArray[Any]:
    """Unpack a PNG, JPEG or TIFF, turned as the file says that it is to be shown.

    Parameters
    ----------
    data : bytes
        Of the whole file.
    name : str
        What messages call it.
    error : type
        Of the failure.
    as_stored : bool
        Turn nothing, as glTF demands of textures.

    Returns
    -------
    pixels : (h, w) or (h, w, c) array
        Codes as the file has them; row 0 on top.

    Raises
    ------
    InputError
        Of the type `error`, if it is none of these, damaged, CMYK, or unfolds to more than `MOST_NUMBERS` numbers.
    """
    import imagecodecs

    kinds: dict[str, Callable[[bytes], NDArray[Any]]] = {
        "PNG": imagecodecs.png_decode,
        "JPEG": imagecodecs.jpeg_decode,
        "TIFF": imagecodecs.tiff_decode,
    }
    kind = kind_of(data)
    if kind not in kinds:
        raise error(f"{name}: is none of {', '.join(kinds)}; save it as PNG")
    claimed(data, name, error=error)
    if kind == "JPEG" and not _has_end(data):
        raise error(f"{name}: is a damaged JPEG (it is cut off before its end); save it again")
    number, at = orientation(data)
    if kind == "TIFF" and number > 1:  # libtiff would mirror, and not turn, those that hold a JPEG
        data = data[:at] + data[at:].replace(bytes([number]), b"\1", 1)
    pixels = _unpacked(lambda: kinds[kind](data), kind, name, error)
    return pixels if as_stored else _upright(pixels, number)


def _upright(pixels: NDArray[Any], number: int) -> NDArray[Any]:
    """Turn what is stored in an `orientation` as it is to be shown."""
    if number >= 5:
        pixels = pixels.swapaxes(0, 1)
    down, right = -1 if number in (3, 4, 7, 8) else 1, -1 if number in (2, 3, 6, 7) else 1
    return np.ascontiguousarray(pixels[::down, ::right])


def kind_of(data: bytes) -> str:
    """Tell the format of a picture by its first bytes.

    Parameters
    ----------
    data : bytes
        At least the beginning of the file.

    Returns
    -------
    kind : str
        ``PNG``, ``JPEG``, ``TIFF``, ``EXR``, or nothing.
    """
    if data[:4] == b"\x89PNG":
        return "PNG"
    if data[:2] == b"\xff\xd8":
        return "JPEG"
    return "TIFF" if data[:4] in TIFF else "EXR" if data[:4] == b"v/1\x01" else ""


def claimed(data: bytes, name: str, *, error: type[InputError] = InputError) -> tuple[int, int, int]:
    """Read what a picture claims to be; refuse it where that is more than could be meant, or inks.

    Parameters
    ----------
    data : bytes
        At least the head of the file.
    name : str
        What messages call it.
    error : type
        Of the failure.

    Returns
    -------
    width : int
        Pixels of a row, as stored.
    height : int
        Rows, as stored.
    channels : int
        Numbers of a pixel.

    Raises
    ------
    InputError
        Of the type `error`, if the head is cut off, or claims nothing, CMYK, or more than `MOST_NUMBERS`.
    """
    claims = {"PNG": _png_claim, "JPEG": _jpeg_claim, "TIFF": _tiff_claim, "EXR": _exr_claim}
    try:
        width, height, channels, inks = claims[kind_of(data)](data)
    except (struct.error, IndexError, ValueError, OverflowError):
        raise error(f"{name}: is cut off within its head, or damaged; save the picture again") from None
    if width < 1 or height < 1 or channels < 1:
        raise error(f"{name}: claims {width} x {height} pixels; save the picture again")
    if width * height * channels > MOST_NUMBERS:
        raise error(
            f"{name}: claims {width} x {height} pixels of {channels} channels, more than the {MOST_NUMBERS} "
            "numbers that are read; scale it down"
        )
    if inks:
        raise error(f"{name}: is CMYK, for printers; convert it to RGB")
    return width, height, channels


def read_exr_channels(path: str | Path, *, error: type[InputError] = InputError) -> dict[str, NDArray[Any]]:
    """Read the channels of an EXR file, each by its own name.

    Parameters
    ----------
    path : path
        Of a file that is there.
    error : type
        Of the failure.

    Returns
    -------
    channels : dict of str to (h, w) array
        Copies; row 0 on top.

    Raises
    ------
    InputError
        Of the type `error`, if it is damaged, or unfolds to more than `MOST_NUMBERS` numbers.
    """
    import OpenEXR

    name = printable(str(path))
    with Path(path).open("rb") as file:
        head = file.read(2**16)
    if kind_of(head) != "EXR":
        raise error(f"{name}: is {'no EXR file' if head else 'empty'}")
    claimed(head, name, error=error)

    def unpack() -> dict[str, NDArray[Any]]:
        with OpenEXR.File(str(path), separate_channels=True) as opened:
            return {key: np.array(channel.pixels) for key, channel in opened.channels().items()}

    return _unpacked(unpack, "EXR", name, error)


def _unpacked(unpack: Callable[[], Any], kind: str, name: str, error: type[InputError]) -> Any:
    """Run a decoder; what it raises, and what it only prints of broken data, becomes a line."""
    pixels = None
    try:
        with _overheard() as said:
            pixels = unpack()
        reason = next((line for line in said if any(word in line for word in _BROKEN)), "")
    except Exception as problem:  # noqa: BLE001  (decoders raise whatever they like on broken files)
        reason = str(problem).splitlines()[0] if str(problem) else type(problem).__name__
    if reason:
        raise error(
            f"{name}: is a damaged {kind} ({printable(reason, longest=120)}); save it again"
        ) from None
    return pixels


@contextmanager
def _overheard() -> Iterator[list[str]]:
    """Collect the lines that libraries print meanwhile; what others print on stderr is passed on."""
    said: list[str] = []
    printed = io.StringIO()
    with _one_at_a_time, ExitStack() as stack:
        with suppress(OSError):  # where there is no stderr
            stack.enter_context(_taken_over(2, said))
        stack.enter_context(redirect_stdout(printed))
        yield said
    said += printed.getvalue().splitlines()


@contextmanager
def _taken_over(stream: int, said: list[str]) -> Iterator[None]:
    """Put a file in the place of a stream of this process, and sort what was written to it."""
    kept = os.dup(stream)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), stream)
        try:
            yield
        finally:
            os.dup2(kept, stream)
            os.close(kept)
            file.seek(0)
            for line in file.read().splitlines(keepends=True):
                if any(word in line for word in _PRINTED):
                    said.append(line.decode("utf-8", "replace").strip())
                else:
                    os.write(stream, line)


def _png_claim(data: bytes) -> tuple[int, int, int, bool]:
    if data[12:16] != b"IHDR":
        raise ValueError("no IHDR")
    width, height, _, color = struct.unpack_from(">IIBB", data, 16)
    return width, height, _CHANNELS.get(color, 4), False


def _jpeg_claim(data: bytes) -> tuple[int, int, int, bool]:
    for at, marker in segments(data):
        if marker in _FRAMES:
            height, width, channels = struct.unpack_from(">HHB", data, at + 5)
            return width, height, channels, channels == 4
    raise ValueError("no frame")


def _has_end(data: bytes) -> bool:
    """Tell whether a JPEG's marker of the end follows its first scan; what is cut off is decoded to grey without a word."""
    scan = next((at for at, marker in segments(data) if marker == 0xDA), len(data))
    return data.find(b"\xff\xd9", scan) >= 0


def _tiff_claim(data: bytes) -> tuple[int, int, int, bool]:
    """Read the first page's size from its tags."""
    found = {_WIDTH: 0, _HEIGHT: 0, _SAMPLES: 1, _INKS: 0}
    found.update((tag, value) for tag, value, _ in tags(data))
    return found[_WIDTH], found[_HEIGHT], found[_SAMPLES], found[_INKS] == _PRINTERS


def _exr_claim(data: bytes) -> tuple[int, int, int, bool]:
    """Read the data window and the channels of the first part."""
    at, found = 8, {}
    while data[at] != 0:
        name_end = data.index(b"\0", at)
        kind_end = data.index(b"\0", name_end + 1)
        (size,) = struct.unpack_from("<i", data, kind_end + 1)
        if size < 0:
            raise ValueError("a negative size")
        found[data[at:name_end]] = data[kind_end + 5 : kind_end + 5 + size]
        at = kind_end + 5 + size
    left, low, right, high = struct.unpack("<4i", found.get(b"dataWindow", b""))
    table, at, channels = found.get(b"channels", b""), 0, 0
    while table[at] != 0:
        at = table.index(b"\0", at) + 17
        channels += 1
    return right - left + 1, high - low + 1, channels, False
