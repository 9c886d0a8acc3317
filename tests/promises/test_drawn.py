"""Drawn soups, recipes, pictures and models: refused in a line, or sound all the way."""

import numpy as np
from hypothesis import HealthCheck, given, settings

import surftex as sx
from surftex.errors import InputError
from surftex.exemplar.store import as_json, packed, unpacked
from surftex.fields.expressions import Expression
from surftex.files.decoding import decoded
from surftex.files.doors import as_surface
from surftex.files.images import png_bytes
from surftex.recipe.read import recipe_from_text
from surftex.recipe.write import recipe_text
from surftex.surface.points import SurfacePoints
from tests.strategies import expressions, pictures, recipes, soups, texture_models

slowly = settings(max_examples=8, suppress_health_check=[HealthCheck.too_slow])


@given(soups())
@settings(max_examples=40)
def test_a_soup_is_a_line_or_a_sound_surface_with_distances(soup):
    surface = surface_of(soup)
    if surface is None:
        return
    assert np.isfinite(surface.vertices).all()
    assert (surface.face_area_mm2 > 0).all()
    assert len(surface.fans[1]) == 3 * len(surface.faces)
    every = np.arange(len(surface.faces))
    middles = SurfacePoints(every, np.full((len(every), 3), 1 / 3))
    walked = sx.geodesic_distance(surface, first(middles), middles)
    assert not np.isnan(walked).any()
    assert (np.isinf(walked) == (surface.component != surface.component[0])).all()
    apart = np.linalg.norm(middles.positions(surface) - middles.positions(surface)[0], axis=1)
    assert (walked >= apart * (1 - 1e-9) - 1e-9).all()


@given(soups(most=9))
@slowly
def test_a_soup_that_can_be_walked_on_can_be_baked(soup):
    surface = surface_of(soup)
    if surface is None:
        return
    maps = sx.bake(surface, sx.Leather(cell_size=60.0, pore_density=1e-4), resolution=32, threads=1)
    for name in maps:
        assert np.isfinite(maps[name]).all(), name


def surface_of(soup):
    try:
        return as_surface(soup, size="300 mm")
    except InputError as problem:
        return refused(problem)


def refused(problem):
    """A line of its own words."""
    assert str(problem).isprintable()
    assert str(problem)


def first(points):
    return SurfacePoints(points.face[:1], points.barycentric[:1])


@given(expressions())
def test_an_expression_lies_within_its_span(text):
    known = Expression.parse(text)
    low, high = known.span(lambda name: (np.array([-2.0]), np.array([3.0])), 1)
    random = np.random.Generator(np.random.PCG64(1))
    try:
        values = known.evaluate(lambda name: random.uniform(-2, 3, 40), 40)
    except InputError:
        return  # not finite somewhere, and said so
    room = 1e-9 * (1 + np.abs(values))
    assert (values >= low - room).all()
    assert (values <= high + room).all()


@given(recipes())
@settings(max_examples=15)
def test_a_recipe_is_the_same_after_it_was_written(tmp_path_factory, text):
    folder = tmp_path_factory.getbasetemp()
    recipe = recipe_from_text(text, folder=folder)
    again = recipe_from_text(recipe_text(recipe, folder), folder=folder)
    assert again.written_out() == recipe.written_out()


@given(recipes())
@slowly
def test_a_recipe_bakes_or_is_a_line(text):
    ball = sx.shapes.sphere(12.0, subdivisions=1)
    try:
        maps = sx.bake(ball, recipe_from_text(text), threads=1)
    except InputError as problem:
        refused(problem)
    else:
        assert all(np.isfinite(maps[name]).all() for name in maps)


@given(pictures())
def test_a_png_gives_its_pixels_back(pixels):
    np.testing.assert_array_equal(np.squeeze(decoded(png_bytes(pixels), "a")), np.squeeze(pixels))


@given(texture_models())
@slowly
def test_a_model_is_the_same_after_it_was_written(model):
    for data in (packed(model), as_json(model).encode()):
        again = unpacked(data)
        assert packed(again) == packed(unpacked(packed(model)))
    drawn = again.synthesize(20, 16, 1, sweeps=1, threads=1)
    np.testing.assert_array_equal(drawn, again.synthesize(20, 16, 1, sweeps=1, threads=2))
