"""Painted and computed numbers of mesh files: PLY properties, colours of OBJ, ``COLOR_0`` and ``_NAME`` of GLB."""

import json
import struct

import numpy as np

from surftex.files.meshes import load

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.uint16)
COLORS = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 51]], np.uint8)
WEAR = np.array([0.0, 0.25, 0.5, 1.0], np.float32)
RECORDS = list(zip(CORNERS, COLORS, WEAR, strict=True))


def at_corners(surface, values):
    """What the corners of a surface must hold, by their places in the file."""
    place = (surface.vertices + surface.origin_mm) / surface.mm_per_unit
    index = np.linalg.norm(place[:, None] - CORNERS, axis=2).argmin(axis=1)
    return np.asarray(values)[index][surface.faces]


def test_properties_of_ply(tmp_path):
    rows = [f"{x} {y} {z} {r} {g} {b} {w} {w} 2 0" for (x, y, z), (r, g, b), w in RECORDS]
    head = ["ply", "format ascii 1.0", "element vertex 4", *(f"property float {name}" for name in "xyz")]
    head += [f"property uchar {name}" for name in ("red", "green", "blue")] + ["property float wear"]
    head += [f"property float flow_{axis}" for axis in "xyz"]
    head += ["element face 2", "property list uchar int vertex_indices", "property int kind", "end_header"]
    text = "\n".join([*head, *rows, "3 0 1 2 7", "3 0 2 3 9", ""])
    (tmp_path / "a.ply").write_text(text)
    surface = load(tmp_path / "a.ply", units="mm")
    np.testing.assert_allclose(surface.attributes["color"], at_corners(surface, COLORS / 255))
    np.testing.assert_allclose(surface.attributes["wear"], at_corners(surface, WEAR))
    np.testing.assert_allclose(
        surface.attributes["flow"], at_corners(surface, np.stack([WEAR, 0 * WEAR + 2, 0 * WEAR], axis=1))
    )
    first = (at_corners(surface, WEAR) == 0.25).any(axis=1)
    np.testing.assert_array_equal(surface.attributes["kind"][:, 0], np.where(first, 7, 9))


def test_colours_of_obj(tmp_path):
    rows = [f"v {x} {y} {z} {r} {g} {b}" for (x, y, z), (r, g, b) in zip(CORNERS, COLORS / 255, strict=True)]
    (tmp_path / "a.obj").write_text("\n".join([*rows, "f 1 2 3", "f 1 3 4", ""]))
    surface = load(tmp_path / "a.obj", units="mm")
    np.testing.assert_allclose(surface.attributes["color"], at_corners(surface, COLORS / 255))


def test_colours_and_own_numbers_of_glb(tmp_path):
    padded = np.column_stack([COLORS, np.full(4, 255, np.uint8)])
    parts = [CORNERS.tobytes(), padded.tobytes(), WEAR.tobytes(), FACES.tobytes()]
    start = np.concatenate([[0], np.cumsum([len(part) for part in parts])])
    kinds = [(5126, "VEC3", 4), (5121, "VEC4", 4), (5126, "SCALAR", 4), (5123, "SCALAR", 6)]
    accessors = [
        {"bufferView": i, "componentType": kind, "type": width, "count": count}
        for i, (kind, width, count) in enumerate(kinds)
    ]
    accessors[1]["normalized"] = True
    accessors[0].update(min=[0, 0, 0], max=[1, 1, 0])
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1, "_WEAR": 2}, "indices": 3}]}],
        "accessors": accessors,
        "bufferViews": [
            {"buffer": 0, "byteOffset": int(start[i]), "byteLength": len(part)}
            for i, part in enumerate(parts)
        ],
        "buffers": [{"byteLength": int(start[-1])}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    held = b"".join(parts)
    chunks = (
        struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(held), 0x004E4942) + held
    )
    (tmp_path / "a.glb").write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)
    surface = load(tmp_path / "a.glb")
    np.testing.assert_allclose(surface.attributes["color"], at_corners(surface, padded / 255), atol=1e-6)
    np.testing.assert_allclose(surface.attributes["wear"], at_corners(surface, WEAR))
