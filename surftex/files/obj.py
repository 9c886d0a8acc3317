"""Wavefront OBJ: vertices, UVs, normals and polygons; no other file is ever opened for one.

Faces may index each corner as ``v``, ``v/vt``, ``v//vn`` or ``v/vt/vn``, forwards or (negative) backwards.
``usemtl``, ``g`` and ``o`` become parts; three numbers behind the place of each vertex are its ``color``. Material
libraries are not needed for geometry and stay closed.
"""

import numpy as np
from numpy.typing import NDArray

from surftex.errors import MeshFileError
from surftex.files.polygons import Polygons, check_face_count, skipped_faces, starts_of
from surftex.files.reading import printable
from surftex.files.textlines import TextLines, columns
from surftex.words import by_count

_LABELS = {b"usemtl": "material", b"g": "group", b"o": "object"}


def read_obj(data: bytes, where: str) -> Polygons:
    """Read an OBJ file.

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
        Naming the line that is wrong.
    """
    text = TextLines(data, where)
    lines = {word: text.starting(word) for word in (b"v", b"vt", b"vn", b"f", b"fo")}
    face_lines = np.sort(np.concatenate([lines[b"f"], lines[b"fo"]]))
    if len(lines[b"v"]) == 0 and len(face_lines) == 0:
        hint = "; it looks like a PLY file" if data[:3] == b"ply" else ""
        raise MeshFileError(f"{where}: holds no OBJ records (no 'v', no 'f'){hint}")
    if len(lines[b"v"]) == 0:
        raise MeshFileError(f"{where}: has no vertices (no 'v' line)")
    if len(face_lines) == 0:
        raise MeshFileError(
            f"{where}: has {len(lines[b'v'])} vertices but no faces (no 'f' line); surftex textures surfaces"
        )
    check_face_count(len(face_lines), where)
    warnings: list[str] = []
    _warn_of_libraries(text, warnings)

    values, begin = text.numbers(lines[b"v"], 1, 3, "vertex")
    vertices = columns(values, begin, 3)
    painted = len(values) == 6 * len(vertices) and (np.diff(begin) == 6).all()
    few = text.tokens[face_lines] < 4
    if few.any():
        warnings.append(skipped_faces(int(few.sum())) + f"; the first in line {int(face_lines[few][0]) + 1}")
        face_lines = face_lines[~few]
        if len(face_lines) == 0:
            raise MeshFileError(
                f"{where}: has no face of 3 corners or more; surftex textures surfaces, not points or lines"
            )
    index, sizes = _corner_indices(text, face_lines)
    line_of = np.repeat(face_lines, sizes)
    corner = _resolved(index[:, 0], lines[b"v"], line_of, where, "vertex", required=True)

    uv_sets, normals = [], None
    if len(lines[b"vt"]) and index[:, 1].any():
        which = _resolved(index[:, 1], lines[b"vt"], line_of, where, "texture vertex")
        uv = columns(*_padded(*text.numbers(lines[b"vt"], 2, 1, "texture vertex")), 2)
        uv_sets = [np.concatenate([uv, np.full((1, 2), np.nan)])[which]]
    if len(lines[b"vn"]) and index[:, 2].any():
        which = _resolved(index[:, 2], lines[b"vn"], line_of, where, "normal")
        normal = columns(*text.numbers(lines[b"vn"], 2, 3, "normal"), 3)
        normals = np.concatenate([normal, np.full((1, 3), np.nan)])[which]
    _check_finite(vertices, corner, lines[b"v"], where)
    return Polygons(
        vertices, starts_of(sizes), corner, uv_sets, normals, _labels(text, face_lines), None, warnings,
        {"color": values.reshape(-1, 6)[:, 3:][corner]} if painted else {},
    )  # fmt: skip


def _warn_of_libraries(text: TextLines, warnings: list[str]) -> None:
    outside = 0
    for line in text.starting(b"mtllib").tolist():
        path = text.content(line)[6:].strip().replace("\\", "/")
        outside += path.startswith("/") or ":" in path or ".." in path.split("/")
    if outside:
        warnings.append(
            by_count(outside, "{} 'mtllib' line names", "{} 'mtllib' lines name")
            + " a path outside the file's folder; nothing is read there"
        )


