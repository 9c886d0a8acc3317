"""GLB: a mesh with its unwrap, tangents and maps, for any glTF 2.0 viewer.

Metres; one vertex per distinct corner; one primitive and one material per part, all with the same textures.
The embedded PNGs are the bytes of the files on disk, the normal map with its 16 bits: readers that know only
8 drop the rest. Occlusion, roughness and metallic share one picture. `specular` is F0 / 0.08, as in other
tools; here it becomes the colour of KHR_materials_specular, times two. Displacement is no part of glTF: the
name, unit and range of the height map stand in the material's extras.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.surface.surface import Surface
from surftex.surface.weld import equal_rows

TEXTURES = ("base_color", "orm", "normal", "specular_color")
"""Pictures that a GLB can carry; ``orm`` holds occlusion, roughness and metallic in red, green and blue."""

_FAR = 100.0
_FLOAT, _SHORT, _INT = 5126, 5123, 5125
_VERTICES, _INDICES = 34962, 34963


@dataclass
class _Buffer:
    """The binary chunk of a GLB while it grows."""

    document: Any
    parts: list[bytes] = field(default_factory=list)
    size: int = 0

    def view(self, data: bytes, target: int | None = None) -> int:
        """Append bytes on a boundary of four; the number of their view."""
        from pygltflib import BufferView

        self.document.bufferViews.append(
            BufferView(buffer=0, byteOffset=self.size, byteLength=len(data), target=target)
        )
        padding = b"\0" * (-len(data) % 4)
        self.parts += [data, padding]
        self.size += len(data) + len(padding)
        return len(self.document.bufferViews) - 1

    def accessor(
        self, array: NDArray[Any], kind: str, component: int, target: int, *, bounds: bool = False
    ) -> int:
        """Append an array; the number of its accessor."""
        from pygltflib import Accessor

        view = self.view(array.tobytes(), target)
        self.document.accessors.append(
            Accessor(
                bufferView=view,
                componentType=component,
                count=len(array),
                type=kind,
                min=array.min(axis=0).tolist() if bounds else None,
                max=array.max(axis=0).tolist() if bounds else None,
            )
        )
        return len(self.document.accessors) - 1


def glb_bytes(
    surface: Surface,
    corner_uv: NDArray[np.float64],
    tangents: NDArray[np.float64],
    pictures: Mapping[str, bytes | str],
    *,
    tile: NDArray[np.integer] | None = None,
    name: str | None = None,
    occluded: bool = False,
    extras: Mapping[str, Mapping[str, Any]] | None = None,
) -> bytes:
    """Pack a surface with its maps.

    Parameters
    ----------
    surface : Surface
        m faces; the origin that was taken off is added again.
    corner_uv : (m, 3, 2) float
        The unwrap; v up.
    tangents : (m, 3, 4) float
        Of `surftex.maps.normal.surface_tangents`.
    pictures : mapping of str to bytes or str
        PNG files by what they hold, some of `TEXTURES`: their bytes, to have inside, or the names of files beside.
        Those of several pages end in a point and its UDIM number.
    tile : (m,) int, optional
        UDIM number of each face's page, where there are several: each has materials of its own.
    name : str, optional
        Stem of the names of mesh and pictures; the surface's without it.
    occluded : bool
        Whether red of ``orm`` holds ambient occlusion.
    extras : mapping, optional
        Kept in the materials of each page, by its number, "" for the only one: plain JSON.

    Returns
    -------
    data : bytes
        A whole GLB file; the same input gives the same bytes.

    Raises
    ------
    InputError
        If a picture has a role that no texture has.
    """
    import pygltflib

    unknown = sorted({role.partition(".")[0] for role in pictures} - set(TEXTURES))
    if unknown:
        raise InputError(f"pictures holds {unknown[0]!r}; a GLB takes {', '.join(TEXTURES)}")
    name = surface.name if name is None else name
    document = pygltflib.GLTF2()
    document.asset = pygltflib.Asset(version="2.0", generator="surftex")
    buffer = _Buffer(document)
    shift, offset = _placed(surface)
    pages = np.zeros(len(surface.faces), np.int64) if tile is None else np.asarray(tile, np.int64)
    used = [
        (int(part), int(page)) for part, page in np.unique(np.stack([surface.part, pages], axis=1), axis=0)
    ]
    slot = surface.slot_names(name)
    primitives = [
        _primitive(
            buffer, surface, corner_uv if page == 0 else corner_uv - _origin(page), tangents,
            np.flatnonzero((surface.part == part) & (pages == page)), offset, material,
        )
        for material, (part, page) in enumerate(used)
    ]  # fmt: skip
    textures = _textures(buffer, pictures, name)
    numbers = {role.partition(".")[2] for role in pictures} | set(extras or {})
    one = numbers.pop() if len(numbers) == 1 else ""
    document.materials = []
    for part, page in used:
        number = str(page) if page else one
        suffix = f".{number}" if number else ""
        own = {role: textures[role + suffix] for role in TEXTURES if role + suffix in textures}
        label = slot[part] + (f".{page}" if page else "")
        document.materials.append(_material(label, own, occluded, (extras or {}).get(number)))
    if any(role.startswith("specular_color") for role in textures):
        document.extensionsUsed = ["KHR_materials_specular"]
    document.meshes = [pygltflib.Mesh(name=name, primitives=primitives)]
    document.nodes = [pygltflib.Node(name=name, mesh=0, translation=shift)]
    document.scenes = [pygltflib.Scene(nodes=[0])]
    document.scene = 0
    document.buffers = [pygltflib.Buffer(byteLength=buffer.size)]
    document.set_binary_blob(b"".join(buffer.parts))
    return b"".join(document.save_to_bytes())


def _origin(tile: int) -> NDArray[np.float64]:
    """Lower left corner of a UDIM page."""
    return np.array([(tile - 1001) % 10, (tile - 1001) // 10], np.float64)


def _placed(surface: Surface) -> tuple[list[float] | None, NDArray[np.float64]]:
    """Choose a translation of the node in metres, or millimetres to add to the vertices.

    The origin goes into the vertices, unless it lies so far off that their float32 would lose fine detail.
    """
    if far_origin(surface):
        return (surface.origin_mm / 1000).tolist(), np.zeros(3)
    return None, surface.origin_mm


def far_origin(surface: Surface) -> bool:
    """Tell whether a mesh lies so far from the origin of its file that float32 would lose fine detail.

    Parameters
    ----------
    surface : Surface
        Any.

    Returns
    -------
    far : bool
        Then its place belongs into a transform.
    """
    return bool(np.abs(surface.origin_mm).max() > _FAR * np.ptp(surface.vertices, axis=0).max())


def _primitive(
    buffer: _Buffer,
    surface: Surface,
    corner_uv: NDArray[np.float64],
    tangents: NDArray[np.float64],
    face: NDArray[np.int64],
    offset_mm: NDArray[np.float64],
    material: int,
) -> Any:
    """Pack a part: its distinct corners, and triangles between them."""
    from pygltflib import Attributes, Primitive

    position = (surface.vertices + offset_mm)[surface.faces[face]] / 1000
    uv = corner_uv[face] * [1.0, -1.0] + [0.0, 1.0]
    parts = (position, surface.shading_normal[face], tangents[face], uv)
    rows = np.concatenate(parts, axis=2).reshape(-1, 12).astype(np.float32)
    number = equal_rows(rows)
    first = np.zeros(int(number.max()) + 1, np.int64)
    first[number[::-1]] = np.arange(len(number))[::-1]
    vertex = rows[first]
    narrow = len(vertex) < 65535
    index = number.astype(np.uint16 if narrow else np.uint32)
    column = {"POSITION": (0, 3), "NORMAL": (3, 6), "TANGENT": (6, 10), "TEXCOORD_0": (10, 12)}
    accessors = {
        role: buffer.accessor(
            np.ascontiguousarray(vertex[:, a:b]), f"VEC{b - a}", _FLOAT, _VERTICES, bounds=role == "POSITION"
        )
        for role, (a, b) in column.items()
    }
    indices = buffer.accessor(index, "SCALAR", _SHORT if narrow else _INT, _INDICES)
    return Primitive(attributes=Attributes(**accessors), indices=indices, material=material, mode=4)


def _textures(buffer: _Buffer, pictures: Mapping[str, bytes | str], name: str) -> dict[str, int]:
    """Embed or name the pictures; number the textures by role."""
    from pygltflib import Image, Sampler, Texture

    document = buffer.document
    result = {}
    if pictures:
        document.samplers = [Sampler(magFilter=9729, minFilter=9987, wrapS=33071, wrapT=33071)]
    for base in TEXTURES:
        for role in sorted(role for role in pictures if role.partition(".")[0] == base):
            picture = pictures[role]
            own: dict[str, Any] = (
                {"uri": quote(picture)}
                if isinstance(picture, str)
                else {"mimeType": "image/png", "bufferView": buffer.view(picture)}
            )
            document.images.append(Image(name=f"{name}_{role}", **own))
            document.textures.append(
                Texture(name=f"{name}_{role}", sampler=0, source=len(document.images) - 1)
            )
            result[role] = len(document.textures) - 1
    return result


def _material(
    name: str, textures: Mapping[str, int], occluded: bool, extras: Mapping[str, Any] | None
) -> Any:
    """Wire the textures."""
    from pygltflib import (
        Material,
        NormalMaterialTexture,
        OcclusionTextureInfo,
        PbrMetallicRoughness,
        TextureInfo,
    )

    def info(role: str) -> Any:
        return TextureInfo(index=textures[role]) if role in textures else None

    surface = PbrMetallicRoughness(
        baseColorFactor=[1.0, 1.0, 1.0, 1.0] if "base_color" in textures else [0.5, 0.5, 0.5, 1.0],
        baseColorTexture=info("base_color"),
        metallicRoughnessTexture=info("orm"),
        metallicFactor=1.0 if "orm" in textures else 0.0,
        roughnessFactor=1.0 if "orm" in textures else 0.6,
    )
    material = Material(
        name=name, pbrMetallicRoughness=surface, alphaMode="OPAQUE", extras=dict(extras or {})
    )
    material.alphaCutoff = None
    if "normal" in textures:
        material.normalTexture = NormalMaterialTexture(index=textures["normal"])
    if occluded and "orm" in textures:
        material.occlusionTexture = OcclusionTextureInfo(index=textures["orm"])
    if "specular_color" in textures:
        color = {
            "specularColorFactor": [2.0, 2.0, 2.0],
            "specularColorTexture": {"index": textures["specular_color"]},
        }
        material.extensions = {"KHR_materials_specular": color}
    return material
