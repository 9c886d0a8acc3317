"""Leather grown from particles: a tile that repeats, cells that fill the surface, the same under any threads and unwrap."""

import dataclasses

import numpy as np
import pytest

from surftex.bake.bake import bake, run
from surftex.bake.stack import feature_counts
from surftex.errors import RecipeError
from surftex.materials.cells.model import Cells
from surftex.materials.cells.pattern import CHANNELS
from surftex.recipe.model import Recipe
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.shapes import plane, sphere

QUICK = {"generations": 90, "blob_density": 12.0}


def samples_of(surface, count=3000):
    random = np.random.Generator(np.random.PCG64(3))
    face = random.choice(len(surface.faces), count, p=surface.face_area_mm2 / surface.area_mm2)
    return Samples(SurfacePoints(face, random.dirichlet([1, 1, 1], count)), np.full(count, 0.02, np.float32))


@pytest.fixture(scope="module")
def ball():
    return sphere(12.0, subdivisions=3)


@pytest.fixture(scope="module")
def pattern(ball):
    return Cells.preset("even", cell_size=2.0).place(ball, 3)


@pytest.fixture(scope="module")
def tile():
    return Cells.preset("even", cell_size=1.0).tile(14.0, 3)


def test_a_tile_repeats(tile):
    random = np.random.Generator(np.random.PCG64(1))
    place = random.uniform(0, 14, (500, 2))
    here, there = tile.at(place), tile.at(place + np.array([14.0, -28.0]))
    for name in CHANNELS:
        np.testing.assert_allclose(here[name], there[name], atol=1e-5)
    edge = tile.at(np.stack([np.full(200, 1e-7), np.linspace(0, 14, 200)], axis=1))["height_mm"]
    back = tile.at(np.stack([np.full(200, 14 - 1e-7), np.linspace(0, 14, 200)], axis=1))["height_mm"]
    np.testing.assert_allclose(edge, back, atol=1e-4)


def test_cells_of_a_tile_fill_it_without_overlap(tile):
    corner, sides = tile.planes.corner, tile.planes.sides
    onward = np.roll(corner, -1, axis=1)
    area = 0.5 * (corner[..., 0] * onward[..., 1] - corner[..., 1] * onward[..., 0]).sum(axis=1)
    assert area.min() > 0
    assert area.sum() == pytest.approx(14.0**2, rel=1e-9)
    assert (sides == 3).mean() < 0.6
    meeting = np.bincount(tile.features["cell"]["corner"][tile.features["cell"]["corner"] >= 0])
    assert meeting.max() <= 8  # no stars
    corner, lone = tile.features["cell"]["corner"], tile.features["cell"]["sides"] == 3
    assert np.bincount(corner[lone][:, :3].ravel()).max() < 5


def test_narrow_cells_rise_less_than_broad_ones(tile):
    middle = tile.centre_mm + tile.outlines.middle
    flat = tile.cells.model_copy(update={"blob_height": 0.0, "grain_height": 0.0, "relief_variation": 0.0})
    height = dataclasses.replace(tile, cells=flat).at(middle)["height_mm"]
    breadth = tile.outlines.breadth
    narrow, broad = breadth < 0.15, breadth > 0.36
    assert narrow.sum() > 5
    assert broad.sum() > 5
    assert np.median(height[narrow]) < 0.7 * np.median(height[broad])


def test_grooves_have_no_step_where_two_cells_meet():
    from surftex.materials.cells.relief import Place, layers

    level = np.linspace(0, 1, 7, dtype=np.float32)
    none, ones = np.zeros(7, np.float32), np.ones(7, np.float32)
    place = Place(
        np.arange(7, dtype=np.int32), 1.2 * ones, -0.1 * ones, none, 2 * ones, level[::-1], np.float32(0.6), level, level,
        (), 0.3 * ones, none, none,
    )  # fmt: skip
    height = layers(Cells.preset("milled"), place, none)["height_mm"]
    assert height.min() > 0
    assert np.ptp(height) < 1e-7


