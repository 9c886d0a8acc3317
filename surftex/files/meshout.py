"""Plain meshes out: OBJ, PLY and STL in millimetres, GLB in metres. Same mesh, same bytes."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError, WorkError
from surftex.files.scaling import OWN_COMMENT
from surftex.interrupts import undisturbed
from surftex.surface.weld import equal_rows

SUFFIXES = (".obj", ".ply", ".stl", ".glb")
"""Formats that `write_mesh` knows."""


def write_mesh(
    path: str | Path,
    vertices: NDArray[np.float64],
    faces: NDArray[np.int32],
    corner_uv: NDArray[np.float64] | None = None,
    pictures: Mapping[str, str] | None = None,
) -> None:
    """Write triangles in the format that the path ends in.

    Parameters
    ----------
    path : path
        Ends in one of `SUFFIXES`. An existing file is replaced: `surftex.files.output` makes that safe.
    vertices : (n, 3) float64
        Millimetres.
    faces : (k, 3) int32
        Counter-clockwise seen from outside.
    corner_uv : (k, 3, 2) float64, optional
        For OBJ, where it leaves the vertices whole, and GLB, whose vertices part at seams.
    pictures : mapping of str to str, optional
        For GLB: names of files beside it, of ``base_color`` and ``roughness``.

    Raises
    ------
    InputError
        If the format is unknown.
    WorkError
        If the file cannot be written.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise InputError(f"{path.name}: no mesh format that can be written; it takes {', '.join(SUFFIXES)}")
    if kind == ".stl":
        data = _stl(vertices, faces)
    elif kind == ".ply":
        data = _ply(vertices, faces)
    elif kind == ".obj":
        data = _obj(vertices, faces, corner_uv)
    else:
        data = _glb(path.stem, vertices, faces, corner_uv, pictures or {})
    try:
        path.write_bytes(data)
    except OSError as problem:
        raise WorkError(f"{path.name}: cannot write: {problem.strerror or problem}") from None


def _stl(vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> bytes:
    """Pack binary STL."""
    rows = np.zeros(len(faces), [("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("note", "<u2")])
    rows["corner"] = vertices[faces]
    corner = rows["corner"].astype(np.float64)
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    rows["normal"] = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0)
    return OWN_COMMENT.encode().ljust(80) + len(faces).to_bytes(4, "little") + rows.tobytes()


def _ply(vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> bytes:
    """Pack binary PLY."""
    header = (
        f"ply\nformat binary_little_endian 1.0\ncomment {OWN_COMMENT}\n"
        f"element vertex {len(vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.zeros(len(faces), [("count", "u1"), ("corner", "<i4", 3)])
    rows["count"], rows["corner"] = 3, faces
    return header.encode() + vertices.astype("<f4").tobytes() + rows.tobytes()


def _obj(
    vertices: NDArray[np.float64], faces: NDArray[np.int32], corner_uv: NDArray[np.float64] | None
) -> bytes:
    """Pack OBJ text, to a tenth of a micrometre."""
    parts = [f"# {OWN_COMMENT}\n", _lines("v %.4f %.4f %.4f\n", vertices)]
    if corner_uv is None:
        parts.append(_lines("f %d %d %d\n", faces + 1))
    else:
        place = np.round(corner_uv.reshape(-1, 2), 7)
        number = equal_rows(place)
        first = np.unique(number, return_index=True)[1]
        parts.append(_lines("vt %.7f %.7f\n", place[first]))
        both = np.stack([faces, number.reshape(-1, 3)], axis=2).reshape(-1, 6) + 1
        parts.append(_lines("f %d/%d %d/%d %d/%d\n", both))
    return "".join(parts).encode()


def _lines(form: str, rows: NDArray[Any]) -> str:
    """Format rows a block at a time."""
    block = 100_000
    texts = []
    for first in range(0, len(rows), block):
        piece = rows[first : first + block]
        texts.append(form * len(piece) % tuple(piece.ravel().tolist()))
    return "".join(texts)


def _glb(
    name: str, vertices: NDArray[np.float64], faces: NDArray[np.int32], corner_uv: NDArray[np.float64] | None,
    pictures: Mapping[str, str],
) -> bytes:  # fmt: skip
    """Pack GLB with smooth normals; vertices that differ only in UV look alike."""
    with undisturbed():  # trimesh takes an interrupt for a failure of a library, and goes on another way
        import trimesh
        from trimesh.visual import TextureVisuals
        from trimesh.visual.material import PBRMaterial

        mesh = trimesh.Trimesh(vertices / 1000, faces, process=False)
        if corner_uv is not None:
            corner = np.concatenate(
                [faces.reshape(-1, 1).astype(np.float64), corner_uv.reshape(-1, 2)], axis=1
            )
            number = equal_rows(corner)
            first = np.unique(number, return_index=True)[1]
            vertex = faces.ravel()[first]
            normals = mesh.vertex_normals[vertex]
            mesh = trimesh.Trimesh(
                vertices[vertex] / 1000, number.reshape(-1, 3), vertex_normals=normals, process=False
            )
            mesh.visual = TextureVisuals(corner[first, 1:], PBRMaterial(name, metallicFactor=0.0))
        else:
            mesh.vertex_normals  # noqa: B018 (trimesh exports normals once they have been asked for)
        scene = trimesh.Scene()
        scene.add_geometry(mesh, node_name=name, geom_name=name)
        data = scene.export(file_type="glb", include_normals=True)
    if not isinstance(data, bytes):
        raise TypeError(f"trimesh exported a glb as {type(data).__name__}, not as bytes")
    return _dressed(data, pictures) if pictures and corner_uv is not None else data


def _dressed(data: bytes, pictures: Mapping[str, str]) -> bytes:
    """Wire the material of a GLB to pictures beside it; what is no metal reads roughness from a grey picture."""
    from pygltflib import GLTF2, Image, Sampler, Texture, TextureInfo

    document: Any = GLTF2().load_from_bytes(data)
    document.samplers = [Sampler(magFilter=9729, minFilter=9987, wrapS=33071, wrapT=33071)]
    document.images = [Image(name=role, uri=quote(file)) for role, file in pictures.items()]
    document.textures = [Texture(name=role, sampler=0, source=i) for i, role in enumerate(pictures)]
    at = {role: TextureInfo(index=i) for i, role in enumerate(pictures)}
    look = document.materials[0].pbrMetallicRoughness
    look.baseColorTexture, look.metallicRoughnessTexture = at.get("base_color"), at.get("roughness")
    look.baseColorFactor = [1.0] * 4 if "base_color" in at else look.baseColorFactor
    look.roughnessFactor = 1.0 if "roughness" in at else 0.6
    return b"".join(document.save_to_bytes())
