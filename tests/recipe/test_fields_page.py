"""The page on fields: every entry that it shows is read, every kind is shown, and its example can be made."""

import re
from pathlib import Path

import numpy as np
import pytest

from surftex.bake.fields import make_fields
from surftex.fields.face import face_atlas
from surftex.files.meshes import load
from surftex.recipe.fields import KINDS
from surftex.recipe.read import recipe_from_text
from surftex.surface.closest import closest_points

PAGE = Path(__file__).parents[2] / "docs" / "recipe.md"


@pytest.fixture(scope="module")
def page():
    if not PAGE.is_file():
        pytest.skip("docs/recipe.md is not beside the tests")
    return PAGE.read_text("utf-8")


def test_every_entry_that_is_shown_is_read_and_every_kind_is_shown(page):
    shown = re.findall(r"^\| `(\{.*?\})` \|", page, re.MULTILINE)
    kinds = set()
    for entry in shown:
        text = f'[fields]\nlips = 1\na = {entry}\n[[layer]]\npreset = "calf"\n'
        recipe = recipe_from_text(text, name="page.toml")
        kinds.add(next(key for key, model in KINDS.items() if isinstance(recipe.fields_["a"], model)))
    assert kinds == set(KINDS)
    for name in (*face_atlas()["masks"], *face_atlas()["lines"], *face_atlas()["landmarks"]):
        assert name in page


def test_its_example_can_be_made(page, meshes):
    example = re.search(r"```toml\n(.*?)```", page, re.DOTALL)
    assert example
    recipe = recipe_from_text(example[1], name="page.toml", folder=meshes)
    head = load(meshes / "head.ply", units="mm")
    fields = make_fields(recipe, head)
    lips = closest_points(head, np.array([[0.0, -80, 98]]) - head.origin_mm)[0]
    assert fields.scalar("lips")(lips)[0] > 0.5
    assert fields.scalar("freckled")(lips)[0] == 0
    drawn = sum(len(face_atlas()["lines"][name]["curves"]) for name in ("crows_feet", "forehead", "smile"))
    assert len(np.unique(fields.curves("lines")["curve"])) == drawn
