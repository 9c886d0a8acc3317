"""--set: what it may name, what its values mean, and what it says when that is unclear."""

import pytest

from surftex.errors import RecipeError
from surftex.recipe.read import recipe_from_preset, recipe_from_text

ONE = "[[layer]]\npreset = 'calf'\n[fields]\ntoe = 0.5\n"
TWO = "[[layer]]\npreset = 'calf'\n[[layer]]\nmaterial = 'leather'\npreset = 'goat'\n"


@pytest.mark.parametrize(
    "change",
    [
        "cell_size=2 mm",
        "cell_size='2 mm'",
        'leather.cell_size="2 mm"',
        "calf.cell_size = 2",
        "layer.cell_size=2.0",
        "layer[1].cell_size=0.2cm",
    ],
)
def test_the_only_layer_has_many_names(change):
    assert recipe_from_text(ONE, changes=[change]).layer[0].material.cell_size == 2.0
    assert recipe_from_preset("calf", changes=[change]).layer[0].material.cell_size == 2.0


def test_one_of_two_layers_is_named():
    recipe = recipe_from_text(
        TWO, changes=["layer[2].cell_size=2", "calf.cell_size=3", "goat.pore_density='2 * 3'"]
    )
    assert [layer.material.cell_size for layer in recipe.layer] == [3.0, 2.0]
    assert recipe.layer[1].material.pore_density == "2 * 3"


def test_tables_and_the_seed_can_be_set():
    recipe = recipe_from_text(
        ONE,
        changes=[
            "bake.resolution=64",
            "seed=9",
            "fields.toe=z / 2",
            "fields.new={ part = 'a' }",
            "mask=1 - toe",
            "bake.maps=height,normal",
            "mesh.size=30 cm",
        ],
    )
    assert (recipe.bake.resolution, recipe.seed, recipe.fields_["toe"]) == (64, 9, "z / 2")
    assert recipe.fields_["new"].part == "a"
    assert recipe.bake.maps == ("height", "normal")
    assert recipe.mesh.size == 300.0
    assert recipe.layer[0].mask == "1 - toe"


@pytest.mark.parametrize(
    ("text", "change", "says"),
    [
        (
            TWO,
            "cell_size=2",
            "--set cell_size=2: which layer? Write one of layer[1], layer[2] before the key",
        ),
        (ONE, "goat.cell_size=2", "--set goat.cell_size=2: nothing is called 'goat'"),
        (ONE, "clf.cell_size=2", "did you mean calf?"),
        (ONE, "layer[2].cell_size=2", "there is no layer[2]; layers count from 1 to 1"),
        (ONE, "cell_sise=2", "--set cell_sise=2: layer.cell_sise: unknown key; did you mean cell_size?"),
        (ONE, "cell_size", "is no change; write key=value"),
        (ONE, ".=1", "is no change"),
        (
            ONE,
            "bake.resolution=big",
            "--set bake.resolution=big: bake.resolution: 'big': should be a valid integer",
        ),
        (ONE, "fields.toe.deeper=1", "toe is no table"),
        (
            ONE.replace("[fields]", "color = [0.2, 0.1, 0.1]\n[fields]"),
            "layer.color.red=1",
            "color is no table",
        ),
        (ONE, "fields.a=fields", "unknown field 'fields'"),
        (ONE, "cell_size=1\nseed = 3", "cell_size: '1\\nseed = 3'"),
    ],
)
def test_unclear_changes_are_refused(text, change, says):
    with pytest.raises(RecipeError) as refused:
        recipe_from_text(text, changes=[change])
    assert says in str(refused.value)
