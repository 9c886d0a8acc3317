"""Leather on surfaces: what is placed, what stays, what the samples see."""

import math
import re

import numpy as np
import pytest
from scipy.ndimage import label
from scipy.spatial import cKDTree

import surftex as sx
from surftex.bake.fields import make_fields
from surftex.bake.stack import feature_counts
from surftex.errors import InputError, RecipeError
from surftex.features.uniform import area_points
from surftex.fields.fieldset import FieldSet
from surftex.files.meshes import load
from surftex.files.strokes import Stroke, write_strokes
from surftex.geodesics.directions import DirectionField
from surftex.materials.leather.model import Leather
from surftex.randomness import stream
from surftex.recipe.read import load_recipe
from surftex.surface.closest import closest_points
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.shapes import plane, sphere

PLAIN = {"wrinkle_density": 0.0, "grain_height": 0.0}


@pytest.fixture(scope="module")
def ball():
    return sphere(8.0, subdivisions=4)


def samples_on(surface, count=4000, footprint=0.02):
    points = area_points(surface, stream(1, "samples").uniform(count, 3))
    return Samples(points, np.full(count, footprint, np.float32))


@pytest.mark.parametrize("name", sorted(Leather.presets()))
def test_every_preset_answers_everywhere(name):
    ball = sphere(30.0 if name in ("crocodile", "ostrich") else 4.0, subdivisions=3)
    leather = Leather.preset(name)
    pattern = leather.place(ball, 3)
    layers = pattern.at(samples_on(ball, 1500))
    assert set(pattern.channels) == set(layers.channels)
    for channel in layers.channels.values():
        assert np.isfinite(channel).all()
    assert (layers["region"] >= 0).all()
    assert np.ptp(layers["height_mm"]) > 0.3 * leather.crista_height
    color = layers["base_color"]
    assert color.min() >= 0
    assert color.max() <= 1
    assert 0.04 <= layers["roughness"].min() <= layers["roughness"].max() <= 1


def test_threads_change_no_byte(ball):
    leather = Leather.preset("calf", wrinkle_count=6)
    one, two = (leather.place(ball, 5, threads=threads) for threads in (1, 2))
    assert one.features.keys() == two.features.keys()
    for kind in one.features:
        assert one.features[kind].tobytes() == two.features[kind].tobytes()
    samples = samples_on(ball)
    assert one.at(samples)["height_mm"].tobytes() == two.at(samples)["height_mm"].tobytes()


def test_samples_do_not_see_one_another(ball):
    pattern = Leather.preset("goat").place(ball, 5)
    samples = samples_on(ball, 999)
    whole = pattern.at(samples)
    parts = [pattern.at(samples.part(first, last)) for first, last in ((0, 10), (10, 600), (600, 999))]
    for name in pattern.channels:
        assert whole[name].tobytes() == np.concatenate([part[name] for part in parts]).tobytes()


def test_saved_features_give_the_same_pattern(ball):
    leather = Leather.preset("calf", wrinkle_count=4)
    first = leather.place(ball, 5)
    again = leather.place(ball, 5, features={kind: table.copy() for kind, table in first.features.items()})
    samples = samples_on(ball)
    for name in first.channels:
        assert first.at(samples)[name].tobytes() == again.at(samples)[name].tobytes()


def test_adding_one_kind_moves_no_other(ball):
    plain = Leather.preset("calf", **PLAIN).place(ball, 5).features
    more = (
        Leather.preset("calf", crown_spacing=3.0, wrinkle_count=3, grain_height=0.0).place(ball, 5).features
    )
    assert {"crown", "wrinkle"} <= more.keys() - plain.keys()
    for kind in plain:
        assert plain[kind].tobytes() == more[kind].tobytes()


def test_sulci_lie_on_the_borders_and_cristae_on_the_sites():
    sheet = plane(8.0, cells=8)
    leather = Leather(cell_size=0.8, grain_height=0.0)
    pattern = leather.place(sheet, 2)
    layers = pattern.at(samples_on(sheet, 6000, 0.002))
    from scipy.spatial import cKDTree

    sites = sheet_points(sheet, pattern.features["cell"])
    place = samples_on(sheet, 6000).points.positions(sheet)
    distance, _ = cKDTree(sites).query(place, k=2)
    border = (distance[:, 1] - distance[:, 0]) / 2
    height = layers["height_mm"]
    on_border, on_site = border < 0.01, distance[:, 0] < 0.1
    assert np.allclose(height[on_border], -leather.sulcus_depth, atol=0.15 * leather.sulcus_depth + 0.01)
    assert np.allclose(height[on_site], leather.crista_height, atol=0.02 * leather.crista_height)


