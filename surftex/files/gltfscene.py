"""What a glTF scene shows: its nodes walked from the roots, each mesh put in its place."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import MeshFileError
from surftex.files.gltfaccessor import Document
from surftex.files.polygons import Polygons, check_face_count, starts_of
from surftex.files.reading import printable
from surftex.words import by_count

_MODES = {
    0: "POINTS",
    1: "LINES",
    2: "LINE_LOOP",
    3: "LINE_STRIP",
    4: "TRIANGLES",
    5: "TRIANGLE_STRIP",
    6: "TRIANGLE_FAN",
}
_MOST_UV_SETS = 8
_MOST_ATTRIBUTES = 64


@dataclass
class _Pieces:
    """Arrays of the scene while it is walked."""

    vertices: list[NDArray[np.float64]] = field(default_factory=list)
    corner: list[NDArray[np.int64]] = field(default_factory=list)
    uv_sets: list[list[NDArray[np.float64]]] = field(default_factory=list)
    normals: list[NDArray[np.float64] | None] = field(default_factory=list)
    attributes: list[dict[str, NDArray[np.float64]]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    labels: dict[str, list[str]] = field(default_factory=lambda: {"material": [], "node": [], "mesh": []})
    vertex_count: int = 0
    face_count: int = 0
    skipped: dict[str, int] = field(default_factory=dict)
    skinned: int = 0


def unfolded(document: Document) -> Polygons:
    """Walk the scene.

    Parameters
    ----------
    document : Document
        With its buffers.

    Returns
    -------
    polygons : Polygons
        Triangles in metres.

    Raises
    ------
    MeshFileError
        If the node graph has a cycle, a number is wrong, or there are no triangles.
    """
    pieces = _Pieces()
    warnings: list[str] = []
    nodes = document.listed("nodes")
    if nodes:
        seen: set[int] = set()
        stack: list[tuple[Any, NDArray[np.float64]]] = [
            (root, np.eye(4)) for root in reversed(_roots(document))
        ]
        while stack:
            index, above = stack.pop()
            node = document.item("nodes", index)
            if index in seen:
                raise document.fail(
                    f"nodes[{index}] is reached twice: the node graph has a cycle or a shared child"
                )
            seen.add(index)
            placed = above @ _matrix(document, node, f"nodes[{index}]")
            if node.get("mesh") is not None:
                skinned = node.get("skin") is not None
                pieces.skinned += skinned
                name = printable(str(node.get("name") or f"node {index}"), longest=80)
                _add_mesh(document, node["mesh"], np.eye(4) if skinned else placed, name, pieces)
            children = node.get("children", [])
            if not isinstance(children, list):
                raise document.fail(f"nodes[{index}] has children that are no list")
            stack.extend((child, placed) for child in reversed(children))
    else:
        for index in range(len(document.listed("meshes"))):
            _add_mesh(document, index, np.eye(4), f"mesh {index}", pieces)
        warnings.append("the file has meshes but no nodes; each mesh is taken once, where it is")
    if pieces.face_count == 0:
        what = ", ".join(f"{count} of {mode}" for mode, count in pieces.skipped.items())
        raise document.fail(f"has no triangles{f' (only {what})' if what else ''}; surftex textures surfaces")
    if pieces.skipped:
        what = ", ".join(f"{count} of {mode}" for mode, count in pieces.skipped.items())
        warnings.append(f"primitives without triangles skipped: {what}")
    if pieces.skinned:
        warnings.append(
            by_count(
                pieces.skinned,
                "{} skinned node is taken in its rest pose",
                "{} skinned nodes are taken in their rest pose",
            )
        )
    return _gathered(pieces, warnings)


def _roots(document: Document) -> list[Any]:
    scenes, nodes = document.listed("scenes"), document.listed("nodes")
    if scenes:
        roots = document.item("scenes", document.json.get("scene", 0)).get("nodes", [])
    else:
        children = {
            child for node in nodes if isinstance(node, dict) and isinstance(node.get("children"), list)
            for child in node["children"] if isinstance(child, int)
        }  # fmt: skip
        roots = [index for index in range(len(nodes)) if index not in children]
        if not roots:
            raise document.fail("has nodes but no root among them: the node graph has a cycle")
    if not isinstance(roots, list):
        raise document.fail("its scene has nodes that are no list")
    return roots


def _matrix(document: Document, node: dict[str, Any], what: str) -> NDArray[np.float64]:
    if "matrix" in node:
        return np.array(document.numbers(node["matrix"], 16, f"{what}.matrix")).reshape(4, 4).T
    result = np.eye(4)
    if "rotation" in node:
        x, y, z, w = document.numbers(node["rotation"], 4, f"{what}.rotation")
        length = (x * x + y * y + z * z + w * w) ** 0.5
        if length == 0:
            raise document.fail(f"{what}.rotation is zero, which is no rotation")
        x, y, z, w = x / length, y / length, z / length, w / length
        result[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    if "scale" in node:
        result[:3, :3] *= document.numbers(node["scale"], 3, f"{what}.scale")
    if "translation" in node:
        result[:3, 3] = document.numbers(node["translation"], 3, f"{what}.translation")
    return result


def _add_mesh(
    document: Document, index: Any, matrix: NDArray[np.float64], node: str, pieces: _Pieces
) -> None:
    mesh = document.item("meshes", index)
    mesh_name = printable(str(mesh.get("name") or f"mesh {index}"), longest=80)
    primitives = mesh.get("primitives", [])
    if not isinstance(primitives, list) or not all(isinstance(p, dict) for p in primitives):
        raise document.fail(f"meshes[{index}] has primitives that are no list of objects")
    linear = matrix[:3, :3]
    determinant = float(np.linalg.det(linear))
    size = float(np.abs(linear).max()) ** 3
    if not np.isfinite(determinant) or abs(determinant) <= 1e-12 * size or size == 0:
        raise document.fail(
            f"the node {node!r} has a scale of 0 (or beyond all numbers), which flattens its mesh; "
            "mend its transform"
        )
    for number, primitive in enumerate(primitives):
        what = f"meshes[{index}].primitives[{number}]"
        mode = document.whole(primitive, "mode", 4, what)
        if mode not in (4, 5, 6):
            name = _MODES.get(mode, f"unknown mode {mode}")
            pieces.skipped[name] = pieces.skipped.get(name, 0) + 1
            continue
        material = "no material"
        if primitive.get("material") is not None:
            entry = document.item("materials", primitive["material"])
            material = printable(str(entry.get("name") or f"material {primitive['material']}"), longest=80)
        faces = _add_primitive(document, primitive, mode, what, matrix, determinant < 0, pieces)
        for kind, name in (("material", material), ("node", node), ("mesh", mesh_name)):
            pieces.labels[kind].extend([name] if faces else [])


def _add_primitive(
    document: Document,
    primitive: dict[str, Any],
    mode: int,
    what: str,
    matrix: NDArray[np.float64],
    mirrored: bool,
    pieces: _Pieces,
) -> int:
    """Append a primitive's triangles; how many they are."""
    attributes = primitive.get("attributes")
    extensions = primitive.get("extensions")
    if not isinstance(attributes, dict) or "POSITION" not in attributes:
        raise document.fail(f"{what} has no POSITION")
    if isinstance(extensions, dict) and "KHR_draco_mesh_compression" in extensions:
        accessor = document.item("accessors", attributes["POSITION"])
        if accessor.get("bufferView") is None:
            raise document.fail(
                f"{what} is packed with KHR_draco_mesh_compression; export it without compression"
            )
    position = document.accessor(attributes["POSITION"], ("VEC3",)).astype(np.float64)
    if primitive.get("indices") is not None:
        index = document.accessor(primitive["indices"], ("SCALAR",))
        if index.dtype.kind != "u":
            raise document.fail(f"{what} has indices that are no whole numbers")
        index = index[:, 0].astype(np.int64)
    else:
        index = np.arange(len(position))
    if len(index) and index.max() >= len(position):
        raise document.fail(f"{what} refers to vertex {int(index.max())} of {len(position)}")
    triangles = _triangles(index, mode)
    if len(triangles) == 0:
        pieces.skipped["empty triangle lists"] = pieces.skipped.get("empty triangle lists", 0) + 1
        return 0
    pieces.face_count += len(triangles)
    check_face_count(pieces.face_count, document.where)
    if mirrored:
        triangles = triangles[:, [0, 2, 1]]
    corner = triangles.ravel()
    used = np.zeros(len(position), bool)
    used[corner] = True
    wrong = np.flatnonzero(used & ~np.isfinite(position).all(axis=1))
    if len(wrong):
        raise document.fail(
            f"{what} has {len(wrong)} vertices that are not finite; the first is vertex {int(wrong[0])}"
        )
    linear = matrix[:3, :3]
    pieces.vertices.append(position @ linear.T + matrix[:3, 3])
    pieces.corner.append(corner + pieces.vertex_count)
    pieces.vertex_count += len(position)
    uvs = []
    while len(uvs) < _MOST_UV_SETS and f"TEXCOORD_{len(uvs)}" in attributes:
        uv = document.accessor(attributes[f"TEXCOORD_{len(uvs)}"], ("VEC2",)).astype(np.float64)
        uv = _long_enough(document, uv, len(position), f"{what} TEXCOORD_{len(uvs)}")[corner]
        uvs.append(np.column_stack([uv[:, 0], 1 - uv[:, 1]]))
    pieces.uv_sets.append(uvs)
    normals = None
    if "NORMAL" in attributes:
        normals = document.accessor(attributes["NORMAL"], ("VEC3",)).astype(np.float64)
        normals = _long_enough(document, normals, len(position), f"{what} NORMAL") @ np.linalg.inv(linear)
        normals = normals[corner].astype(np.float64)
    pieces.normals.append(normals)
    pieces.attributes.append(_attributes(document, attributes, corner, len(position), what, pieces.notes))
    return len(triangles)


