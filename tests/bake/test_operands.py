"""What masks and directions may be made of: each against what it must be on a plane, a ball, a box of two levels."""

import json
import pickle

import numpy as np
import pytest

from surftex.bake.fields import make_fields
from surftex.errors import RecipeError
from surftex.recipe.model import Recipe
from surftex.recipe.read import recipe_from_text
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import plane, sphere
from surftex.surface.surface import Surface

LAYER = '\n[[layer]]\npreset = "calf"\n'


def fields(text, surface, folder=None):
    return make_fields(recipe_from_text(f"[fields]\n{text}{LAYER}", name="r.toml", folder=folder), surface)


def points_of(surface, count=400):
    random = np.random.Generator(np.random.PCG64(5))
    weights = random.dirichlet([1, 1, 1], count)
    return SurfacePoints(random.integers(0, len(surface.faces), count), weights)


def test_distance_to_a_point_is_walked():
    surface = sphere(20.0, subdivisions=4)
    points = points_of(surface, 6000)
    distance = fields("d = { distance_to = [0, 0, 20] }", surface).scalar("d")(points)
    place = points.positions(surface) + surface.origin_mm
    angle = np.arccos(np.clip(place[:, 2] / np.linalg.norm(place, axis=1), -1, 1))
    np.testing.assert_allclose(distance, 20 * angle, atol=0.6)  # beyond three edges by the heat method
    near = angle < 0.07  # within an edge, where it is exact on the polyhedron
    assert near.sum() > 3
    np.testing.assert_allclose(distance[near], 20 * angle[near], atol=0.02)


def test_distance_to_the_border_of_a_mask_is_signed():
    surface = plane(10.0, cells=20)
    text = 'side = { gradient = [1, 0, 0] }\nd = { distance_to = "side", level = 0.33 }'
    points = points_of(surface)
    found = fields(text, surface).scalar("d")(points)
    x = points.positions(surface)[:, 0] + surface.origin_mm[0]
    np.testing.assert_allclose(found, 3.3 - x, atol=0.12)


def test_distance_to_strokes(tmp_path):
    surface = plane(10.0, cells=20)
    (tmp_path / "s.json").write_text(json.dumps({"strokes": [[[5, 0, 0], [5, 10, 0]]]}))
    points = points_of(surface)
    found = fields('d = { distance_to = "s.json", limit = "3 mm" }', surface, tmp_path).scalar("d")(points)
    x = points.positions(surface)[:, 0] + surface.origin_mm[0]
    np.testing.assert_allclose(found, np.minimum(np.abs(x - 5), 3), atol=0.1)


def test_attributes_of_vertices_and_faces_and_their_labels():
    bare = plane(10.0, cells=6)
    height = bare.vertices[:, 0] + bare.origin_mm[0]
    label = (np.arange(len(bare.faces)) % 3).astype(float)
    colour = np.stack([height / 10, 0 * height, 1 - height / 10], axis=1)
    surface = bare.with_attributes({"wear": height, "paint": colour}).with_attributes(
        {"kind": label}, at="faces"
    )
    points = points_of(surface)
    x = points.positions(surface)[:, 0] + surface.origin_mm[0]
    text = """
    wear = { attribute = "wear" }
    two = { attribute = "kind", label = 2 }
    blue = { attribute = "paint", channel = "blue" }
    """
    made = fields(text, surface)
    np.testing.assert_allclose(made.scalar("wear")(points), x, atol=1e-9)
    np.testing.assert_array_equal(made.scalar("two")(points), label[points.face] == 2)
    np.testing.assert_allclose(made.scalar("blue")(points), 1 - x / 10, atol=1e-9)
    for wrong, said in [
        ('a = { attribute = "waer" }', "did you mean 'wear'"),
        ('a = { attribute = "kind", label = 9 }', "is 9 nowhere; it holds 0, 1, 2"),
        ('a = { attribute = "paint", channel = "alpha" }', "has 3 numbers and no alpha"),
    ]:
        with pytest.raises(RecipeError, match=said) as caught:
            fields(wrong, surface)
        assert str(caught.value).startswith("r.toml:2: fields.a: ")
    broken = bare.with_attributes({"wear": np.where(np.arange(len(height)) == 3, np.nan, height)})
    with pytest.raises(RecipeError, match="is not finite on"):
        fields('a = { attribute = "wear" }', broken)


