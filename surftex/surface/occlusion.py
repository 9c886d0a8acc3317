"""How much of the sky each vertex of a surface sees: rays to the sphere, the same ones for every vertex."""

import numpy as np
from numpy.typing import NDArray

from surftex.errors import SurfaceError
from surftex.surface.surface import Surface

RAYS = 96
"""Directions over the whole sphere; a vertex asks the half of them that its normal faces."""

_BATCH = 1 << 16
_GOLDEN = np.pi * (3 - np.sqrt(5))


def vertex_occlusion(surface: Surface, reach_mm: float) -> NDArray[np.float64]:
    """Measure how closed each vertex is.

    Parameters
    ----------
    surface : Surface
        n vertices.
    reach_mm : float
        What is farther off does not close; what is nearer closes the more, the nearer it is. inf counts everything.

    Returns
    -------
    occlusion : (n,) float64
        0 where the whole half sphere above is open, towards 1 where all of it is near; weighted by the cosine
        to the normal.

    Raises
    ------
    SurfaceError
        If the reach is no length.
    """
    import igl

    if not reach_mm > 0:
        raise SurfaceError(f"an occlusion reach of {reach_mm} mm; it takes a length above 0")
    corners, faces = np.array(surface.vertices), surface.faces.astype(np.int64)
    tree = igl.AABB()
    tree.init(corners, faces)
    normal = surface.vertex_normal
    origin = surface.vertices + 1e-4 * max(surface.mean_edge_mm, 1e-9) * normal
    shut, total = np.zeros(len(origin)), np.zeros(len(origin))
    for direction in _sphere(RAYS):
        cosine = normal @ direction
        above = np.flatnonzero(cosine > 0)
        total[above] += cosine[above]
        for first in range(0, len(above), _BATCH):
            rows = above[first : first + _BATCH]
            ways = np.tile(direction, (len(rows), 1))
            face, far, _ = map(np.asarray, tree.intersect_ray_first(corners, faces, origin[rows], ways))
            near = np.clip(1 - far / reach_mm, 0.0, 1.0) if np.isfinite(reach_mm) else 1.0
            shut[rows] += np.where(face >= 0, near, 0.0) * cosine[rows]
    return shut / np.maximum(total, 1e-12)


def _sphere(count: int) -> NDArray[np.float64]:
    """Directions spread evenly, along a spiral."""
    height = 1 - (2 * np.arange(count) + 1) / count
    turn = _GOLDEN * np.arange(count)
    ring = np.sqrt(1 - height**2)
    return np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)
