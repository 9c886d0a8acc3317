"""The model that the thesis matches: a Phong-like lobe over a diffuse term that keeps energy.

M. Ashikhmin, P. Shirley. An Anisotropic Phong BRDF Model. Journal of Graphics Tools 5 (2000); both exponents equal.
"""

import numpy as np
from numpy.typing import NDArray

from surftex.optics.shaders.shader import Geometry, Shader


def _parts(exponent: float, geometry: Geometry) -> tuple[NDArray, NDArray, NDArray]:
    c, o = geometry.incident, geometry.outgoing
    diffuse = 28 / (23 * np.pi) * (1 - (1 - c / 2) ** 5) * (1 - (1 - o / 2) ** 5)
    lobe = geometry.half**exponent / (geometry.half_incident * np.maximum(c, o))
    lobe = lobe * (exponent + 1) / (8 * np.pi)
    grazing = (1 - geometry.half_incident) ** 5
    return diffuse, lobe * grazing, lobe * (1 - grazing)


def _color(diffuse: NDArray[np.float64], reflectance: NDArray[np.float64]) -> NDArray[np.float64]:
    return diffuse / np.maximum(1 - reflectance, 1e-6)[..., None]


SHADER = Shader(
    name="ashikhmin-shirley",
    caption="Ashikhmin and Shirley's Phong lobe over their diffuse term, as in the thesis",
    shapes=np.geomspace(1.0, 2e4, 96),
    parts=_parts,
    shape_of=lambda width: max(2 / width**2 - 2, 1.0),
    roughness=lambda exponent: np.sqrt(np.sqrt(2 / (exponent + 2))),
    color=_color,
)
