"""What a bake would cost, told before it is done: density, seconds, memory, within a factor of two or so."""

from collections.abc import Iterable, Iterator
from typing import Any

from surftex.bake.locating import located
from surftex.bake.stack import layer_seed
from surftex.errors import SurftexError
from surftex.features.poisson import expected_sites
from surftex.features.relax import samples_per_site
from surftex.fields.fieldset import FieldSet
from surftex.fields.sized import sized
from surftex.kernels.pool import thread_count
from surftex.paged import in_file
from surftex.recipe.model import Recipe
from surftex.surface.surface import Surface

COVERAGE = 0.62
"""Share of a page that charts cover, as unwraps come out."""

_SIZES = {
    "leather": ("cell", "cell_size"),
    "cells": ("grown cell", "cell_size"),
    "composite": ("pixel", "pixel_size"),
}
"""What lies as densely as its size allows, by material, and the parameter that tells its size."""

_OVER_DISKS = {"cell": 1.0, "grown cell": 2.6, "pixel": 1.43}
"""How many there are for each site of a full Poisson-disk set of that size: measured, and by definition for pixels."""

_BEYOND = 1e15

_CPU_S_PER = {
    "face": 6.0e-5,
    "cell": 1.2e-4,
    "grown cell": 3.6e-4,
    "pixel": 1.7e-4,
    "sample": 1.5e-6,
    "texel": 7.0e-7,
}
_START_S = 2.0
_BYTES_PER = {
    "face": 1500,
    "face among cells": 4200,
    "cell": 4400,
    "grown cell": 4000,
    "pixel": 700,
    "texel": 69,
    "paged texel": 8,
    "tile texel": 66,
}
"""A face smaller than the cells around it holds some thirty of their windows, whatever the size of either."""

_START_MB = 300.0


def bake_cost(surface: Surface, material: str = "calf", recipe: Recipe | None = None) -> dict[str, Any]:
    """Estimate the cost of a bake at several resolutions.

    Parameters
    ----------
    surface : Surface
        What would be baked.
    material : str
        Name of a preset, or the path of a recipe.
    recipe : Recipe, optional
        That recipe, where it is read already.

    Returns
    -------
    cost : dict
        ``material``; ``cells`` (grown ones and pixels too; ``placed`` tells them apart); ``made_of``: what the lowest layer
        is made of first; ``finest``: ``kind`` and ``mm`` of the finest of the material; ``suggested_resolution``, at which
        that is two texels wide (None where no usual page would do), and ``suggested_texels_per_mm``; ``max_features``;
        ``threads``; and ``pages``: for each ``resolution`` ``texels_per_mm``, ``texels_per_cell`` (of ``made_of``),
        ``seconds`` of wall time, ``memory_mb``, and ``disk_mb`` of pages that lie in temporary files; ``warnings``: where
        its cells fit neither the mesh nor the usual page. What is not known before a bake is None.

    Raises
    ------
    RecipeError
        If there is no such material, or it does not fit the mesh.
    """
    from surftex.bake.scales import density_for, finest_kind, side_for, size_warnings
    from surftex.recipe.read import recipe_for

    recipe = recipe or recipe_for(material)
    counts, samples = _placed(recipe, _grounds(recipe, surface))
    known = getattr(recipe.layer[0].material, "wavelengths_mm", dict)()
    made_of, size_mm = next(((kind, size) for kind, size in known.items() if size > 0), (None, None))
    finest = finest_kind(recipe)
    threads, faces = thread_count(None), len(surface.faces)
    pages = [
        {
            "resolution": side,
            "texels_per_mm": round(_density(surface, side), 4),
            "texels_per_cell": None if size_mm is None else round(_density(surface, side) * size_mm, 3),
            "seconds": round(_START_S + _cpu_s(faces, counts, samples, side) / (0.8 * threads + 0.2), 1),
            "memory_mb": _memory_mb(faces, counts, side),
            "disk_mb": _disk_mb(side),
        }
        for side in (1024, 2048, 4096, 8192)
    ]
    side = recipe.bake.resolution
    warnings = size_warnings(recipe, surface.longest_side_mm, _density(surface, side), side)
    return {
        "material": material,
        "cells": sum(counts.values()),
        "placed": counts,
        "made_of": made_of,
        "finest": None if finest is None else {"kind": finest[0], "mm": round(finest[1], 4)},
        "suggested_resolution": None if finest is None else side_for(finest[1], _density(surface, 1)),
        "suggested_texels_per_mm": None if finest is None else density_for(finest[1]),
        "threads": threads,
        "max_features": recipe.bake.max_features,
        "pages": pages,
        "warnings": list(warnings),
    }


def _grounds(recipe: Recipe, surface: Surface) -> list[tuple[Surface, FieldSet] | None]:
    """Find what each layer lies on, with the fields there; None where its mask covers nothing."""
    from surftex.bake.covered import fields_on
    from surftex.bake.fields import make_fields
    from surftex.bake.stack import layer_cover
    from surftex.surface.bodies import Bodies

    fields = make_fields(recipe, surface)
    grounds: list[tuple[Surface, FieldSet] | None] = []
    for i in range(len(recipe.layer)):
        covered = layer_cover(recipe, i, surface, fields)
        if covered.all():
            grounds.append((surface, fields))
        elif covered.any():
            bodies = Bodies.of(surface, covered)
            grounds.append((bodies.surface, fields_on(bodies, fields)))
        else:
            grounds.append(None)
    return grounds


