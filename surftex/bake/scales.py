"""How the detail of a mesh and that of the materials on it fit together: what lies between them, what both may have."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.fields.detail import finest_detail_mm
from surftex.recipe.model import Recipe
from surftex.surface.surface import Surface
from surftex.words import plain

GAP = 4.0
"""Between the largest feature and the finest detail of a mesh, from which on it is told as a gap."""


LEAST_TEXELS, GOOD_TEXELS = 3.0, 5.0
"""Across a feature: below the first its shape is lost, at the second it is seen well: two sides, and a middle between them."""

_NEARLY = 0.9
"""Share of `GOOD_TEXELS` that a usual page may stay below it, rather than to take four times the texels."""

_RESOLUTIONS = (256, 512, 1024, 2048, 4096, 8192)


def size_warnings(
    recipe: Recipe, size_mm: float, texels_per_mm: float, resolution: int, *, about: bool = False
) -> dict[int, str]:
    """Warn of what each layer is made of first, such as its cells, where it fits neither the mesh nor the texels.

    Parameters
    ----------
    recipe : Recipe
        The layers.
    size_mm : float
        Longest side of the mesh.
    texels_per_mm : float
        Density of the page.
    resolution : int
        Side of the page in texels.
    about : bool
        Whether the density is an estimate, and is told as one.

    Returns
    -------
    warnings : dict of int to str
        What would do, for each layer that does not fit; layers count from 0.
    """
    found = {}
    for i, layer in enumerate(recipe.layer):
        known = getattr(layer.material, "wavelengths_mm", dict)()
        kind, wide_mm = next(iter(known.items()), ("", 0.0))
        label = f"layer[{i + 1}]: " if len(recipe.layer) > 1 else ""
        texels = wide_mm * texels_per_mm
        if wide_mm > size_mm:
            found[i] = (
                f"{label}{kind} of {plain(wide_mm, 4)} mm are larger than the mesh, whose longest side is "
                f"{plain(size_mm, 4)} mm; is a unit wrong? units and size (--units, --size) scale the mesh"
            )
        elif 0 < texels < LEAST_TEXELS:
            side = (
                None
                if recipe.bake.texels_per_mm is not None
                else side_for(wide_mm, texels_per_mm / resolution)
            )
            density = density_for(wide_mm)
            would = [] if side is None else [f"a resolution of {side}"]
            would.append(f"udim with texels_per_mm = {density:g} (--udim --texels-per-mm {density:g})")
            found[i] = (
                f"{label}{kind} of {plain(wide_mm, 4)} mm are {'about ' if about else ''}{texels:.3g} texels wide at "
                f"{resolution}, too few to be seen well; {' or '.join(would)} would do"
            )
    return found


def finest_kind(recipe: Recipe) -> tuple[str, float] | None:
    """Tell the finest of what the layers of a recipe are made of.

    Parameters
    ----------
    recipe : Recipe
        The layers.

    Returns
    -------
    finest : (kind, wide_mm) or None
        Such as pores and 0.14 mm; None where no size is known before a bake.
    """
    known = [getattr(layer.material, "wavelengths_mm", dict)() for layer in recipe.layer]
    sizes = [(kind, size) for each in known for kind, size in each.items() if size > 0]
    return min(sizes, key=lambda item: item[1], default=None)


def side_for(wide_mm: float, per_mm: float) -> int | None:
    """Tell the least page on which something is seen well.

    Parameters
    ----------
    wide_mm : float
        How wide it is.
    per_mm : float
        Texels per millimetre and texel of the page's side.

    Returns
    -------
    side : int or None
        In texels; None where no usual page would do.
    """
    return next((side for side in _RESOLUTIONS if side * per_mm * wide_mm >= _NEARLY * GOOD_TEXELS), None)


def density_for(wide_mm: float) -> float:
    """Tell the least density at which something is seen well.

    Parameters
    ----------
    wide_mm : float
        How wide it is.

    Returns
    -------
    texels_per_mm : float
        In steps of a twentieth.
    """
    return float(np.ceil(20 * GOOD_TEXELS / wide_mm) / 20)


def scale_report(
    surface: Surface, *recipes: Recipe, features: Mapping[str, NDArray[Any]] = MappingProxyType({})
) -> dict[str, Any]:
    """Compare wavelengths.

    Parameters
    ----------
    surface : Surface
        What is baked.
    *recipes : Recipe
        With what.
    features : mapping of str to structured array
        What was placed, as `Stack.features`: curves that were drawn have widths of their own.

    Returns
    -------
    scales : dict
        ``mesh_mm``: the finest wavelength of the mesh, None where it is smooth or was not measured; ``features_mm``: the
        wavelength of each kind; ``note``: a gap or an overlap in words, or None.
    """
    sizes: dict[str, float] = {}
    for layer in (layer for recipe in recipes for layer in recipe.layer):
        known = getattr(layer.material, "wavelengths_mm", None)
        for kind, size in (known() if known is not None else {}).items():
            sizes[kind] = max(size, sizes.get(kind, 0.0))
    for kind, table in features.items():
        if len(table) and "width_mm" in (table.dtype.names or ()):
            name = f"{kind.split('_')[-1]}s"
            sizes[name] = max(2 * float(table["width_mm"].max()), sizes.get(name, 0.0))
    mesh = finest_detail_mm(surface)
    return {
        "mesh_mm": None if mesh is None else round(mesh, 4),
        "features_mm": {kind: round(size, 4) for kind, size in sizes.items()},
        "note": _note(mesh, sizes),
    }


def _note(mesh: float | None, sizes: dict[str, float]) -> str | None:
    if mesh is None or not sizes:
        return None
    both = [f"{kind} ({plain(size)} mm)" for kind, size in sizes.items() if size >= mesh]
    if both:
        return f"the mesh has relief of its own from {plain(mesh)} mm on; it may double {', '.join(both)}"
    kind, size = max(sizes.items(), key=lambda item: item[1])
    if mesh > GAP * size:
        return (
            f"between {plain(size)} mm ({kind}) and {plain(mesh)} mm (the finest relief of the mesh) nothing has detail; "
            "larger features or a finer mesh would fill the gap"
        )
    return None
