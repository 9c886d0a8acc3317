"""The walk over the page: tiles and threads change no byte, layers cover by their masks."""

import numpy as np
import pytest

from surftex.bake.fields import make_fields
from surftex.bake.pages import bake_pages, chosen_maps
from surftex.bake.stack import feature_counts, layer_seed, place_stack
from surftex.charts.unwrap import unwrap
from surftex.errors import InputError, RecipeError
from surftex.recipe.layer import Layer
from surftex.recipe.model import Recipe
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.shapes import cylinder, sphere
from tests.bake.waves import Waves


def stacked(surface, *layers, fields=None, seed=3):
    recipe = Recipe(seed=seed, layer=layers, fields=fields or {})
    return place_stack(recipe, surface, make_fields(recipe, surface))


@pytest.fixture(scope="module")
def tube():
    surface = cylinder(20.0, 60.0)
    return surface, unwrap(surface, method="uvunwrap", resolution=256)


@pytest.fixture(scope="module")
def ball():
    surface = sphere(20.0, subdivisions=3)
    return surface, unwrap(surface, method="uvunwrap", resolution=128, gutter_px=12)


MAPS = ("normal", "height", "base_color", "region", "ambient_occlusion")


@pytest.mark.parametrize(("tile_rows", "threads"), [(256, 1), (100, 2), (31, 1), (17, 2)])
def test_tiles_and_threads_change_no_byte(tube, tile_rows, threads):
    surface, atlas = tube
    stack = stacked(surface, Layer(material=Waves()))
    whole = bake_pages(surface, atlas, stack, 256, MAPS, threads=1)
    parts = bake_pages(surface, atlas, stack, 256, MAPS, tile_rows=tile_rows, threads=threads)
    assert (whole.core, whole.mapped) == (parts.core, parts.mapped)
    for name in MAPS:
        assert whole.images[name].tobytes() == parts.images[name].tobytes(), name


@pytest.mark.parametrize(
    ("shape", "gutter", "tile_rows"), [("tube", 3, None), ("ball", 12, None), ("ball", 12, 31)]
)
def test_the_page_holds_what_the_pattern_says_at_its_texels(shape, gutter, tile_rows, request):
    from surftex.charts.texels import EXACT_PX, texels
    from surftex.maps.normal import normal_map

    surface, atlas = request.getfixturevalue(shape)
    stack = stacked(surface, Layer(material=Waves()))
    asked = ("height", "base_color", "normal")
    pages = bake_pages(surface, atlas, stack, 128, asked, gutter_px=gutter, tile_rows=tile_rows)
    tile = texels(surface, atlas, 128, gutter_px=gutter, exact_px=EXACT_PX)
    assert (np.count_nonzero(tile.source != np.arange(len(tile))) > 500) == (gutter > 3)
    expected = stack.at(tile.samples, ("height_mm", "base_color"))
    np.testing.assert_array_equal(pages.images["height"].ravel()[tile.texel], expected["height_mm"])
    np.testing.assert_array_equal(
        pages.images["base_color"].reshape(-1, 3)[tile.texel], expected["base_color"]
    )
    normal = normal_map(surface, atlas, tile, expected["height_mm"])
    np.testing.assert_allclose(pages.images["normal"].reshape(-1, 3)[tile.texel], normal, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(pages.images["normal"], axis=2), 1, atol=1e-5)
    assert pages.core == tile.core.sum()
    assert pages.mapped == len(tile)


def test_layers_cover_what_lies_below_by_their_masks():
    surface = sphere(20.0, subdivisions=2)
    low, high = Waves(height=1.0, spots=5), Waves(wavelength=9.0, height=2.0, spots=7)
    both = stacked(surface, Layer(material=low), Layer(material=high, mask="clamp(z / 10, 0, 1)"))
    numbers = np.arange(len(surface.faces), dtype=np.int32)
    points = SurfacePoints(numbers, np.full((len(numbers), 3), 1 / 3))
    samples = Samples(points, np.full(len(numbers), 0.1, np.float32))
    cover = np.clip(points.positions(surface)[:, 2] / 10, 0, 1)
    first, second = (pattern.at(samples) for pattern in both.patterns)
    mixed = both.at(samples, ("height_mm", "base_color", "region"))
    np.testing.assert_allclose(
        mixed["height_mm"], first["height_mm"] * (1 - cover) + second["height_mm"] * cover, atol=1e-6
    )
    np.testing.assert_allclose(mixed["base_color"][cover == 0], first["base_color"][cover == 0])
    np.testing.assert_allclose(mixed["base_color"][cover == 1], second["base_color"][cover == 1])
    assert feature_counts(both.features) == {"spot": 5, "layer2_spot": 7}
    assert (first["height_mm"] != second["height_mm"] / 2).any()


