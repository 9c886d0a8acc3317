"""Heads of pictures: segments of JPEG, tags of TIFF and EXIF, and which way up a picture is to be shown."""

import struct
from collections.abc import Iterator

TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
"""First bytes of a TIFF, and of the tags of EXIF."""

_ORIENTATION = 274
_WHOLE = {1: "B", 3: "H", 4: "I", 16: "Q"}


def orientation(data: bytes) -> tuple[int, int]:
    """Read how a picture is to be turned, as cameras note it.

    Parameters
    ----------
    data : bytes
        Of a JPEG (EXIF), PNG (eXIf) or TIFF.

    Returns
    -------
    number : int
        Stored by columns from 5 on, then mirrored sideways at 2, 3, 6, 7, and upside down at 3, 4, 7, 8; 1 where nothing
        is said, or nothing that can be read.
    at : int
        Where it stands among the tags.
    """
    try:
        found = ((value, at) for tag, value, at in tags(_exif(data)) if tag == _ORIENTATION)
        number, at = next(found, (1, 0))
    except (struct.error, ValueError, OverflowError):
        return 1, 0
    return (number, at) if number in range(1, 9) else (1, 0)


def _exif(data: bytes) -> bytes:
    """Find the tags within a picture."""
    if data[:2] == b"\xff\xd8":
        found = (
            at for at, marker in segments(data) if marker == 0xE1 and data[at + 4 : at + 10] == b"Exif\0\0"
        )
        at = next(found, len(data))
        return data[at + 10 : at + 2 + int.from_bytes(data[at + 2 : at + 4], "big")]
    if data[:4] == b"\x89PNG":  # the chunk's name before the beginning of tags means nothing else
        at = max(data.find(b"eXIf" + head) for head in TIFF[:2])
        return data[at + 4 : at + 2**16] if at >= 0 else b""
    return data


def segments(data: bytes) -> Iterator[tuple[int, int]]:
    """Walk over the segments of a JPEG, up to its first scan.

    Parameters
    ----------
    data : bytes
        Of the file.

    Yields
    ------
    at : int
        Where a segment begins.
    marker : int
        Its kind.
    """
    at = 2
    while at + 4 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == 0xFF or 0xD0 <= marker <= 0xD8:
            at += 1 if marker == 0xFF else 2
            continue
        yield at, marker
        if marker == 0xDA:
            return
        at += 2 + max(2, int.from_bytes(data[at + 2 : at + 4], "big"))


def tags(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Walk over the tags of a TIFF's first page.

    Parameters
    ----------
    data : bytes
        Of a TIFF or BigTIFF, or of what EXIF holds.

    Yields
    ------
    tag : int
        Its number.
    value : int
        The first of its whole numbers; 0 where it holds none, or they are not in the tag itself.
    at : int
        Where that stands.

    Raises
    ------
    ValueError
        If these are no tags; `struct.error` or `OverflowError` where they point beyond the end.
    """
    if data[:4] not in TIFF:
        raise ValueError("no tags")
    order, big = "<" if data[:2] == b"II" else ">", b"+" in data[2:4]
    (at,) = struct.unpack_from(order + ("Q" if big else "I"), data, 8 if big else 4)
    (count,) = struct.unpack_from(order + ("Q" if big else "H"), data, at)
    at += 8 if big else 2
    for entry in range(at, at + min(count, 4096) * (20 if big else 12), 20 if big else 12):
        tag, kind = struct.unpack_from(order + "HH", data, entry)
        whole, at = _WHOLE.get(kind), entry + (12 if big else 8)
        yield tag, struct.unpack_from(order + whole, data, at)[0] if whole else 0, at
