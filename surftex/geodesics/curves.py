"""Exact distances to curves: each piece sends straight ahead to both sides, ends and bends send into their wedge."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import frozen
from surftex.errors import InputError, SurfaceError
from surftex.geodesics.buckets import Buckets
from surftex.geodesics.flooding import flood_primitives
from surftex.geodesics.pieces import CurvePieces, barycentric_of
from surftex.geodesics.records import CurveRecords, entries_of
from surftex.geodesics.windows import (
    NUDGE,
    POINTS_A_SLICE,
    buckets_for,
    checked_bound,
    checked_radius,
    where,
)
from surftex.kernels.pool import Tick, slices
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

BEND_RAD = 1e-5
"""A curve that turns by less at a joint needs no cap there: distances err by less than the square of it."""


def flood_curves(
    surface: Surface,
    pieces: CurvePieces,
    radius_mm: ArrayLike,
    *,
    buckets: Buckets | None = None,
    bound_mm: NDArray[np.float64] | None = None,
    wanted: NDArray[np.bool_] | None = None,
    threads: int | None = None,
    tick: Tick | None = None,
) -> CurveRecords:
    """Flood curves, each as far as its radius.

    Parameters
    ----------
    surface : Surface
        m faces.
    pieces : CurvePieces
        The c curves; pieces without length are skipped, a curve without any length is a point.
    radius_mm : float or (c,) float
        How far to go from each curve.
    buckets : Buckets, optional
        Cells to list the rows by; made to fit radius and number of pieces without it.
    bound_mm : (m,) float64, optional
        For each face a distance beyond which a curve does not matter on it.
    wanted : (m,) bool, optional
        Faces that will be asked about; others get no rows.
    threads : int, optional
        None means every core; the result does not depend on it.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    records : CurveRecords
        For `nearest_curve`.

    Raises
    ------
    SurfaceError
        If a piece lies on a face that does not exist.
    InputError
        If a radius is not positive, or an array has a wrong shape.
    WorkError
        If one curve sends more windows than any sound mesh asks for.
    """
    _check(surface, pieces)
    count = pieces.curve_count
    radius = checked_radius(radius_mm, count)
    bound = checked_bound(bound_mm, surface)
    a, b = _inward(surface, pieces.face, pieces.start), _inward(surface, pieces.face, pieces.end)
    length = np.hypot(*(b - a).T) if len(pieces) else np.zeros(0)
    full = np.flatnonzero(
        (pieces.length_mm > 1e-9 * surface.edge_length[pieces.face].max(axis=1)) & (length > 0)
    )
    tangent = (b[full] - a[full]) / length[full, None]
    body = np.zeros((len(full), 8))
    body[:, 0:2], body[:, 2:4] = a[full], b[full]
    cap_piece, cap_place, cap_wedge, cap_tangent, cap_along = _caps(surface, pieces, full, a, b, tangent)
    caps = np.column_stack([cap_place, cap_place, cap_wedge])
    lone = np.setdiff1d(np.unique(pieces.curve), np.unique(pieces.curve[full]))
    lone = np.searchsorted(pieces.curve, lone)
    dots = np.column_stack([a[lone], a[lone], np.zeros((len(lone), 4))])
    piece_of = np.concatenate([full, cap_piece, lone]).astype(np.int64)
    primitive = np.concatenate([body, caps, dots])
    along = np.concatenate([pieces.start_mm[full], cap_along, pieces.start_mm[lone]])
    tangents = np.concatenate([tangent, cap_tangent, np.tile([1.0, 0.0], (len(lone), 1))])
    order = np.argsort(pieces.curve[piece_of], kind="stable")
    piece_of, primitive, along, tangents = piece_of[order], primitive[order], along[order], tangents[order]
    curve = pieces.curve[piece_of]
    start = np.searchsorted(curve, np.arange(count + 1)).astype(np.int64)
    rows = flood_primitives(
        surface, start, pieces.face[piece_of], primitive, radius, bound, wanted, threads, tick
    )
    limit = frozen(radius[curve])
    if buckets is None:
        buckets = buckets_for(surface, limit)
    entries = entries_of(buckets, *rows, limit, bound)
    return CurveRecords(
        buckets,
        pieces.points(surface),
        radius,
        bound,
        frozen(curve.astype(np.int32)),
        limit,
        rows[0],
        rows[1],
        *entries,
        pieces,
        frozen(piece_of.astype(np.int32)),
        frozen(along),
        frozen(tangents),
    )


def nearest_curve(
    records: CurveRecords, points: SurfacePoints, *, threads: int | None = None
) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64], NDArray[np.int8]]:
    """Ask for the nearest place on any curve.

    Parameters
    ----------
    records : CurveRecords
        From `flood_curves`.
    points : SurfacePoints
        n points.
    threads : int, optional
        None means every core; the result does not depend on it.

    Returns
    -------
    piece : (n,) int32
        Piece that holds the nearest place; -1 where no curve has the point within its radius.
    distance_mm : (n,) float64
        inf where there is none.
    along_mm : (n,) float64
        Length of the curve from its start to the nearest place; 0 where there is none.
    side : (n,) int8
        1 to the left of the curve, -1 to its right, 0 where there is none.
    """
    piece, distance, along, side = nearest_curves(records, points, 1, threads=threads)
    return piece[:, 0], distance[:, 0], along[:, 0], side[:, 0]


def nearest_curves(
    records: CurveRecords, points: SurfacePoints, k: int, *, threads: int | None = None
) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64], NDArray[np.int8]]:
    """Ask for the nearest place on each of the k nearest curves.

    Parameters
    ----------
    records : CurveRecords
        From `flood_curves`, without `bound_mm` where k is more than 1.
    points : SurfacePoints
        n points.
    k : int
        How many, at least 1.
    threads : int, optional
        None means every core; the result does not depend on it.

    Returns
    -------
    piece : (n, k) int32
        Pieces of as many curves, the nearest first; -1 where fewer have the point within their radius.
    distance_mm, along_mm : (n, k) float64
        As of `nearest_curve`.
    side : (n, k) int8
        As of `nearest_curve`.
    """
    from surftex.kernels.gather import nearest_places

    if k < 1:
        raise InputError(f"k is {k}; ask for at least 1 nearest curve")
    points.check_on(records.surface)
    shape = len(points), k
    piece, distance = np.full(shape, -1, np.int32), np.full(shape, np.inf)
    along, side = np.zeros(shape), np.zeros(shape, np.int8)
    place = where(records, points)
    rest = (
        records.row,
        records.row_id,
        records.source_of,
        records.limit_mm,
        records.piece_of,
        records.along_mm,
        records.tangent,
    )

    def work(begin: int, end: int) -> None:
        nearest_places(begin, end, *place, *rest, piece, distance, along, side)

    slices(work, len(points), size=POINTS_A_SLICE, threads=threads)
    return piece, distance, along, side


def _check(surface: Surface, pieces: CurvePieces) -> None:
    """Refuse faces that the surface does not have."""
    wrong = np.flatnonzero((pieces.face < 0) | (pieces.face >= len(surface.faces)))
    if len(wrong):
        raise SurfaceError(
            f"{len(wrong)} of {len(pieces)} pieces lie on faces outside 0..{len(surface.faces) - 1}; "
            f"the first is piece {int(wrong[0])} on face {int(pieces.face[wrong[0]])}"
        )


def _inward(surface: Surface, face: NDArray[np.int32], place: NDArray[np.float64]) -> NDArray[np.float64]:
    """Places moved off the edges of their faces."""
    weights = np.maximum(barycentric_of(surface, face, place), NUDGE)
    weights = weights / weights.sum(axis=1, keepdims=True)
    return np.einsum("pk,pki->pi", weights, surface.flat[face])


def _caps(
    surface: Surface,
    pieces: CurvePieces,
    full: NDArray[np.int64],
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    tangent: NDArray[np.float64],
) -> tuple[NDArray[Any], ...]:
    """Piece, place, wedge, direction and arc length of the caps: both ends of each curve, and where it bends."""
    if not len(full):
        return np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros((0, 4)), np.zeros((0, 2)), np.zeros(0)
    curve = pieces.curve[full]
    first = np.concatenate([[True], curve[1:] != curve[:-1]])
    last = np.concatenate([first[1:], [True]])
    left = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    size = pieces.length_mm[full]
    before, after = np.flatnonzero(~last), np.flatnonzero(~first)
    onward, known = _carried_back(
        surface,
        pieces.face[full[before]],
        pieces.face[full[after]],
        b[full[before]],
        a[full[after]],
        tangent[after],
    )
    turn = np.arctan2(
        tangent[before, 0] * onward[:, 1] - tangent[before, 1] * onward[:, 0],
        (tangent[before] * onward).sum(axis=1),
    )
    bends = np.flatnonzero(known & (np.abs(turn) > BEND_RAD))
    broken = np.flatnonzero(~known)
    here, there = left[before[bends]], np.stack([-onward[bends, 1], onward[bends, 0]], axis=1)
    to_left = (turn[bends] > 0)[:, None]
    wedge = np.concatenate([np.where(to_left, -here, there), np.where(to_left, -there, here)], axis=1)
    middle = tangent[before[bends]] + onward[bends]
    norm = np.hypot(middle[:, 0], middle[:, 1])[:, None]
    middle = np.where(norm > 1e-6, middle / np.maximum(norm, 1e-300), tangent[before[bends]])
    starts = np.concatenate([np.flatnonzero(first), after[broken]])
    ends = np.concatenate([np.flatnonzero(last), before[broken]])
    piece = np.concatenate([full[starts], full[ends], full[before[bends]]])
    place = np.concatenate([a[full[starts]], b[full[ends]], b[full[before[bends]]]])
    wedges = np.concatenate(
        [
            np.concatenate([left[starts], -left[starts]], axis=1),
            np.concatenate([-left[ends], left[ends]], axis=1),
            wedge,
        ]
    )
    direction = np.concatenate([tangent[starts], tangent[ends], middle])
    along = np.concatenate(
        [
            pieces.start_mm[full[starts]],
            (pieces.start_mm[full] + size)[ends],
            (pieces.start_mm[full] + size)[before[bends]],
        ]
    )
    return piece, place, wedges, direction, along


def _carried_back(
    surface: Surface,
    face: NDArray[np.int32],
    next_face: NDArray[np.int32],
    end: NDArray[np.float64],
    start: NDArray[np.float64],
    direction: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Directions in `next_face` as seen from `face`, and whether the two meet at the joint.

    Faces that share an edge at the joint are unfolded; a joint at a shared corner only is not known.
    """
    seen, known = direction.copy(), face == next_face
    best = np.where(known, 0.0, np.inf)
    for edge in range(3):
        fits = (surface.neighbor[face, edge] == next_face) & (face != next_face)
        c, s, x, y = np.moveaxis(surface.transport[face, edge], -1, 0)
        there = np.stack([c * end[:, 0] - s * end[:, 1] + x, s * end[:, 0] + c * end[:, 1] + y], axis=1)
        gap = np.hypot(*(there - start).T)
        better = fits & (gap < best)
        back = np.stack(
            [c * direction[:, 0] + s * direction[:, 1], c * direction[:, 1] - s * direction[:, 0]], axis=1
        )
        seen[better] = back[better]
        best[better] = gap[better]
        known = known | better
    size = surface.edge_length[face].max(axis=1)
    return seen, known & ((best <= 1e-6 * size) | (face == next_face))
