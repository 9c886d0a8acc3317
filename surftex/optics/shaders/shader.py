"""What a render model is to the matching: three functions of its shape, and how its numbers are called."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Geometry:
    """Pairs of directions on a reflecting surface, as the cosines that isotropic models need.

    Attributes
    ----------
    incident, outgoing : (m,) float64
        Cosines to the normal.
    half : (m,) float64
        Cosine of the half vector to the normal.
    half_incident : (m,) float64
        Cosine of the half vector to the incident direction.
    """

    incident: NDArray[np.float64]
    outgoing: NDArray[np.float64]
    half: NDArray[np.float64]
    half_incident: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Shader:
    """A render model ``f = diffuse * parts[0] + parts[1] + reflectance * parts[2]`` with one shape.

    Attributes
    ----------
    name : str
        As users write it.
    caption : str
        What it is and where it comes from.
    shapes : (k,) float64
        Shapes to try, evenly spaced in their logarithm.
    parts : callable
        ``parts(shape, geometry)``, the three functions of the formula above, each (m,) in 1/sr.
    shape_of : callable
        Width of a GGX surface to the shape that stands for it.
    roughness : callable
        Shape to the roughness that renderers of today take, 0 to 1.
    color : callable
        Fitted diffuse factor (..., 3) and reflectance (...) to the model's own diffuse colour.
    """

    name: str
    caption: str
    shapes: NDArray[np.float64]
    parts: Callable[[float, Geometry], tuple[NDArray, NDArray, NDArray]]
    shape_of: Callable[[float], float]
    roughness: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    color: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]
