"""STL, text and binary: loose triangles; a ``solid`` of a text file is a part."""

import numpy as np

from surftex.errors import MeshFileError
from surftex.files.polygons import Polygons, check_face_count
from surftex.files.reading import printable
from surftex.files.textlines import TextLines, columns

_RECORD = np.dtype([("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(data: bytes, where: str) -> Polygons:
    """Read an STL file; whether it is text or binary is told by its length, not by its first word.

    Parameters
    ----------
    data : bytes
        The file.
    where : str
        Its name for messages.

    Returns
    -------
    polygons : Polygons
        What it holds.

    Raises
    ------
    MeshFileError
        If it is neither, or is cut short.
    """
    warnings: list[str] = []
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else -1
    needed = 84 + 50 * count
    textual = data[:512].lstrip()[:5].lower() == b"solid" and b"facet" in data[:4096]
    if count >= 0 and (needed == len(data) or (needed < len(data) and count > 0 and not textual)):
        if needed < len(data):
            warnings.append(f"{len(data) - needed} bytes after the last triangle ignored")
    elif textual or (data[:512].lstrip()[:5].lower() == b"solid" and b"\0" not in data[:512]):
        return _read_text(data, where)
    elif count > 0:
        raise MeshFileError(
            f"{where}: is no STL file, or is cut short: its header claims {count} triangles "
            f"({needed} bytes), it has {len(data)} bytes"
        )
    else:
        raise MeshFileError(
            f"{where}: is no STL file: neither a binary header nor the words 'solid' and 'facet'"
        )
    if count == 0:
        raise MeshFileError(f"{where}: has no triangles")
    check_face_count(count, where)
    records = np.frombuffer(data, _RECORD, count, 84)
    vertices = records["corner"].astype(np.float64).reshape(-1, 3)
    return _loose(vertices, where, warnings)


def _read_text(data: bytes, where: str) -> Polygons:
    text = TextLines(data.lower() if b"VERTEX" in data[:4096] else data, where)
    lines = text.starting(b"vertex")
    if len(lines) == 0 or len(lines) % 3:
        raise MeshFileError(
            f"{where}: has {len(lines)} 'vertex' lines, no whole number of triangles; is it cut short?"
        )
    check_face_count(len(lines) // 3, where)
    polygons = _loose(columns(*text.numbers(lines, 6, 3, "vertex"), 3), where, [])
    solids = text.starting(b"solid")
    if len(solids) > 1:
        names = [
            printable(text.content(line)[5:].strip()) or f"solid {k + 1}"
            for k, line in enumerate(solids.tolist())
        ]
        index = np.maximum(np.searchsorted(solids, lines[::3]) - 1, 0)
        unique = {name: k for k, name in enumerate(dict.fromkeys(names))}
        polygons.labels["solid"] = (np.array([unique[n] for n in names], np.int32)[index], tuple(unique))
    return polygons


def _loose(vertices: np.ndarray, where: str, warnings: list[str]) -> Polygons:
    wrong = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(wrong):
        raise MeshFileError(
            f"{where}: {len(wrong)} corners are not finite; the first is in triangle {int(wrong[0]) // 3}"
        )
    return Polygons(vertices, np.arange(0, len(vertices) + 1, 3), np.arange(len(vertices)), warnings=warnings)
