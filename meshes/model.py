"""What a generator returns: parts with names, glued by position only within themselves; and the three formats written."""

import json
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Part:
    """One body: vertices in millimetres, triangles, the material slot, and maybe UV for each vertex.

    `seam` lists, where UV need several places for one point, the point that each vertex is.
    """

    name: str
    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray | None = None


def write(path, parts):
    {".obj": write_obj, ".ply": write_ply, ".glb": write_glb}[Path(path).suffix](Path(path), parts)


def _numbers(row):
    return " ".join(
        f"{value:.3f}".rstrip("0").rstrip(".") if value else "0" for value in row.tolist()
    ).replace("-0 ", "0 ")


def write_obj(path, parts):
    """Points with a micrometre of precision, one `usemtl` group for each part; equal points are written once."""
    lines = [f"# surftex test mesh {path.stem}, millimetres, y up, MIT licence"]
    faces, base, base_uv = [], 1, 1
    for part in parts:
        rounded = np.round(part.vertices, 3) + 0.0
        if part.uv is None:
            unique, index = rounded, np.arange(len(rounded))
        else:
            unique, first, index = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
            order = np.argsort(first, kind="stable")
            place = np.zeros(len(order), int)
            place[order] = np.arange(len(order))
            unique, index = unique[order], place[index.ravel()]
        lines += ["v " + _numbers(row) for row in unique]
        faces.append(f"usemtl {part.name}")
        if part.uv is not None:
            lines += [f"vt {u:.5f} {v:.5f}" for u, v in part.uv.tolist()]
            faces += [
                "f " + " ".join(f"{p}/{t}" for p, t in zip(points, places, strict=True))
                for points, places in zip(
                    (index[part.faces] + base).tolist(), (part.faces + base_uv).tolist(), strict=True
                )
            ]
            base_uv += len(part.uv)
        else:
            faces += [f"f {a} {b} {c}" for a, b, c in (part.faces + base).tolist()]
        base += len(unique)
    path.write_text("\n".join(lines + faces) + "\n", encoding="ascii", newline="\n")


def write_ply(path, parts):
    """Binary, float32 millimetres, one body."""
    vertices = np.concatenate([part.vertices for part in parts]).astype("<f4")
    start = np.cumsum([0] + [len(part.vertices) for part in parts])
    faces = np.concatenate([part.faces + at for part, at in zip(parts, start[:-1], strict=True)])
    record = np.zeros(len(faces), dtype=[("n", "u1"), ("corner", "<i4", 3)])
    record["n"], record["corner"] = 3, faces
    header = (
        "ply\nformat binary_little_endian 1.0\ncomment surftex test mesh, millimetres, y up, MIT licence\n"
        f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(header.encode("ascii") + vertices.tobytes() + record.tobytes())


def write_glb(path, parts):
    """glTF binary in metres, one primitive and one material for each part."""
    chunks, views, accessors, primitives = [], [], [], []

    def store(array, target, kind, component, **extra):
        data = array.tobytes()
        data += b"\0" * (-len(data) % 4)
        views.append(
            {"buffer": 0, "byteOffset": sum(map(len, chunks)), "byteLength": array.nbytes, "target": target}
        )
        accessors.append(
            {
                "bufferView": len(views) - 1,
                "componentType": component,
                "count": len(array.reshape(-1)) if kind == "SCALAR" else len(array),
                "type": kind,
                **extra,
            }
        )
        chunks.append(data)
        return len(accessors) - 1

    for number, part in enumerate(parts):
        metres = (part.vertices / 1000.0).astype("<f4")
        attributes = {
            "POSITION": store(
                metres, 34962, "VEC3", 5126, min=metres.min(axis=0).tolist(), max=metres.max(axis=0).tolist()
            )
        }
        if part.uv is not None:
            down = np.column_stack([part.uv[:, 0], 1 - part.uv[:, 1]]).astype("<f4")
            attributes["TEXCOORD_0"] = store(down, 34962, "VEC2", 5126)
        wide = len(part.vertices) > 65535
        indices = store(
            part.faces.astype("<u4" if wide else "<u2").ravel(), 34963, "SCALAR", 5125 if wide else 5123
        )
        primitives.append({"attributes": attributes, "indices": indices, "material": number})
    binary = b"".join(chunks)
    tree = {
        "asset": {"version": "2.0", "generator": "surftex meshes", "copyright": "MIT licence"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": path.stem}],
        "meshes": [{"name": path.stem, "primitives": primitives}],
        "materials": [
            {"name": part.name, "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.6}}
            for part in parts
        ],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(tree, separators=(",", ":")).encode("ascii")
    text += b" " * (-len(text) % 4)
    path.write_bytes(
        struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(binary))
        + struct.pack("<II", len(text), 0x4E4F534A)
        + text
        + struct.pack("<II", len(binary), 0x004E4942)
        + binary
    )
