"""A whole bake: what comes back, the report, and that threads, tiles and saved features change no byte."""

import importlib
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import surftex as sx
from surftex.bake.stages import peak_rss_mb
from surftex.errors import InputError, RecipeError, WorkError
from surftex.surface.shapes import cylinder, sphere
from tests.bake.waves import Waves

ORDER = ["load", "place", "unwrap", "bake", "seams", "scales"]


@pytest.fixture(scope="module")
def maps():
    return sx.bake(sphere(20.0, subdivisions=3), Waves(), resolution=128, seed=5)


def test_maps_and_report(maps):
    assert list(maps) == ["base_color", "roughness", "normal", "height"]
    assert maps["height"].shape == (128, 128)
    assert maps["height"].dtype == np.float32
    assert 0.05 < np.ptp(maps["height"]) < 0.6
    report = json.loads(json.dumps(maps.report))
    promised = (
        "version mesh recipe seed resolution texels coverage stages wall_s peak_rss_mb features seam warnings"
    )
    assert {*promised.split(), "outputs"} <= set(report)
    assert report["mesh"]["faces"] == 1280
    assert report["mesh"]["boundary_loops"] == 0
    assert report["mesh"]["area_mm2"] == pytest.approx(4 * np.pi * 400, rel=0.01)
    assert report["seed"] == report["recipe"]["seed"] == 5
    assert report["recipe"]["bake"]["resolution"] == report["resolution"] == 128
    written = {
        "material": "waves",
        "mask": 1.0,
        "wavelength": 5.0,
        "height": 0.2,
        "spots": 20,
        "strength": 1.0,
    }
    assert report["recipe"]["layer"] == [written]
    assert report["features"] == {"spot": 20}
    assert sorted(stage["name"] for stage in report["stages"]) == sorted(ORDER)
    assert all(stage["wall_s"] >= 0 and stage["cpu_s"] >= 0 for stage in report["stages"])
    assert report["texels"] == round(report["coverage"] * 128**2)
    assert 0.3 < report["coverage"] < 1
    assert set(report["seam"]["maps"]) == {"base_color", "roughness", "normal", "height"}
    assert report["peak_rss_mb"] > 50


def same(first, second):
    assert list(first) == list(second)
    for name in first:
        assert first[name].tobytes() == second[name].tobytes(), name


@pytest.mark.parametrize("options", [{"threads": 1}, {"threads": 2}, {"tile": 40}, {"uv": "unwrap"}])
def test_how_it_is_done_changes_no_byte(maps, options):
    same(maps, sx.bake(sphere(20.0, subdivisions=3), Waves(), resolution=128, seed=5, **options))


def test_a_bake_from_saved_features_gives_the_same_bytes(maps, tmp_path):
    maps.save(tmp_path / "out")
    features = sx.load_features(tmp_path / "out" / "features.npz")
    same(maps, sx.bake(sphere(20.0, subdivisions=3), Waves(), resolution=128, seed=5, features=features))
    again = sx.bake(
        sphere(20.0, subdivisions=3),
        Waves(),
        resolution=128,
        seed=5,
        features=tmp_path / "out" / "features.npz",
    )
    same(maps, again)
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert set(report["outputs"]) == {path.name for path in (tmp_path / "out").iterdir()} - {"report.json"}


def test_another_seed_is_another_pattern(maps):
    other = sx.bake(sphere(20.0, subdivisions=3), Waves(), resolution=128, seed=6)
    assert (other["height"] != maps["height"]).mean() > 0.5


def test_own_uvs_are_kept_where_they_will_do():
    from surftex.surface.shapes import plane

    kept = sx.bake(plane(20.0), Waves(), resolution=64, maps="height")
    assert kept.report["unwrap"]["unwrapper"] == "own"
    anew = sx.bake(plane(20.0), Waves(), resolution=64, maps="height", uv="unwrap", unwrapper="uvunwrap")
    assert anew.report["unwrap"]["unwrapper"] == "uvunwrap"
    with pytest.raises(InputError, match="no UVs"):
        sx.bake(cylinder(), Waves(), resolution=64, uv="keep")