def sheet_points(sheet, table):
    from surftex.surface.points import SurfacePoints

    return SurfacePoints(table["face"], table["barycentric"]).positions(sheet)


def test_wrinkles_keep_to_the_stress():
    sheet = plane(30.0, cells=24)
    fields = FieldSet(sheet, {}, {"up": lambda: DirectionField.from_axis(sheet, (0.0, 1.0, 0.0))})
    leather = Leather(cell_size=1.0, stress="up", wrinkle_count=40, wrinkle_length=8.0, wrinkle_angle=30.0)
    table = leather.place(sheet, 4, fields=fields).features["wrinkle"]
    start = sheet_points(sheet, table)
    table_end = table.copy()
    table_end["barycentric"] = table["end_barycentric"]
    step = sheet_points(sheet, table_end) - start
    length = np.linalg.norm(step, axis=1)
    assert len(np.unique(table["curve"])) > 30
    assert length.sum() / 40 == pytest.approx(8.0, rel=0.35)
    assert (step[:, 1].sum()) / length.sum() > 0.8
    joined = np.flatnonzero(np.diff(table["curve"]) == 0)
    assert np.linalg.norm(start[joined + 1] - (start + step)[joined], axis=1).max() < 0.25


def test_cracks_follow_the_stress_and_taper():
    sheet = plane(12.0, cells=12)
    fields = FieldSet(sheet, {}, {"up": lambda: DirectionField.from_axis(sheet, (0.0, 1.0, 0.0))})
    leather = Leather(cell_size=1.0, stress="up", invasion="0.3 mm")
    table = leather.place(sheet, 4, fields=fields).features["crack"]
    first = np.flatnonzero(np.diff(table["curve"], prepend=-1))
    assert table["length_mm"][first].max() <= 0.3 + 1e-9
    end = table.copy()
    end["barycentric"] = table["end_barycentric"]
    step = (sheet_points(sheet, end) - sheet_points(sheet, table))[first]
    along = np.abs(step[:, 1]) / np.maximum(np.linalg.norm(step, axis=1), 1e-12)
    whole = np.array([table["start_mm"][i] == 0 for i in first])
    assert whole.all()
    straight = table["length_mm"][first] < 0.3 * (along + 0.05) + 1e-6
    assert straight.mean() > 0.95


def test_pig_pores_stand_in_threes(ball):
    pattern = Leather.preset("pig", pore_spread=0.55, pore_density=0.55).place(ball, 5)
    place = sheet_points(ball, pattern.features["pore"]).reshape(-1, 3, 3)
    middle = place.mean(axis=1, keepdims=True)
    assert np.linalg.norm(place - middle, axis=2).max() < 1.3 * 0.55
    assert np.linalg.norm(place - middle, axis=2).min() > 0.6 * 0.55
    # Three over 0.55 a square millimetre, in a full set of disks: no two groups nearer than 1.95 mm.
    apart = np.linalg.norm(middle - middle[:, 0], axis=2)
    assert np.sort(apart, axis=1)[:, 1].min() > 1.8
    assert len(place) * 3 == pytest.approx(0.55 * ball.area_mm2, rel=0.06)


def test_sizes_vary_in_patches():
    sheet = plane(40.0, cells=16)
    nearest = {}
    for variation in (0.0, 0.6):
        table = Leather(cell_size=1.0, size_variation=variation).place(sheet, 4).features["cell"]
        place = sheet_points(sheet, table)[:, :2]
        nearest[variation] = cKDTree(place).query(place, 2)[0][:, 1]
    assert nearest[0.0].min() > 0.999
    low, high = np.percentile(nearest[0.6], (5, 95))
    assert 0.4 <= nearest[0.6].min() < low < 0.75
    assert 1.3 < high < 1.8


def test_small_cells_do_not_make_the_borders_of_large_ones_ragged():
    sheet, side = plane(100.0, cells=12), 160
    x, y = np.meshgrid(
        (np.arange(side) + 0.5) * 40 / side, (np.arange(side) + 0.5) * 100 / side, indexing="ij"
    )
    points, _ = closest_points(sheet, np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1))
    leather = Leather(cell_size="mix(2, 14, smoothstep(55, 40, x))", waviness=0.05, regularity=4)
    pattern = leather.place(sheet, 4, fields=FieldSet(sheet))
    own = pattern.at(Samples(points, np.full(len(points), 0.1, np.float32)))["region"].reshape(side, side)
    pieces = sum(label(own == cell)[1] for cell in np.unique(own))
    assert pieces == len(np.unique(own))  # 28; where waves answer to the cell's own size alone, 61


