"""GGX over Lambert: the metallic-roughness model of glTF, and the principled shader of Blender 4."""

import numpy as np
from numpy.typing import NDArray

from surftex.optics.shaders.ggx import WIDTHS, lobe
from surftex.optics.shaders.shader import Geometry, Shader


def _parts(width: float, geometry: Geometry) -> tuple[NDArray, NDArray, NDArray]:
    fixed, scaled = lobe(width, geometry)
    return np.full_like(fixed, 1 / np.pi), fixed, scaled


SHADER = Shader(
    name="ggx-lambert",
    caption="GGX over Lambert: glTF metallic-roughness, Blender 4's principled shader",
    shapes=WIDTHS,
    parts=_parts,
    shape_of=lambda width: width,
    roughness=np.sqrt,
    color=lambda diffuse, reflectance: diffuse,
)
