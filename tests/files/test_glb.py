"""GLB files: right by Khronos' validator, and what comes back is what went in."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pygltflib
import pytest

from surftex.charts.atlas import Atlas
from surftex.charts.unwrap import unwrap
from surftex.errors import InputError
from surftex.files.glb import glb_bytes
from surftex.files.images import png_bytes
from surftex.maps.normal import surface_tangents
from surftex.surface.shapes import cylinder, plane, sphere, torus
from surftex.surface.surface import Surface


def pictures(roles=("base_color", "orm", "normal", "specular_color")):
    random = np.random.RandomState(0)
    result = {}
    for role in roles:
        shape = (8, 8) if role == "specular_color" else (8, 8, 3)
        dtype = np.uint16 if role == "normal" else np.uint8
        result[role] = png_bytes(random.randint(0, 256, shape).astype(dtype))
    return result


def parted_ball(origin_mm=(1.0, 2.0, 3.0)):
    ball = sphere(20.0, subdivisions=2)
    names = ("upper", "unused", "sole")
    part = 2 * (ball.vertices[ball.faces][..., 2].mean(axis=1) < 0)
    return Surface.from_arrays(ball.vertices, ball.faces, part=part, part_names=names, origin_mm=origin_mm)


def test_one_part_of_a_file_keeps_its_name_and_a_whole_file_of_one_is_called_by_its_stem():
    for selected, name in ((False, "shoe"), (True, "sole")):
        ball = sphere(20.0, subdivisions=2)
        surface = Surface.from_arrays(ball.vertices, ball.faces, part_names=("sole",), selected=selected)
        document = pygltflib.GLTF2.load_from_bytes(packed(surface, name="shoe")[0])
        assert [material.name for material in document.materials] == [name]


def faceted():
    """More corners than 16 bits can number, each a vertex of its own."""
    ring = torus(columns=150, rows=120)
    normal = np.repeat(ring.frame[:, None, 2], 3, axis=1)
    return Surface.from_arrays(ring.vertices, ring.faces, corner_normal=normal, name="ring")


def packed(surface, roles=("base_color", "orm", "normal", "specular_color"), **options):
    atlas = unwrap(surface, method="uvunwrap", resolution=256)
    tangents = surface_tangents(surface, atlas)
    return glb_bytes(surface, atlas.corner_uv, tangents, pictures(roles), **options), atlas, tangents


def array_of(document, index):
    accessor = document.accessors[index]
    view = document.bufferViews[accessor.bufferView]
    dtype = {5126: np.float32, 5123: np.uint16, 5125: np.uint32}[accessor.componentType]
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor.type]
    data = document.binary_blob()[view.byteOffset : view.byteOffset + view.byteLength]
    return np.frombuffer(data, dtype).reshape(accessor.count, width)


def test_corners_come_back_by_part():
    surface = parted_ball()
    data, atlas, tangents = packed(surface)
    document = pygltflib.GLTF2.load_from_bytes(data)
    primitives = document.meshes[0].primitives
    assert [document.materials[p.material].name for p in primitives] == ["upper", "sole"]
    assert document.nodes[0].translation is None
    for primitive, part in zip(primitives, (0, 2), strict=True):
        face = surface.part == part
        index = array_of(document, primitive.indices).ravel()
        attributes = primitive.attributes
        expected = {
            "POSITION": (surface.vertices[surface.faces] + surface.origin_mm) / 1000,
            "NORMAL": surface.shading_normal,
            "TANGENT": tangents,
            "TEXCOORD_0": atlas.corner_uv * [1, -1] + [0, 1],
        }
        for role, corners in expected.items():
            found = array_of(document, getattr(attributes, role))[index]
            np.testing.assert_allclose(found, corners[face].reshape(len(index), -1), atol=1e-6, err_msg=role)
        vertices = np.concatenate(
            [array_of(document, getattr(attributes, role)) for role in expected], axis=1
        )
        assert len(np.unique(vertices, axis=0)) == len(vertices)


def test_a_far_origin_goes_into_the_node():
    document = pygltflib.GLTF2.load_from_bytes(packed(parted_ball((5e6, 0, 0)))[0])
    assert document.nodes[0].translation == [5000.0, 0.0, 0.0]
    position = array_of(document, document.meshes[0].primitives[0].attributes.POSITION)
    assert np.abs(position).max() <= 0.0200001


def test_textures_are_wired():
    data, *_ = packed(parted_ball(), name="shoe", occluded=True, extras={"": {"height": "x.exr"}})
    document = pygltflib.GLTF2.load_from_bytes(data)
    source = {t.source: i for i, t in enumerate(document.textures)}
    role = {image.name: source[i] for i, image in enumerate(document.images)}
    for material in document.materials:
        surface = material.pbrMetallicRoughness
        assert surface.baseColorTexture.index == role["shoe_base_color"]
        assert surface.metallicRoughnessTexture.index == role["shoe_orm"]
        assert material.occlusionTexture.index == role["shoe_orm"]
        assert material.normalTexture.index == role["shoe_normal"]
        assert (
            material.extensions["KHR_materials_specular"]["specularColorTexture"]["index"]
            == role["shoe_specular_color"]
        )
        assert material.extras == {"height": "x.exr"}
    given = pictures()
    for image in document.images:
        view = document.bufferViews[image.bufferView]
        data = document.binary_blob()[view.byteOffset : view.byteOffset + view.byteLength]
        assert data == given[image.name.removeprefix("shoe_")]


def test_same_input_same_bytes_and_unknown_roles_are_refused():
    assert packed(parted_ball())[0] == packed(parted_ball())[0]
    with pytest.raises(InputError, match="'gloss'"):
        glb_bytes(plane(), plane().corner_uv, np.zeros((512, 3, 4)), {"gloss": b""})


def validator():
    """Khronos' validator, if node and its package are at hand."""
    package = Path(os.environ.get("SURFTEX_GLTF_VALIDATOR", "node_modules/gltf-validator")).absolute()
    if not shutil.which("node") or not package.is_dir():
        pytest.skip(
            "no glTF validator: npm install gltf-validator, and name its folder in SURFTEX_GLTF_VALIDATOR"
        )
    return package


