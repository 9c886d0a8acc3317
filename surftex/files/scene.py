"""glTF with its pictures, for drawing: bodies with vertices as the file has them, and their materials."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import MeshFileError
from surftex.files.decoding import decoded, kind_of
from surftex.files.gltf import _beside, _buffer, _parted
from surftex.files.gltfaccessor import Document
from surftex.files.gltfscene import _matrix, _roots, _triangles
from surftex.files.reading import printable, read_bytes


@dataclass(frozen=True, eq=False)
class Body:
    """One primitive of a scene.

    Attributes
    ----------
    vertices : (n, 3) float64
        Millimetres.
    faces : (m, 3) int32
        Counter-clockwise seen from outside.
    normals : (n, 3) float64 or None
        Unit length.
    tangents : (n, 4) float64 or None
        Unit length; the last is the sign of the bitangent.
    uv : (n, 2) float64 or None
        As in glTF: v runs down.
    material : str
        Its name.
    factors : dict
        ``base_color`` (3,) linear, ``roughness``, ``metallic``, ``specular`` (3,): F0 = 0.04 times it.
    pictures : dict of str to (h, w, c) uint8 or uint16
        Some of ``base_color`` (sRGB codes), ``orm``, ``normal``, ``specular`` (sRGB codes).
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    normals: NDArray[np.float64] | None
    tangents: NDArray[np.float64] | None
    uv: NDArray[np.float64] | None
    material: str
    factors: dict[str, Any]
    pictures: dict[str, NDArray[Any]]


def read_scene(path: str | os.PathLike[str]) -> list[Body]:
    """Read the triangles of a GLB or glTF file with what they should look like.

    Parameters
    ----------
    path : path
        Of the file; pictures and buffers may lie within its folder.

    Returns
    -------
    bodies : list of Body
        One for each primitive with triangles, in the place where the scene has it.

    Raises
    ------
    MeshFileError
        If the file is broken.
    """
    try:
        with np.errstate(all="ignore"):
            return _bodies(path)
    except (
        TypeError,
        ValueError,
        KeyError,
        IndexError,
        AttributeError,
        OverflowError,
        np.linalg.LinAlgError,
    ) as problem:
        if isinstance(problem, MeshFileError):
            raise
        shown = printable(os.fspath(path))
        raise MeshFileError(
            f"{shown}: holds what no glTF file may ({printable(str(problem), longest=80)})"
        ) from None


def _bodies(path: str | os.PathLike[str]) -> list[Body]:
    """Walk the nodes of a file and read what hangs on them."""
    import json

    where, folder = printable(os.fspath(path)), Path(path).parent
    data = read_bytes(path)
    text, chunk = _parted(data, where) if data[:4] == b"glTF" else (data, None)
    try:
        tree = json.loads(text)
    except (ValueError, RecursionError):
        raise MeshFileError(f"{where}: its JSON does not parse") from None
    if not isinstance(tree, dict):
        raise MeshFileError(f"{where}: its JSON is no glTF document")
    document = Document(tree, [], where)
    document.buffers = [_buffer(document, i, chunk, folder) for i in range(len(document.listed("buffers")))]
    looks: dict[int, tuple[str, dict[str, Any], dict[str, NDArray[Any]]]] = {}
    bodies: list[Body] = []
    pending = [(root, np.eye(4)) for root in reversed(_roots(document))]
    seen: set[int] = set()
    while pending:
        index, above = pending.pop()
        node = document.item("nodes", index)
        if index in seen:
            raise document.fail(f"nodes[{index}] is reached twice")
        seen.add(index)
        placed = above @ _matrix(document, node, f"nodes[{index}]")
        if node.get("mesh") is not None:
            for primitive in document.item("meshes", node["mesh"]).get("primitives", []):
                which = primitive.get("material", -1)
                if which not in looks:
                    looks[which] = _look(document, which, folder)
                body = _body(document, primitive, placed, *looks[which])
                bodies += [body] if body is not None else []
        pending += [(child, placed) for child in reversed(node.get("children", []))]
    if not bodies:
        raise document.fail("has no triangles")
    return bodies