def _placed(recipe: Recipe, grounds: list[tuple[Surface, FieldSet] | None]) -> tuple[dict[str, int], float]:
    """Estimate how many cells, grown cells and pixels lie on the grounds, and samples to even cells out by.

    Other features cost little beside them.
    """
    counts: dict[str, int] = {}
    samples = 0.0
    for i, (layer, found) in enumerate(zip(recipe.layer, grounds, strict=True)):
        if layer.kind not in _SIZES or found is None:
            continue
        surface, fields = found
        kind, key = _SIZES[layer.kind]
        with located(recipe, "layer", i, label=_label(recipe, i)):
            size = sized(fields, getattr(layer.material, key), f"{layer.kind}.{key}")
            ratio = getattr(layer.material, "cell_ratio", 1.0) if kind == "cell" else 1.0
            ratio = sized(fields, ratio, f"{layer.kind}.cell_ratio", least=1.0)
            count = _OVER_DISKS[kind] * expected_sites(surface, size, ratio)
        counts[kind] = counts.get(kind, 0) + max(1, round(min(count, _BEYOND)))
        samples += min(count, _BEYOND) * samples_per_site(getattr(layer.material, "regularity", 0))
    return counts, samples


def _label(recipe: Recipe, index: int) -> str:
    return "layer" if len(recipe.layer) == 1 else f"layer[{index + 1}]"


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
    from surftex.bake.loading import load

    last, found = None, None
    for recipe in recipes:
        mesh, side = recipe.mesh, recipe.bake.resolution
        if found is None or mesh != last:
            try:
                surface = load(
                    mesh.path or "", units=mesh.units, size=mesh.size, part=mesh.part, crease=mesh.crease
                )
            except SurftexError as problem:
                found = problem
            else:
                found = surface
            last = mesh
        try:
            if isinstance(found, SurftexError):
                raise found
            tiles = _foreseen_tiles(recipe, found)
            grounds = _grounds(recipe, found)
            _refuse_too_many(recipe, grounds)
            counts, samples = _placed(recipe, grounds)
        except SurftexError as problem:
            yield {"problem": str(problem), "exit_code": problem.exit_code}
            continue
        faces = len(found.faces)
        yield {
            "faces": faces,
            "cells": sum(counts.values()),
            "tiles": tiles,
            "seconds": round(_START_S + _cpu_s(faces, counts, samples, side, tiles), 1),
            "memory_mb": _memory_mb(faces, counts, side, tiles),
        }


def _foreseen_tiles(recipe: Recipe, surface: Surface) -> int:
    from surftex.charts.atlas import Atlas
    from surftex.charts.unwrap import tiles_for

    settings = recipe.bake
    if settings.texels_per_mm is not None:
        return tiles_for(surface, settings.texels_per_mm, settings.resolution)
    own = settings.udim and settings.uv != "unwrap" and surface.corner_uv is not None
    return len(Atlas.of(surface, surface.corner_uv).tiles) if own and surface.corner_uv is not None else 1


def _refuse_too_many(recipe: Recipe, grounds: list[tuple[Surface, FieldSet] | None]) -> None:
    """Refuse what a layer by itself would refuse for the number of its features."""
    for i, (layer, found) in enumerate(zip(recipe.layer, grounds, strict=True)):
        refuse = getattr(layer.material, "refuse_too_many", None)
        if refuse is not None and found is not None:
            with located(recipe, "layer", i, label=_label(recipe, i)):
                seed = layer_seed(recipe.seed, i)
                refuse(found[0], seed, fields=found[1], max_features=recipe.bake.max_features)


def _density(surface: Surface, side: int) -> float:
    return side * (COVERAGE / surface.area_mm2) ** 0.5


def _cpu_s(faces: int, counts: dict[str, int], samples: float, side: int, tiles: int = 1) -> float:
    work = {"face": faces, **counts, "sample": samples, "texel": side * side * tiles}
    return sum(_CPU_S_PER[key] * count for key, count in work.items())


def _disk_mb(side: int) -> int:
    """Size of the pages in temporary files: what they would take of the memory otherwise."""
    bytes_per = _BYTES_PER["texel"] - _BYTES_PER["paged texel"]
    return round(bytes_per * side * side / 1e6) if in_file((side, side)) else 0


def _memory_mb(faces: int, counts: dict[str, int], side: int, tiles: int = 1) -> int:
    from surftex.bake.pages import TILE_TEXELS

    texels = side * side
    work = {
        "face": faces,
        "face among cells": faces if counts.get("cell") else 0,
        **counts,
        "paged texel" if in_file((side, side)) else "texel": texels * tiles,
        "tile texel": min(texels, TILE_TEXELS),
    }
    return round(_START_MB + sum(_BYTES_PER[key] * count for key, count in work.items()) / 1e6)