def issues(path):
    command = ["node", Path(__file__).with_name("validate.js"), validator(), path]
    told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return json.loads(told)["issues"]


@pytest.mark.parametrize("subject", ["parts", "far", "tube", "faceted", "mirrored", "bare", "colour only"])
def test_valid_by_khronos(subject, tmp_path):
    roles = {"bare": (), "colour only": ("base_color",)}.get(
        subject, ("base_color", "orm", "normal", "specular_color")
    )
    if subject == "mirrored":
        flat = plane(cells=4)
        atlas = Atlas.of(flat, np.abs(flat.corner_uv - [0.5, 0]))
        data = glb_bytes(flat, atlas.corner_uv, surface_tangents(flat, atlas), pictures(roles))
    else:
        surface = {
            "parts": parted_ball,
            "far": lambda: parted_ball((5e6, 0, 0)),
            "faceted": faceted,
        }.get(subject, cylinder)()
        data = packed(surface, roles, occluded=True, extras={"": {"note": "é"}})[0]
    (tmp_path / "a.glb").write_bytes(data)
    found = issues(tmp_path / "a.glb")
    assert (found["numErrors"], found["numWarnings"]) == (0, 0), found["messages"][:3]
    wide = [a for a in pygltflib.GLTF2.load(tmp_path / "a.glb").accessors if a.componentType == 5125]
    assert len(wide) == (subject == "faceted")


def test_the_validator_sees_mistakes(tmp_path):
    flat = plane(cells=2)
    tangents = np.zeros((len(flat.faces), 3, 4))
    (tmp_path / "a.glb").write_bytes(glb_bytes(flat, flat.corner_uv, tangents, pictures()))
    assert issues(tmp_path / "a.glb")["numErrors"] > 0