def _attributes(
    document: Document,
    named: dict[str, Any],
    corner: NDArray[np.int64],
    count: int,
    what: str,
    notes: list[str],
) -> dict[str, NDArray[np.float64]]:
    """Colours (``COLOR_0`` is ``color``) and an application's own numbers (``_WEAR`` is ``wear``) at the corners."""
    found: dict[str, NDArray[np.float64]] = {}
    for name in list(named)[:_MOST_ATTRIBUTES]:
        if name != "COLOR_0" and not (name.startswith("_") and len(name) > 1):
            continue
        key = "color" if name == "COLOR_0" else printable(name[1:].lower(), longest=80)
        try:
            values = document.accessor(named[name], ("SCALAR", "VEC2", "VEC3", "VEC4")).astype(np.float64)
            values = _long_enough(document, values, count, f"{what} {printable(name, longest=80)}")[corner]
        except MeshFileError as problem:
            notes.append(f"an attribute is ignored: {problem}")
            continue
        found[key] = values[:, 0] if values.shape[1] == 1 else values
    return found


def _triangles(index: NDArray[np.int64], mode: int) -> NDArray[np.int64]:
    if mode == 4:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    if len(index) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == 6:
        return np.column_stack([np.full(len(index) - 2, index[0]), index[1:-1], index[2:]])
    strip = np.column_stack([index[:-2], index[1:-1], index[2:]])
    strip[1::2] = strip[1::2][:, [1, 0, 2]]
    return strip


