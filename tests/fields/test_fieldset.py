"""Named fields: pictures through UVs, parts, gradients, curvature, noise, and expressions over them."""

import numpy as np
import pytest

from surftex.errors import RecipeError
from surftex.fields.curvature import curvature_field, mean_curvature
from surftex.fields.fieldset import FieldSet
from surftex.fields.noise import Noise
from surftex.fields.sources import constant_field, gradient_field, image_field, noise_field, part_field
from surftex.randomness import stream
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import cylinder, plane, sphere, torus
from surftex.surface.surface import Surface


def random_points(surface, count, seed=0):
    numbers = stream(seed, "test").uniform(count, 3)
    face = (numbers[:, 0] * len(surface.faces)).astype(np.int32)
    a, b = np.sqrt(numbers[:, 1]), numbers[:, 2]
    return SurfacePoints(face, np.stack([1 - a, a * (1 - b), a * b], axis=1))


def two_parts():
    base = plane(10.0, cells=4)
    return Surface.from_arrays(
        base.vertices,
        base.faces,
        corner_uv=base.corner_uv,
        origin_mm=(100.0, 0.0, 0.0),
        part=(base.vertices[base.faces][:, :, 0].mean(axis=1) > 5).astype(int),
        part_names=("left", "right"),
    )


def test_coordinates_are_the_files_own_and_parts_are_named():
    surface = two_parts()
    points = random_points(surface, 200)
    fields = FieldSet(surface, {"half": "part('right')", "far": "x - 100 + 2 * half"})
    place = points.positions(surface)
    np.testing.assert_allclose(fields["half"](points), place[:, 0] > 5)
    np.testing.assert_allclose(
        fields.scalar("far * 2 + y")(points), 2 * (place[:, 0] + 2 * (place[:, 0] > 5)) + place[:, 1]
    )
    assert fields.names == ("far", "half")
    assert "far" in fields
    assert "near" not in fields


def test_a_picture_is_read_between_its_pixels():
    surface = plane(10.0, cells=4)
    rows, columns = np.mgrid[0:40, 0:80]
    picture = (columns + 0.5) / 80 + 3 * (1 - (rows + 0.5) / 40)  # u + 3 v
    points = random_points(surface, 500)
    place = points.positions(surface) / 10
    inside = (np.abs(place[:, :2] - 0.5) < 0.48).all(axis=1)
    read = image_field(surface, picture)(points)
    np.testing.assert_allclose(read[inside], (place[:, 0] + 3 * place[:, 1])[inside], atol=1e-12)


def test_a_picture_needs_uvs_and_one_number_per_pixel():
    with pytest.raises(RecipeError, match="needs the mesh's own UVs"):
        image_field(sphere(subdivisions=1), np.zeros((4, 4)))
    with pytest.raises(RecipeError, match="one number per pixel"):
        image_field(plane(), np.zeros((4, 4, 3)))
    with pytest.raises(RecipeError, match="1 pixels that are not finite"):
        image_field(plane(), np.array([[np.nan, 1.0]]))


def test_a_gradient_runs_over_the_extent_or_between_given_ends():
    surface = cylinder(20.0, 60.0)
    points = random_points(surface, 100)
    height = points.positions(surface)[:, 2]
    np.testing.assert_allclose(gradient_field(surface, [0, 0, 5])(points), height / 60, atol=1e-12)
    np.testing.assert_allclose(
        gradient_field(surface, [0, 0, 1], 40, 20)(points), np.clip((40 - height) / 20, 0, 1)
    )
    with pytest.raises(RecipeError, match="no direction"):
        gradient_field(surface, [0, 0, 0])
    with pytest.raises(RecipeError, match="does the surface extend"):
        gradient_field(plane(), [0, 0, 1])


@pytest.mark.parametrize("radius_mm", [10.0, 40.0])
def test_mean_curvature_of_a_ball_is_one_over_its_radius(radius_mm):
    worst = []
    for subdivisions in (2, 3):
        curvature = mean_curvature(sphere(radius_mm, subdivisions=subdivisions), radius_mm / 3)
        worst.append(np.abs(curvature * radius_mm - 1).max())
    assert worst[1] < 0.02
    assert worst[1] < worst[0]


def test_vertices_of_no_face_change_no_curvature():
    ball = sphere(20.0, subdivisions=2)
    more = Surface.from_arrays(np.concatenate([ball.vertices, [[0.0, 0.0, 0.0]]]), ball.faces)
    curvature = mean_curvature(more, 3.0)
    np.testing.assert_allclose(curvature[:-1], mean_curvature(ball, 3.0), rtol=1e-4)
    assert curvature[-1] == 0


def test_convex_and_concave_tell_the_outside_of_a_torus_from_its_hole():
    surface = torus(30.0, 12.0)
    points = random_points(surface, 300)
    place = points.positions(surface)
    away = np.hypot(place[:, 0], place[:, 1])
    convex = curvature_field(surface, "convex", 6.0)(points)
    mean = 0.5 * (1 / 12 + (away - 30) / 12 / away)
    np.testing.assert_allclose(convex, np.clip(6 * mean, 0, 1), atol=0.05)
    assert (curvature_field(surface, "concave", 6.0)(points) == 0).all()
    flipped = Surface.from_arrays(surface.vertices, surface.faces[:, ::-1])
    assert curvature_field(flipped, "concave", 6.0)(points).min() > 0.1
    assert curvature_field(plane(), "convex", 2.0)(random_points(plane(), 9)).max() < 1e-9