def test_recipes_of_the_shipped_meshes_grade_their_scales(meshes):
    for name, middle, rim in (
        (
            "handbag_crocodile.toml",
            lambda p: (np.abs(p[:, 0]) < 40) & (p[:, 1] < 0),
            lambda p: np.abs(p[:, 0]) > 140,
        ),
        ("watch_strap_stingray.toml", lambda p: np.abs(p[:, 2]) < 0.5, lambda p: np.abs(p[:, 2]) > 6),
    ):
        recipe = load_recipe(meshes / name, changes=["layer.regularity=0"])
        surface = load(recipe.mesh.path, units=recipe.mesh.units, part=recipe.mesh.part)
        pattern = recipe.layer[0].material.place(surface, 7, fields=make_fields(recipe, surface))
        table = pattern.features["cell"]
        place = SurfacePoints(table["face"], table["barycentric"]).positions(surface) + surface.origin_mm
        assert np.median(table["major_mm"][middle(place)]) > 2.2 * np.median(table["major_mm"][rim(place)])


def test_plates_meet_without_a_step_where_their_furrow_is_faint():
    """Height is continuous across borders, though plates differ in height and do not fall to the border there."""
    sheet = plane(12.0, cells=8)
    leather = Leather(cell_size=1.0, variation=1.0, sulcus_variation=1.0, sulcus_depth=0.0, crista_height=1.0)
    pattern = leather.place(sheet, 4)
    x = np.linspace(1, 11, 40_001)
    place = np.stack([x, np.full_like(x, 6.1), np.zeros_like(x)], axis=1)
    points, _ = closest_points(sheet, place)
    layers = pattern.at(Samples(points, np.full(len(x), 1e-4, np.float32)))
    height = layers["height_mm"]
    border = np.flatnonzero(np.diff(layers["region"]))
    assert len(border) >= 8
    assert np.abs(np.diff(height))[border].max() < 0.01
    assert np.ptp(height[border]) > 0.3


def test_two_zones_of_anisotropy_meet():
    sheet = plane(16.0, cells=16)
    fields = FieldSet(
        sheet, {"left": "x < 8"}, {"up": lambda: DirectionField.from_axis(sheet, (0.0, 1.0, 0.0))}
    )
    leather = Leather(cell_size="0.6 + 0.6 * left", cell_ratio=1.5, direction="up")
    table = leather.place(sheet, 4, fields=fields).features["cell"]
    x = sheet_points(sheet, table)[:, 0]
    assert (x > 8).sum() > 2.5 * (x < 8).sum()


def test_detail_finer_than_the_footprint_fades(ball):
    pattern = Leather.preset("calf", **PLAIN).place(ball, 5)
    fine = pattern.at(samples_on(ball, footprint=0.01))["height_mm"]
    coarse = pattern.at(samples_on(ball, footprint=2.0))["height_mm"]
    assert np.std(coarse) < 0.2 * np.std(fine)


def test_too_many_features_are_refused(ball):
    with pytest.raises(RecipeError, match="most of them pores"):
        Leather(cell_size=2.0, pore_density=1e6).place(ball, 1, max_features=10_000)
    for size in (1e-300, 5e-324):
        with pytest.raises(RecipeError, match="would hold about inf cells"):
            Leather(cell_size=size).place(ball, 1)


@pytest.mark.parametrize(
    ("changes", "advice"),
    [
        ({"cell_size": 0.01}, "raise cell_size"),
        ({"cell_size": "0.01 + 0 * x"}, "raise cell_size"),
        ({"pore_density": "400 + 0 * x"}, "lower pore_density"),
        ({"crown_spacing": 0.01}, "raise crown_spacing"),
        ({"wrinkle_density": 1e6}, "lower wrinkle_density"),
        ({"wrinkle_count": 60_000}, "lower wrinkle_count to 4"),
    ],
)
def test_too_many_features_are_refused_before_any_is_placed(ball, monkeypatch, changes, advice):
    monkeypatch.setattr("surftex.materials.leather.skeleton._direction", pytest.fail)
    with pytest.raises(RecipeError, match=advice):
        Leather.preset("calf", **changes).place(ball, 1, max_features=50_000)