def test_slope_is_the_cosine_to_an_axis():
    surface = sphere(10.0, subdivisions=4)
    points = points_of(surface)
    found = fields("up = { slope = [0, 0, 3] }", surface).scalar("up")(points)
    place = points.positions(surface) + surface.origin_mm
    np.testing.assert_allclose(found, place[:, 2] / np.linalg.norm(place, axis=1), atol=0.01)


def test_occlusion_is_nothing_on_a_ball_and_much_inside_one():
    ball = sphere(10.0, subdivisions=3)
    inside = Surface.from_arrays(ball.vertices, ball.faces[:, ::-1])
    points = points_of(ball, 50)
    assert np.abs(fields('o = { occlusion = "50 mm" }', ball).scalar("o")(points)).max() < 1e-6
    assert fields('o = { occlusion = "1000 mm" }', inside).scalar("o")(points).min() > 0.95


def test_vectors_of_an_attribute_have_their_length_and_may_be_turned():
    bare = plane(10.0, cells=6)
    surface = bare.with_attributes({"pull": np.tile([0.0, 2.0, 0.0], (len(bare.vertices), 1))})
    text = 'v = { vector_attribute = "pull" }\nw = { vector_attribute = "pull", perpendicular = true }'
    made = fields(text, surface)
    points = points_of(surface, 30)
    frame = surface.frame[points.face]
    for name, expected in (("v", [0, 2, 0]), ("w", [-2, 0, 0])):
        found = np.einsum("pk,pki->pi", made.vectors(name).at(points), frame[:, :2])
        np.testing.assert_allclose(found, np.tile(expected, (30, 1)), atol=1e-9)


def test_curves_carry_their_own_width_and_depth(tmp_path):
    surface = plane(10.0, cells=8)
    strokes = [{"points": [[1, 1, 0], [5, 2, 0], [9, 1, 0]], "width_mm": 0.7}, [[1, 8, 0], [9, 8, 0]]]
    (tmp_path / "lines.json").write_text(json.dumps({"strokes": strokes}))
    table = fields('c = { curves = "lines.json", depth = "0.3 mm" }', surface, tmp_path).curves("c")
    widths = {int(number): width for number, width in zip(table["curve"], table["width_mm"], strict=True)}
    assert widths == {0: pytest.approx(0.7), 1: pytest.approx(1.0)}
    np.testing.assert_allclose(table["depth_mm"], 0.3)
    straight = table[table["curve"] == 1]
    assert straight["length_mm"][0] == pytest.approx(8.0)


def test_circles_of_distances_are_refused():
    text = '[fields]\na = "b"\nb = { distance_to = "a" }' + LAYER
    with pytest.raises(RecipeError, match=r"circle|itself"):
        recipe_from_text(text)


def test_as_many_distances_as_may_build_on_one_another_do():
    surface = plane(10.0, cells=3)
    nested = "(" * 50 + "d{}" + " + 0)" * 50
    lines = [f'd{i} = {{ distance_to = "{nested.format(i - 1)}", level = 0 }}' for i in range(1, 6)]
    made = fields("\n".join(['d0 = "x - 5"', *lines]), surface)
    points = SurfacePoints(np.arange(18), np.full((18, 3), 1 / 3))
    np.testing.assert_allclose(np.abs(made["d5"](points)), np.abs(made["d0"](points)), atol=0.2)
    low, high = made["d5"].span()
    assert (low <= high).all()
    with pytest.raises(RecipeError, match="too many fields build on one another below 'd6'"):
        fields("\n".join(['d0 = "x - 5"', *lines, f'd6 = "{nested.format(5)}"']), surface)


