"""Expressions for sizes: told by the name that the user wrote."""

import pytest

import surftex as sx
from surftex.bake.cost import bake_cost
from surftex.errors import RecipeError
from surftex.recipe.model import Recipe
from surftex.surface.shapes import sphere

BALL = sphere(10.0, subdivisions=3)
WRONG = {
    "size": ({"cell_size": "z"}, r"leather\.cell_size: 'z' falls to -\d.*; it must stay above 0"),
    "size that varies": ({"cell_size": "z", "size_variation": 0.3}, r"leather\.cell_size: 'z' falls to -\d"),
    "ratio": (
        {"cell_ratio": "0.5 + 0 * x"},
        r"leather\.cell_ratio: .* falls to 0\.5, .*; it must be at least 1",
    ),
    "no field": ({"cell_ratio": "toe"}, r"leather\.cell_ratio: 'toe': unknown field"),
}


@pytest.mark.parametrize(("changes", "says"), WRONG.values(), ids=WRONG)
def test_a_size_that_cannot_be_is_told_by_its_own_name(changes, says):
    leather = sx.Leather(**{"cell_size": 2.0, **changes})
    with pytest.raises(RecipeError, match=f"^{says}"):
        leather.place(BALL)
    with pytest.raises(RecipeError, match=says.split(".", 1)[1]):
        bake_cost(BALL, "mine", Recipe.of(leather))
