"""What a bake would cost, told before it is done: density, seconds, memory, within a factor of two or so."""

from collections.abc import Iterable, Iterator
from typing import Any

from surftex.bake.limits import Foreseen, foresee, refuse_too_many
from surftex.errors import SurftexError
from surftex.features.relax import samples_per_site
from surftex.kernels.pool import thread_count
from surftex.paged import in_file
from surftex.recipe.model import Recipe
from surftex.surface.surface import Surface

COVERAGE = 0.62
"""Share of a page that charts cover, as unwraps come out."""

_BEYOND = 1e15

_CPU_S_PER = {
    "face": (1.5e-5, 4.5e-5),
    "leather.cell": (2.15e-5, 1.4e-5),
    "leather.corner": (0.5e-5, 1.2e-5),
    "leather.crack": (1.2e-5, 0.1e-5),
    "leather.pore": (0.1e-6, 0.4e-6),
    "leather.pore in a group": (0.5e-5, 0.35e-5),
    "leather.crown": (2.15e-5, 1.4e-5),
    "leather.sample": (3.7e-7, 3.0e-7),
    "leather.sample of a shape": (4.5e-7, 1.1e-6),
    "cells.particle": (2.6e-7, 2.7e-6),
    "cells.particle pushed": (0.9e-6, 0.0),
    "cells.particle near creases": (0.0, 1.25e-6),
    "cells.mm of creases": (5.0e-5, 0.5e-5),
    "cells.cell": (3.0e-5, 6.0e-5),
    "cells.cell with wrinkles": (1.0e-5, 0.1e-5),
    "composite.pixel": (0.75e-4, 0.55e-4),
    "skin.pore": (0.2e-5, 0.1e-5),
    "texel": (1.8e-7, 0.8e-7),
    "leather.texel": (0.0, 4.0e-7),
    "leather.texel of a shape": (0.0, 6.5e-7),
    "skin.texel": (0.0, 9.5e-7),
    "cells.texel": (0.0, 7.0e-7),
    "composite.texel": (0.0, 2.0e-7),
}
"""What each takes of one thread, and what all threads share: measured. Cells count by their effort; corners are those of
Voronoi graphs, by their cells; samples are those that even cells out; particles count once for each generation they live."""

START_S = 2.0
"""Imports, and compiled kernels that are read."""

