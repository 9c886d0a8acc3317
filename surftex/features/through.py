"""Smooth curves through points on a surface, as a draughtsman's spline passes through its pins."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, frozen
from surftex.errors import SurfaceError
from surftex.geodesics.bezier import bezier
from surftex.geodesics.paths import PathGround, shortest_path
from surftex.geodesics.pieces import CurvePieces, barycentric_of
from surftex.geodesics.tracing import inside_place, trace
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_INWARD = 1e-6
"""Share of the way to the middle of its face that a point is moved, so that every way from it begins in that face."""


def curves_through(
    surface: Surface,
    points: SurfacePoints,
    curve: ArrayLike,
    *,
    chord_mm: ArrayLike,
    threads: int | None = None,
) -> CurvePieces:
    """Smooth curves through points, each a Bézier curve from one to the next.

    Their common tangent is that of the parabola through a point and its two neighbours, by walking distance [1]_. A curve
    whose last point is its first is closed.

    Parameters
    ----------
    surface : Surface
        Where they lie.
    points : SurfacePoints
        In order along each curve.
    curve : (n,) int
        Curve of each point, never falling.
    chord_mm : (c,) float
        For each number of a curve, the length of straight parts wished for.
    threads : int, optional
        None means every core; the result does not depend on it.

    Returns
    -------
    pieces : CurvePieces
        Numbered by `curve`; without those of one place, and those whose points lie on several components.

    Raises
    ------
    SurfaceError
        If the numbers fall, or a point lies on a face that does not exist.

    References
    ----------
    .. [1] Bessel's tangents: Farin. Curves and Surfaces for CAGD, 5th edition (2002), section 9.3.
    """
    points.check_on(surface)
    number = checked(curve, "curve", (len(points),), np.int32, error=SurfaceError)
    if (np.diff(number) < 0).any():
        raise SurfaceError("the numbers of curves fall; sort the points by curve")
    weights = np.maximum(points.barycentric, 0.0)
    weights = (1 - _INWARD) * weights / weights.sum(axis=1, keepdims=True) + _INWARD / 3
    points = SurfacePoints.trusted(points.face, frozen(weights))

    first = np.flatnonzero(np.diff(number) == 0)
    ways, length = shortest_path(surface, points.taken(first), points.taken(first + 1), threads=threads)
    gone = np.isin(number[first], number[first[~np.isfinite(length)]])
    legs = np.flatnonzero(~gone & (length > 1e-6 * surface.mean_edge_mm))
    if not len(legs):
        return CurvePieces.joined([])
    own, length = number[first[legs]], length[legs]
    begin = np.searchsorted(ways.curve, legs)
    end = np.searchsorted(ways.curve, legs, side="right") - 1
    leaving = _unit(ways.end[begin] - ways.start[begin])
    arriving = _unit(ways.end[end] - ways.start[end])

    # The leg before each; of the first of a closed curve that is its last.
    opens = np.flatnonzero(np.diff(own, prepend=-1))
    before = np.arange(len(legs)) - 1
    before[opens] = np.append(opens[1:], len(legs)) - 1
    start, goal = points.taken(first[legs]), points.taken(first[legs] + 1)
    apart = np.abs(goal.barycentric[before] - start.barycentric).max(axis=1)
    met = np.flatnonzero((goal.face[before] == start.face) & (apart < 1e-3))
    came = before[met]
    weigh = (length[met] / (length[came] + length[met]))[:, None]
    tangent = (1 - weigh) * leaving[met] + weigh * arriving[came]
    heading, share = np.arctan2(tangent[:, 1], tangent[:, 0]), np.hypot(*tangent.T) / 3
    spot = start.taken(met)
    ahead = trace(surface, spot, heading, share * length[met], threads=threads).end
    back = trace(surface, spot, heading + np.pi, share * length[came], threads=threads).end

    # Controls of each leg: its start, those before and behind, its end; an open end bends as little as its leg allows.
    corner = [start, _put(start, met, ahead), _put(goal, came, back), goal]
    free = np.ones((2, len(legs)), bool)
    free[0, met] = free[1, came] = False
    ground = PathGround(surface)
    for side in (0, 1):
        open_ = np.flatnonzero(free[side])
        one, other = corner[3 * side].taken(open_), corner[2 - side].taken(open_)
        corner[1 + side] = _put(corner[1 + side], open_, _middles(surface, ground, one, other))
    faces = np.stack([each.face for each in corner], axis=1).ravel()
    every = np.stack([each.barycentric for each in corner], axis=1).reshape(-1, 3)
    chords = np.asarray(chord_mm, np.float64)[own]
    controls = SurfacePoints.trusted(frozen(faces), frozen(every))
    pieces, _ = bezier(surface, controls, chord_mm=chords, threads=threads)
    return CurvePieces.of(pieces.face, pieces.start, pieces.end, own[pieces.curve])


def _unit(way: NDArray[np.float64]) -> NDArray[np.float64]:
    return way / np.linalg.norm(way, axis=1, keepdims=True)


def _put(points: SurfacePoints, rows: NDArray[np.int64], others: SurfacePoints) -> SurfacePoints:
    """Points of which some rows are others."""
    face, barycentric = points.face.copy(), points.barycentric.copy()
    face[rows], barycentric[rows] = others.face, others.barycentric
    return SurfacePoints.trusted(frozen(face), frozen(barycentric))


def _middles(surface: Surface, ground: PathGround, one: SurfacePoints, other: SurfacePoints) -> SurfacePoints:
    """Half way from points to others."""
    face, place = ground.halfway(
        one.face, inside_place(surface, one), other.face, inside_place(surface, other)
    )
    return SurfacePoints.trusted(frozen(face), frozen(barycentric_of(surface, face, place)))