def test_a_page_is_the_tile_and_threads_change_no_byte(tile):
    one, two = tile.page(64, threads=1), tile.page(64, threads=2)
    assert one["height_mm"].shape == (64, 64)
    assert one["base_color"].shape == (64, 64, 3)
    for name in one:
        np.testing.assert_array_equal(one[name], two[name])
    step = 14 / 64
    np.testing.assert_array_equal(
        one["height_mm"][0, :3],
        tile.at([[step / 2 + i * step, 14 - step / 2] for i in range(3)], step)["height_mm"],
    )


def test_a_tile_goes_on_from_saved_particles(tile):
    again = tile.cells.tile(14.0, 3, features={"particle": tile.features["particle"]})
    np.testing.assert_array_equal(again.features["cell"], tile.features["cell"])


@pytest.mark.parametrize(
    ("changes", "side", "says"),
    [
        ({"cell_size": 4.0}, 10.0, "too small for cells"),
        ({"cell_size": "1 + wear"}, 40.0, "cell_size: an expression needs a surface"),
        ({"potential": "wear"}, 40.0, "cells.potential: 'wear': unknown field"),
        ({"direction": "grain"}, 40.0, "unknown direction 'grain'"),
        ({}, -3.0, "a tile of -3 mm is too small"),
        ({"births": 5.0}, 4000.0, "more than the 5,000,000 allowed"),
        ({"cell_size": 1e-300}, 40.0, "hold about inf features, most of them particles"),
    ],
)
def test_what_a_tile_cannot_be_is_said(changes, side, says):
    with pytest.raises(RecipeError, match=says):
        Cells(**changes).tile(side)


def test_cells_of_next_to_no_size_are_refused(ball):
    with pytest.raises(RecipeError, match="hold about inf features, most of them particles"):
        Cells(cell_size=1e-300).place(ball)


def test_as_many_cells_are_foreseen_as_grow(ball):
    cells = Cells(cell_size=2.0, wrinkle_count=2)
    placed = feature_counts(cells.place(ball, 1).features)
    foreseen = {each.kind: each.count for each in cells.expected_features(ball, 1) if each.count}
    assert foreseen["cell"] == pytest.approx(placed["cell"], rel=0.1)
    assert foreseen["particle"] == pytest.approx(placed["particle"], rel=0.15)
    assert foreseen["wrinkle"] == 2
    allowed = round(1.05 * foreseen["particle"])
    with pytest.raises(RecipeError, match="most of them particles"):
        cells.place(ball, 1, max_features=allowed)


@pytest.mark.parametrize("ratio", ["0.1 * x", "6 + 0 * x"])
def test_needles_are_refused(ball, ratio):
    with pytest.raises(RecipeError, match=r"cell_ratio: .* gives .*, not between 0.2 and 5"):
        Cells(cell_size=2.0, cell_ratio=ratio).place(ball, 1)


@pytest.mark.parametrize(
    ("ratio", "says"),
    [(0, "0: should be greater than or equal to 0.2"), ("100", "should be less than or equal to 5")],
)
def test_a_ratio_of_needles_is_refused_where_it_is_written(ratio, says):
    with pytest.raises(RecipeError, match=f"^cells.cell_ratio: .*{says}"):
        Cells(cell_ratio=ratio)


def test_a_mesh_smaller_than_a_cell_is_one():
    pattern = Cells(cell_size=80.0).place(sphere(2.0, subdivisions=1), 1)
    assert len(pattern.features["cell"]) == 0
    layers = pattern.at(samples_of(pattern.surface, 50))
    assert np.isfinite(layers["height_mm"]).all()


