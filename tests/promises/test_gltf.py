"""Whatever a bake writes as GLB is right by Khronos' validator: skin, leather in parts, tiles with pictures beside, relief."""

import pytest

from surftex.bake.bake import run
from surftex.bake.saving import save
from surftex.materials.leather.model import Leather
from surftex.materials.skin.model import Skin
from surftex.recipe.model import Recipe
from surftex.surface.shapes import sphere
from tests.bake.test_udim import two_tiles
from tests.files.test_glb import issues, parted_ball, validator

LEATHER = Leather.preset("calf", cell_size=4.0)


@pytest.mark.parametrize(
    ("subject", "recipe"),
    [
        (lambda: sphere(20.0, subdivisions=3), Recipe.of(Skin(), resolution=128)),
        (parted_ball, Recipe.of(LEATHER, resolution=128)),
        (two_tiles, Recipe.of(LEATHER, resolution=128, udim=True, uv="keep")),
        (parted_ball, Recipe.of(LEATHER, resolution=64, displaced=True)),
    ],
    ids=["skin", "parts", "udim", "displaced"],
)
def test_what_a_bake_writes_is_valid(subject, recipe, tmp_path):
    validator()
    paths = [
        path for path in save(run(recipe, subject()), tmp_path / "my out", threads=1) if path.suffix == ".glb"
    ]
    assert len(paths) == 1 + recipe.bake.displaced
    for path in paths:
        found = issues(path)
        assert (found["numErrors"], found["numWarnings"]) == (0, 0), found["messages"][:3]


def test_the_validator_looks_at_pictures_beside(tmp_path):
    validator()
    paths = save(run(Recipe.of(LEATHER, resolution=64, udim=True, uv="keep"), two_tiles()), tmp_path / "out")
    picture = next(path for path in paths if path.name.endswith("_orm.1002.png"))
    picture.unlink()
    assert issues(next(path for path in paths if path.suffix == ".glb"))["numErrors"] > 0
