"""A map set saves what it holds, in the stated formats, and shows itself."""

import hashlib
import json

import numpy as np
import pytest

from surftex.charts.texels import texels
from surftex.charts.unwrap import unwrap
from surftex.errors import InputError
from surftex.files.features import load_features
from surftex.files.images import read_exr, read_png
from surftex.maps.mapset import MapSet
from surftex.maps.normal import normal_map, surface_tangents
from surftex.surface.shapes import sphere


@pytest.fixture(scope="module")
def ball():
    surface = sphere(20.0, subdivisions=3)
    atlas = unwrap(surface, method="uvunwrap", resolution=128)
    page = texels(surface, atlas, 128)
    place = page.points.positions(surface) / 20
    height = np.sin(place[:, 0] * 9).astype(np.float32)
    channels = {
        "base_color": 0.5 + 0.4 * place,
        "normal": normal_map(surface, atlas, page, height),
        "roughness": 0.5 + 0.4 * place[:, 0],
        "height": height,
        "ambient_occlusion": 0.8 + 0.2 * place[:, 1],
        "specular": 0.4 + 0.1 * place[:, 2],
        "metallic": np.zeros(len(place)),
        "region": (height * 5).astype(np.int32) - 1,
        "melanin": place[:, 1],
    }
    maps = {name: page.image(values) for name, values in channels.items()}
    return MapSet(
        maps, surface, atlas, surface_tangents(surface, atlas), features={}, report={"seed": 3}, stem="ball"
    )


def test_saves_every_map_in_its_format(ball, tmp_path):
    paths = ball.save(tmp_path / "out")
    assert (
        sorted(p.name for p in paths)
        == sorted(ball.file_names)
        == sorted(p.name for p in (tmp_path / "out").iterdir())
    )
    read = {
        name: read_png(tmp_path / "out" / f"ball_{name}.png")
        for name in ("roughness", "base_color", "normal")
    }
    np.testing.assert_allclose(read["roughness"] / 255, ball["roughness"], atol=0.501 / 255)
    np.testing.assert_allclose(read["normal"] / 32767.5 - 1, ball["normal"], atol=0.51 / 32767.5)
    assert read["base_color"].dtype == np.uint8
    np.testing.assert_allclose((read["base_color"] / 255) ** 2.2, ball["base_color"], atol=0.02)
    for name in ("height", "melanin", "region"):
        np.testing.assert_array_equal(read_exr(tmp_path / "out" / f"ball_{name}.exr")["Y"], ball[name])
    assert load_features(tmp_path / "out" / "features.npz") == {}


def test_report_lists_every_file(ball, tmp_path):
    ball.save(tmp_path)
    report = json.loads((tmp_path / "report.json").read_text("utf-8"))
    assert report["seed"] == 3
    assert sorted(report["outputs"]) == sorted(set(ball.file_names) - {"report.json"})
    for name, told in report["outputs"].items():
        assert hashlib.sha256((tmp_path / name).read_bytes()).hexdigest() == told


def test_same_bytes_for_any_threads(ball, tmp_path):
    for threads in (1, 3):
        ball.save(tmp_path / str(threads), threads=threads)
    for name in ball.file_names:
        assert (tmp_path / "1" / name).read_bytes() == (tmp_path / "3" / name).read_bytes(), name


def test_overwrites_only_when_told(ball, tmp_path):
    (tmp_path / "ball_height.exr").write_text("mine")
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"holds ball_height\.exr already"):
        ball.save(tmp_path)
    assert len(list(tmp_path.iterdir())) == 2
    ball.save(tmp_path, overwrite=True)
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert (tmp_path / "ball_height.exr").stat().st_size > 1000


def test_failure_in_the_middle_leaves_nothing(ball, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("surftex.files.features.save_features", full)
    with pytest.raises(Exception, match="No space left"):
        ball.save(tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_occlusion_roughness_and_metal_share_a_picture(ball, tmp_path):
    import pygltflib

    ball.save(tmp_path)
    document = pygltflib.GLTF2.load(tmp_path / "ball.glb")
    image = next(image for image in document.images if image.name == "ball_orm")
    view = document.bufferViews[image.bufferView]
    (tmp_path / "orm.png").write_bytes(
        document.binary_blob()[view.byteOffset : view.byteOffset + view.byteLength]
    )
    codes = read_png(tmp_path / "orm.png") / 255
    for channel, name in enumerate(("ambient_occlusion", "roughness", "metallic")):
        np.testing.assert_allclose(codes[..., channel], ball[name], atol=0.501 / 255)
    extras = document.materials[0].extras["surftex_height"]
    assert extras["file"] == "ball_height.exr"
    assert extras["greatest"] == pytest.approx(float(ball["height"].max()))


def test_is_a_mapping_of_read_only_arrays(ball):
    assert "height" in ball
    assert len(ball) == 9
    assert not ball["height"].flags.writeable
    assert ball["height"].dtype == np.float32
    assert ball["region"].dtype == np.int32
    with pytest.raises(KeyError, match="this bake made base_color"):
        ball["gloss"]


def test_refuses_maps_that_do_not_fit(ball):
    def rebuilt(stem="x", **maps):
        return MapSet(maps, ball.surface, ball.atlas, ball.tangents, stem=stem)

    with pytest.raises(InputError, match="takes \\(h, w\\) mm above"):
        rebuilt(height=np.zeros((4, 4, 3)))
    with pytest.raises(InputError, match="several sizes"):
        rebuilt(height=np.zeros((4, 4)), roughness=np.zeros((8, 8)))
    with pytest.raises(InputError, match="1 values that are not finite"):
        rebuilt(height=np.array([[0, np.nan]]))
    with pytest.raises(InputError, match="no name of a map"):
        rebuilt(**{"../x": np.zeros((4, 4))})
    with pytest.raises(InputError, match="cannot start file names"):
        rebuilt(stem="../x", height=np.zeros((4, 4)))


def test_meshes_for_notebooks(ball):
    meshes = ball.textured_mesh()
    assert meshes.polydata.n_cells == len(ball.surface.faces) == len(meshes.trimesh.faces)
    assert meshes.polydata.area == pytest.approx(ball.surface.area_mm2, rel=1e-5)
    assert meshes.trimesh.is_winding_consistent
    assert meshes.texture is not None
    assert meshes.trimesh.visual.material.baseColorTexture.size == (128, 128)
    sheet = ball._repr_html_()
    assert sheet.count("<img") == len(ball)