_BYTES_PER = {
    "face": 1500,
    "face among cells": 4200,
    "leather.cell": 1900,
    "leather.corner": 1200,
    "leather.crack": 2400,
    "cells.cell": 4000,
    "composite.pixel": 700,
    "page texel": 69,
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
        ``material``; ``cells`` (and pixels); ``features`` of all kinds, and ``placed``: how many of each; ``refused``: why a
        bake would refuse that many, None where it would not; ``made_of``: what the lowest layer is made of first; ``finest``:
        ``kind`` and ``mm`` of the finest of the material; ``advice``: for the one and the other ``kind``, ``mm``, and the
        ``resolution`` (None where no usual page would do) or ``texels_per_mm`` at which it is about five texels wide; those of
        the finest are ``suggested_resolution`` and ``suggested_texels_per_mm`` too; ``max_features``; ``threads``; and
        ``pages``: for each ``resolution`` ``texels_per_mm``, ``texels_per_cell`` (of ``made_of``), ``seconds`` of wall time
        where nothing else runs, ``cpu_s`` over all threads, ``memory_mb``, and ``disk_mb`` of pages that lie in temporary
        files; ``warnings``: where its cells fit neither the mesh nor the usual page. What is not known before a bake is None.

    Raises
    ------
    RecipeError
        If there is no such material, or it does not fit the mesh.
    """
    from surftex.bake.scales import density_for, finest_kind, side_for, size_warnings
    from surftex.recipe.read import recipe_for

    recipe = recipe or recipe_for(material)
    foreseen = _foreseen(recipe, surface)
    placed, work = _placed(foreseen), _work(recipe, foreseen)
    texels = _texels(recipe, foreseen, surface.area_mm2)
    known = getattr(recipe.layer[0].material, "wavelengths_mm", dict)()
    made_of, size_mm = next(((kind, size) for kind, size in known.items() if size > 0), (None, None))
    finest = finest_kind(recipe)
    advice = [
        {
            "kind": kind,
            "mm": round(wide_mm, 4),
            "resolution": side_for(wide_mm, foreseen_density(surface, 1)),
            "texels_per_mm": density_for(wide_mm),
        }
        for kind, wide_mm in dict.fromkeys([(made_of, size_mm), finest or (None, None)])
        if kind is not None and wide_mm is not None
    ]
    threads, faces = thread_count(None), len(surface.faces)
    pages = []
    for side in (1024, 2048, 4096, 8192):
        alone, shared = _cpu_s(faces, work, texels, side)
        pages.append(
            {
                "resolution": side,
                "texels_per_mm": round(foreseen_density(surface, side), 4),
                "texels_per_cell": None
                if size_mm is None
                else round(foreseen_density(surface, side) * size_mm, 3),
                "seconds": round(alone + shared / threads, 1),
                "cpu_s": round(alone + shared, 1),
                "memory_mb": _memory_mb(faces, work, side),
                "disk_mb": _disk_mb(side),
            }
        )
    side = recipe.bake.resolution
    warnings = size_warnings(recipe, surface.longest_side_mm, foreseen_density(surface, side), side)
    return {
        "material": material,
        "cells": _cells(placed),
        "features": sum(placed.values()),
        "placed": placed,
        "refused": _refusal(recipe, foreseen),
        "made_of": made_of,
        "finest": None if finest is None else {"kind": finest[0], "mm": round(finest[1], 4)},
        "advice": advice,
        "suggested_resolution": None if finest is None else advice[-1]["resolution"],
        "suggested_texels_per_mm": None if finest is None else advice[-1]["texels_per_mm"],
        "threads": threads,
        "max_features": recipe.bake.max_features,
        "pages": pages,
        "warnings": list(warnings.values()),
    }


def bake_seconds(
    recipe: Recipe, surface: Surface, foreseen: list[Foreseen], *, tiles: int = 1, threads: int | None = None
) -> float:
    """Estimate the wall time of a bake where nothing else runs.

    Parameters
    ----------
    recipe : Recipe
        What would be baked.
    surface : Surface
        Where.
    foreseen : list of Foreseen
        From `surftex.bake.limits.foresee`.
    tiles : int
        Pages that the unwrap takes.
    threads : int, optional
        None means every core.

    Returns
    -------
    seconds : float
        Within a factor of two or so.
    """
    work, texels = _work(recipe, foreseen), _texels(recipe, foreseen, surface.area_mm2)
    alone, shared = _cpu_s(len(surface.faces), work, texels, recipe.bake.resolution, tiles)
    return alone + shared / thread_count(threads)


def _foreseen(recipe: Recipe, surface: Surface) -> list[Foreseen]:
    from surftex.bake.fields import make_fields

    return foresee(recipe, surface, make_fields(recipe, surface))


def _refusal(recipe: Recipe, foreseen: list[Foreseen]) -> str | None:
    """Say why a bake would be refused for the number of its features; None where it would not."""
    try:
        refuse_too_many(recipe, foreseen)
    except SurftexError as problem:
        return str(problem)
    return None


def _placed(foreseen: list[Foreseen]) -> dict[str, int]:
    """Count the features of all layers by kind."""
    counts: dict[str, int] = {}
    for each in (each for layer in foreseen for each in layer.expected or ()):
        counts[each.kind] = counts.get(each.kind, 0) + round(min(each.count, _BEYOND))
    return {kind: count for kind, count in counts.items() if count}


def _cells(placed: dict[str, int]) -> int:
    return placed.get("cell", 0) + placed.get("pixel", 0)


def _work(recipe: Recipe, foreseen: list[Foreseen]) -> dict[str, float]:
    """Count what costs time and memory beside faces and pages: features by their effort, and what their layer makes of them."""
    work: dict[str, float] = {}
    for layer, told in zip(recipe.layer, foreseen, strict=True):
        found = {each.kind: 0.0 for each in told.expected or ()}
        for each in told.expected or ():
            found[each.kind] += each.effort * min(each.count, _BEYOND)
        if layer.kind == "leather":
            found = _leather_work(layer.material, told, found)
        if layer.kind == "cells":
            found |= _growth_work(layer.material, found)
        for unit, count in found.items():
            work[f"{layer.kind}.{unit}"] = work.get(f"{layer.kind}.{unit}", 0.0) + count
    return work


def _leather_work(leather: Any, told: Foreseen, found: dict[str, float]) -> dict[str, float]:
    """Add the graph of the cells, where anything hangs on it, and the samples that even them out."""
    cells = sum(min(each.count, _BEYOND) for each in told.expected or () if each.kind == "cell")
    on_graph = any(found.get(kind) for kind in ("pocket", "crack", "wrinkle"))
    more = {"corner": cells} if on_graph else {}
    shaped = "" if leather.cell_shape == "round" else " of a shape"
    more[f"sample{shaped}"] = cells * samples_per_site(leather.regularity)
    if leather.pore_group > 1:
        more["pore in a group"] = found.pop("pore", 0.0)
    return found | more


def _growth_work(cells: Any, found: dict[str, float]) -> dict[str, float]:
    """Tell what a potential and wrinkles add to a growth: creases lie there before it, other wrinkles walk along its cells."""
    wrinkles = found.get("wrinkle", 0.0)
    if cells.wrinkle_potential <= 0:
        creases, walked = 0.0, found.get("cell", 0.0) if wrinkles else 0.0
    else:
        creases, walked = wrinkles, 0.0
    near, pushed = 0.0, 0.0
    if cells.potential_force > 0:
        near = found.get("particle", 0.0) if creases else 0.0
        pushed = near if cells.potential is None else found.get("particle", 0.0)
    return {
        "particle pushed": pushed,
        "particle near creases": near,
        "mm of creases": creases * cells.wrinkle_length,
        "cell with wrinkles": walked,
    }


def _texels(recipe: Recipe, foreseen: list[Foreseen], area_mm2: float) -> dict[str, float]:
    """Tell which share of a page's texels ask each material."""
    shares: dict[str, float] = {"texel": 1.0}
    for layer, told in zip(recipe.layer, foreseen, strict=True):
        shaped = "" if getattr(layer.material, "cell_shape", "round") == "round" else " of a shape"
        unit = f"{layer.kind}.texel{shaped}"
        shares[unit] = shares.get(unit, 0.0) + told.area_mm2 / area_mm2
    return shares


def recipe_costs(recipes: Iterable[Recipe]) -> Iterator[dict[str, Any]]:
    """Estimate the cost of recipes; each mesh is read once for all that bake it in a row.

    Parameters
    ----------
    recipes : iterable of Recipe
        With the paths of their meshes.

    Yields
    ------
    cost : dict
        ``faces``, ``cells``, ``features``, ``tiles``, ``seconds`` of CPU time, ``memory_mb``; or, where the mesh cannot be
        read, or there would be too many features or tiles, ``problem`` and ``exit_code``.
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
            foreseen = _foreseen(recipe, found)
            refuse_too_many(recipe, foreseen)
        except SurftexError as problem:
            yield {"problem": str(problem), "exit_code": problem.exit_code}
            continue
        faces, placed, work = len(found.faces), _placed(foreseen), _work(recipe, foreseen)
        texels = _texels(recipe, foreseen, found.area_mm2)
        yield {
            "faces": faces,
            "cells": _cells(placed),
            "features": sum(placed.values()),
            "tiles": tiles,
            "seconds": round(sum(_cpu_s(faces, work, texels, side, tiles)), 1),
            "memory_mb": _memory_mb(faces, work, side, tiles),
        }


def _foreseen_tiles(recipe: Recipe, surface: Surface) -> int:
    from surftex.charts.atlas import Atlas
    from surftex.charts.unwrap import tiles_for

    settings = recipe.bake
    if settings.texels_per_mm is not None:
        return tiles_for(surface, settings.texels_per_mm, settings.resolution)
    own = settings.udim and settings.uv != "unwrap" and surface.corner_uv is not None
    return len(Atlas.of(surface, surface.corner_uv).tiles) if own and surface.corner_uv is not None else 1


def foreseen_density(surface: Surface, side: int) -> float:
    """Estimate the density of a page, as unwraps come out.

    Parameters
    ----------
    surface : Surface
        What would be unwrapped.
    side : int
        Of the page in texels.

    Returns
    -------
    texels_per_mm : float
        Along the surface.
    """
    return side * (COVERAGE / surface.area_mm2) ** 0.5


def _cpu_s(
    faces: int, work: dict[str, float], texels: dict[str, float], side: int, tiles: int = 1
) -> tuple[float, float]:
    """Seconds of one thread, and seconds that all threads share."""
    whole = {"face": faces, **work, **{unit: share * side * side * tiles for unit, share in texels.items()}}
    alone, shared = (
        sum(_CPU_S_PER.get(unit, (0.0, 0.0))[i] * count for unit, count in whole.items()) for i in (0, 1)
    )
    return START_S + alone, shared


def _disk_mb(side: int) -> int:
    """Size of the pages in temporary files: what they would take of the memory otherwise."""
    bytes_per = _BYTES_PER["page texel"] - _BYTES_PER["paged texel"]
    return round(bytes_per * side * side / 1e6) if in_file((side, side)) else 0


def _memory_mb(faces: int, work: dict[str, float], side: int, tiles: int = 1) -> int:
    from surftex.bake.pages import TILE_TEXELS

    texels = side * side
    whole = {
        "face": faces,
        "face among cells": faces if work.get("leather.cell") else 0,
        **work,
        "paged texel" if in_file((side, side)) else "page texel": texels * tiles,
        "tile texel": min(texels, TILE_TEXELS),
    }
    return round(_START_MB + sum(_BYTES_PER.get(unit, 0) * count for unit, count in whole.items()) / 1e6)
