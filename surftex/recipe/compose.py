"""Putting a recipe together from a material, a mesh and the options of a command or a batch."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from surftex.recipe.mistakes import checked_recipe
from surftex.recipe.model import MeshSettings, Recipe


def composed(recipe: Recipe, mesh: str | Path | None, scale: Mapping[str, Any], **settings: Any) -> Recipe:
    """Give a recipe its mesh and its settings.

    Parameters
    ----------
    recipe : Recipe
        The material, and what it says of mesh and bake.
    mesh : path, optional
        Bake this one; the recipe's own without it. How the recipe's own mesh was to be read says nothing of
        another.
    scale : mapping
        ``units``, ``size``, ``part``, ``crease``; None leaves what is there.
    **settings : Any
        As for `Recipe.of`.

    Returns
    -------
    recipe : Recipe
        Checked.

    Raises
    ------
    RecipeError
        If a setting is wrong.
    """
    whole = Recipe.of(recipe, **settings)
    settings_of_mesh = whole.mesh
    if mesh is not None:
        settings_of_mesh = MeshSettings() if settings_of_mesh.path is not None else settings_of_mesh
        settings_of_mesh = settings_of_mesh.model_copy(update={"path": str(mesh)})
    values = whole.written_keys()
    given = {key: value for key, value in scale.items() if value is not None}
    values["mesh"] = {**settings_of_mesh.model_dump(), **given}
    return checked_recipe(values).located(whole.places)