def test_meshes_of_other_libraries_are_taken():
    ball = sphere(20.0, subdivisions=2)
    first = sx.bake((ball.vertices, ball.faces), Waves(), resolution=32, maps=("height",))
    assert first["height"].shape == (32, 32)
    assert first.report["mesh"]["faces"] == len(ball.faces)


@pytest.mark.parametrize(
    ("options", "error", "says"),
    [
        ({"resolution": 3}, RecipeError, "bake.resolution: 3: should be greater than or equal to 16"),
        ({"maps": ["hieght"]}, RecipeError, "unknown map 'hieght'; did you mean height"),
        ({"maps": "metallic"}, InputError, "no layer makes the map 'metallic'"),
        ({"threads": 0}, InputError, "threads is 0"),
        ({"tile": 0}, InputError, "tile is 0"),
        ({"uv": "guess"}, RecipeError, "bake.uv: 'guess': should be 'auto', 'keep' or 'unwrap'"),
        ({"max_features": 3}, RecipeError, "layer: 20 spots are more than"),
        ({"features": "none.npz"}, InputError, "no such file"),
        ({"features": 3}, InputError, "features is an int; it takes a bake's features, or their file"),
        ({"threads": "all"}, InputError, "threads is 'all'; it takes one number"),
        ({"tile": 2.5}, InputError, "tile is 2.5; it takes a whole number"),
        ({"progress": 3}, InputError, "progress is an int; it takes a function of stage and share"),
        ({"maps": 3}, RecipeError, "bake.maps: 3: should be a valid tuple"),
        ({"seed": np.zeros((2, 1))}, RecipeError, "seed: .*should be a valid integer"),
    ],
)
def test_wrong_options_are_refused(options, error, says):
    with pytest.raises(error, match=rf"\A.*{says}.*\Z"):
        sx.bake(sphere(20.0, subdivisions=1), Waves(), **{"resolution": 32, **options})


def test_wrong_subjects_are_refused():
    with pytest.raises(InputError, match="a mesh needs a material"):
        sx.bake(sphere())
    with pytest.raises(RecipeError, match="no preset 'claf'; did you mean calf"):
        sx.bake(sphere(), "claf")
    with pytest.raises(
        RecipeError, match=r"^an int is no material; take a Leather, a Recipe, or the name of a preset$"
    ):
        sx.bake(sphere(), 3)
    with pytest.raises(
        RecipeError, match=r"^the class Leather is no material; make one of it, such as Leather\(\)$"
    ):
        sx.bake(sphere(), sx.Leather)
    with pytest.raises(RecipeError, match=r"^the class dict is no material; take a Leather"):
        sx.bake(sphere(), dict)
    with pytest.raises(InputError, match="the recipe names no mesh"):
        sx.bake(sx.Recipe(layer=({"material": Waves()},)))


def test_progress_is_told_by_stage_and_cancels_at_once():
    told = []
    sx.bake(sphere(20.0, subdivisions=2), Waves(), resolution=32, progress=lambda *each: told.append(each))
    assert list(dict.fromkeys(name for name, _ in told if name in ("load", "place", "bake", "seams"))) == [
        "load", "place", "bake", "seams",
    ]  # fmt: skip
    assert all(0 <= share <= 1 for _, share in told)

    class StopError(Exception):
        pass

    def stop(name, share):
        if name == "place":
            raise StopError

    with pytest.raises(StopError):
        sx.bake(sphere(20.0, subdivisions=2), Waves(), resolution=32, progress=stop)


def test_running_out_of_memory_is_told_in_a_line(monkeypatch):
    def exhausted(*_, **__):
        raise MemoryError

    monkeypatch.setattr(importlib.import_module("surftex.bake.pages"), "bake_pages", exhausted)
    with pytest.raises(WorkError, match="not enough memory for 32 x 32"):
        sx.bake(sphere(20.0, subdivisions=1), Waves(), resolution=32)


