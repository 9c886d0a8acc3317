"""The look of skin under the names that renderers give it: Blender's principled shader, and glTF."""

from typing import Any

from surftex.optics.appearance import SkinAppearance

_METRES_PER_MM = 0.001


def blender_inputs(skin: SkinAppearance) -> list[dict[str, Any]]:
    """Write looks as the inputs of Blender's principled shader, 4.0 or later.

    Parameters
    ----------
    skin : SkinAppearance
        From ``lookup``.

    Returns
    -------
    inputs : list of dict
        One per sample, by the names of the sockets; the scene's unit is the metre, the method Christensen and
        Burley's.

    Examples
    --------
    >>> from surftex.optics import lookup
    >>> sorted(blender_inputs(lookup({}))[0])[:3]
    ['Base Color', 'IOR', 'Roughness']
    """
    rows = zip(
        skin.base_color,
        skin.roughness,
        skin.specular,
        skin.subsurface_weight,
        skin.subsurface_radius_mm,
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
            "Subsurface Scale": _METRES_PER_MM,
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
        Metallic-roughness with ``KHR_materials_specular``; no ratified extension takes a subsurface radius, so it
        stands in the extras, in millimetres.

    Examples
    --------
    >>> from surftex.optics import lookup
    >>> gltf_material(lookup({}))["pbrMetallicRoughness"]["metallicFactor"]
    0.0
    """
    gloss = 2 * float(skin.specular[index])
    return {
        "pbrMetallicRoughness": {
            "baseColorFactor": [*map(float, skin.base_color[index]), 1.0],
            "metallicFactor": 0.0,
            "roughnessFactor": float(skin.roughness[index]),
        },
        "extensions": {"KHR_materials_specular": {"specularColorFactor": [gloss] * 3}},
        "extras": {"subsurface_radius_mm": [float(each) for each in skin.subsurface_radius_mm[index]]},
    }
