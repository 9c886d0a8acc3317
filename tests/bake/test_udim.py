"""Pages of several tiles: own UVs that go over tiles, unwraps spread over tiles, and pages too large for memory."""

import json

import numpy as np
import OpenEXR
import pytest

import surftex as sx
from surftex import paged
from surftex.bake.bake import bake
from surftex.charts.atlas import Atlas
from surftex.charts.gate import keep_own
from surftex.charts.lookup import bilinear_tiles
from surftex.charts.seams import seam_samples
from surftex.errors import InputError, RecipeError
from surftex.features.uniform import scatter
from surftex.files.images import read_exr, read_png
from surftex.materials.leather.model import Leather
from surftex.randomness import stream
from surftex.recipe.model import Recipe
from surftex.surface.shapes import plane, sphere
from surftex.surface.surface import Surface

LEATHER = Leather(cell_size=4.0)


def two_tiles():
    """A square sheet whose halves lie on two tiles."""
    sheet = plane(40.0, cells=8)
    middle = sheet.vertices[sheet.faces].mean(axis=1)
    right = middle[:, 0] > sheet.vertices[:, 0].mean()
    uv = sheet.vertices[sheet.faces][..., :2] - sheet.vertices[:, :2].min(axis=0)
    local = (uv - np.where(right, 20.0, 0.0)[:, None, None] * [1, 0]) / 40 * 0.9 + 0.05
    local[right] += [1.0, 0.0]
    return Surface.from_arrays(sheet.vertices, sheet.faces, corner_uv=local, name="sheet")


def heights(maps):
    return {int(name.partition(".")[2]): maps[name] for name in maps if name.startswith("height")}


