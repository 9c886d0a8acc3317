"""Damaged files: whatever bytes change, a file is a surface or one line of error, never another exception."""

import json
import warnings

import numpy as np
import pytest

from surftex.errors import InputError
from surftex.files.meshes import load
from tests.files.bad_inputs import ball, document, glb, glb_of, gltf, obj, off, ply, sheet, stl, stl_text
from tests.fuzz.damage import changed, damaged

V, F = ball(6, 4)
SEEDS = {
    "a.obj": obj(V, F, uv=V[:, :2], before="usemtl m\ng n\n"),
    "b.obj": obj(*sheet(2), after="f 1 2 3 4 5\n"),
    "a.stl": stl(V, F),
    "b.stl": stl_text(V, F),
    "a.ply": ply(V, F),
    "b.ply": b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
    b"property float y\nproperty float z\nelement face 2\nproperty list int int vertex_indices\nend_header\n"
    b"0 0 0\n1 0 0\n0 1 0\n"
    b"3 0 1 2\n4 0 1 2 0\n",
    "a.off": off(V, F),
    "a.glb": glb(V, F),
    "a.gltf": gltf(V, F),
}


def rich_document():
    """A glTF document that uses most of what is read."""
    doc, binary = document(V, F)
    attributes = doc["meshes"][0]["primitives"][0]["attributes"]
    attributes.update(NORMAL=0, TEXCOORD_0=2)
    doc["meshes"][0]["primitives"][0].update(material=0, mode=4)
    doc["materials"] = [{"name": "skin"}]
    doc["nodes"] = [
        {"mesh": 0, "name": "a", "children": [1]},
        {"mesh": 0, "scale": [1, 2, 3], "rotation": [0, 0, 0, 1], "translation": [9, 0, 0]},
        {"mesh": 0, "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 5, 5, 5, 1]},
    ]
    doc["scenes"][0]["nodes"] = [0, 2]
    doc["accessors"].append(
        {"bufferView": 0, "byteOffset": 4, "componentType": 5126, "count": len(V), "type": "VEC2"}
    )
    doc["accessors"][0]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": 1, "byteOffset": 8, "componentType": 5125},
        "values": {"bufferView": 0, "byteOffset": 12},
    }
    doc["bufferViews"][0]["byteStride"] = 12
    return doc, binary


@pytest.mark.parametrize("name", SEEDS)
def test_damage_is_a_surface_or_a_line(name, tmp_path):
    path = tmp_path / name
    fates = {"surface": 0, "refused": 0}
    for number in range(40):
        path.write_bytes(damaged(SEEDS[name], name, number))
        fates[fate(path, number)] += 1
    assert fates["refused"] > 5


def test_odd_documents_are_a_surface_or_a_line(tmp_path):
    path = tmp_path / "a.glb"
    doc, binary = rich_document()
    fates = {"surface": 0, "refused": 0}
    for number in range(200):
        path.write_bytes(glb_of(json.dumps(changed(doc, number)).encode(), binary))
        fates[fate(path, number)] += 1
    assert min(fates.values()) > 8


def fate(path, number):
    """What becomes of a file; an exception of the wrong kind passes through."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            surface = load(path, size="300 mm")
    except InputError as problem:
        line = str(problem)
        surface = None
    if surface is None:
        assert line.isprintable(), (number, line)
        return "refused"
    assert np.isfinite(surface.vertices).all(), number
    assert len(surface.fans[1]) == 3 * len(surface.faces), number
    return "surface"
