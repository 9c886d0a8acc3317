"""Walking distance to curves, points and the borders of masks, as a field.

Within three mean edges the distance is exact. Beyond, it is linear between the vertices; these are exact within
eight mean edges, and further off solved once by the heat method. Each fades into the next.
"""

import numpy as np
from numpy.typing import NDArray

from surftex.fields.sources import SpannedField
from surftex.fields.spans import Span
from surftex.geodesics.curves import flood_curves, nearest_curve
from surftex.geodesics.heat import EXACT_EDGES, HeatSolver
from surftex.geodesics.pieces import CurvePieces
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_VERTEX_EDGES = 8.0
"""Mean edges within which the distances of vertices are exact."""

_HEAT_ERROR = 0.1
"""Share of a distance by which the heat method is never off by more."""


def distance_field(
    surface: Surface,
    pieces: CurvePieces,
    *,
    inside: NDArray[np.bool_] | None = None,
    limit_mm: float | None = None,
) -> SpannedField:
    """Measure how far it is to curves.

    Parameters
    ----------
    surface : Surface
        n vertices.
    pieces : CurvePieces
        At least one; a curve of no length is a point.
    inside : (n,) bool, optional
        With the curves as a border that has its inside on the left: whether each vertex is inside. The field is
        then negative inside. Without it no side is told.
    limit_mm : float, optional
        Greatest distance, also of places that no path leads to; twice the diagonal of the mesh without it.

    Returns
    -------
    field : SpannedField
        Millimetres.
    """
    limit = (
        2 * float(np.linalg.norm(np.ptp(surface.vertices, axis=0))) if limit_mm is None else float(limit_mm)
    )
    reach = EXACT_EDGES * surface.mean_edge_mm
    far = np.minimum(_at_vertices(surface, pieces), limit)
    if inside is not None:
        far = np.where(inside, -far, far)
    records = flood_curves(surface, pieces, reach)
    corners = far[surface.faces]

    def field(points: SurfacePoints, footprint_mm: NDArray | float = 0.0) -> NDArray[np.float64]:
        beyond = np.einsum("pk,pk->p", points.barycentric, corners[points.face])
        _, distance, _, side = nearest_curve(records, points)
        share = np.clip((reach - distance) / (reach * 2 / 3), 0.0, 1.0)
        near = np.where(share > 0, distance, 0.0)
        if inside is not None:
            near = np.where(side > 0, -near, near)
        return np.clip(share * near + (1 - share) * beyond, -limit, limit)

    def span() -> Span:
        room = surface.edge_length.max(axis=1) + _HEAT_ERROR * np.abs(corners).max(axis=1)
        low, high = corners.min(axis=1) - room, corners.max(axis=1) + room
        return np.clip(low, 0.0 if inside is None else -limit, limit), np.clip(high, -limit, limit)

    return SpannedField(field, span)


def _at_vertices(surface: Surface, pieces: CurvePieces) -> NDArray[np.float64]:
    """(n,) distance of every vertex: exact near by, by heat beyond; inf where no path leads."""
    reach = _VERTEX_EDGES * surface.mean_edge_mm
    places, ends = pieces.points(surface, 0.5), pieces.points(surface, 0.0)
    sources = SurfacePoints.trusted(
        np.concatenate([places.face, ends.face]), np.concatenate([places.barycentric, ends.barycentric])
    )
    heat = HeatSolver(surface).vertex_distance(sources)
    used, corner = np.unique(surface.faces.ravel(), return_index=True)
    bound = heat[surface.faces].max(axis=1) * 1.5 + 2 * surface.mean_edge_mm
    records = flood_curves(surface, pieces, reach, bound_mm=bound)
    points = SurfacePoints.trusted((corner // 3).astype(np.int32), np.eye(3)[corner % 3])
    exact = np.full(len(heat), np.inf)
    exact[used] = nearest_curve(records, points)[1]
    ring = (exact > reach / 2) & np.isfinite(exact) & np.isfinite(heat)
    if ring.any():
        heat = np.maximum(heat - np.mean(heat[ring] - exact[ring]), 0.0)
    share = np.clip((reach - exact) / (reach / 2), 0.0, 1.0)
    near = np.where(share > 0, exact, 0.0)
    return np.where(share == 1, near, share * near + (1 - share) * heat)


def point_pieces(surface: Surface, points: SurfacePoints) -> CurvePieces:
    """Take points for curves of no length.

    Parameters
    ----------
    surface : Surface
        Where they lie.
    points : SurfacePoints
        n points.

    Returns
    -------
    pieces : CurvePieces
        n of them.
    """
    place = points.flat(surface)
    return CurvePieces.of(points.face, place, place, np.arange(len(points)))