def test_mistakes_name_the_nearest():
    with pytest.raises(RecipeError, match="did you mean calf"):
        Leather.preset("calv")
    with pytest.raises(RecipeError, match="crista_height"):
        Leather.preset("calf", crista_heigth=1)


@pytest.mark.parametrize(
    "changes",
    [
        {"pocket_depth": 0.1, "invasion": 0.4, "pore_density": 0.5, "wrinkle_count": 3, "crown_spacing": 7.0},
        {"pocket_depth": 0.1, "invasion": "0.4 * (x > 0)", "cell_ratio": 1.6, "size_variation": 0.3},
        {"pore_density": 1.5, "pore_group": 3, "regularity": 3},
    ],
)
def test_as_many_of_every_kind_are_foreseen_as_are_placed(changes):
    ball, leather = sphere(20.0, subdivisions=4), Leather(cell_size=2.0, **changes)
    placed = feature_counts(leather.place(ball, 1).features)
    foreseen = {each.kind: each.count for each in leather.expected_features(ball, 1) if each.count}
    assert foreseen == {kind: pytest.approx(count, rel=0.1, abs=3) for kind, count in placed.items()}


@pytest.mark.parametrize(
    ("changes", "kind"), [({"pocket_depth": 0.1}, "pocket"), ({"invasion": 0.4}, "crack")]
)
def test_what_cells_bring_with_them_counts_before_any_is_placed(monkeypatch, changes, kind):
    monkeypatch.setattr("surftex.materials.leather.skeleton._direction", pytest.fail)
    ball, leather = sphere(20.0, subdivisions=3), Leather(cell_size=1.0, **changes)
    most = round(1.5 * leather.expected_features(ball)[0].count)
    with pytest.raises(
        RecipeError, match=rf"most of them {kind}s .*raise cell_size to [12]\.\d+ mm"
    ) as refused:
        leather.place(ball, 1, max_features=most)
    larger = float(re.search(r"cell_size to (\S+) mm", str(refused.value))[1])
    wider = Leather(cell_size=larger, **changes).expected_features(ball)
    assert 0.9 * most < sum(each.count for each in wider) <= most


def test_a_bake_that_just_fits_is_given_back_within_the_same_bound():
    ball, leather = sphere(20.0, subdivisions=3), Leather(cell_size=3.0, pocket_depth=0.1, invasion=0.4)
    most = math.ceil(sum(each.count for each in leather.expected_features(ball, 1)))
    placed = leather.place(ball, 1, max_features=most).features
    assert set(placed) == {"cell", "pocket", "crack"}
    sx.bake(ball, leather, resolution=32, features=placed, max_features=most, seed=1)
    with pytest.raises(InputError, match="features are given, more than the"):
        sx.bake(ball, leather, resolution=32, features=placed, max_features=3 * len(placed["cell"]), seed=1)


@pytest.mark.parametrize("invasion", [1e7, 1e300])
def test_cracks_across_everything_are_refused_before_they_run(invasion):
    with pytest.raises(RecipeError, match=r"leather.invasion makes cracks of 1e\+"):
        Leather(cell_size=3.0, invasion=invasion).place(sphere(20.0, subdivisions=3), 1)


def test_drawn_wrinkles_have_their_own_width_and_depth(ball, tmp_path):
    turn = np.linspace(0, 2 * np.pi, 40)
    ring = np.stack([8 * np.cos(turn), 8 * np.sin(turn), 0 * turn], axis=1) - ball.origin_mm
    write_strokes(tmp_path / "ring.json", ball, [Stroke(closest_points(ball, ring)[0])])
    fields = {"ring": {"curves": str(tmp_path / "ring.json"), "width": 1.0, "depth": 0.4}}
    layer = {
        "material": "leather",
        "cell_size": 1.0,
        "wrinkle_count": 3,
        "wrinkle_length": 5,
        "grain_height": 0.0,
    }
    names = make_fields(sx.Recipe.model_validate({"fields": fields, "layer": [layer]}), ball)
    leather = Leather(**{key: value for key, value in layer.items() if key != "material"})
    plain = leather.place(ball, 5, fields=names)
    lined = leather.model_copy(update={"wrinkle_curves": "ring"})
    drawn = lined.place(ball, 5, fields=names)
    table = drawn.features["wrinkle"]
    assert len(np.unique(table["curve"])) == len(np.unique(plain.features["wrinkle"]["curve"])) + 1
    assert set(table["width_mm"]) == {0.0, 1.0}
    assert drawn.features["cell"].tobytes() == plain.features["cell"].tobytes()
    samples = samples_on(ball)
    sunk = plain.at(samples)["height_mm"] - drawn.at(samples)["height_mm"]
    away = np.abs(samples.points.positions(ball)[:, 2] + ball.origin_mm[2])
    assert 0.3 < sunk[away < 0.1].max() < 0.45
    assert 0.05 < np.median(sunk[np.abs(away - 0.5) < 0.05]) < 0.1  # (1 - 1/2)^4 (4/2 + 1) 0.4 mm = 0.075 mm
    np.testing.assert_allclose(sunk[away > 1.1], 0, atol=1e-6)
    again = lined.place(ball, 5, fields=names, features=drawn.features)
    assert again.at(samples)["height_mm"].tobytes() == drawn.at(samples)["height_mm"].tobytes()
    with pytest.raises(
        RecipeError, match=r"wrinkle_curves is 'ring', and the features hold no drawn wrinkle"
    ):
        lined.place(ball, 5, fields=names, features=plain.features)
    with pytest.raises(RecipeError, match=r"leather\.wrinkle_curves: unknown curves 'rung'.*ring"):
        leather.model_copy(update={"wrinkle_curves": "rung"}).place(ball, 5, fields=names)


