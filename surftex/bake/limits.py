"""How many features the layers of a recipe would lay, and the refusal of more than are allowed: told before any work."""

from collections.abc import Sequence
from dataclasses import dataclass

from surftex.bake.covered import fields_on
from surftex.bake.locating import located
from surftex.bake.stack import layer_cover, layer_label, layer_seed
from surftex.fields.fieldset import FieldSet
from surftex.materials.limits import Expected, refuse_more
from surftex.recipe.model import Recipe
from surftex.surface.bodies import Bodies
from surftex.surface.surface import Surface

ABOUT = 1.1
"""By how much the features of a bake may go beyond what was foreseen: as many are taken back within the same bound."""


@dataclass(frozen=True)
class Foreseen:
    """What a layer would lay.

    Attributes
    ----------
    area_mm2 : float
        Of the bodies that it lies on.
    expected : tuple of Expected, or None
        Its features; None of a material that cannot tell.
    """

    area_mm2: float
    expected: tuple[Expected, ...] | None

    @property
    def count(self) -> float:
        """Features of all kinds."""
        return sum(each.count for each in self.expected or ())


def foresee(recipe: Recipe, surface: Surface, fields: FieldSet) -> list[Foreseen]:
    """Tell about how many features each layer would lay.

    Parameters
    ----------
    recipe : Recipe
        Its layers.
    surface : Surface
        The whole.
    fields : FieldSet
        The recipe's fields on it.

    Returns
    -------
    foreseen : list of Foreseen
        Of each layer.

    Raises
    ------
    RecipeError
        If a mask or an expression does not fit; the message names the layer.
    """
    found = []
    for i, layer in enumerate(recipe.layer):
        covered = layer_cover(recipe, i, surface, fields)
        tell = getattr(layer.material, "expected_features", None)
        if not covered.any():
            found.append(Foreseen(0.0, ()))
            continue
        ground, here = surface, fields
        if not covered.all():
            bodies = Bodies.of(surface, covered)
            ground, here = bodies.surface, fields_on(bodies, fields)
        with located(recipe, "layer", i, label=layer_label(recipe, i)):
            expected = tell and tell(ground, layer_seed(recipe.seed, i), fields=here)
        found.append(Foreseen(ground.area_mm2, expected))
    return found


def refuse_too_many(recipe: Recipe, foreseen: Sequence[Foreseen]) -> None:
    """Refuse layers that would lay more features than are allowed of all together.

    Parameters
    ----------
    recipe : Recipe
        Its layers, and what is allowed.
    foreseen : sequence of Foreseen
        From `foresee`.

    Raises
    ------
    RecipeError
        Of the layer that goes beyond it; the message says how many of what, and what to change.
    """
    left = recipe.bake.max_features
    for i, (layer, each) in enumerate(zip(recipe.layer, foreseen, strict=True)):
        with located(recipe, "layer", i, label=layer_label(recipe, i)):
            refuse_more(layer.kind, each.expected or (), each.area_mm2, left)
        left -= round(each.count)
