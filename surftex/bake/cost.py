"""What a bake would cost, told before it is done: density, seconds, memory, within a factor of two or so."""

from collections.abc import Iterable, Iterator
from typing import Any

from surftex.bake.stack import layer_seed
from surftex.errors import SurftexError
from surftex.kernels.pool import thread_count
from surftex.paged import in_file
from surftex.recipe.model import Recipe
from surftex.surface.surface import Surface

COVERAGE = 0.62
"""Share of a page that charts cover, as unwraps come out."""

_CELLS = 0.84
"""Cells per square of the cell size, as full Poisson-disk sets come out."""

_CPU_S_PER = {"face": 6.0e-5, "cell": 1.2e-4, "texel": 7.0e-7}
_START_S = 2.0
_BYTES_PER = {
    "face": 1500,
    "face among cells": 4200,
    "cell": 4400,
    "texel": 69,
    "paged texel": 8,
    "tile texel": 66,
}
"""A face smaller than the cells around it holds some thirty of their windows, whatever the size of either."""

_START_MB = 300.0


def bake_cost(surface: Surface, material: str = "calf") -> dict[str, Any]:
    """Estimate the cost of a bake at several resolutions.

    Parameters
    ----------
    surface : Surface
        What would be baked.
    material : str
        Name of a leather preset with a plain cell size.

    Returns
    -------
    cost : dict
        ``material``, ``cells``, ``max_features``, ``threads``, and ``pages``: for each ``resolution``
        ``texels_per_mm``, ``texels_per_cell``, ``seconds`` of wall time, ``memory_mb``, and ``disk_mb`` of pages that lie
        in temporary files; ``warnings``: where its cells fit neither the mesh nor the usual page.
    """
    from surftex.bake.scales import size_warnings
    from surftex.materials.leather.model import Leather

    recipe = Recipe.of(Leather.preset(material))
    size_mm = float(Leather.preset(material).cell_size)
    cells = max(1, round(_CELLS * surface.area_mm2 / size_mm**2))
    most = recipe.bake.max_features
    threads, faces = thread_count(None), len(surface.faces)
    pages = [
        {
            "resolution": side,
            "texels_per_mm": round(_density(surface, side), 4),
            "texels_per_cell": round(_density(surface, side) * size_mm, 3),
            "seconds": round(_START_S + _cpu_s(faces, cells, side) / (0.8 * threads + 0.2), 1),
            "memory_mb": _memory_mb(faces, cells, side),
            "disk_mb": _disk_mb(side),
        }
        for side in (1024, 2048, 4096, 8192)
    ]
    side = recipe.bake.resolution
    warnings = size_warnings(recipe, surface.longest_side_mm, _density(surface, side), side)
    return {
        "material": material,
        "cells": cells,
        "threads": threads,
        "max_features": most,
        "pages": pages,
        "warnings": list(warnings),
    }


def recipe_costs(recipes: Iterable[Recipe]) -> Iterator[dict[str, Any]]:
    """Estimate the cost of recipes; each mesh is read once for all that bake it in a row.

    Parameters
    ----------
    recipes : iterable of Recipe
        With the paths of their meshes.

    Yields
    ------
    cost : dict
        ``faces``, ``cells``, ``tiles``, ``seconds`` of CPU time, ``memory_mb``; or, where the mesh cannot be read, or
        there would be too many features or tiles, ``problem`` and ``exit_code``.
    """
    from surftex.files.meshes import load

    last, found = None, None
    for recipe in recipes:
        mesh, side = recipe.mesh, recipe.bake.resolution
        if found is None or mesh != last:
            try:
                surface = load(mesh.path or "", units=mesh.units, size=mesh.size, part=mesh.part)
            except SurftexError as problem:
                found = problem
            else:
                found = surface
            last = mesh
        try:
            if isinstance(found, SurftexError):
                raise found
            tiles = _foreseen_tiles(recipe, found)
            areas = _refuse_too_many(recipe, found)
        except SurftexError as problem:
            yield {"problem": str(problem), "exit_code": problem.exit_code}
            continue
        faces = len(found.faces)
        sizes = [getattr(layer.material, "cell_size", None) for layer in recipe.layer]
        cells = sum(
            max(1, round(_CELLS * area_mm2 / size**2))
            for size, area_mm2 in zip(sizes, areas, strict=True)
            if isinstance(size, (int, float)) and area_mm2 > 0
        )
        yield {
            "faces": faces,
            "cells": cells,
            "tiles": tiles,
            "seconds": round(_START_S + _cpu_s(faces, cells, side, tiles), 1),
            "memory_mb": _memory_mb(faces, cells, side, tiles),
        }


def _foreseen_tiles(recipe: Recipe, surface: Surface) -> int:
    from surftex.charts.atlas import Atlas
    from surftex.charts.unwrap import tiles_for

    settings = recipe.bake
    if settings.texels_per_mm is not None:
        return tiles_for(surface, settings.texels_per_mm, settings.resolution)
    own = settings.udim and settings.uv != "unwrap" and surface.corner_uv is not None
    return len(Atlas.of(surface, surface.corner_uv).tiles) if own and surface.corner_uv is not None else 1


def _refuse_too_many(recipe: Recipe, surface: Surface) -> list[float]:
    """Refuse what a layer by itself would refuse for the number of its features; tell the mm^2 that each lies on."""
    from surftex.bake.covered import fields_on
    from surftex.bake.fields import make_fields
    from surftex.bake.locating import located
    from surftex.bake.stack import layer_cover
    from surftex.surface.bodies import Bodies

    fields, areas = make_fields(recipe, surface), []
    for i, layer in enumerate(recipe.layer):
        covered = layer_cover(recipe, i, surface, fields)
        areas.append(float(surface.face_area_mm2[covered[surface.component]].sum()))
        if not covered.any():
            continue
        ground, names = surface, fields
        if not covered.all():
            bodies = Bodies.of(surface, covered)
            ground, names = bodies.surface, fields_on(bodies, fields)
        refuse = getattr(layer.material, "refuse_too_many", None)
        if refuse is not None:
            with located(recipe, "layer", i, label="layer" if len(recipe.layer) == 1 else f"layer[{i + 1}]"):
                seed = layer_seed(recipe.seed, i)
                refuse(ground, seed, fields=names, max_features=recipe.bake.max_features)
    return areas


def _density(surface: Surface, side: int) -> float:
    return side * (COVERAGE / surface.area_mm2) ** 0.5


def _cpu_s(faces: int, cells: int, side: int, tiles: int = 1) -> float:
    work = {"face": faces, "cell": cells, "texel": side * side * tiles}
    return sum(_CPU_S_PER[key] * count for key, count in work.items())


def _disk_mb(side: int) -> int:
    """Size of the pages in temporary files: what they would take of the memory otherwise."""
    bytes_per = _BYTES_PER["texel"] - _BYTES_PER["paged texel"]
    return round(bytes_per * side * side / 1e6) if in_file((side, side)) else 0


def _memory_mb(faces: int, cells: int, side: int, tiles: int = 1) -> int:
    from surftex.bake.pages import TILE_TEXELS

    texels = side * side
    work = {
        "face": faces,
        "face among cells": faces if cells else 0,
        "cell": cells,
        "paged texel" if in_file((side, side)) else "texel": texels * tiles,
        "tile texel": min(texels, TILE_TEXELS),
    }
    return round(_START_MB + sum(_BYTES_PER[key] * count for key, count in work.items()) / 1e6)