def test_where_no_layer_covers_the_surface_is_bare():
    surface = sphere(20.0, subdivisions=2)
    stack = stacked(surface, Layer(material=Waves(), mask=0))
    points = Samples(stack_points(surface), np.full(10, 0.1, np.float32))
    values = stack.at(points, ("height_mm", "base_color", "region"))
    assert (values["height_mm"] == 0).all()
    assert (values["base_color"] == 0.5).all()
    assert (values["region"] == -1).all()


def stack_points(surface):
    return SurfacePoints(np.arange(10), np.full((10, 3), 1 / 3))


def test_features_of_each_layer_are_handed_back_to_it():
    surface = sphere(20.0, subdivisions=2)
    recipe = Recipe(seed=3, layer=(Layer(material=Waves(spots=4)), Layer(material=Waves(spots=6), mask=0.5)))
    fields = make_fields(recipe, surface)
    first = place_stack(recipe, surface, fields)
    again = place_stack(recipe, surface, fields, features=first.features)
    assert {kind: table.tobytes() for kind, table in first.features.items()} == {
        kind: table.tobytes() for kind, table in again.features.items()
    }
    assert layer_seed(3, 0) == 3
    assert layer_seed(3, 1) != 3
    with pytest.raises(RecipeError, match=r"layer\[2\]: the features file holds nothing for this layer"):
        place_stack(recipe, surface, fields, features={"spot": first.features["spot"]})


def test_a_layer_that_does_not_fit_is_named():
    surface = sphere(20.0, subdivisions=2)
    with pytest.raises(RecipeError, match=r"^layer\[2\].mask: the mesh has no part 'lid'"):
        stacked(surface, Layer(material=Waves()), Layer(material=Waves(), mask="part('lid')"))
    recipe = Recipe(layer=(Layer(material=Waves()),), bake={"max_features": 3})
    with pytest.raises(RecipeError, match=r"^layer: 20 spots are more than max_features = 3"):
        place_stack(recipe, surface, make_fields(recipe, surface))


def test_maps_are_what_the_layers_make():
    stack = stacked(sphere(20.0, subdivisions=1), Layer(material=Waves()))
    assert chosen_maps(stack, None) == ("base_color", "roughness", "normal", "height")
    assert chosen_maps(stack, ("region", "height")) == ("region", "height")
    with pytest.raises(
        InputError, match="no layer makes the map 'metallic'; these layers make base_color, roughness"
    ):
        chosen_maps(stack, ("metallic",))


def test_progress_is_told_and_may_cancel(tube):
    surface, atlas = tube
    stack = stacked(surface, Layer(material=Waves()))
    told = []
    bake_pages(surface, atlas, stack, 128, ("height",), tile_rows=50, tick=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0

    class StopError(Exception):
        pass

    def stop(share):
        raise StopError

    with pytest.raises(StopError):
        bake_pages(surface, atlas, stack, 128, ("height",), tick=stop)


def test_layers_share_what_is_allowed_of_features():
    surface = sphere(20.0, subdivisions=2)
    layers = (Layer(material=Waves()), Layer(material=Waves()))
    recipe = Recipe(layer=layers, bake={"max_features": 40})
    assert len(place_stack(recipe, surface, make_fields(recipe, surface)).patterns) == 2
    short = Recipe(layer=layers, bake={"max_features": 39})
    with pytest.raises(RecipeError, match=r"^layer\[2\]: 20 spots are more than max_features = 19"):
        place_stack(short, surface, make_fields(recipe, surface))
