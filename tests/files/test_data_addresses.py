"""Buffers inside a glTF's own text: base64, or percent-encoded as RFC 2397 has it."""

import base64
import json
import struct
import urllib.parse

import pytest

from surftex.errors import MeshFileError
from surftex.files.meshes import load

POINTS = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)


def written(folder, uri):
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(POINTS)}],
        "buffers": [{"byteLength": len(POINTS), "uri": uri}],
    }
    (folder / "one.gltf").write_text(json.dumps(document))
    return folder / "one.gltf"


@pytest.mark.parametrize(
    "uri",
    [
        "data:application/octet-stream;base64," + base64.b64encode(POINTS).decode(),
        "data:;base64," + urllib.parse.quote(base64.b64encode(POINTS).decode(), safe=""),
        "data:application/octet-stream," + urllib.parse.quote_from_bytes(POINTS),
    ],
)
def test_a_buffer_inside_the_text_is_read(tmp_path, uri):
    assert load(written(tmp_path, uri)).area_mm2 == pytest.approx(0.5e6)


@pytest.mark.parametrize(
    ("uri", "said"),
    [
        ("data:nothing", "has a data address without a comma"),
        ("data:;base64,A", "has base64 data that does not decode"),
        ("data:,%00%01", "declares 36 bytes and has 2"),
    ],
)
def test_a_data_address_that_is_wrong_is_told(tmp_path, uri, said):
    with pytest.raises(MeshFileError, match=said):
        load(written(tmp_path, uri))
