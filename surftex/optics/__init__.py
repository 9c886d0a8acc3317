"""Light in layered tissue: spectra, walks of light, BRDFs, matched render models, tables. It knows no mesh."""

from surftex.optics.appearance import SkinAppearance, lookup, skin_color
from surftex.optics.slab import slab

__all__ = ["SkinAppearance", "lookup", "skin_color", "slab"]