def at_points(maps, surface, count=3000):
    points = scatter(surface, stream(5, "points"), count=count)
    tile = maps.atlas.tile[points.face]
    uv = np.einsum("nk,nkc->nc", points.barycentric, maps.atlas.corner_uv[points.face])
    return bilinear_tiles(
        heights(maps), uv - np.stack([(tile - 1001) % 10, (tile - 1001) // 10], axis=1), tile
    )


def test_own_uvs_over_two_tiles_show_what_one_page_shows():
    surface = two_tiles()
    two = bake(surface, Recipe.of(LEATHER, udim=True, uv="keep"), resolution=256, seed=3)
    assert {name.partition(".")[2] for name in two} == {"1001", "1002"}
    assert two.report["unwrap"]["tiles"] == [1001, 1002]
    one = bake(plane(40.0, cells=8), LEATHER, resolution=512, seed=3)
    wanted, got = (
        at_points(two, surface),
        np.asarray(one["height"], np.float64),
    )
    points = scatter(surface, stream(5, "points"), count=3000)
    uv = np.einsum("nk,nkc->nc", points.barycentric, one.atlas.corner_uv[points.face])
    same = bilinear_tiles({1001: got}, uv, np.full(len(uv), 1001))
    assert np.abs(wanted - same).mean() < 0.1 * same.std()
    assert two.report["seam"]["maps"]["height"]["rms"] < 0.1 * same.std()


def test_uvs_over_several_tiles_are_a_warning_where_one_page_is_wanted_alone(tmp_path):
    surface = two_tiles()
    rows = [f"v {x} {y} {z}" for x, y, z in surface.vertices]
    rows += [f"vt {u} {v}" for u, v in surface.corner_uv.reshape(-1, 2)]
    for i, face in enumerate(surface.faces):
        rows.append("f " + " ".join(f"{v + 1}/{3 * i + k + 1}" for k, v in enumerate(face)))
    (tmp_path / "sheet.obj").write_text("\n".join(rows))
    loaded = sx.load(tmp_path / "sheet.obj", units="mm")
    told = [
        [
            line
            for line in bake(loaded, Recipe.of(LEATHER, udim=udim), resolution=64).report["warnings"]
            if "0..1" in line
        ]
        for udim in (True, False)
    ]
    assert told[0] == []
    assert "the file's UVs leave 0..1 (they run from 0.05 to 1.5)" in told[1]


@pytest.mark.parametrize(
    ("options", "told"), [({}, True), ({"texels_per_mm": 0.2}, False), ({"udim": False}, False)]
)
def test_tiles_that_are_one_for_want_of_a_density_are_told(options, told):
    ball = sx.shapes.sphere(20.0, subdivisions=2)
    report = bake(ball, Recipe.of(LEATHER, **{"udim": True, **options}), resolution=64).report
    assert report["unwrap"]["tiles"] == [1001]
    assert (
        any(
            "all lies on one tile; name a density (texels_per_mm, --texels-per-mm)" in line
            for line in report["warnings"]
        )
        == told
    )


def test_kept_uvs_on_one_tile_are_not_told_of_a_density_that_they_cannot_take():
    square = sx.shapes.plane(20.0, cells=2)
    report = bake(square, Recipe.of(LEATHER, udim=True, uv="keep"), resolution=64).report
    assert report["unwrap"]["tiles"] == [1001]
    assert not any("density" in line for line in report["warnings"])


@pytest.mark.parametrize("shift", [(10.0, 0.0), (-1.0, 0.0), (0.0, -3.0)])
def test_uvs_off_all_tiles_are_told_in_a_line(shift):
    surface = two_tiles()
    moved = Surface.from_arrays(
        surface.vertices, surface.faces, corner_uv=surface.corner_uv + np.array(shift), name="sheet"
    )
    with pytest.raises(
        InputError, match=r"faces leave the tiles \(u goes from 0 to 10, v from 0 up\)"
    ) as caught:
        keep_own(moved, resolution=64, udim=True)
    assert "\n" not in str(caught.value)


def test_a_seam_between_tiles_is_measured_on_both():
    surface = two_tiles()
    atlas = keep_own(surface, resolution=256, udim=True)
    samples = seam_samples(surface, atlas, 256)
    assert set(samples.here_tile) | set(samples.there_tile) == {1001, 1002}
    assert (samples.here_tile != samples.there_tile).all()
    for uv in (samples.here_uv, samples.there_uv):
        assert ((uv >= 0) & (uv <= 1)).all()


def test_tiles_are_refused_without_leave_and_faces_across_two():
    surface = two_tiles()
    with pytest.raises(InputError, match=r"\(udim, --udim, takes tiles\)"):
        keep_own(surface, resolution=256)
    astride = Atlas.of(surface, surface.corner_uv + np.array([0.7, 0.0]))
    with pytest.raises(InputError, match="leave their tile"):
        keep_own(Surface.from_arrays(surface.vertices, surface.faces, corner_uv=astride.corner_uv, name="a"),
                 resolution=256, udim=True)  # fmt: skip


def test_an_unwrap_is_spread_at_the_density_asked_for(tmp_path):
    ball = sphere(20.0, subdivisions=3)
    recipe = Recipe.of(LEATHER, udim=True, texels_per_mm=4.0)
    maps = bake(ball, recipe, resolution=128, seed=2)
    assert len(maps.atlas.tiles) > 4
    assert maps.report["unwrap"]["texels_per_mm"] == pytest.approx(4.0, rel=0.02)
    whole = bake(ball, LEATHER, resolution=512, seed=2)
    assert np.abs(at_points(maps, ball) - at_points_one(whole, ball)).mean() < 0.1 * whole["height"].std()
    maps.save(tmp_path / "out")
    tile = maps.atlas.tiles[1]
    assert read_png(tmp_path / "out" / f"{maps.stem}_base_color.{tile}.png").shape == (128, 128, 3)
    exr = read_exr(tmp_path / "out" / f"{maps.stem}_height.{tile}.exr")
    assert np.array_equal(next(iter(exr.values())), maps[f"height.{tile}"])
    again = sx.load(tmp_path / "out" / f"{maps.stem}.glb")
    assert len(again.faces) == len(ball.faces)
    assert ((again.corner_uv >= -1e-6) & (again.corner_uv <= 1 + 1e-6)).all()
    listed = json.loads((tmp_path / "out" / "report.json").read_text())["outputs"]
    assert set(maps.file_names) - {"report.json"} == set(listed)


@pytest.mark.parametrize(("texels_per_mm", "grey"), [(4.0, True), (None, False)])
def test_a_displaced_mesh_without_pictures_is_told(texels_per_mm, grey):
    recipe = Recipe.of(LEATHER, udim=True, texels_per_mm=texels_per_mm, displaced=True)
    warnings = bake(sphere(20.0, subdivisions=2), recipe, resolution=128, maps=("height",)).report["warnings"]
    assert any("names no pictures" in each for each in warnings) == grey


def at_points_one(maps, surface):
    points = scatter(surface, stream(5, "points"), count=3000)
    uv = np.einsum("nk,nkc->nc", points.barycentric, maps.atlas.corner_uv[points.face])
    return bilinear_tiles({1001: maps["height"]}, uv, np.full(len(uv), 1001))


def test_densities_that_cannot_be_are_refused():
    with pytest.raises(RecipeError, match="takes udim = true"):
        Recipe.of(LEATHER, texels_per_mm=4.0)
    with pytest.raises(RecipeError, match="density of a new unwrap"):
        Recipe.of(LEATHER, udim=True, texels_per_mm=4.0, uv="keep")
    with pytest.raises(InputError, match="at most 100 are made"):
        bake(sphere(20.0, subdivisions=2), Recipe.of(LEATHER, udim=True, texels_per_mm=400.0), resolution=64)


def test_pages_in_files_are_the_same_pages(tmp_path, monkeypatch):
    """Small pages that are forced into files: the same maps, and the same numbers in the pictures."""
    ball = sphere(15.0, subdivisions=2)
    plain = bake(ball, LEATHER, resolution=128, seed=2, maps=("base_color", "normal", "height", "roughness"))
    plain.save(tmp_path / "plain")
    monkeypatch.setattr(paged, "LARGEST_IN_MEMORY", 1000)
    monkeypatch.setattr(paged, "_BLOCK_BYTES", 4096)
    paged_ = bake(
        ball, LEATHER, resolution=128, seed=2, tile=16, maps=("base_color", "normal", "height", "roughness")
    )
    assert all(np.array_equal(plain[name], paged_[name]) for name in plain)
    assert plain.report["seam"] == paged_.report["seam"]
    paged_.save(tmp_path / "paged")
    for name in ("base_color", "normal", "roughness"):
        pictures = [read_png(tmp_path / how / f"{plain.stem}_{name}.png") for how in ("plain", "paged")]
        assert np.array_equal(*pictures)
    assert np.array_equal(*(
        read_exr(tmp_path / how / f"{plain.stem}_height.exr")["Y"] for how in ("plain", "paged")
    ))  # fmt: skip
    for how, kind in (("plain", "scanlineimage"), ("paged", "tiledimage")):
        with OpenEXR.File(str(tmp_path / how / f"{plain.stem}_height.exr")) as opened:
            assert opened.header()["type"] == getattr(OpenEXR, kind)
    assert (tmp_path / "paged" / f"{plain.stem}_orm.png").is_file()
    assert (tmp_path / "paged" / f"{plain.stem}.glb").stat().st_size < (
        tmp_path / "plain" / f"{plain.stem}.glb"
    ).stat().st_size