def test_the_room_and_the_function_share_a_name():
    import surftex

    room = importlib.import_module("surftex.bake")
    assert callable(room)
    assert room(sphere(20.0, subdivisions=1), Waves(), resolution=32, maps="height")["height"].shape == (
        32,
        32,
    )
    assert surftex.bake is not None
    assert set(surftex.__all__) == set(surftex._HOME) | {"__version__"}


def test_equalising_lowers_the_jumps_at_seams_and_says_what_it_moved():
    plain = sx.bake(sphere(20.0, subdivisions=3), Waves(), resolution=128, maps="height,roughness,region")
    even = sx.bake(
        sphere(20.0, subdivisions=3), Waves(), resolution=128, maps="height,roughness,region", equalise=True
    )
    for name in ("height", "roughness"):
        before, after = (maps.report["seam"]["maps"][name]["rms"] for maps in (plain, even))
        assert after < 0.6 * before
        moved = even.report["equalised"][name]
        assert 0 < moved["rms"] <= moved["max"] <= np.abs(even[name] - plain[name]).max() * 1.01
    assert even["region"].tobytes() == plain["region"].tobytes()
    assert "equalised" not in plain.report


@pytest.mark.parametrize("kind", ["stl", "obj"])
def test_the_displaced_mesh_is_the_relief_that_the_maps_show(tmp_path, kind):
    from surftex.bake.bake import run
    from surftex.bake.saving import save

    ball = sphere(20.0, subdivisions=3)
    material = Waves(height=1.0, wavelength=15.0)
    recipe = sx.Recipe.of(material, resolution=128, displaced=True, displaced_format=kind)
    baked = run(recipe, ball)
    paths = save(baked, tmp_path / "out")
    assert tmp_path / "out" / f"sphere_displaced.{kind}" in paths
    raised = sx.load(tmp_path / "out" / f"sphere_displaced.{kind}", units="mm")
    radius = np.linalg.norm(raised.vertices + raised.origin_mm, axis=1)
    assert raised.border_loops == 0
    assert radius.max() == pytest.approx(20 + baked.maps["height"].max(), abs=0.15)
    assert radius.min() == pytest.approx(20 + baked.maps["height"].min(), abs=0.3)
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert f"sphere_displaced.{kind}" in report["outputs"]


@pytest.mark.parametrize(("maps", "roles"), [(None, {"base_color", "roughness"}), (("height",), set())])
def test_a_displaced_glb_shows_the_maps_beside_it(tmp_path, maps, roles):
    from pygltflib import GLTF2

    from surftex.bake.bake import run
    from surftex.bake.saving import save

    recipe = sx.Recipe.of(
        sx.Leather.preset("crocodile", cell_size=8.0), resolution=64, maps=maps, displaced=True
    )
    save(run(recipe, sphere(20.0, subdivisions=2)), tmp_path / "out")
    document = GLTF2().load(tmp_path / "out" / "sphere_displaced.glb")
    assert document is not None
    assert {image.uri for image in document.images} == {f"sphere_{role}.png" for role in roles}
    assert all((tmp_path / "out" / image.uri).exists() for image in document.images)
    look = document.materials[0].pbrMetallicRoughness
    assert look.metallicFactor == 0.0
    assert (look.baseColorTexture is not None) == ("base_color" in roles)


@pytest.mark.skipif(
    not Path("/proc/self/status").exists(), reason="the system does not tell a process' own peak"
)
def test_the_most_memory_is_that_of_this_process_not_of_the_one_that_started_it():
    held = bytearray(300_000_000)
    held[::4096] = bytes(len(held[::4096]))
    peak = subprocess.run(
        [sys.executable, "-c", "from surftex.bake.stages import peak_rss_mb; print(peak_rss_mb())"],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    assert 5 < float(peak) < 150
    assert peak_rss_mb() > 300