def test_a_place_that_is_far_off_is_told():
    with pytest.raises(RecipeError, match=r"d: positions\[0\] .* lies off a surface of 14.14 mm"):
        fields("d = { distance_to = [1e90, 0, 0] }", plane(10.0, cells=3))


def test_a_recipe_that_remembers_its_lines_can_be_sent_to_another_process():
    recipe = recipe_from_text(f"[fields]\nside = {{ gradient = [1, 0, 0] }}{LAYER}", name="r.toml")
    again = pickle.loads(pickle.dumps(Recipe.of(recipe, resolution=64)))
    assert again.where("fields", "side") == "r.toml:2: "
    assert again.bake.resolution == 64


def test_langer_lines_are_those_that_a_skin_takes_by_itself():
    from surftex.materials.skin.model import Skin
    from surftex.materials.skin.placing import tension

    ball = sphere(10.0, subdivisions=3)
    surface = Surface.from_arrays(ball.vertices * [1, 1, 2], ball.faces)
    made = fields('lines = { direction = "langer" }', surface)
    own = tension(Skin(), surface, made).angle_rad
    turned = np.sin(made.direction("lines").angle_rad - own)
    np.testing.assert_allclose(turned, 0, atol=1e-6)


@pytest.mark.parametrize("mask", ["y > 7", "noise - 0.1"])
def test_the_side_of_a_border_is_that_of_its_mask_and_the_span_holds_on_coarse_faces(mask):
    ball = sphere(60.0, subdivisions=1)
    text = f"""
    noise = {{ noise = 1, wavelength = 45 }}
    mask = "{mask}"
    away = {{ distance_to = "mask" }}
    near = "clamp(1 - abs(away) / 5, 0, 1)"
    """
    made = fields(text, ball)
    points = points_of(ball, 6000)
    away, inside = made["away"](points), made["mask"](points) > 0.5
    assert ((away < 0) == inside).all()
    for name in ("away", "near"):
        low, high = made[name].span()
        value = made[name](points)
        assert (value >= low[points.face] - 1e-9).all()
        assert (value <= high[points.face] + 1e-9).all()
    if mask == "y > 7":  # meridians are the shortest ways to a circle of latitude
        turn = np.arcsin(np.clip(points.positions(ball)[:, 1] / 60, -1, 1)) - np.arcsin(7 / 60)
        near = np.abs(turn) < 0.3
        assert np.abs(np.abs(away) - 60 * np.abs(turn))[near].max() < 5
        assert (
            np.abs(away)[np.abs(points.positions(ball)[:, 1] - 7) < 0.3].max() < 0.6
        )  # no jump where it changes its sign


@pytest.mark.parametrize(
    ("stroke", "message"),
    [
        ([[1, 1, 0], [1, 1, 0]], r"r.toml:2: fields.c: s.json: strokes\[0\] has no length"),
        ([[1, 1, 0], [2, 1, 0], [32, 1, 0]], r"strokes\[0\] leads from one piece .* places 2 and 3"),
    ],
)
@pytest.mark.parametrize("entry", ['{ curves = "s.json" }', '{ distance_to = "s.json" }'])
def test_strokes_that_lead_nowhere_are_refused(tmp_path, stroke, message, entry):
    one = plane(10.0, cells=2)
    vertices = np.concatenate([one.vertices, one.vertices + np.array([30.0, 0.0, 0.0])])
    surface = Surface.from_arrays(vertices, np.concatenate([one.faces, one.faces + len(one.vertices)]))
    (tmp_path / "s.json").write_text(json.dumps({"strokes": [stroke]}))
    with pytest.raises(RecipeError, match=message):
        fields(f"c = {entry}", surface, tmp_path)
