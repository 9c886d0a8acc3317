"""A tile: grown leather on a square that repeats, as maps, beside a square mesh that shows them."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import checked_whole
from surftex.bake.growing import GROWS, Growth
from surftex.bake.growth_facts import cell_statistics
from surftex.bake.stages import Progress, Stages, peak_rss_mb
from surftex.errors import InputError, RecipeError
from surftex.recipe.model import Recipe

if TYPE_CHECKING:
    from surftex.maps.mapset import MapSet


def bake_tile(
    recipe: Recipe,
    side_mm: float,
    *,
    growth: Growth | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    stem: str = "tile",
) -> "MapSet":
    """Grow a tile, and make its maps.

    Parameters
    ----------
    recipe : Recipe
        With one layer, of a material that grows. Its fields lie on a square in the xy plane from the origin, whose own
        UVs fill the page: a picture lies over the whole tile, and should repeat.
    side_mm : float
        Of the square.
    growth : Growth, optional
        As for `surftex.bake.bake.run`.
    threads : int, optional
        None means every core; cannot change a byte.
    progress : callable, optional
        ``progress(stage, share)``; may raise to cancel.
    stem : str
        Start of file names.

    Returns
    -------
    maps : MapSet
        Opposite borders match, in the normal map too.

    Raises
    ------
    InputError
        If the recipe is no tile's, or the square too small for its cells.

    Examples
    --------
    >>> import surftex as sx
    >>> recipe = sx.Recipe.of(sx.Cells.preset("even"), resolution=64)
    >>> bake_tile(recipe, 16.0)["height"].shape  # doctest: +SKIP
    (64, 64)
    """
    from surftex.bake.fields import make_fields
    from surftex.bake.stack import feature_counts
    from surftex.charts.atlas import Atlas
    from surftex.maps.mapset import MapSet
    from surftex.maps.normal import surface_tangents
    from surftex.materials.cells.tile import sheet_of

    threads = None if threads is None else checked_whole(threads, "threads", 1)
    stages = Stages(progress)
    material = _only_layer(recipe)
    asked = _chosen(recipe.bake.maps)
    sheet = sheet_of(side_mm)
    fields = make_fields(recipe, sheet)
    growth = Growth() if growth is None else growth
    begun = growth.begun(recipe, f"tile of {side_mm!r} mm")
    with stages.stage("place"), growth.kept(stages, "place") as tick:
        try:
            tile = material.tile(
                side_mm, recipe.seed, fields=fields, features=begun, max_features=recipe.bake.max_features,
                threads=threads, tick=tick,
            )  # fmt: skip
        except RecipeError as problem:
            raise RecipeError(f"layer: {problem}") from None
    with stages.stage("bake") as told:
        page = tile.page(recipe.bake.resolution, threads=threads, tick=told)
    page["height"] = page.pop("height_mm")
    page["normal"] = tile_normals(page["height"], side_mm)
    atlas = Atlas.of(sheet, np.asarray(sheet.corner_uv))
    report = {
        **_facts(recipe, side_mm),
        "cells": cell_statistics(tile.features["cell"]),
        "stages": stages.done,
        "wall_s": stages.wall_s(),
        "peak_rss_mb": peak_rss_mb(),
        "features": feature_counts(tile.features),
        "warnings": list(tile.warnings),
        "outputs": {},
    }
    images = {name: page[name] for name in asked}
    return MapSet(images, sheet, atlas, surface_tangents(sheet, atlas), tile.features, report, stem)


def tile_normals(height_mm: NDArray[np.floating], side_mm: float) -> NDArray[np.float32]:
    """Take the normals of a height that repeats.

    Parameters
    ----------
    height_mm : (n, n) float
        Row 0 on top.
    side_mm : float
        Of the square.

    Returns
    -------
    normal : (n, n, 3) float32
        Unit vectors; x to the right, y up.
    """
    height = np.asarray(height_mm, np.float64)
    twice = 2 * side_mm / len(height)
    right = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / twice
    up = (np.roll(height, 1, 0) - np.roll(height, -1, 0)) / twice
    normal = np.stack([-right, -up, np.ones_like(height)], axis=2)
    return (normal / np.linalg.norm(normal, axis=2, keepdims=True)).astype(np.float32)


def _only_layer(recipe: Recipe) -> Any:
    """Take the one material that a tile can be."""
    if len(recipe.layer) != 1:
        raise RecipeError(f"a tile takes one layer; this recipe has {len(recipe.layer)}")
    layer = recipe.layer[0]
    if layer.kind not in GROWS:
        raise RecipeError(
            f"layer.material: {layer.kind} needs a mesh; tiles are made of {', '.join(GROWS)} (surftex presets)"
        )
    if layer.mask != 1:
        raise RecipeError("layer.mask: a tile has nothing below its layer; leave the mask out")
    return layer.material


def _chosen(asked: tuple[str, ...] | None) -> tuple[str, ...]:
    made = ("base_color", "roughness", "specular", "normal", "height")
    for name in asked or ():
        if name not in (*made, "region"):
            raise InputError(f"a tile has no map {name!r}; it has {', '.join(made)}, region")
    return asked or made


def _facts(recipe: Recipe, side_mm: float) -> dict[str, Any]:
    from surftex import __version__

    side = recipe.bake.resolution
    return {
        "version": __version__,
        "tile": {"side_mm": side_mm, "mm_per_texel": side_mm / side},
        "recipe": recipe.written_out(),
        "seed": recipe.seed,
        "resolution": side,
        "texels": side**2,
    }
