"""From the mouse to the surface: the nearest place that a ray meets."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface


def pick(surface: Surface, start: ArrayLike, direction: ArrayLike) -> SurfacePoints | None:
    """Find the nearest place of a surface on a ray [1]_.

    Parameters
    ----------
    surface : Surface
        m faces; both their sides count.
    start : (3,) float
        In the frame of `Surface.vertices`.
    direction : (3,) float
        Of any length.

    Returns
    -------
    point : SurfacePoints or None
        One place; None where the ray meets nothing.

    References
    ----------
    .. [1] Möller, Trumbore. Fast, Minimum Storage Ray-Triangle Intersection. Journal of Graphics Tools 2 (1997).
    """
    origin = checked(start, "start", (3,), np.float64)
    ray = checked(direction, "direction", (3,), np.float64)
    corner: NDArray[np.float64] = surface.vertices[surface.faces]
    first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    across = np.cross(ray, second)
    size = (first * across).sum(axis=1)
    inverse = np.divide(1.0, size, out=np.zeros_like(size), where=np.abs(size) > 1e-300)
    away = origin - corner[:, 0]
    u = (away * across).sum(axis=1) * inverse
    turned = np.cross(away, first)
    v = (turned @ ray) * inverse
    way = (second * turned).sum(axis=1) * inverse
    met = (inverse != 0) & (u >= 0) & (v >= 0) & (u + v <= 1) & (way > 0)
    if not met.any():
        return None
    face = int(np.flatnonzero(met)[way[met].argmin()])
    return SurfacePoints([face], [[max(1 - u[face] - v[face], 0.0), u[face], v[face]]])
