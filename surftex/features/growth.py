"""Wrinkles and other smooth curves: splines through controls that were drawn, or that grow along a field.

A curve grows from a start as in [1]_: with v the field's vector there, the next control is the place that a walk of
a share of v leads to, and so on until the length of the first vector is used up. The controls steer cubic Bézier
pieces that meet half way between every second and third control, so that the curve never has a kink.

References
----------
.. [1] Bando, Kuratate, Nishita. A Simple Method for Modeling Wrinkles on Human Skin. Pacific Graphics (2002).
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, frozen
from surftex.errors import SurfaceError
from surftex.geodesics.bezier import bezier
from surftex.geodesics.paths import PathGround
from surftex.geodesics.pieces import CurvePieces, barycentric_of
from surftex.geodesics.tracing import WHOLE, inside_place, trace
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

Vectors = Callable[[SurfacePoints], NDArray[np.float64]]
"""``vectors(points) -> (n, 2)``: millimetres in the frame of each point's face."""

_MOST_STEPS = 8
"""A curve whose field shrinks along the way ends after so many times its share of steps."""


def grow(
    surface: Surface,
    starts: SurfacePoints,
    vectors: Vectors,
    *,
    steps: int = 5,
    depth: int = 4,
    threads: int | None = None,
) -> CurvePieces:
    """Grow curves along a field of vectors, all at once.

    Parameters
    ----------
    surface : Surface
        Where they grow.
    starts : SurfacePoints
        n starts.
    vectors : callable
        Direction to grow in, and how long: the length at the start is that of the whole curve. Where the vector
        points back against the way that a curve has come, its opposite is taken: lines have no sense.
    steps : int
        Walks that make up a curve; the shorter the walks, the closer it follows the field.
    depth : int
        Halvings of each Bézier piece, as of `surftex.geodesics.bezier.bezier`.
    threads : int, optional
        None means every core; the result does not depend on it.

    Returns
    -------
    pieces : CurvePieces
        Curve i grew from start i. It ends early at a border; where the vector at the start is 0 there is none.

    Raises
    ------
    SurfaceError
        If a start lies on no face, there are no steps, or a vector is not finite.
    """
    points, curve = grown_controls(surface, starts, vectors, steps=steps, threads=threads)
    return spline(surface, points, curve, depth=depth, threads=threads)


def grown_controls(
    surface: Surface,
    starts: SurfacePoints,
    vectors: Vectors,
    *,
    steps: int = 5,
    threads: int | None = None,
) -> tuple[SurfacePoints, NDArray[np.int32]]:
    """Find the controls of curves that grow along a field.

    Parameters
    ----------
    surface : Surface
        Where they grow.
    starts : SurfacePoints
        n starts.
    vectors : callable
        As for `grow`.
    steps : int
        Walks that make up a curve.
    threads : int, optional
        None means every core; the result does not depend on it.

    Returns
    -------
    points : SurfacePoints
        Controls in order along each curve, at least two of each.
    curve : (k,) int32
        Start that each belongs to, never falling.

    Raises
    ------
    SurfaceError
        As for `grow`.
    """
    starts.check_on(surface)
    if steps < 1:
        raise SurfaceError(f"steps is {steps}; it takes at least 1")
    alive = np.arange(len(starts))
    here, came = starts, np.zeros(len(starts))
    left = np.full(len(starts), np.inf)
    faces, weights, curves = [starts.face], [starts.barycentric], [alive]
    for turn in range(_MOST_STEPS * steps):
        vector = checked(vectors(here), "vectors(points)", (len(here), 2), np.float64, error=SurfaceError)
        size, heading = np.hypot(vector[:, 0], vector[:, 1]), np.arctan2(vector[:, 1], vector[:, 0])
        if turn == 0:
            left = size
        elif len(here):
            heading = np.where(np.cos(heading - came) < 0, heading + np.pi, heading)
        step = np.minimum(size / steps, left)
        going = step > 1e-9 * surface.mean_edge_mm
        here = SurfacePoints.trusted(here.face[going], here.barycentric[going])
        alive, left, step, heading = alive[going], left[going] - step[going], step[going], heading[going]
        if not len(alive):
            break
        walk = trace(surface, here, heading, step, threads=threads)
        here, came = walk.end, walk.angle_rad
        left = np.where((walk.reason == WHOLE) & (left > 1e-9 * step), left, 0.0)
        faces.append(here.face)
        weights.append(here.barycentric)
        curves.append(alive)
    curve = np.concatenate(curves)
    order = np.argsort(curve, kind="stable")
    several = np.isin(curve[order], np.flatnonzero(np.bincount(curve, minlength=1) > 1))
    order = order[several]
    points = SurfacePoints.trusted(
        frozen(np.concatenate(faces)[order].astype(np.int32)), frozen(np.concatenate(weights)[order])
    )
    return points, curve[order].astype(np.int32)


