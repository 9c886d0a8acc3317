"""Whatever a user makes in Python tells its mistakes in one line, in the words of the command."""

import numpy as np
import pytest

import surftex as sx
from surftex.recipe.layer import MATERIALS, material_class
from surftex.recipe.model import BakeSettings, MeshSettings


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: sx.Leather.preset("calf", cell_size=-1), "leather.cell_size: -1: should be greater than 0"),
        (
            lambda: sx.Leather.preset("calf", cell_size="1 parsec/2"),
            None,  # an expression; its names are looked up where the recipe is known
        ),
        (
            lambda: sx.Leather.preset("calf", cel_size=1, crista_heigth=2),
            "leather.cel_size: unknown key; did you mean cell_size?; also leather.crista_heigth: unknown key; did you mean "
            "crista_height?",
        ),
        (lambda: sx.Leather(color="red"), "leather.color: 'red' is no colour; write '#8a5a34'"),
        (lambda: sx.Leather(color=[0, 0, 2]), "leather.color[3]: 2: should be less than or equal to 1"),
        (lambda: sx.Leather.preset("claf"), "there is no leather preset 'claf'; did you mean calf?"),
        (lambda: sx.Recipe(layer=[]), "layer: a recipe needs at least one [[layer]]"),
        (lambda: sx.Recipe(layer=[{"preset": "calf", "cel_size": 1}]), "layer.cel_size: unknown key; did you mean cell_size?"),
        (lambda: BakeSettings(resolution=2), "BakeSettings.resolution: 2: should be greater than or equal to 16"),
        (lambda: BakeSettings(texels_per_mm=2), "BakeSettings: texels_per_mm spreads an unwrap over tiles"),
        (lambda: MeshSettings(siize=2), "MeshSettings.siize: unknown key; did you mean size?"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line_in_plain_words(make, says):
    if says is None:
        make()
        return
    with pytest.raises(sx.RecipeError) as raised:
        make()
    assert str(raised.value).startswith(says)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("kind", MATERIALS)
def test_every_material_does(kind):
    model = material_class(kind)
    wrong = next(key for key in model.model_fields if len(key) > 8) + "s"
    preset = next(iter(model.presets()))
    needed = {"model": "a"} if kind == "composite" else {}
    for make in (lambda: model.preset(preset, **{wrong: 1}), lambda: model(**{wrong: 1}, **needed)):
        with pytest.raises(
            sx.RecipeError, match=rf"^{kind}\.{wrong}: unknown key; did you mean {wrong[:-1]}"
        ):
            make()


@pytest.mark.parametrize("kind", MATERIALS)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, np.float32(np.nan)])
def test_what_is_no_finite_number_is_refused_by_name(kind, value):
    model = material_class(kind)
    needed = {"model": "a"} if kind == "composite" else {}
    for key in model.model_fields:
        with pytest.raises(sx.RecipeError, match=rf"^{kind}\.{key}: ") as raised:
            model(**{key: value}, **{name: text for name, text in needed.items() if name != key})
        assert not np.isnan(value) or "than" not in str(raised.value)


def test_of_many_mistakes_the_first_are_told():
    with pytest.raises(
        sx.RecipeError, match=r"leather\.k0: .*leather\.k7: unknown key.*; and 2 more mistakes$"
    ):
        sx.Leather(**{f"k{i}": 1 for i in range(10)})


def test_numbers_of_numpy_are_taken_as_plain_ones():
    leather = sx.Leather.preset("calf", cell_size=np.float32(2.5), regularity=np.int64(2))
    assert (leather.cell_size, leather.regularity) == (2.5, 2)
    assert BakeSettings(resolution=np.int64(64), udim=np.bool_(True)) == BakeSettings(
        resolution=64, udim=True
    )
    with pytest.raises(sx.RecipeError, match=r"resolution: 64\.5: should be a valid integer"):
        BakeSettings(resolution=np.float64(64.5))


def test_a_preset_is_named_by_text():
    with pytest.raises(sx.RecipeError, match="leather preset None: a preset is named by text, such as"):
        sx.Leather.preset(None)