def test_cells_cover_a_ball_evenly(pattern, ball):
    layers = pattern.at(samples_of(ball))
    assert (layers["region"] >= 0).mean() > 0.85
    assert np.isfinite(layers["height_mm"]).all()
    assert layers["height_mm"].max() < 3 * 0.14 * 2.0
    assert np.ptp(layers["height_mm"]) > 0.1
    corner, sides = pattern.features["cell"]["corner_mm"], pattern.features["cell"]["sides"]
    onward = np.roll(corner, -1, axis=1)
    area = 0.5 * (corner[..., 0] * onward[..., 1] - corner[..., 1] * onward[..., 0]).sum(axis=1)
    assert area.sum() == pytest.approx(ball.area_mm2, rel=0.03)
    assert area.std() / area.mean() < 0.6
    assert (sides == 3).mean() < 0.6


def test_threads_change_no_byte_and_growths_go_on(pattern, ball):
    again = Cells.preset("even", cell_size=2.0).place(ball, 3, threads=1)
    np.testing.assert_array_equal(again.features["cell"], pattern.features["cell"])
    on = Cells.preset("even", cell_size=2.0).place(
        ball, 3, features={"particle": pattern.features["particle"]}
    )
    np.testing.assert_array_equal(on.features["cell"], pattern.features["cell"])
    samples = samples_of(ball)
    np.testing.assert_array_equal(again.at(samples)["height_mm"], pattern.at(samples)["height_mm"])


def test_borders_have_cells_up_to_the_rim():
    surface = plane(24.0, cells=12)
    pattern = Cells.preset("even", cell_size=2.0).place(surface, 1)
    x = np.linspace(0.5, 23.5, 200)
    place = np.stack([x, np.full(200, 0.4), np.zeros(200)], axis=1) - surface.origin_mm
    from surftex.surface.closest import closest_points

    points = closest_points(surface, place)[0]
    layers = pattern.at(Samples(points, np.full(200, 0.02, np.float32)))
    assert (layers["region"] >= 0).mean() > 0.7


def test_wrinkles_lie_over_the_cells(ball):
    plain = Cells.preset("even", cell_size=2.0, **QUICK).place(ball, 3)
    creased = Cells.preset("even", cell_size=2.0, wrinkle_count=6, wrinkle_depth=0.5, **QUICK).place(ball, 3)
    assert len(np.unique(creased.features["wrinkle"]["curve"])) == 6
    samples = samples_of(ball)
    sunk = plain.at(samples)["height_mm"] - creased.at(samples)["height_mm"]
    assert sunk.max() > 0.4
    assert np.median(sunk) == 0
    np.testing.assert_array_equal(plain.features["cell"], creased.features["cell"])


def test_drawn_wrinkles_lie_over_the_cells_and_may_drive_them(ball, tmp_path):
    from surftex.files.strokes import Stroke, write_strokes
    from surftex.surface.closest import closest_points

    turn = np.linspace(0, 2 * np.pi, 40)
    ring = np.stack([12 * np.cos(turn), 12 * np.sin(turn), 0 * turn], axis=1) - ball.origin_mm
    write_strokes(tmp_path / "ring.json", ball, [Stroke(closest_points(ball, ring)[0])])
    fields = {
        "ring": {"curves": str(tmp_path / "ring.json"), "width": 1.5, "depth": 0.6},
        "near": {"distance_to": str(tmp_path / "ring.json")},
    }
    layer = {
        "material": "cells",
        "cell_size": 2.0,
        "generations": 60,
        "wrinkle_curves": "ring",
        "wrinkle_count": 2,
    }
    settings = {"resolution": 32, "maps": ("height",), "unwrapper": "uvunwrap"}

    def made(**changes):
        recipe = Recipe.model_validate({"fields": fields, "layer": [{**layer, **changes}]})
        return run(Recipe.of(recipe, **settings), ball)

    drawn, plain = made(), made(wrinkle_curves=None)
    table = drawn.maps.features["wrinkle"]
    assert len(np.unique(table["curve"])) == 3
    assert set(table["width_mm"]) == {0.0, 1.5}
    samples = samples_of(ball)
    height, below = (each.stack.at(samples, ("height_mm",))["height_mm"] for each in (drawn, plain))
    z = np.abs(samples.points.positions(ball)[:, 2] + ball.origin_mm[2])
    sunk = below - height
    assert sunk[z < 0.2].max() > 0.5
    np.testing.assert_allclose(sunk[z > 1.7], 0, atol=1e-6)
    driven = made(potential="1 - smoothstep(0, 4, near)", potential_force=0.05).maps.features["particle"]
    off = [
        np.abs(
            SurfacePoints.trusted(each["face"], each["barycentric"]).positions(ball)[:, 2] + ball.origin_mm[2]
        )
        for each in (driven, plain.maps.features["particle"])
    ]
    assert (off[0] < 1.5).mean() < 0.8 * (off[1] < 1.5).mean()
    with pytest.raises(RecipeError, match="drawn curves need a mesh"):
        Cells(wrinkle_curves="ring").tile(30.0)


