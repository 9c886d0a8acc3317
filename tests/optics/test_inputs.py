"""Names and units of renderers."""

import json

import numpy as np
import pytest

from surftex.optics import blender_inputs, gltf_material, lookup
from surftex.optics.subsurface import mean_free_path


def test_both_hold_the_same_look():
    skin = lookup({"melanin": [0.02, 0.2]})
    blender, gltf = blender_inputs(skin)[1], gltf_material(skin, 1)
    json.dumps([blender, gltf])
    assert blender["Base Color"] == gltf["pbrMetallicRoughness"]["baseColorFactor"]
    assert blender["Roughness"] == pytest.approx(float(skin.roughness[1]))
    assert blender["Subsurface Scale"] == 0.001
    width = np.array(blender["Subsurface Radius"]) / (
        4 * np.pi * 1.04
    )  # of the profile that Cycles draws, in mm
    assert mean_free_path(width, skin.base_color[1]) == pytest.approx(skin.subsurface_radius_mm[1], rel=1e-6)
    assert gltf["extras"]["subsurface_radius_mm"] == pytest.approx(skin.subsurface_radius_mm[1])
    gloss = gltf["extensions"]["KHR_materials_specular"]["specularColorFactor"][0]
    assert 0.04 * gloss == pytest.approx(0.08 * blender["Specular IOR Level"])  # the same reflectance
