"""Cubic Bézier curves on a surface: de Casteljau's scheme with shortest paths for straight lines [1]_.

A curve is halved again and again, and the ends of the parts are joined by shortest paths. It starts and ends at
its outer controls, towards and from the inner ones, and bends smoothly between. Halving, unlike evaluating the
scheme at every parameter, cannot tear the curve where the shortest paths between controls jump.

References
----------
.. [1] Mancinelli, Nazzaro, Pellacini, Puppo. b/Surf: Interactive Bézier Splines on Surface Meshes. TVCG (2022).
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, frozen
from surftex.errors import SurfaceError
from surftex.geodesics.paths import PathGround, polyline
from surftex.geodesics.pieces import CurvePieces, barycentric_of
from surftex.geodesics.tracing import inside_place
from surftex.kernels.pool import Tick, slices
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_SLICE = 64


def bezier(
    surface: Surface,
    controls: SurfacePoints,
    *,
    depth: int = 4,
    chord_mm: ArrayLike | None = None,
    threads: int | None = None,
    tick: Tick | None = None,
) -> tuple[CurvePieces, NDArray[np.float64]]:
    """Cubic Bézier curves on a surface, all at once.

    Parameters
    ----------
    surface : Surface
        Where they lie.
    controls : SurfacePoints
        4 n points: the controls of curve i are 4 i to 4 i + 3.
    depth : int
        Halvings, 0 to 10: a curve consists of 2^depth shortest paths.
    chord_mm : (n,) float, optional
        Lengths wished for these paths: a curve is halved, up to twice as often as `depth` says, until its own are about as
        short.
    threads : int, optional
        None means every core; the result does not depend on it.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    pieces : CurvePieces
        Curve i is curve i; one whose controls lie on several components has no pieces.
    length_mm : (n,) float64
        inf where the controls lie on several components.

    Raises
    ------
    SurfaceError
        If the number of controls is no multiple of 4, the depth is out of range, or a point lies on no face.
    """
    count = _curves(surface, controls)
    parts, length = [], np.full(count, np.inf)
    for halvings, own in _by_halvings(surface, controls, depth, chord_mm):
        some = controls.taken((4 * own[:, None] + np.arange(4)).ravel())
        points, curve = bezier_points(surface, some, depth=halvings, threads=threads, tick=tick)
        pieces, total = polyline(surface, points, curve, threads=threads)
        there = np.unique(curve)
        length[own[there]] = total[there]
        parts.append((own[pieces.curve], pieces.face, pieces.start, pieces.end))
    number, face, start, end = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    order = np.argsort(number, kind="stable")
    return CurvePieces.of(face[order], start[order], end[order], number[order]), length


def _curves(surface: Surface, controls: SurfacePoints) -> int:
    """Count the curves of controls that are on a surface."""
    controls.check_on(surface)
    if len(controls) % 4:
        raise SurfaceError(f"there are {len(controls)} controls; a cubic curve has 4")
    return len(controls) // 4


def _by_halvings(
    surface: Surface, controls: SurfacePoints, depth: int, chord_mm: ArrayLike | None
) -> list[tuple[int, NDArray[np.int64]]]:
    """Numbers of halvings, and the curves that take so many."""
    count = len(controls) // 4
    if chord_mm is None:
        return [(depth, np.arange(count))]
    wished = checked(chord_mm, "chord_mm", (count,), np.float64, error=SurfaceError)
    legs = np.diff(controls.positions(surface).reshape(count, 4, 3), axis=1)
    chords = np.linalg.norm(legs, axis=2).sum(axis=1) / np.maximum(wished, np.finfo(float).tiny)
    halvings = np.clip(np.ceil(np.log2(np.maximum(chords, 1.0))), depth, min(2 * depth, 10)).astype(int)
    return [(int(each), np.flatnonzero(halvings == each)) for each in np.unique(halvings)]


def bezier_points(
    surface: Surface,
    controls: SurfacePoints,
    *,
    depth: int = 4,
    threads: int | None = None,
    tick: Tick | None = None,
) -> tuple[SurfacePoints, NDArray[np.int32]]:
    """Points on cubic Bézier curves at equal steps of their parameter.

    Parameters
    ----------
    surface : Surface
        Where they lie.
    controls : SurfacePoints
        4 n points, as for `bezier`.
    depth : int
        Halvings, 0 to 10.
    threads : int, optional
        None means every core; the result does not depend on it.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    points : SurfacePoints
        2^depth + 1 for each curve.
    curve : (k,) int32
        Curve of each; curves with controls on several components are left out.

    Raises
    ------
    SurfaceError
        As for `bezier`.
    """
    _curves(surface, controls)
    if not 0 <= depth <= 10:
        raise SurfaceError(f"depth is {depth}; it takes 0 to 10")
    component = surface.component[controls.face].reshape(-1, 4)
    curves = np.flatnonzero((component == component[:, :1]).all(axis=1))
    face = np.array(controls.face, np.int32).reshape(-1, 4)[curves]
    place = inside_place(surface, controls).reshape(-1, 4, 2)[curves]
    ground = PathGround(surface)

    def work(first: int, last: int) -> tuple[NDArray[Any], NDArray[Any]]:
        return _halved(ground, face[first:last], place[first:last], depth)

    parts = slices(work, len(curves), size=_SLICE, threads=threads, tick=tick)
    knots = 2**depth + 1
    if not parts:
        return SurfacePoints.trusted(np.zeros(0, np.int32), np.zeros((0, 3))), np.zeros(0, np.int32)
    faces, places = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    flat_faces = frozen(faces.ravel())
    weights = barycentric_of(surface, flat_faces, places.reshape(-1, 2))
    return SurfacePoints.trusted(flat_faces, frozen(weights)), np.repeat(curves, knots).astype(np.int32)


def _halved(
    ground: PathGround, face: NDArray[np.int32], place: NDArray[np.float64], depth: int
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Faces (n, 2^depth + 1) and places of the points on n curves, from their controls (n, 4)."""

    def middles(
        f: NDArray[np.int32], p: NDArray[np.float64]
    ) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        begin, end = np.ascontiguousarray(f[:, :-1]).ravel(), np.ascontiguousarray(f[:, 1:]).ravel()
        start, goal = (np.ascontiguousarray(side).reshape(-1, 2) for side in (p[:, :-1], p[:, 1:]))
        half_face, half_place = ground.halfway(begin, start, end, goal)
        return half_face.reshape(len(f), -1), half_place.reshape(len(f), -1, 2)

    faces, places = face, place
    for _ in range(depth):
        # Rows of triangles: 4 controls, 3 middles, 2 middles of those, 1; their sides are the two halves.
        rows = [(faces, places)]
        for _ in range(3):
            rows.append(middles(*rows[-1]))
        left = [(f[:, :1], p[:, :1]) for f, p in rows]
        right = [(f[:, -1:], p[:, -1:]) for f, p in rows[::-1]]
        faces = np.concatenate([np.hstack([f for f, _ in left]), np.hstack([f for f, _ in right])], axis=1)
        places = np.concatenate([np.hstack([p for _, p in left]), np.hstack([p for _, p in right])], axis=1)
        faces, places = faces.reshape(-1, 4), places.reshape(-1, 4, 2)
    count = len(face)
    faces, places = faces.reshape(count, -1, 4), places.reshape(count, -1, 4, 2)
    ends = np.concatenate([faces[:, :, 0], faces[:, -1:, 3]], axis=1)
    return ends, np.concatenate([places[:, :, 0], places[:, -1:, 3]], axis=1)
