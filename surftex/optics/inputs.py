"""The look of skin under the names that renderers give it: Blender's principled shader, and glTF."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked_whole
from surftex.errors import InputError
from surftex.optics.appearance import SkinAppearance
from surftex.optics.subsurface import profile_width
from surftex.words import sort_of

METRES_PER_MM = 0.001
"""Scale of a subsurface radius in mm where the scene's unit is the metre."""

_CYCLES_RADIUS = 4 * np.pi * 1.04
"""Radius that Cycles takes for a profile of width 1, whatever the colour. Measured at the edge of a shadow on a block,
Blender 4.5.15: 13.05 at 10 mm, 12.6 at 20 mm."""


def blender_radius(radius_mm: ArrayLike, base_color: ArrayLike) -> NDArray[np.float64]:
    """Turn mean free paths into the radius that Cycles takes for the same profile.

    Parameters
    ----------
    radius_mm : (..., 3) float
        Mean free paths, as in `SkinAppearance`.
    base_color : (..., 3) float
        Linear sRGB, which they go with.

    Returns
    -------
    radius_mm : (..., 3) float64
        For the socket ``Subsurface Radius``, method ``BURLEY``, and a ``Subsurface Scale`` of a thousandth.
    """
    return _CYCLES_RADIUS * profile_width(radius_mm, base_color)


def subsurface_facts(radius_mm: ArrayLike, weight: float) -> dict[str, Any]:
    """Write how far light wanders as reports and ``surftex_subsurface`` in the extras of glTF materials have it.

    Parameters
    ----------
    radius_mm : (3,) float
        Mean free paths of red, green and blue.
    weight : float
        Share of the diffuse light that has wandered.

    Returns
    -------
    facts : dict
        ``profile``, ``radius_mm``, ``weight``.
    """
    return {
        "profile": "Christensen-Burley",
        "radius_mm": np.round(np.asarray(radius_mm, np.float64), 6).tolist(),
        "weight": round(float(weight), 6),
    }


def blender_inputs(skin: SkinAppearance) -> list[dict[str, Any]]:
    """Write looks as the inputs of Blender's principled shader, 4.0 or later.

    Parameters
    ----------
    skin : SkinAppearance
        From ``lookup``.

    Returns
    -------
    inputs : list of dict
        One per sample, by the names of the sockets; the scene's unit is the metre, the node's ``subsurface_method``
        is ``"BURLEY"``. Its radius is not the mean free path: see `blender_radius`.

    Raises
    ------
    InputError
        If it is no look.

    Examples
    --------
    >>> from surftex.optics import lookup
    >>> sorted(blender_inputs(lookup({}))[0])[:3]
    ['Base Color', 'IOR', 'Roughness']
    """
    skin = _checked(skin)
    rows = zip(
        skin.base_color,
        skin.roughness,
        skin.specular,
        skin.subsurface_weight,
        blender_radius(skin.subsurface_radius_mm, skin.base_color),
        strict=True,
    )
    return [
        {
            "Base Color": [*map(float, color), 1.0],
            "Roughness": float(rough),
            "Specular IOR Level": float(specular),
            "IOR": 1.5,
            "Subsurface Weight": float(weight),
            "Subsurface Radius": [float(each) for each in radius],
            "Subsurface Scale": METRES_PER_MM,
        }
        for color, rough, specular, weight, radius in rows
    ]  # fmt: skip


def gltf_material(skin: SkinAppearance, index: int = 0) -> dict[str, Any]:
    """Write a look as a glTF material.

    Parameters
    ----------
    skin : SkinAppearance
        From ``lookup``.
    index : int
        Of the sample.

    Returns
    -------
    material : dict
        Metallic-roughness with ``KHR_materials_specular``; no ratified extension takes a subsurface radius, so
        ``surftex_subsurface`` in the extras holds ``profile``, ``radius_mm`` and ``weight``, as in the GLB of a bake.

    Raises
    ------
    InputError
        If it is no look, or has no such sample.

    Examples
    --------
    >>> from surftex.optics import lookup
    >>> gltf_material(lookup({}))["pbrMetallicRoughness"]["metallicFactor"]
    0.0
    """
    skin = _checked(skin)
    if not len(skin.specular):
        raise InputError("the look holds 0 samples; there is none to write")
    index = checked_whole(index, "index", 0, len(skin.specular) - 1)
    gloss = 2 * float(skin.specular[index])
    return {
        "pbrMetallicRoughness": {
            "baseColorFactor": [*map(float, skin.base_color[index]), 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": float(skin.roughness[index]),
        },
        "extensions": {"KHR_materials_specular": {"specularColorFactor": [gloss] * 3}},
        "extras": {
            "surftex_subsurface": subsurface_facts(
                skin.subsurface_radius_mm[index], skin.subsurface_weight[index]
            )
        },
    }


def _checked(skin: Any) -> SkinAppearance:
    if not isinstance(skin, SkinAppearance):
        raise InputError(f"skin is {sort_of(skin)}; it takes what lookup answers")
    return skin