def spline(
    surface: Surface,
    points: SurfacePoints,
    curve: ArrayLike,
    *,
    depth: int = 4,
    threads: int | None = None,
) -> CurvePieces:
    """Smooth curves steered by controls.

    Parameters
    ----------
    surface : Surface
        Where they lie.
    points : SurfacePoints
        Controls in order along each curve. A curve starts at its first and ends at its last, and is drawn
        towards those between; controls every few edges apart keep it close.
    curve : (n,) int
        Curve of each control, never falling.
    depth : int
        Halvings of each Bézier piece, 0 to 10.
    threads : int, optional
        None means every core; the result does not depend on it.

    Returns
    -------
    pieces : CurvePieces
        Numbered by `curve`; without those of one control, and those whose controls lie on several components.

    Raises
    ------
    SurfaceError
        If the numbers fall, or a point lies on a face that does not exist.
    """
    points.check_on(surface)
    number = checked(curve, "curve", (len(points),), np.int32, error=SurfaceError)
    falls = np.flatnonzero(np.diff(number) < 0)
    if len(falls):
        raise SurfaceError(
            f"curve numbers fall at {len(falls)} controls; the first is control {falls[0] + 1}"
        )
    ground = PathGround(surface)
    face, place, number = _one_component(surface, points, number)
    face, place, number = _made_odd(surface, ground, face, place, number)
    if not len(number):
        return CurvePieces.joined([])
    # Controls 0, (1, 2), (3, 4)... last: the pieces meet half way from 2 to 3, from 4 to 5, and so on.
    first = np.flatnonzero(np.diff(number, prepend=-1))
    size = np.diff(np.append(first, len(number)))
    rank = np.arange(len(number)) - np.repeat(first, size)
    last = np.repeat(size, size) - 1
    joint = np.flatnonzero((rank > 0) & (rank % 2 == 0) & (rank < last - 1))
    middle_face, middle_place = ground.halfway(face[joint], place[joint], face[joint + 1], place[joint + 1])
    every = np.arange(len(number))
    where = np.concatenate([every, joint, joint])
    order = np.argsort(np.concatenate([every * 4.0, joint * 4.0 + 1, joint * 4.0 + 2]), kind="stable")
    faces = np.concatenate([face, middle_face, middle_face])[order]
    places = np.concatenate([place, middle_place, middle_place])[order]
    controls = SurfacePoints.trusted(frozen(faces), frozen(barycentric_of(surface, faces, places)))
    pieces, _ = bezier(surface, controls, depth=depth, threads=threads)
    owner = number[where[order]][::4]
    return CurvePieces.of(pieces.face, pieces.start, pieces.end, owner[pieces.curve])


def _one_component(
    surface: Surface, points: SurfacePoints, number: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.int32]]:
    """Faces, places and numbers of the controls whose curves have several, all on one component."""
    component = surface.component[points.face]
    wrong = number[:-1][(number[1:] == number[:-1]) & (component[1:] != component[:-1])]
    lone = np.flatnonzero(np.bincount(number, minlength=1) < 2)
    kept = ~np.isin(number, np.concatenate([wrong, lone]))
    place = inside_place(surface, points)
    return np.array(points.face[kept], np.int32), place[kept], number[kept]


def _made_odd(
    surface: Surface,
    ground: PathGround,
    face: NDArray[np.int32],
    place: NDArray[np.float64],
    number: NDArray[np.int32],
) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.int32]]:
    """Put a control half way along the longest leg of curves until each has an even number, 4 or more."""
    while True:
        first = np.flatnonzero(np.diff(number, prepend=-1))
        size = np.diff(np.append(first, len(number)))
        short = np.flatnonzero((size % 2 == 1) | (size < 4))
        if not len(short):
            return face, place, number
        spot = SurfacePoints.trusted(face, barycentric_of(surface, face, place)).positions(surface)
        leg = np.linalg.norm(np.diff(spot, axis=0), axis=1)
        longest = np.array([first[c] + int(np.argmax(leg[first[c] : first[c] + size[c] - 1])) for c in short])
        begin, goal = face[longest], face[longest + 1]
        half_face, half_place = ground.halfway(begin, place[longest], goal, place[longest + 1])
        face = np.insert(face, longest + 1, half_face)
        place = np.insert(place, longest + 1, half_place, axis=0)
        number = np.insert(number, longest + 1, number[longest])