def test_wrinkles_that_are_laid_first_drive_the_growth(ball):
    from surftex.features.curves import curve_pieces
    from surftex.fields.distances import distance_field

    given = {
        "cell_size": 1.5,
        "generations": 60,
        "wrinkle_count": 3,
        "wrinkle_length": 30,
        "wrinkle_depth": 0.4,
    }
    driving = {"wrinkle_potential": 1.0, "potential_height": 8, "potential_force": 0.05}
    driven = Cells(**given, **driving).place(ball, 2)
    unmoved = Cells(**given, **{**driving, "potential_force": 0.0}).place(ball, 2)
    np.testing.assert_array_equal(driven.features["wrinkle"], unmoved.features["wrinkle"])
    assert len(np.unique(driven.features["wrinkle"]["curve"])) == 3
    away = distance_field(ball, curve_pieces(ball, driven.features["wrinkle"]))
    near = [
        (away(SurfacePoints.trusted(table["face"], table["barycentric"])) < 1.2).mean()
        for table in (driven.features["particle"], unmoved.features["particle"])
    ]
    assert near[0] < 0.75 * near[1]
    samples = samples_of(ball)
    line = away(samples.points) < 0.15
    height = driven.at(samples)["height_mm"]
    assert height[line].mean() < height[~line].mean() - 0.05
    with pytest.raises(RecipeError, match="wrinkles that drive the growth need a mesh"):
        Cells(wrinkle_potential=0.5, wrinkle_count=1).tile(30.0)


@pytest.mark.parametrize(("force", "drop"), [(0.02, 0.3), (0.06, 1.0)])
def test_a_potential_drives_particles_away(ball, force, drop):
    layer = {"material": "cells", "cell_size": 2.0, "potential": "top", "potential_force": force}
    recipe = Recipe.model_validate({"fields": {"top": {"gradient": [0, 0, 1]}}, "layer": [layer]})
    settings = {"resolution": 32, "maps": ("height",), "unwrapper": "uvunwrap"}
    driven = run(Recipe.of(recipe, **settings), ball).maps.features["particle"]
    where = SurfacePoints.trusted(driven["face"], driven["barycentric"]).positions(ball) + ball.origin_mm
    assert where[:, 2].mean() < -drop


@pytest.mark.parametrize("name", Cells.presets())
def test_every_preset_answers(name, ball):
    pattern = Cells.preset(name, generations=60).place(ball, 1)
    layers = pattern.at(samples_of(ball, 300))
    for channel in CHANNELS:
        assert np.isfinite(layers[channel]).all()
    assert layers["base_color"].min() >= 0
    assert layers["base_color"].max() <= 1


@pytest.mark.slow
def test_the_unwrap_moves_no_cell(ball):
    cells = Cells.preset("mixed", cell_size=3.0)
    one, two = (
        bake(ball, cells, resolution=128, maps="height", uv="unwrap", unwrapper=name)
        for name in ("xatlas", "uvunwrap")
    )
    for kind in one.features:
        np.testing.assert_array_equal(one.features[kind], two.features[kind])
