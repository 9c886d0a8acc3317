"""How the detail of a mesh and that of the materials on it fit together: what lies between them, what both may have."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from numpy.typing import NDArray

from surftex.fields.detail import finest_detail_mm
from surftex.recipe.model import Recipe
from surftex.surface.surface import Surface

GAP = 4.0
"""Between the largest feature and the finest detail of a mesh, from which on it is told as a gap."""


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
    both = [f"{kind} ({size:.3g} mm)" for kind, size in sizes.items() if size >= mesh]
    if both:
        return f"the mesh has relief of its own from {mesh:.3g} mm on; it may double {', '.join(both)}"
    kind, size = max(sizes.items(), key=lambda item: item[1])
    if mesh > GAP * size:
        return (
            f"between {size:.3g} mm ({kind}) and {mesh:.3g} mm (the finest relief of the mesh) nothing has detail; "
            "larger features or a finer mesh would fill the gap"
        )
    return None
