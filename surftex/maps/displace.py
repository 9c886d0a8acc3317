"""The relief as a mesh: finer triangles, moved along the smooth normal, for printing, milling and close-ups.

Edges are cut by their length alone, at their middles, again and again, so both faces of an edge cut it
alike: no cracks, no T-junctions, and what was closed stays closed. Heights are asked at places on the
surface, one place for each new vertex, so that seams of an unwrap cannot part it.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked
from surftex.errors import InputError
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.subdivide import subdivided
from surftex.surface.surface import Surface

HeightAt = Callable[[Samples], ArrayLike]
"""Height in mm at n samples: for a pattern, ``lambda samples: pattern.at(samples)["height_mm"]``."""

MAX_FACES = 20_000_000
"""Most faces of a displaced mesh."""


class DisplacedMesh(NamedTuple):
    """A mesh with its relief.

    Attributes
    ----------
    vertices : (n, 3) float64
        Millimetres, in the frame of `Surface.vertices`.
    faces : (k, 3) int32
        Turned as those of the surface.
    uv : (k, 3, 2) float64 or None
        Per corner, where an unwrap was given.
    points : SurfacePoints
        Place on the surface that each vertex was moved from.
    parent : (k,) int32
        Face of the surface that each face is a piece of.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    uv: NDArray[np.float64] | None
    points: SurfacePoints
    parent: NDArray[np.int32]


def displaced(
    surface: Surface,
    height_at: HeightAt,
    *,
    edge_mm: float,
    corner_uv: ArrayLike | None = None,
    max_faces: int = MAX_FACES,
) -> DisplacedMesh:
    """Cut a surface fine and raise it.

    Parameters
    ----------
    surface : Surface
        m faces.
    height_at : callable
        Height in mm at samples; their footprint is `edge_mm`.
    edge_mm : float
        Longest edge before the relief is added.
    corner_uv : (m, 3, 2) float, optional
        An unwrap to carry along.
    max_faces : int
        Refuse to make more.

    Returns
    -------
    mesh : DisplacedMesh
        Watertight where the surface is.

    Raises
    ------
    InputError
        If the length is none, or would take too many faces.
    """
    if not (np.isfinite(edge_mm) and edge_mm > 0):
        raise InputError(f"edge_mm is {edge_mm}; it takes a length above 0")
    expected = surface.area_mm2 / (0.25 * edge_mm**2)
    if expected > max_faces:
        raise InputError(
            f"edges of {edge_mm:g} mm take about {expected:.2g} faces; the limit is {max_faces}. "
            f"Take edges of {np.sqrt(surface.area_mm2 / (0.25 * max_faces)):.2g} mm or more"
        )
    parent, weight, faces, points, vertices = subdivided(surface, edge_mm, max_faces=max_faces)
    normal = np.einsum("pk,pki->pi", points.barycentric, surface.vertex_normal[surface.faces[points.face]])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    samples = Samples(points, np.full(len(points), edge_mm, np.float32))
    height = checked(height_at(samples), "the height", (len(points),), np.float64)
    uv = None
    if corner_uv is not None:
        unwrap = checked(corner_uv, "corner_uv", (len(surface.faces), 3, 2), np.float64)
        uv = np.einsum("fck,fki->fci", weight, unwrap[parent])
    return DisplacedMesh(vertices + normal * height[:, None], faces, uv, points, parent)