def test_creases_of_the_shipped_shoe_lie_on_its_upper(meshes):
    recipe = load_recipe(meshes / "shoe_calf.toml")
    surface = load(recipe.mesh.path, units=recipe.mesh.units)
    names = make_fields(recipe, surface)
    assert recipe.layer[0].material.wrinkle_curves == "creases"
    table = names.curves("creases")
    assert len(np.unique(table["curve"])) == 4
    points = SurfacePoints(table["face"], table["barycentric"])
    assert (names.scalar('part("upper")')(points) == 1).all()
    assert all(names.scalar(layer.mask)(points).max() < 0.1 for layer in recipe.layer[1:])


def test_cracks_are_as_deep_as_their_furrow_even_where_that_is_wider_than_they_are_long():
    sheet, depth = plane(12.0, cells=12), 0.1
    bare = {"crista_height": 0.0, "grain_height": 0.0, "sulcus_depth": depth, "sulcus_width": 0.4}
    fields = FieldSet(sheet, {}, {"up": lambda: DirectionField.from_axis(sheet, (0.0, 1.0, 0.0))})
    for taper, deep_until in ((False, 1.0), (True, 0.5)):
        leather = Leather(cell_size=1.0, stress="up", invasion=0.3, crack_taper=taper, **bare)
        pattern = leather.place(sheet, 4, fields=fields)
        table = pattern.features["crack"]
        ends = SurfacePoints.trusted(
            np.ascontiguousarray(table["face"]), np.ascontiguousarray(table["end_barycentric"])
        )
        height = pattern.at(Samples(ends, np.full(len(table), 1e-4, np.float32)))["height_mm"]
        inside = _reached(sheet, table) < deep_until + 1e-9
        assert inside.sum() > 20
        np.testing.assert_allclose(height[inside], -depth, atol=2e-3)
        assert taper == (height[~inside].max(initial=-depth) > -0.9 * depth)


def _reached(sheet, table):
    """How much of its crack each piece has behind it, at its end."""
    start, end = (
        SurfacePoints.trusted(table["face"], np.ascontiguousarray(table[name])).positions(sheet)
        for name in ("barycentric", "end_barycentric")
    )
    return (table["start_mm"] + np.linalg.norm(end - start, axis=1)) / table["length_mm"]


def test_crowns_have_a_dark_pit_a_pale_rim_and_a_ring_of_dye():
    sheet = plane(60.0, cells=12)
    leather = Leather.preset("ostrich", mottle=0.0, cell_tone=0.0, dye=0.0)
    pattern = leather.place(sheet, 2)
    samples = samples_on(sheet, 20000)
    answer, skeleton = pattern.at(samples), pattern.gather(samples)
    share = skeleton.crown_mm / (leather.crown_width * skeleton.crown_scale)
    green = answer["base_color"][:, 1]
    pit, rim = green[skeleton.crown_mm < 0.15], green[(share > 0.6) & (share < 0.7)]
    ring, hide = green[np.abs(share - 1) < 0.05], green[share > 1.6]
    assert np.median(pit) < 0.5 * np.median(rim)
    assert np.median(ring) < 0.85 * np.median(hide) < np.median(rim)
    risen = answer["height_mm"]
    assert np.median(risen[(share > 0.5) & (share < 0.6)]) > np.median(risen[share > 1.3]) + 0.4
