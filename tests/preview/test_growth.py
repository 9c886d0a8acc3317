"""Frames of a growth: caps are those of ellipsoids, bare ground closes, and the files are written with the rest."""

import json

import numpy as np
import pytest

from surftex.bake.bake import run
from surftex.bake.growing import Growth
from surftex.bake.saving import save, save_maps
from surftex.bake.tiling import bake_tile
from surftex.materials.cells.growing import GROUND, GrowthPattern, tile_growth
from surftex.materials.cells.model import Cells
from surftex.materials.cells.skeleton import PARTICLE
from surftex.preview import growth as frames
from surftex.recipe.model import Recipe
from surftex.surface.closest import closest_points
from surftex.surface.points import Samples
from surftex.surface.shapes import plane, sphere

CELLS = Cells(cell_size=2.5, generations=60, blob_density=0.0)
LAW = CELLS.law


def one_particle(**state):
    table = np.zeros(1, PARTICLE)
    table["barycentric"] = 1 / 3
    table["aspect"], table["scale_mm"], table["generation"] = 1, 2, 1000
    for name, value in state.items():
        table[name] = value
    return table


def test_a_cap_on_a_surface_is_that_of_an_ellipsoid():
    surface = plane(10.0, cells=6)
    foot = np.array([[5.0, 5.0, 0.0]])
    point = closest_points(surface, foot - surface.origin_mm)[0]
    table = one_particle(diameter_mm=2.0, height_mm=0.7, aspect=4.0)
    table["face"], table["barycentric"] = point.face, point.barycentric
    frame = surface.frame[point.face[0]]
    table["angle_rad"] = np.arctan2(frame[1, 0], frame[0, 0])  # along x of the plane
    pattern = GrowthPattern.of(surface, table, LAW)
    x = np.array([0.0, 1.0, 1.9, 2.1, 0.0, 0.0])
    y = np.array([0.0, 0.0, 0.0, 0.0, 0.4, 0.6])
    place = foot + np.stack([x, y, np.zeros(6)], axis=1) - surface.origin_mm
    seen = pattern.at(Samples(closest_points(surface, place)[0], np.zeros(6, np.float32)))
    square = (x / 2) ** 2 + (y / 0.5) ** 2
    expected = np.where(square < 1, 0.7 + np.sqrt(np.maximum(1 - square, 0)), 0)
    np.testing.assert_allclose(seen["height_mm"], expected, atol=2e-3)
    assert (seen["base_color"][[3, 5]] < GROUND).all()


def test_a_cap_on_a_tile_comes_in_on_the_other_side():
    table = one_particle(diameter_mm=4.0, height_mm=1.0)
    table["place_mm"] = 0.0, 5.0
    height = tile_growth(table, LAW, 10.0, 50)["height_mm"]
    np.testing.assert_allclose(height, height[:, ::-1], atol=1e-5)
    assert height.max() == pytest.approx(3.0, abs=0.01)
    assert height[25, 0] > 2.9
    assert (height[:, 20:30] == 0).all()


def test_ground_closes_from_frame_to_frame():
    growth = Growth(frames=3)
    maps = bake_tile(Recipe.of(CELLS, resolution=32), 20.0, growth=growth)
    bare = [
        (tile_growth(features["particle"], LAW, 20.0, 80)["height_mm"] == 0).mean()
        for _, features in growth.states
    ]
    assert bare[0] > bare[1] > bare[2]
    pictures = frames.growth_frames(
        maps, CELLS, growth.states, resolution=48, size=(40, 40), view="front", floor=False
    )
    assert next(pictures).shape == (40, 40, 3)


def test_the_camera_is_set_up_once_for_all_frames(monkeypatch):
    growth, aims = Growth(frames=3), []
    maps = bake_tile(Recipe.of(CELLS, resolution=32), 20.0, growth=growth)
    options = {"size": (30, 20), "view": "front"}
    first = list(frames.growth_frames(maps, CELLS, growth.states[1:], resolution=48, **options))
    aim = frames.Shot.of
    monkeypatch.setattr(frames.Shot, "of", staticmethod(lambda *a, **k: aims.append(1) or aim(*a, **k)))
    again = list(frames.growth_frames(maps, CELLS, growth.states, resolution=48, **options))
    assert len(aims) == 1
    np.testing.assert_array_equal(first[-1], again[-1])
    assert (again[0] != again[-1]).any()


def test_frames_are_written_with_the_rest(tmp_path, monkeypatch):
    monkeypatch.setattr(frames, "SIZE", (40, 30))
    monkeypatch.setattr(frames, "RESOLUTION", 64)
    recipe = Recipe.of(CELLS, resolution=32, maps=("height",), unwrapper="uvunwrap")
    growth = Growth(frames=2)
    baked = run(recipe, sphere(8.0, subdivisions=2), growth=growth)
    paths = save(baked, tmp_path / "ball", more=frames.frames_to_write(baked.maps, recipe, growth))
    names = ["sphere_growth_0001.png", "sphere_growth_0002.png"]
    assert {path.name for path in paths} >= set(names)
    report = json.loads((tmp_path / "ball" / "report.json").read_text("utf-8"))
    assert set(report["outputs"]) >= set(names)
    assert [stage["name"] for stage in report["stages"]].count("frames") == 1
    assert report["cells"]["cell"]["count"] == len(baked.maps.features["cell"])
    assert 0 < report["cells"]["cell"]["area_cv"] < 1.5
    assert 0 < report["cells"]["cell"]["triangles"] < 1
    growth = Growth(frames=1)
    tile = bake_tile(recipe, 20.0, growth=growth)
    paths = save_maps(tile, tmp_path / "tile", recipe.bake, more=frames.frames_to_write(tile, recipe, growth))
    assert "tile_growth_0001.png" in {path.name for path in paths}
    assert frames.frames_to_write(tile, recipe, Growth()) is None