def _corner_indices(text: TextLines, lines: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(c, 3) indices v, vt, vn of each corner, 0 where absent, and (p,) corners of each face."""
    raw = text.bytes_of(lines, 1)
    if (raw == ord("o")).any():
        raw = np.where(raw == ord("o"), np.uint8(32), raw)
    data = raw.tobytes()
    if b"/" not in data:
        values = _integers(data)
        sizes = text.tokens[lines] - 1
        if values is None or len(values) != sizes.sum():
            raise _bad_face(text, lines)
        return np.column_stack([values, np.zeros((len(values), 2), np.int64)]), sizes
    while b"//" in data:
        data = data.replace(b"//", b"/0/")
    raw = np.frombuffer(data, np.uint8)
    slash, gap = raw == ord("/"), (raw == 32) | ((raw >= 9) & (raw <= 13))
    part = ~(slash | gap)
    begins = part.copy()
    begins[1:] &= ~part[:-1]
    word = ~gap
    word_begins = word.copy()
    word_begins[1:] &= ~word[:-1]
    where_number, where_word = np.flatnonzero(begins), np.flatnonzero(word_begins)
    slashes = np.cumsum(slash)
    slashes_before_word = slashes[where_word] - slash[where_word]
    corner = np.searchsorted(where_word, where_number, side="right") - 1
    column = slashes[where_number] - slashes_before_word[corner]
    values = _integers(data.replace(b"/", b" "))
    sizes = text.tokens[lines] - 1
    if values is None or len(values) != len(where_number) or len(where_word) != sizes.sum():
        raise _bad_face(text, lines)
    if column.max() > 2 or slash[where_word].any():
        raise _bad_face(text, lines)
    index = np.zeros((len(where_word), 3), np.int64)
    index[corner, column] = values
    return index, sizes


def _integers(data: bytes) -> NDArray[np.int64] | None:
    try:
        return np.fromstring(data, dtype=np.int64, sep=" ") if data.strip() else np.zeros(0, np.int64)
    except (ValueError, DeprecationWarning, OverflowError):
        return None


def _bad_face(text: TextLines, lines: NDArray[np.int64]) -> MeshFileError:
    for line in lines.tolist():
        for word in bytes(text.text[text.start[line] : text.end[line]]).split()[1:]:
            pieces = word.split(b"/")
            good = len(pieces) <= 3 and pieces[0]
            for piece in pieces:
                good = good and (not piece or (piece.lstrip(b"+-").isdigit() and len(piece) < 19))
            if not good:
                shown = printable(word.decode("utf-8", "replace"), longest=40)
                return MeshFileError(
                    f"{text.where}: line {line + 1}: {shown!r} is no face corner (v, v/vt, v//vn, v/vt/vn)"
                )
    return MeshFileError(f"{text.where}: the face lines do not read as indices")


def _resolved(
    index: NDArray[np.int64],
    record_lines: NDArray[np.int64],
    line_of: NDArray[np.int64],
    where: str,
    what: str,
    *,
    required: bool = False,
) -> NDArray[np.int64]:
    """Count indices from 0; -1 where a corner has none."""
    count = len(record_lines)
    result = index - 1
    backwards = np.flatnonzero(index < 0)
    if len(backwards):
        before = np.searchsorted(record_lines, line_of[backwards])
        result[backwards] = before + index[backwards]
        wrong = backwards[result[backwards] < 0]
        if len(wrong):
            at = int(wrong[0])
            raise MeshFileError(
                f"{where}: line {int(line_of[at]) + 1}: relative index {int(index[at])} "
                f"lies before the first {what}"
            )
    zero = np.flatnonzero(index == 0) if required else []
    if len(zero):
        raise MeshFileError(
            f"{where}: line {int(line_of[zero[0]]) + 1}: a face uses index 0; OBJ counts from 1"
        )
    wrong = np.flatnonzero(result >= count)
    if len(wrong):
        at = int(wrong[0])
        raise MeshFileError(
            f"{where}: line {int(line_of[at]) + 1}: a face refers to {what} {int(index[at])} of {count} "
            f"({len(wrong)} such corners)"
        )
    return result


def _padded(
    values: NDArray[np.float64], start: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Give texture vertices of one number a second, 0."""
    counts = np.diff(start)
    if (counts >= 2).all():
        return values, start
    table = np.zeros((len(counts), 2))
    table[:, 0] = values[start[:-1]]
    two = counts >= 2
    table[two, 1] = values[start[:-1][two] + 1]
    return table.ravel(), np.arange(0, 2 * len(counts) + 1, 2)


def _check_finite(
    vertices: NDArray[np.float64], corner: NDArray[np.int64], lines: NDArray[np.int64], where: str
) -> None:
    wrong = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    wrong = wrong[np.isin(wrong, corner)] if len(wrong) else wrong
    if len(wrong):
        first = int(wrong[0])
        raise MeshFileError(
            f"{where}: {len(wrong)} vertices in use are not finite; the "
            f"first is vertex {first + 1}, line {int(lines[first]) + 1}"
        )


def _labels(
    text: TextLines, face_lines: NDArray[np.int64]
) -> dict[str, tuple[NDArray[np.int32], tuple[str, ...]]]:
    labels = {}
    for word, kind in _LABELS.items():
        lines = text.starting(word)
        if len(lines) == 0:
            continue
        names: dict[str, int] = {}
        said = [
            names.setdefault(printable(text.content(line)[len(word) :].strip()) or "default", len(names))
            for line in lines.tolist()
        ]
        at = np.searchsorted(lines, face_lines) - 1
        if (at < 0).any():
            unnamed = names.setdefault("default", len(names))
            index = np.where(at < 0, unnamed, np.asarray(said)[np.maximum(at, 0)])
        else:
            index = np.asarray(said)[at]
        labels[kind] = (index.astype(np.int32), tuple(names))
    return labels
