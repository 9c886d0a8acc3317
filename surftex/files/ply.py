"""PLY, text and binary: vertices, polygons, normals, UVs by vertex (``s t``, ``u v``...) or by face, and attributes.

Every other number of a vertex or a face is an attribute of its name: ``red green blue`` make ``color``, 0 to 1, and
``flow_x flow_y flow_z`` make the vector ``flow``.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import MeshFileError
from surftex.files.plyheader import Element, read_header
from surftex.files.polygons import Polygons, check_face_count, skipped_faces, starts_of
from surftex.files.reading import printable
from surftex.files.textlines import parse_floats

_UV_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texture_s", "texture_t"), ("texu", "texv"))
_LIST_NAMES = ("vertex_indices", "vertex_index")
_PLACES = frozenset({"x", "y", "z", "nx", "ny", "nz", *(name for pair in _UV_NAMES for name in pair)})
_COLORS = ("red", "green", "blue", "alpha")
MOST_ATTRIBUTES = 64
"""Further properties are passed over."""


@dataclass
class _Runs:
    """A list property: its lengths, and the values of all records in a row."""

    sizes: NDArray[np.int64]
    values: NDArray[Any]


def read_ply(data: bytes, where: str) -> Polygons:
    """Read a PLY file.

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
        If counts do not fit the file, or an index or a coordinate is wrong.
    """
    order, elements, offset = read_header(data, where)
    by_name = {element.name: element for element in elements}
    for name in ("vertex", "face"):
        if name not in by_name or by_name[name].count == 0:
            raise MeshFileError(
                f"{where}: has no element {name!r}; surftex textures surfaces of vertices and faces"
            )
    check_face_count(by_name["face"].count, where)
    body: Any = data
    if not order:
        body = parse_floats(data[offset:], len(data[offset:].split()))
        if body is None:
            raise MeshFileError(f"{where}: its body holds words that are not numbers")
        offset = 0
    found: dict[str, dict[str, Any]] = {}
    for element in elements:
        found[element.name], offset = _read_element(body, offset, order, element, where)
        if "vertex" in found and "face" in found:
            break
    if not order:
        for name, values in found.items():
            for column, kind, listed in by_name[name].properties:
                if listed is None and kind[0] in "iu" and _fits(values[column], kind):
                    values[column] = values[column].astype(kind)
    return _assembled(found["vertex"], found["face"], where)


def _fits(values: NDArray[np.float64], kind: str) -> bool:
    """Tell whether words of a text are whole numbers of the type that its head names."""
    bounds = np.iinfo(kind)
    return bool(np.all((values >= bounds.min) & (values <= bounds.max) & (values == np.rint(values))))


def _read_element(
    body: bytes | NDArray[np.float64], offset: int, order: str, element: Element, where: str
) -> tuple[dict[str, Any], int]:
    """Values of each property, and where the next element begins. Offsets count bytes, or words of a text."""
    width = [_width(kind, order) for _, kind, _ in element.properties]
    least = sum(
        _width(count, order) if count else w
        for (_, _, count), w in zip(element.properties, width, strict=True)
    )
    name = printable(element.name, longest=40)
    if element.count * max(least, 1) > len(body) - offset:
        raise MeshFileError(
            f"{where}: its header claims {element.count} records of {name!r}, "
            f"at least {element.count * least} {'bytes' if order else 'numbers'}, "
            f"but {max(len(body) - offset, 0)} are left"
        )
    if element.count == 0 or not element.properties:
        return {}, offset
    uniform = _uniform(body, offset, order, element)
    return uniform if uniform is not None else _walked(body, offset, order, element, where)


def _width(kind: str, order: str) -> int:
    return int(kind[1:]) if order else 1


def _count_at(body: Any, offset: int, order: str, kind: str) -> int | None:
    """Length of a list, None beyond the body or where it is no length."""
    if offset + _width(kind, order) > len(body):
        return None
    if order:
        return int(np.frombuffer(body, order + kind, 1, offset)[0])
    value = body[offset]
    return int(value) if value == np.floor(value) and abs(value) < 2**40 else None


def _uniform(body: Any, offset: int, order: str, element: Element) -> tuple[dict[str, Any], int] | None:
    """Read records whose lists all have the lengths of the first record's, or return None."""
    fields: list[tuple[str, str, int]] = []
    at = offset
    for index, (_, kind, count_kind) in enumerate(element.properties):
        length = 1
        if count_kind:
            read = _count_at(body, at, order, count_kind)
            if read is None or read < 0:
                return None
            length = read
            fields.append((f"n{index}", count_kind, 1))
            at += _width(count_kind, order)
        fields.append((f"p{index}", kind, length))
        at += _width(kind, order) * length
    row = at - offset
    if row * element.count > len(body) - offset:
        return None
    table: dict[str, Any] = {}
    if order:
        records = np.frombuffer(
            body, np.dtype([(n, order + k, (c,)) for n, k, c in fields]), element.count, offset
        )
        table = {n: records[n] for n, _, _ in fields}
    else:
        rows, column = body[offset : offset + row * element.count].reshape(element.count, row), 0
        for n, _, c in fields:
            table[n] = rows[:, column : column + c]
            column += c
    values: dict[str, Any] = {}
    for index, (name, _, count_kind) in enumerate(element.properties):
        column = table[f"p{index}"]
        if count_kind:
            if (table[f"n{index}"] != column.shape[1]).any():
                return None
            values[name] = _Runs(np.full(element.count, column.shape[1]), column.reshape(-1))
        else:
            values[name] = column[:, 0]
    return values, offset + row * element.count