def _long_enough(document: Document, values: NDArray[Any], count: int, what: str) -> NDArray[Any]:
    if len(values) < count:
        raise document.fail(f"{what} has {len(values)} entries for {count} vertices")
    return values


def _gathered(pieces: _Pieces, warnings: list[str]) -> Polygons:
    sizes = [len(corner) for corner in pieces.corner]
    uv_sets = []
    for k in range(max(len(uvs) for uvs in pieces.uv_sets)):
        parts = [
            uvs[k] if k < len(uvs) else np.full((size, 2), np.nan)
            for uvs, size in zip(pieces.uv_sets, sizes, strict=True)
        ]
        uv_sets.append(np.concatenate(parts))
    normals = None
    if any(n is not None for n in pieces.normals):
        normals = np.concatenate(
            [np.full((s, 3), np.nan) if n is None else n for n, s in zip(pieces.normals, sizes, strict=True)]
        )
    labels = {}
    for kind, names in pieces.labels.items():
        unique = {name: k for k, name in enumerate(dict.fromkeys(names))}
        index = np.repeat([unique[name] for name in names], [size // 3 for size in sizes])
        labels[kind] = (index.astype(np.int32), tuple(unique))
    corner = np.concatenate(pieces.corner)
    attributes = {}
    for name in list(dict.fromkeys(name for each in pieces.attributes for name in each))[:_MOST_ATTRIBUTES]:
        have = [each[name] for each in pieces.attributes if name in each]
        if len({values.shape[1:] for values in have}) == 1:
            attributes[name] = np.concatenate(
                [
                    each.get(name, np.full((size, *have[0].shape[1:]), np.nan))
                    for each, size in zip(pieces.attributes, sizes, strict=True)
                ]
            )
    start = starts_of(np.full(len(corner) // 3, 3))
    return Polygons(
        np.concatenate(pieces.vertices), start, corner, uv_sets, normals, labels, 1000.0,
        [*warnings, *pieces.notes], attributes,
    )  # fmt: skip
