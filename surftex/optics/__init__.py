"""Light in layered tissue: spectra, walks of light, BRDFs, matched render models, tables. It knows no mesh."""

from surftex.optics.appearance import SkinAppearance, lookup, skin_color
from surftex.optics.fitting import fit_reflectance
from surftex.optics.inputs import blender_inputs, gltf_material
from surftex.optics.slab import slab
from surftex.optics.store import load_table
from surftex.optics.tally import RangeTally
from surftex.optics.types import skin_type, skin_types

__all__ = [
    "RangeTally",
    "SkinAppearance",
    "blender_inputs",
    "fit_reflectance",
    "gltf_material",
    "load_table",
    "lookup",
    "skin_color",
    "skin_type",
    "skin_types",
    "slab",
]
