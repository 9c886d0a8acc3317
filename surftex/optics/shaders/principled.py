"""GGX over Burley's diffuse lobe: the principled shader as Disney published it (B. Burley, SIGGRAPH 2012)."""

import numpy as np
from numpy.typing import NDArray

from surftex.optics.shaders.ggx import WIDTHS, lobe
from surftex.optics.shaders.shader import Geometry, Shader


def _parts(width: float, geometry: Geometry) -> tuple[NDArray, NDArray, NDArray]:
    grazing = 2 * np.sqrt(width) * geometry.half_incident**2 - 0.5
    diffuse = 1 + grazing * (1 - geometry.incident) ** 5
    diffuse = diffuse * (1 + grazing * (1 - geometry.outgoing) ** 5) / np.pi
    return diffuse, *lobe(width, geometry)


SHADER = Shader(
    name="principled",
    caption="GGX over Burley's diffuse lobe: Disney's principled shader",
    shapes=WIDTHS,
    parts=_parts,
    shape_of=lambda width: width,
    roughness=np.sqrt,
    color=lambda diffuse, reflectance: diffuse,
)
