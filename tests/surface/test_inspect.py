"""Descriptions agree with closed forms."""

import json

import numpy as np
import pytest

from surftex.files.meshes import load
from surftex.surface.inspect import describe
from surftex.surface.shapes import cylinder, plane, sphere, torus
from surftex.surface.surface import Surface


@pytest.mark.parametrize(
    ("shape", "genus", "euler", "loops"),
    [(sphere(), 0, 2, 0), (torus(), 1, 0, 0), (cylinder(), 0, 0, 2), (plane(), 0, 1, 1)],
    ids=["sphere", "torus", "cylinder", "plane"],
)
def test_topology(shape, genus, euler, loops):
    description = describe(shape)
    assert (description.genus, description.euler_characteristic, description.border_loops) == (
        genus,
        euler,
        loops,
    )
    assert description.components == 1
    assert description.closed_components == (loops == 0)


def test_sizes_of_a_ball():
    description = describe(sphere(40, subdivisions=4))
    assert description.area_mm2 == pytest.approx(4 * np.pi * 1600, rel=0.01)
    assert description.volume_mm3 == pytest.approx(4 / 3 * np.pi * 64000, rel=0.01)
    assert max(description.size_mm) == pytest.approx(80, rel=0.01)


def test_the_span_is_told_in_coordinates_of_the_file(tmp_path):
    corners = np.array([[100, -5, 7], [130, -5, 7], [100, 15, 7.5]])
    rows = [f"v {x} {y} {z}" for x, y, z in corners / 10]
    (tmp_path / "flat.obj").write_text("\n".join([*rows, "f 1 2 3"]))
    span = describe(load(tmp_path / "flat.obj", units="cm")).span_mm
    assert list(span) == ["x", "y", "z"]
    np.testing.assert_allclose(list(span.values()), [(100, 130), (-5, 15), (7, 7.5)], atol=1e-9)


def test_lengths_of_a_square():
    description = describe(plane(10, cells=5))
    assert description.border_length_mm == pytest.approx(40)
    assert description.volume_mm3 is None
    assert description.edges == 5 * 6 * 2 + 25
    assert description.edge_length_mm["least"] == pytest.approx(2)
    assert description.edge_length_mm["longest"] == pytest.approx(8**0.5)
    assert description.smallest_angle_degrees == pytest.approx(45)
    assert description.slivers == 0


def test_the_state_of_the_own_uv():
    square = plane(10, cells=5)
    assert describe(sphere()).own_uv == {"state": "none"}
    uv = describe(square).own_uv
    assert (uv["state"], uv["mirrored_faces"], uv["flat_faces"]) == ("inside 0..1", 0, 0)
    assert uv["area"] == pytest.approx(1)
    mirrored = np.array(square.corner_uv)
    mirrored[:10, :, 0] = 3 - mirrored[:10, :, 0]
    mirrored[20] = 0.5
    uv = describe(Surface.from_arrays(square.vertices, square.faces, corner_uv=mirrored)).own_uv
    assert (uv["state"], uv["mirrored_faces"], uv["flat_faces"]) == ("leaves 0..1", 10, 1)


def test_parts_and_warnings_go_into_json():
    flat = plane(10, cells=2)
    surface = Surface.from_arrays(
        flat.vertices, flat.faces, part=[0] * 6 + [1] * 2, part_names=("a", "b"), warnings=("mended",)
    )
    values = json.loads(json.dumps(describe(surface).as_dict()))
    assert [p["faces"] for p in values["parts"]] == [6, 2]
    assert [p["area_mm2"] for p in values["parts"]] == pytest.approx([75, 25])
    assert values["warnings"] == ["mended"]
