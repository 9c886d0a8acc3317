"""The report of a bake: what went in, what came out, what it took."""

from typing import Any

from surftex.bake.looks import blender_report, subsurface_report
from surftex.bake.pages import Pages
from surftex.bake.placed import placed_by
from surftex.bake.stack import Stack, feature_counts
from surftex.bake.stages import Stages, peak_rss_mb
from surftex.charts.atlas import Atlas
from surftex.recipe.model import Recipe
from surftex.surface.surface import Surface


def make_report(
    surface: Surface,
    recipe: Recipe,
    stack: Stack,
    atlas: Atlas,
    pages: Pages,
    seam: dict[str, Any],
    scales: dict[str, Any],
    stages: Stages,
    warnings: tuple[str, ...],
) -> dict[str, Any]:
    """Write the report of a bake.

    Parameters
    ----------
    surface : Surface
        What was baked.
    recipe : Recipe
        With what.
    stack : Stack
        Everything placed.
    atlas : Atlas
        The unwrap.
    pages : Pages
        The maps.
    seam : dict
        From `measured_seams`.
    scales : dict
        From `surftex.bake.scales.scale_report`.
    stages : Stages
        What each stage took.
    warnings : tuple of str
        What its reader should know.

    Returns
    -------
    report : dict
        JSON types; ``outputs`` is filled in when the maps are saved.
    """
    from surftex import __version__

    side = recipe.bake.resolution
    return {
        "version": __version__,
        "mesh": mesh_facts(surface),
        "recipe": recipe.written_out(),
        "seed": recipe.seed,
        "resolution": side,
        "texels": pages.core,
        "coverage": round(pages.core / (side**2 * len(atlas.tiles)), 6),
        "unwrap": {
            "unwrapper": atlas.unwrapper,
            "charts": atlas.chart_count,
            "seam_length_mm": round(atlas.seam_length_mm(surface), 4),
            "texels_per_mm": round(atlas.texels_per_mm(surface, side), 6),
            "gutter_px": atlas.gutter_px,
            "tiles": list(atlas.tiles),
        },
        "stages": stages.done,
        "wall_s": stages.wall_s(),
        "peak_rss_mb": peak_rss_mb(),
        "features": feature_counts(stack.features),
        "placed": placed_by(recipe, surface, stack.patterns),
        "clamped": pages.clamped,
        "subsurface": subsurface_report(pages, surface.name),
        "blender": blender_report(pages, surface.name),
        "seam": seam,
        "scales": scales,
        "warnings": list(warnings),
        "outputs": {},
    }


def mesh_facts(surface: Surface) -> dict[str, Any]:
    """Describe a surface.

    Parameters
    ----------
    surface : Surface
        Any.

    Returns
    -------
    facts : dict
        ``sha256``, ``faces``, ``vertices``, ``components``, ``boundary_loops``, ``area_mm2``, ``units``.
    """
    from surftex.units import MM_PER_UNIT

    named = [unit for unit, length in MM_PER_UNIT.items() if abs(length / surface.mm_per_unit - 1) < 1e-12]
    return {
        "sha256": surface.sha256,
        "faces": len(surface.faces),
        "vertices": len(surface.vertices),
        "components": int(surface.component.max()) + 1,
        "boundary_loops": surface.border_loops,
        "area_mm2": round(surface.area_mm2, 6),
        "units": named[0] if named else f"{surface.mm_per_unit:.9g} mm",
    }


def measured_seams(surface: Surface, atlas: Atlas, pages: Pages) -> dict[str, Any]:
    """Measure how much the maps jump at seams.

    Parameters
    ----------
    surface : Surface
        What was baked.
    atlas : Atlas
        The unwrap.
    pages : Pages
        The maps.

    Returns
    -------
    seam : dict
        As `surftex.charts.seams.seam_report`; normals are compared as directions in space.
    """
    from surftex.charts.seams import seam_report

    decode = {}
    if any(name.partition(".")[0] == "normal" for name in pages.images):
        from surftex.maps.normal import object_normals

        decode["normal"] = lambda values, points: object_normals(
            surface, pages.tangents, points.face, points.barycentric, values
        )
    measured: dict[str, dict[int, Any]] = {}
    for name, image in pages.images.items():
        base, _, tile = name.partition(".")
        if base != "region":
            measured.setdefault(base, {})[int(tile or 1001)] = image
    return seam_report(surface, atlas, measured, decode=decode)