def test_noise_keeps_to_its_range_and_fades():
    surface = plane(40.0)
    points = random_points(surface, 2000)
    field = noise_field(surface, Noise(stream(1, "wear"), 3.0), 0.2, 0.8)
    assert 0.2 <= field(points).min() < 0.35
    assert 0.65 < field(points).max() <= 0.8
    np.testing.assert_array_equal(field(points, 3.0), 0.5)


@pytest.mark.parametrize(
    ("numbers", "says"),
    [
        ({"a": "b", "b": "c + 1", "c": "2 * a"}, "a -> b -> c -> a"),
        ({"a": "a"}, "a -> a"),
        ({"toe": 1.0, "a": "1 - tow"}, "unknown field 'tow'; did you mean 'toe'"),
        ({"a": "part('midle')"}, "no part 'midle'; it has 'left', 'right'"),
        ({"max": 1.0}, "a function or a coordinate"),
        ({"two words": 1.0}, "letters, digits"),
        ({"a": "grain + 1"}, "is a direction, not a number"),
        ({"grain": 1.0}, "both a number and a direction"),
        ({"a": True}, "not an expression"),
        ({"a": 10**400}, "000 is not finite"),
        (
            {"f0": "x", **{f"f{i}": f"f{i - 1} + f{i - 1}" for i in range(1, 2000)}},
            "build on one another below",
        ),
    ],
)
def test_wrong_fields_are_refused(numbers, says):
    with pytest.raises(RecipeError) as refused:
        FieldSet(two_parts(), numbers, {"grain": object})
    assert says in str(refused.value)


def test_shared_needs_are_no_circle():
    fields = FieldSet(two_parts(), {"a": "b + c", "b": "d", "c": "d", "d": constant_field(2.0)})
    assert fields.scalar("a")(random_points(fields.surface, 3)).tolist() == [4, 4, 4]


def test_as_many_fields_as_may_build_on_one_another_do():
    nested = "(" * 50 + "{}" + " + 0)" * 50
    fields = FieldSet(two_parts(), {"f0": "x", **{f"f{i}": nested.format(f"f{i - 1}") for i in range(1, 6)}})
    points = random_points(fields.surface, 5)
    np.testing.assert_array_equal(fields["f5"](points), fields["f0"](points))
    low, high = fields["f5"].span()
    assert (low <= high).all()


def test_directions_are_made_once_and_looked_up_by_name():
    made = []
    fields = FieldSet(
        two_parts(), {"toe": 1.0}, {"grain": lambda: made.append(1) or "a direction"}, {"lines": list}
    )
    assert not made
    assert fields.direction("grain") == fields.direction("grain") == "a direction"
    assert made == [1]
    with pytest.raises(RecipeError, match="unknown direction 'grian'; did you mean 'grain'"):
        fields.direction("grian")
    for name, kind in (("toe", "a number"), ("lines", "curves")):
        with pytest.raises(RecipeError, match=f"field '{name}' is {kind}; directions"):
            fields.direction(name)
    for name, kind in (("toe", "a number"), ("grain", "a direction")):
        with pytest.raises(RecipeError, match=f"field '{name}' is {kind}; curves"):
            fields.curves(name)


def test_part_names_are_told_when_wrong():
    with pytest.raises(RecipeError, match="has 'surface'"):
        part_field(plane(), "upper")


def test_every_source_keeps_to_its_span():
    surface = plane(10.0, cells=6)
    pixels = stream(4, "test").uniform(37, 53)
    fields = FieldSet(
        surface,
        {
            "picture": image_field(surface, pixels),
            "up": gradient_field(surface, [1, 2, 0], 3.0, 12.0),
            "spots": noise_field(surface, Noise(stream(1, "spots"), 2.0, 3), -1.0, 2.0),
            "all": "picture * (1 - up) + 0.2 * spots ** 2 - x / 10",
        },
    )
    points = random_points(surface, 20_000)
    for name in fields.names:
        low, high = fields[name].span()
        values = fields[name](points)
        assert (values >= low[points.face] - 1e-12).all()
        assert (values <= high[points.face] + 1e-12).all()
    low, high = fields["picture"].span()
    assert (high - low).mean() < 1.0  # of each face alone: the whole picture spans 1
    assert fields["picture"].span()[1].max() <= pixels.max()


def test_the_span_of_a_picture_holds_across_its_edge():
    base = plane(10.0, cells=40)
    surface = Surface.from_arrays(base.vertices, base.faces, corner_uv=base.corner_uv * 3.3 - 1.4)
    field = image_field(surface, stream(5, "test").uniform(20, 9))
    points = random_points(surface, 20_000)
    low, high = field.span()
    values = field(points)
    assert (values >= low[points.face] - 1e-12).all()
    assert (values <= high[points.face] + 1e-12).all()
