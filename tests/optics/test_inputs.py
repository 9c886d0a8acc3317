"""Names and units of renderers."""

import json

import numpy as np
import pytest

from surftex.optics import blender_inputs, gltf_material, lookup


def test_both_hold_the_same_look():
    skin = lookup({"melanin": [0.02, 0.2]})
    blender, gltf = blender_inputs(skin)[1], gltf_material(skin, 1)
    json.dumps([blender, gltf])
    assert blender["Base Color"] == gltf["pbrMetallicRoughness"]["baseColorFactor"]
    assert blender["Roughness"] == pytest.approx(float(skin.roughness[1]))
    radius_m = np.array(blender["Subsurface Radius"]) * blender["Subsurface Scale"]
    assert radius_m * 1000 == pytest.approx(skin.subsurface_radius_mm[1])
    gloss = gltf["extensions"]["KHR_materials_specular"]["specularColorFactor"][0]
    assert 0.04 * gloss == pytest.approx(0.08 * blender["Specular IOR Level"])  # the same reflectance