def _walked(body: Any, offset: int, order: str, element: Element, where: str) -> tuple[dict[str, Any], int]:
    """Read records of mixed lengths, one after another."""
    sizes: list[list[int]] = [[] for _ in element.properties]
    places: list[list[int]] = [[] for _ in element.properties]
    layout = [
        (k, _width(kind, order), count_kind) for k, (_, kind, count_kind) in enumerate(element.properties)
    ]
    for record in range(element.count):
        for k, width, count_kind in layout:
            length = 1
            if count_kind:
                read = _count_at(body, offset, order, count_kind)
                if read is None or read < 0 or offset + read * width > len(body):
                    said = "ends" if read is None else f"has a list of {read}"
                    raise MeshFileError(
                        f"{where}: record {record} of {printable(element.name, longest=40)!r} {said}: "
                        "negative, or beyond the end of the file"
                    )
                length = read
                offset += _width(count_kind, order)
            sizes[k].append(length)
            places[k].append(offset)
            offset += length * width
        if offset > len(body):
            raise MeshFileError(
                f"{where}: ends within record {record} of {printable(element.name, longest=40)!r}"
            )
    values: dict[str, Any] = {}
    bytes_ = np.frombuffer(body, np.uint8) if order else body
    for k, (name, kind, count_kind) in enumerate(element.properties):
        width = layout[k][1]
        size = np.array(sizes[k], np.int64)
        start = starts_of(size * width)
        taken = bytes_[np.repeat(np.array(places[k]) - start[:-1], size * width) + np.arange(start[-1])]
        column = taken.view(order + kind) if order else taken
        values[name] = _Runs(size, column) if count_kind else column
    return values, offset


def _assembled(vertex: dict[str, Any], face: dict[str, Any], where: str) -> Polygons:
    if any(axis not in vertex or isinstance(vertex[axis], _Runs) for axis in "xyz"):
        raise MeshFileError(f"{where}: its vertices have no x, y and z")
    name = next((n for n in _LIST_NAMES if isinstance(face.get(n), _Runs)), None)
    if name is None:
        raise MeshFileError(f"{where}: its faces have no list 'vertex_indices'")
    runs: _Runs = face[name]
    vertices = _columns(vertex, ("x", "y", "z"))
    sizes, index = (
        runs.sizes,
        np.asarray(runs.values, np.float64 if runs.values.dtype.kind == "f" else np.int64),
    )
    wrong = np.flatnonzero(~((index >= 0) & (index < len(vertices)) & (index == np.floor(index))))
    start = starts_of(sizes)
    if len(wrong):
        record = int(np.searchsorted(start, wrong[0], side="right")) - 1
        raise MeshFileError(
            f"{where}: face {record} refers to vertex {index[wrong[0]]:.0f} of {len(vertices)} "
            "(counted from 0)"
        )
    corner = index.astype(np.int64)
    warnings = []
    uv_sets = [_columns(vertex, pair)[corner] for pair in _UV_NAMES if all(p in vertex for p in pair)]
    texture = face.get("texcoord")
    if not uv_sets and isinstance(texture, _Runs) and (texture.sizes == 2 * sizes).all():
        uv_sets = [np.asarray(texture.values, np.float64).reshape(-1, 2)]
    normals = (
        _columns(vertex, ("nx", "ny", "nz"))[corner] if all(n in vertex for n in ("nx", "ny", "nz")) else None
    )
    short = sizes < 3
    attributes = {name: np.repeat(values, sizes, axis=0) for name, values in _attributes(face).items()}
    attributes |= {name: values[corner] for name, values in _attributes(vertex).items()}
    polygons = Polygons(vertices, start, corner, uv_sets, normals, warnings=warnings, attributes=attributes)
    if short.any():
        polygons = polygons.selected(~short)
        warnings.append(skipped_faces(int(short.sum())))
        if short.all():
            raise MeshFileError(f"{where}: has no face of 3 corners or more")
    wrong = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    wrong = wrong[np.isin(wrong, polygons.corner)] if len(wrong) else wrong
    if len(wrong):
        raise MeshFileError(
            f"{where}: {len(wrong)} vertices in use are not finite; the first is vertex {int(wrong[0])}"
        )
    return polygons


def _columns(values: dict[str, Any], names: tuple[str, ...]) -> NDArray[np.float64]:
    return np.stack([np.asarray(values[name], np.float64) for name in names], axis=1)


def _attributes(values: dict[str, Any]) -> dict[str, NDArray[np.float64]]:
    """Numbers of each record beside its place, with colours and vectors put together."""
    numbers = {
        name: column
        for name, column in values.items()
        if name not in _PLACES and not isinstance(column, _Runs)
    }
    found: dict[str, NDArray[np.float64]] = {}
    for before in ("", "diffuse_"):
        names = tuple(before + name for name in _COLORS if before + name in numbers)
        if len(names) >= 3 and "color" not in numbers:
            most = [np.iinfo(c.dtype).max if (c := numbers[n]).dtype.kind in "iu" else 1 for n in names]
            found.setdefault("color", _columns(numbers, names) / most)
            numbers = {name: column for name, column in numbers.items() if name not in names}
    for stem in [name[:-2] for name in numbers if name.endswith("_x") and len(name) > 2]:
        names = tuple(f"{stem}_{axis}" for axis in "xyz")
        if stem not in numbers and all(name in numbers for name in names):
            found[stem] = _columns(numbers, names)
            numbers = {name: column for name, column in numbers.items() if name not in names}
    found |= {name: np.asarray(column, np.float64) for name, column in numbers.items()}
    return {printable(name, longest=80): found[name] for name in list(found)[:MOST_ATTRIBUTES]}
