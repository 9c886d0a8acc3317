"""Unwraps and features of an earlier run: the same bytes, less work, and never those of something else."""

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import surftex.bake.remembering as remembering
from surftex.bake.bake import run
from surftex.charts import unwrap
from surftex.errors import RecipeError
from surftex.files import shelf
from surftex.materials.leather.model import Leather
from surftex.recipe.model import Recipe
from surftex.surface.shapes import sphere


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.setenv("SURFTEX_CACHE_DIR", str(tmp_path))


def recipe(**changes):
    seed = changes.pop("seed", 3)
    leather = Leather.preset("calf", **{"cell_size": 5.0, "wrinkle_density": 0.0, **changes})
    return Recipe.of(leather, resolution=64, seed=seed, maps=("height",))


def height(which, surface=None, **options):
    return run(which, surface or sphere(15.0, subdivisions=2), **options).maps["height"]


def test_remembered_work_gives_the_same_bytes_and_is_not_done_again(monkeypatch):
    fresh = height(recipe())
    assert shelf.held()[0] == 0
    first = height(recipe(), remember=True)
    assert shelf.held()[0] == 2
    monkeypatch.setattr(remembering.shelf, "keep", lambda *a: pytest.fail("kept again"))
    monkeypatch.setattr("surftex.charts.unwrap.unwrap", lambda *a, **k: pytest.fail("unwrapped again"))
    second = height(recipe(), remember=True)
    np.testing.assert_array_equal(first, fresh)
    np.testing.assert_array_equal(second, fresh)


def test_another_seed_parameter_or_surface_is_something_else():
    surface = sphere(15.0, subdivisions=2)
    known = remembering.features_key(recipe(), surface)
    others = [
        remembering.features_key(recipe(seed=4), surface),
        remembering.features_key(recipe(cell_size=5.1), surface),
        remembering.features_key(recipe(), sphere(15.1, subdivisions=2)),
    ]
    assert remembering.features_key(recipe(), surface) == known
    assert len({known, *others}) == 4


def test_another_bound_of_features_places_nothing_anew_and_refuses_all_the_same(monkeypatch):
    first = height(recipe(), remember=True)
    monkeypatch.setattr(
        "surftex.materials.leather.skeleton.place", lambda *a, **k: pytest.fail("placed again")
    )
    wider = Recipe.of(recipe(), max_features=7_000_000)
    np.testing.assert_array_equal(height(wider, remember=True), first)
    with pytest.raises(RecipeError, match="more than the 9 allowed"):
        height(Recipe.of(recipe(), max_features=9), remember=True)


def test_a_picture_that_a_field_reads_counts_by_its_bytes(tmp_path):
    from surftex.files.images import png_bytes
    from surftex.recipe.read import load_recipe

    (tmp_path / "toe.png").write_bytes(png_bytes(np.zeros((4, 4, 3), np.uint8)))
    (tmp_path / "r.toml").write_text(
        '[fields]\ntoe = { image = "toe.png" }\n[[layer]]\npreset = "calf"\nmask = "toe"\n'
    )
    surface = sphere(15.0, subdivisions=2)
    before = remembering.features_key(load_recipe(tmp_path / "r.toml"), surface)
    (tmp_path / "toe.png").write_bytes(png_bytes(np.ones((4, 4, 3), np.uint8)))
    assert remembering.features_key(load_recipe(tmp_path / "r.toml"), surface) != before


def test_a_surface_that_several_bakes_want_is_unwrapped_once(monkeypatch):
    """Jobs of a batch that begin together with the same mesh: one unwraps, the others wait for it."""
    plain, done = unwrap.unwrap, []

    def slow(*arguments, **options):
        done.append(arguments)
        time.sleep(0.5)
        return plain(*arguments, **options)

    monkeypatch.setattr(unwrap, "unwrap", slow)
    with ThreadPoolExecutor(3) as pool:
        found = list(pool.map(lambda seed: height(recipe(seed=seed), remember=True), range(3)))
    assert len(done) == 1
    np.testing.assert_array_equal(found[1], height(recipe(seed=1)))
