"""The point of a surface nearest to a place in space."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked
from surftex.errors import SurfaceError
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_FARTHEST = 1e6
"""Times the diagonal of a surface: places that are looked for."""


def closest_points(surface: Surface, positions: ArrayLike) -> tuple[SurfacePoints, NDArray[np.float64]]:
    """Find the nearest point of a surface for each place.

    Parameters
    ----------
    surface : Surface
        Where to look.
    positions : (n, 3) float
        Millimetres, in the frame of ``surface.vertices``.

    Returns
    -------
    points : SurfacePoints
        One for each place.
    distance_mm : (n,) float64
        From the place to its point, straight through space.

    Raises
    ------
    SurfaceError
        If a place is not finite, or farther off than a million times the size of the surface.

    Examples
    --------
    >>> from surftex.surface.shapes import plane
    >>> closest_points(plane(10.0), [[5.0, 5.0, 2.0]])[1].tolist()
    [2.0]
    """
    import igl

    places = checked(positions, "positions", (None, 3), np.float64, error=SurfaceError)
    if len(places) == 0:
        return SurfacePoints(np.zeros(0, np.int32), np.zeros((0, 3))), np.zeros(0)
    size = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
    far = np.flatnonzero(np.abs(places).max(axis=1) > _FARTHEST * size)
    if len(far):  # squares of what is farther yet are inf, and then no face is the nearest
        raise SurfaceError(
            f"positions[{far[0]}] = {places[far[0]].tolist()} lies off a surface of {size:.4g} mm, by more than "
            f"{_FARTHEST:g} times its size; are its axes and unit those of the mesh file?"
        )
    faces = surface.faces.astype(np.int64)
    squared, face, nearest = igl.point_mesh_squared_distance(
        np.array(places), np.array(surface.vertices), faces
    )
    face = np.atleast_1d(face).astype(np.int32)
    from_corner = np.atleast_2d(nearest) - surface.vertices[surface.faces[face, 0]]
    flat = np.einsum("pki,pi->pk", surface.frame[face, :2], from_corner)
    corner = surface.flat[face]
    third = flat[:, 1] / corner[:, 2, 1]
    second = (flat[:, 0] - third * corner[:, 2, 0]) / corner[:, 1, 0]
    weight = np.clip(np.stack([1 - second - third, second, third], axis=1), 0, 1)
    points = SurfacePoints.trusted(face, weight / weight.sum(axis=1, keepdims=True))
    return points, np.sqrt(np.maximum(np.atleast_1d(squared), 0))
