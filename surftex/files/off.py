"""OFF and its kin with colours, normals or texture coordinates (COFF, NOFF, STOFF); text only."""

import re

import numpy as np

from surftex.errors import MeshFileError
from surftex.files.polygons import Polygons, check_face_count, skipped_faces, starts_of
from surftex.files.textlines import TextLines, columns

_MAGIC = re.compile(rb"(ST)?(C)?(N)?(4)?(n)?OFF")


def read_off(data: bytes, where: str) -> Polygons:
    """Read an OFF file; each vertex and each face has a line of its own.

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
        Naming the line that is wrong, or the counts that do not fit.
    """
    text = TextLines(data, where)
    lines = np.flatnonzero(text.tokens > 0)
    if len(lines) == 0:
        raise MeshFileError(f"{where}: is empty")
    head = bytes(text.text[text.start[lines[0]] : text.end[lines[0]]]).split()
    magic = _MAGIC.fullmatch(head[0])
    if not magic:
        raise MeshFileError(
            f"{where}: does not begin with 'OFF'; add that word as its first line if it is one"
        )
    if magic[4] or magic[5] or b"BINARY" in head:
        raise MeshFileError(
            f"{where}: is a binary or higher-dimensional OFF file, which surftex does not read"
        )
    if len(head) >= 3:
        counts, used = head[1:], 1
    else:
        if len(lines) < 2:
            raise MeshFileError(f"{where}: ends before its counts of vertices and faces")
        counts, used = bytes(text.text[text.start[lines[1]] : text.end[lines[1]]]).split(), 2
    if len(counts) < 2 or not all(word.isdigit() and len(word) < 16 for word in counts[:2]):
        raise MeshFileError(
            f"{where}: line {int(lines[used - 1]) + 1} should hold the counts of vertices and faces"
        )
    vertex_count, face_count = int(counts[0]), int(counts[1])
    if vertex_count + face_count > len(lines) - used:
        raise MeshFileError(
            f"{where}: its header claims {vertex_count} vertices and {face_count} faces, "
            f"but only {len(lines) - used} lines follow"
        )
    if face_count == 0:
        raise MeshFileError(f"{where}: has no faces; surftex textures surfaces, not points or lines")
    check_face_count(face_count, where)
    vertex_lines = lines[used : used + vertex_count]
    face_lines = lines[used + vertex_count : used + vertex_count + face_count]
    width = 3 + 3 * bool(magic[3])
    values, start = text.numbers(vertex_lines, 0, width, "vertex")
    vertices = columns(values, start, 3).copy()
    if not np.isfinite(vertices).all():
        first = int(np.flatnonzero(~np.isfinite(vertices).all(axis=1))[0])
        raise MeshFileError(f"{where}: vertex {first} (line {int(vertex_lines[first]) + 1}) is not finite")
    uv = values[start[1:, None] - [2, 1]] if magic[1] and (np.diff(start) >= width + 2).all() else None
    normal = columns(values, start, 6)[:, 3:6] if magic[3] else None

    values, start = text.numbers(face_lines, 0, 1, "face")
    sizes = values[start[:-1]]
    wrong = np.flatnonzero(~((sizes >= 0) & (sizes == np.floor(sizes)) & (sizes < np.diff(start))))
    if len(wrong):
        line = int(face_lines[wrong[0]]) + 1
        raise MeshFileError(
            f"{where}: line {line}: a face of {sizes[wrong[0]]:g} corners "
            f"with {int(np.diff(start)[wrong[0]]) - 1} numbers"
        )
    sizes = sizes.astype(np.int64)
    warnings = []
    if (sizes < 3).any():
        warnings.append(skipped_faces(int((sizes < 3).sum())))
    kept = sizes >= 3
    first, sizes, kept_lines = start[:-1][kept] + 1, sizes[kept], face_lines[kept]
    if len(sizes) == 0:
        raise MeshFileError(f"{where}: has no face of 3 corners or more")
    corners = starts_of(sizes)
    index = values[np.repeat(first - corners[:-1], sizes) + np.arange(corners[-1])]
    wrong = np.flatnonzero(~((index >= 0) & (index < vertex_count) & (index == np.floor(index))))
    if len(wrong):
        line = int(kept_lines[np.searchsorted(corners, wrong[0], side="right") - 1]) + 1
        raise MeshFileError(
            f"{where}: line {line}: a face refers to vertex {index[wrong[0]]:g} of {vertex_count} "
            "(counted from 0)"
        )
    corner = index.astype(np.int64)
    return Polygons(
        vertices,
        corners,
        corner,
        [] if uv is None else [uv[corner]],
        None if normal is None else normal[corner],
        warnings=warnings,
    )
