"""How far the k-th nearest source can be, face by face: what a flood may leave out."""

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen, read_only_view
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_STEP = 2.0
"""Edges of mean length by which walks go on together."""


def nearest_bound(surface: Surface, points: SurfacePoints, k: int) -> NDArray[np.float64]:
    """Bound the distance to the k-th nearest of some sources, anywhere on each face.

    Walks along edges bound it at the corners; inside, the walk
    from the best corner is added. The bound is good where sources are several edges apart, and loose
    where faces hold many: a radius serves those.

    Parameters
    ----------
    surface : Surface
        m faces.
    points : SurfacePoints
        The sources.
    k : int
        How many nearest are wanted, at least 1.

    Returns
    -------
    bound_mm : (m,) float64
        For `flood_points`; inf where fewer than k sources can be reached.
    """
    from surftex.kernels.bounds import face_bounds, nearest_labels

    points.check_on(surface)
    vertices = len(surface.vertices)
    start, corner, _ = surface.fans
    room, full = _room(vertices, len(points)), 1
    label, length = np.full((vertices, k), -1, np.int32), np.full((vertices, k), np.inf)
    while full:
        label.fill(-1)
        length.fill(np.inf)
        way, item = np.zeros(room), np.zeros((room, 2), np.int32)
        full = nearest_labels(
            read_only_view(points.face, np.int32),
            frozen(points.flat(surface)),
            surface.faces,
            surface.flat,
            surface.neighbor,
            start,
            corner,
            surface.edge_length,
            _STEP * float(np.mean(surface.edge_length)),
            way,
            item,
            label,
            length,
        )
        room *= 2
    bound = np.zeros(len(surface.faces))
    face_bounds(surface.faces, surface.flat, frozen(length[:, k - 1].copy()), 4, bound)
    return frozen(bound * (1 + 1e-9))


def _room(vertices: int, sources: int) -> int:
    """Tell how many walks are usually under way at once."""
    return 6 * vertices + 8 * sources + 64
