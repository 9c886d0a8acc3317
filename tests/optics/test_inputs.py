"""Names and units of renderers."""

import json

import numpy as np
import pytest

from surftex.errors import InputError
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
    assert list(gltf["extras"]) == ["surftex_subsurface"]
    told = gltf["extras"]["surftex_subsurface"]
    assert list(told) == ["profile", "radius_mm", "weight"]
    assert told["radius_mm"] == pytest.approx(skin.subsurface_radius_mm[1], abs=1e-6)
    gloss = gltf["extensions"]["KHR_materials_specular"]["specularColorFactor"][0]
    assert 0.04 * gloss == pytest.approx(0.08 * blender["Specular IOR Level"])  # the same reflectance


@pytest.mark.parametrize(
    ("index", "message"),
    [
        (2, "index is 2; it goes from 0 to 1"),
        (-1, "index is -1; it goes from 0 to 1"),
        (0.5, "index is 0.5; it takes a whole number"),
        ("first", "index is 'first'; it takes one number"),
    ],
)
def test_a_sample_that_is_not_there_is_refused(index, message):
    with pytest.raises(InputError, match=message):
        gltf_material(lookup({"melanin": [0.02, 0.2]}), index)


def test_what_is_no_look_is_refused():
    for write in (gltf_material, blender_inputs):
        with pytest.raises(InputError, match="skin is a dict; it takes what lookup answers"):
            write({"melanin": 0.02})
    with pytest.raises(InputError, match="the look holds 0 samples"):
        gltf_material(lookup({"melanin": []}))
