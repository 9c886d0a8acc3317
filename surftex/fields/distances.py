"""Walking distance to curves, points and the borders of masks, as a field.

Within three mean edges the distance is exact. Beyond, it is linear between the vertices; these are exact within
eight mean edges, and further off solved once by the heat method. Each fades into the next. Where the limit is no more than
three mean edges, all of it is exact.
The side of a border is that of its mask at the very point.
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


def distance_field(
    surface: Surface,
    pieces: CurvePieces,
    *,
    mask: SpannedField | None = None,
    level: float = 0.5,
    limit_mm: float | None = None,
) -> SpannedField:
    """Measure how far it is to curves.

    Parameters
    ----------
    surface : Surface
        n vertices.
    pieces : CurvePieces
        At least one; a curve of no length is a point.
    mask : SpannedField, optional
        With the curves as its border: the field is negative where the mask is above the level. Without it no side is told.
    level : float
        Of the mask.
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
    reach = min(EXACT_EDGES * surface.mean_edge_mm, limit)
    records = flood_curves(surface, pieces, reach)
    corners = None if reach == limit else np.minimum(_at_vertices(surface, pieces), limit)[surface.faces]

    def field(points: SurfacePoints, footprint_mm: NDArray | float = 0.0) -> NDArray[np.float64]:
        distance = nearest_curve(records, points)[1]
        if corners is not None:
            beyond = np.einsum("pk,pk->p", points.barycentric, corners[points.face])
            share = np.clip((reach - distance) / (reach * 2 / 3), 0.0, 1.0)
            distance = share * np.where(share > 0, distance, 0.0) + (1 - share) * beyond
        far = np.minimum(distance, limit)
        return far if mask is None else np.where(mask(points) > level, -far, far)

    def span() -> Span:
        count = len(surface.faces)
        every = SurfacePoints.trusted(
            np.repeat(np.arange(count, dtype=np.int32), 3), np.tile(np.eye(3), (count, 1))
        )
        near = np.minimum(nearest_curve(records, every)[1], reach).reshape(-1, 3)
        # the exact distance changes by no more than the way; where it is not known it is beyond the reach, and unused
        room = surface.edge_length.max(axis=1) * (1 + 1e-6)
        low = np.maximum(near.max(axis=1) - room, 0.0)
        high = np.minimum(near.min(axis=1) + room, reach)
        if corners is not None:
            low, high = np.minimum(low, corners.min(axis=1)), np.maximum(high, corners.max(axis=1))
        low, high = np.minimum(low, limit), np.minimum(high, limit)
        if mask is None:
            return low, high
        least, most = mask.span()
        return np.where(most <= level, low, -high), np.where(least > level, -low, high)

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
