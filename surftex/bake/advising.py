"""What a bake can say before it places anything: where materials do not fit the page, and how long it would take."""

from collections.abc import Mapping

from surftex.bake.cost import bake_seconds, foreseen_density
from surftex.bake.limits import Foreseen
from surftex.bake.scales import size_warnings
from surftex.bake.stages import Stages
from surftex.charts.atlas import Atlas
from surftex.charts.unwrap import tiles_for
from surftex.recipe.model import Recipe
from surftex.surface.surface import Surface

LONG_S = 60.0
"""Bakes that would take less are begun without a word on that."""


def foretell_sizes(recipe: Recipe, surface: Surface, own: Atlas | None, stages: Stages) -> Mapping[int, str]:
    """Warn of layers that fit neither the mesh nor the page, by the density of a usual unwrap where there is none yet.

    Parameters
    ----------
    recipe : Recipe
        The layers, and the size of the page.
    surface : Surface
        The mesh.
    own : Atlas or None
        The mesh's own unwrap, where that is kept.
    stages : Stages
        Who is told.

    Returns
    -------
    told : mapping of int to str
        What was said of which layer.
    """
    side, density = recipe.bake.resolution, recipe.bake.texels_per_mm
    if own is not None:
        density = own.texels_per_mm(surface, side)
    elif density is None:
        density = foreseen_density(surface, side)
    told = size_warnings(recipe, surface.longest_side_mm, density, side, about=own is None)
    stages.warn(*told.values())
    return told


def foretell_time(
    recipe: Recipe,
    surface: Surface,
    foreseen: list[Foreseen],
    own: Atlas | None,
    threads: int | None,
    stages: Stages,
) -> None:
    """Tell about how long a bake would take, where that is long; features are to be placed anew.

    Parameters
    ----------
    recipe : Recipe
        What is to be baked.
    surface : Surface
        Where.
    foreseen : list of Foreseen
        From `surftex.bake.limits.foresee`.
    own : Atlas or None
        The mesh's own unwrap, where that is kept.
    threads : int or None
        None means every core.
    stages : Stages
        Who is told.
    """
    if not stages.has_listener:
        return
    settings, tiles = recipe.bake, 1
    if own is not None:
        tiles = len(own.tiles)
    elif settings.texels_per_mm is not None:
        tiles = tiles_for(surface, settings.texels_per_mm, settings.resolution)
    seconds = bake_seconds(recipe, surface, foreseen, tiles=tiles, threads=threads)
    if seconds > LONG_S:
        stages.say(f"note: this will take about {_lasting(seconds)}")


def _lasting(seconds: float) -> str:
    """Say how long, in the unit that a reader would take."""
    if seconds < 120:
        return f"{round(seconds, -1):.0f} seconds"
    return f"{seconds / 60:.0f} minutes" if seconds < 7200 else f"{seconds / 3600:,.0f} hours"