def _body(
    document: Document,
    primitive: dict[str, Any],
    matrix: NDArray[np.float64],
    name: str,
    factors: dict[str, Any],
    pictures: dict[str, NDArray[Any]],
) -> Body | None:
    """Read one primitive, if it has triangles."""
    mode, attributes = primitive.get("mode", 4), primitive.get("attributes", {})
    if mode not in (4, 5, 6):
        return None

    def read(role: str, kinds: tuple[str, ...]) -> NDArray[np.float64] | None:
        return document.accessor(attributes[role], kinds).astype(np.float64) if role in attributes else None

    position = read("POSITION", ("VEC3",))
    if position is None:
        raise document.fail("a primitive has no POSITION")
    if primitive.get("indices") is None:
        index = np.arange(len(position))
    else:
        index = document.accessor(primitive["indices"], ("SCALAR",))[:, 0].astype(np.int64)
    triangles = _triangles(index, mode)
    if len(triangles) == 0:
        return None
    if triangles.max() >= len(position):
        raise document.fail(f"a primitive refers to vertex {int(triangles.max())} of {len(position)}")
    linear = matrix[:3, :3]
    if np.linalg.det(linear) < 0:
        triangles = triangles[:, [0, 2, 1]]
    normals, tangents = read("NORMAL", ("VEC3",)), read("TANGENT", ("VEC4",))
    if normals is not None:
        normals = _unit(normals @ np.linalg.inv(linear))
    if tangents is not None:
        tangents = np.column_stack([_unit(tangents[:, :3] @ linear.T), tangents[:, 3]])
    return Body(
        vertices=1000 * (position @ linear.T + matrix[:3, 3]),
        faces=triangles.astype(np.int32),
        normals=normals,
        tangents=tangents,
        uv=read("TEXCOORD_0", ("VEC2",)),
        material=name,
        factors=factors,
        pictures=pictures,
    )


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-30)


def _look(
    document: Document, index: int, folder: Path
) -> tuple[str, dict[str, Any], dict[str, NDArray[Any]]]:
    """Name, factors and pictures of a material."""
    entry = {} if index == -1 else document.item("materials", index)
    metal = entry.get("pbrMetallicRoughness", {})
    shine = entry.get("extensions", {}).get("KHR_materials_specular", {})
    factors = {
        "base_color": np.array(metal.get("baseColorFactor", [0.6, 0.6, 0.6, 1.0])[:3], float),
        "roughness": float(metal.get("roughnessFactor", 1.0)),
        "metallic": float(metal.get("metallicFactor", 1.0 if "metallicRoughnessTexture" in metal else 0.0)),
        "specular": np.array(shine.get("specularColorFactor", [1.0] * 3), float)
        * shine.get("specularFactor", 1.0),
        "occluded": "occlusionTexture" in entry,
    }
    wired = {
        "base_color": metal.get("baseColorTexture"),
        "orm": metal.get("metallicRoughnessTexture"),
        "normal": entry.get("normalTexture"),
        "specular": shine.get("specularColorTexture"),
    }
    pictures = {
        role: _picture(document, texture["index"], folder) for role, texture in wired.items() if texture
    }
    name = printable(str(entry.get("name") or "material"), longest=80)
    return name, factors, {role: image for role, image in pictures.items() if image is not None}


def _picture(document: Document, texture: Any, folder: Path) -> NDArray[Any] | None:
    """Decode a picture of a texture; None where it has a format that is not read."""
    source = document.item("textures", texture).get("source")
    if source is None:
        return None
    image = document.item("images", source)
    if image.get("bufferView") is not None:
        data = bytes(document.view(image["bufferView"])[0])
    else:
        data = read_bytes(
            _beside(document, str(image.get("uri", "")), f"images[{source}]", folder), purpose="picture"
        )
    if kind_of(data) not in ("PNG", "JPEG"):
        return None
    pixels = decoded(data, f"{document.where}: images[{source}]", error=MeshFileError, as_stored=True)
    if pixels.ndim == 2:
        pixels = np.repeat(pixels[..., None], 3, axis=2)
    return pixels[..., :3]
