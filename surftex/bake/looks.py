"""What renderers are told of a bake: the map for each socket of Blender's principled shader, and how far light wanders."""

from typing import Any

import numpy as np

from surftex.bake.pages import Pages
from surftex.bake.stack import Stack
from surftex.maps.encode import file_name
from surftex.optics.inputs import METRES_PER_MM, blender_radius, subsurface_facts

_SOCKETS = {
    "base_color": "Base Color",
    "metallic": "Metallic",
    "roughness": "Roughness",
    "specular": "Specular IOR Level",
    "subsurface": "Subsurface Weight",
    "normal": "Normal",
}


def blender_report(pages: Pages, stem: str) -> dict[str, Any]:
    """Wire the maps of a bake to Blender's principled shader, 4.0 or later.

    Parameters
    ----------
    pages : Pages
        The maps.
    stem : str
        Start of the files' names.

    Returns
    -------
    blender : dict
        ``node``, its ``subsurface_method``, and ``inputs`` by socket: a value, or an ``image`` with its ``colorspace``;
        the normal goes through a normal map node. Metres; the radius is that of the mean look, for Cycles.
    """
    inputs: dict[str, Any] = {
        socket: {
            "image": file_name(stem, name),
            "colorspace": "sRGB" if name == "base_color" else "Non-Color",
        }
        for name, socket in _SOCKETS.items()
        if name in pages.images
    }
    inputs["IOR"] = 1.5
    if {"base_color", "subsurface_radius_mm"} <= set(pages.mean):
        radius = blender_radius(pages.mean["subsurface_radius_mm"], pages.mean["base_color"])
        inputs["Subsurface Radius"] = np.round(radius, 4).tolist()
        inputs["Subsurface Scale"] = METRES_PER_MM
    return {"node": "ShaderNodeBsdfPrincipled", "subsurface_method": "BURLEY", "inputs": inputs}


def subsurface_report(pages: Pages, stem: str) -> dict[str, Any]:
    """Tell how far light wanders below the surface.

    Parameters
    ----------
    pages : Pages
        The maps.
    stem : str
        Start of the files' names.

    Returns
    -------
    subsurface : dict
        ``profile``, the mean ``radius_mm`` of red, green and blue (mean free paths), the mean ``weight``, and the
        ``map`` of radii; empty where no layer has any.
    """
    if "subsurface_radius_mm" not in pages.mean:
        return {}
    facts = subsurface_facts(pages.mean["subsurface_radius_mm"], float(pages.mean.get("subsurface", 1.0)))
    return {**facts, "map": file_name(stem, "subsurface_radius_mm")}


def clamped_warnings(pages: Pages, stack: Stack) -> tuple[str, ...]:
    """Warn of channels that leave their range on more than a hundredth of the surface.

    Parameters
    ----------
    pages : Pages
        The maps.
    stack : Stack
        What they show; its patterns know the ranges.

    Returns
    -------
    warnings : tuple of str
        One per channel, with the range.
    """
    ranges: dict[str, set[tuple[float, float]]] = {}
    for pattern in stack.patterns:
        for name, ends in getattr(pattern, "ranges", {}).items():
            ranges.setdefault(name, set()).add(ends)
    told = []
    for name, count in pages.clamped.items():
        if count > 0.01 * pages.core:
            known = " or ".join(
                f"goes from {low:g} to {high:g}" if high > low else f"is {low:g} alone in the table"
                for low, high in sorted(ranges[name])
            )
            told.append(
                f"{name} left its range at {count} of {pages.core} texels and was moved into it; it {known}"
            )
    return tuple(told)
