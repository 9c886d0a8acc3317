"""Straightest lines on a surface: walk on from a point in a direction, and carry that direction along.

A line is straight in each face and, unfolded, straight across each edge; it need not be the shortest way.
Directions are carried along (parallel transport): the angle at the end is the direction of walking there, and
two ways to one place differ by the curvature they enclose.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, frozen
from surftex.errors import SurfaceError
from surftex.geodesics.pieces import CurvePieces, barycentric_of
from surftex.kernels.pool import Tick, slices
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

WHOLE, BORDER, FACES = 0, 1, 2
"""Reasons in `Traces.reason`: the whole length was walked; a border was met; the count of faces ran out."""

_SLICE = 1024


@dataclass(frozen=True, eq=False)
class Traces:
    """What n traced lines found.

    Attributes
    ----------
    pieces : CurvePieces
        Curve i is line i; a line of no length has no pieces.
    end : SurfacePoints
        Where each line ended.
    angle_rad : (n,) float64
        Direction of walking at the end, in the frame of the end's face.
    reason : (n,) int8
        `WHOLE`, `BORDER` or `FACES`: why it ended.
    """

    pieces: CurvePieces
    end: SurfacePoints
    angle_rad: NDArray[np.float64]
    reason: NDArray[np.int8]


def trace(
    surface: Surface,
    points: SurfacePoints,
    angle_rad: ArrayLike,
    length_mm: ArrayLike,
    *,
    most_faces: int = 1_000_000,
    threads: int | None = None,
    tick: Tick | None = None,
) -> Traces:
    """Walk straight on from points, all at once.

    Parameters
    ----------
    surface : Surface
        Where to walk.
    points : SurfacePoints
        n starts, anywhere: inside faces, on edges, on vertices.
    angle_rad : float or (n,) float
        Direction at each start, in the frame of its face.
    length_mm : float or (n,) float
        How far; 0 or more.
    most_faces : int
        A line that has crossed so many faces ends there.
    threads : int, optional
        None means every core; the result does not depend on it.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    traces : Traces
        Pieces, ends, angles at the ends, and why each line ended. A line that meets a vertex passes it on one
        side, so that its two continuations differ by the vertex' curvature.

    Raises
    ------
    SurfaceError
        If a point lies on no face, an angle or length is not finite, or a length is negative.

    References
    ----------
    .. [1] Polthier, Schmies. Straightest Geodesics on Polyhedral Surfaces. Mathematical Visualization (1998).

    Examples
    --------
    >>> from surftex.surface.shapes import plane
    >>> sheet = plane(10.0)
    >>> walk = trace(sheet, SurfacePoints([0], [[1, 0, 0]]), 0.0, 7.5)
    >>> (walk.end.positions(sheet) - sheet.vertices[sheet.faces[0, 0]]).round(9).tolist()
    [[7.5, 0.0, 0.0]]
    """
    points.check_on(surface)
    count = len(points)
    angle, length = per_point(angle_rad, "angle_rad", count), per_point(length_mm, "length_mm", count)
    negative = np.flatnonzero(length < 0)
    if len(negative):
        first = int(negative[0])
        raise SurfaceError(
            f"{len(negative)} of {count} lengths are negative; the first is length_mm[{first}] = "
            f"{length[first]}. Walk backwards by an angle turned by pi"
        )
    face, place = np.array(points.face, np.int32), inside_place(surface, points)

    def walk(first: int, last: int) -> list[NDArray]:
        return _trace_slice(surface, face, place, angle, length, most_faces, first, last)

    parts = slices(walk, count, size=_SLICE, threads=threads, tick=tick)
    if not parts:
        parts = [_trace_slice(surface, face, place, angle, length, most_faces, 0, 0)]
    piece_face, piece_line, piece_place, piece_start, end_face, end_place, end_angle, reason = (
        np.concatenate(arrays) for arrays in zip(*parts, strict=True)
    )
    pieces = CurvePieces(
        frozen(piece_face),
        frozen(piece_place[:, :2].copy()),
        frozen(piece_place[:, 2:].copy()),
        frozen(piece_line),
        frozen(piece_start),
    )
    end = SurfacePoints.trusted(frozen(end_face), frozen(barycentric_of(surface, end_face, end_place)))
    return Traces(pieces, end, frozen(end_angle), frozen(reason))


def per_point(value: ArrayLike, name: str, count: int) -> NDArray[np.float64]:
    """Take one finite number for all points, or one for each.

    Parameters
    ----------
    value : float or (count,) float
        What the caller gave.
    name : str
        What the message calls it.
    count : int
        Number of points.

    Returns
    -------
    values : (count,) float64
        A writable copy.

    Raises
    ------
    SurfaceError
        If the shape does not fit or a value is not finite.
    """
    if np.ndim(value) == 0:
        value = np.full(count, value)
    return checked(value, name, (count,), np.float64, error=SurfaceError).copy()


def inside_place(surface: Surface, points: SurfacePoints) -> NDArray[np.float64]:
    """Coordinates of points in their faces' frames, after weights below 0 are lifted to 0.

    Parameters
    ----------
    surface : Surface
        Where the points lie.
    points : SurfacePoints
        n points.

    Returns
    -------
    place : (n, 2) float64
        Millimetres, writable, inside the faces or on their edges.
    """
    weights = np.maximum(points.barycentric, 0.0)
    weights /= weights.sum(axis=1, keepdims=True)
    return np.einsum("pk,pki->pi", weights, surface.flat[points.face])


def _trace_slice(surface, face, place, angle, length, most_faces, first, last) -> list[NDArray]:
    """Run the kernel over some lines, with more room for pieces whenever it asks."""
    from surftex.kernels.trace import trace_lines

    size = last - first
    room = 64 + 16 * size
    piece_face, piece_line = np.zeros(room, np.int32), np.zeros(room, np.int32)
    piece_place, piece_start = np.zeros((room, 4)), np.zeros(room)
    end_face, end_place = np.zeros(size, np.int32), np.zeros((size, 2))
    end_angle, reason = np.zeros(size), np.zeros(size, np.int8)
    used = np.zeros(1, np.int64)
    done = 0
    while True:
        done = trace_lines(
            surface.flat, surface.neighbor, surface.neighbor_edge, surface.transport, done, size,
            face[first:last], place[first:last], angle[first:last], length[first:last], most_faces,
            piece_face, piece_place, piece_line, piece_start, end_face, end_place, end_angle, reason, used,
        )  # fmt: skip
        if done == size:
            break
        piece_face, piece_line, piece_place, piece_start = (
            np.concatenate([array, np.zeros_like(array)])
            for array in (piece_face, piece_line, piece_place, piece_start)
        )
    kept = int(used[0])
    return [
        piece_face[:kept],
        piece_line[:kept] + np.int32(first),
        piece_place[:kept],
        piece_start[:kept],
        end_face,
        end_place,
        end_angle,
        reason,
    ]
