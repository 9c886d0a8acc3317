"""Shortest paths between pairs of points, and chains of them, as `CurvePieces`.

A strip of faces by A*, pulled tight, and flipped over corners until no corner is cut short [1]_: a path that is
shortest among all near it. Up to three mean edge lengths it is the shortest of all in 92 to 100 of 100 cases, at
ten in two thirds; then another way around a bump may be shorter by a per cent or so.

References
----------
.. [1] Mancinelli, Nazzaro, Pellacini, Puppo. b/Surf: Interactive Bézier Splines on Surface Meshes. TVCG (2022).
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, frozen
from surftex.errors import SurfaceError
from surftex.geodesics.pieces import CurvePieces
from surftex.geodesics.tracing import inside_place
from surftex.kernels.pool import Tick, slices
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_SLICE = 512


def shortest_path(
    surface: Surface,
    start: SurfacePoints,
    end: SurfacePoints,
    *,
    threads: int | None = None,
    tick: Tick | None = None,
) -> tuple[CurvePieces, NDArray[np.float64]]:
    """Shortest paths from starts to ends, all at once.

    Parameters
    ----------
    surface : Surface
        Where to walk.
    start : SurfacePoints
        n starts.
    end : SurfacePoints
        n ends.
    threads : int, optional
        None means every core; the result does not depend on it.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    pieces : CurvePieces
        Curve i is path i; a path of no length, or that leads nowhere, has no pieces.
    length_mm : (n,) float64
        inf where start and end lie on different components.

    Raises
    ------
    SurfaceError
        If the counts differ, or a point lies on a face that does not exist.

    Examples
    --------
    >>> from surftex.surface.shapes import plane
    >>> sheet = plane(10.0)
    >>> ends = SurfacePoints([0, 300], [[1, 0, 0], [1, 0, 0]])
    >>> way, length = shortest_path(sheet, *(SurfacePoints(ends.face[[i]], ends.barycentric[[i]]) for i in (0, 1)))
    >>> bool(abs(length[0] - np.linalg.norm(np.diff(ends.positions(sheet), axis=0))) < 1e-9)
    True
    """
    if len(start) != len(end):
        raise SurfaceError(f"there are {len(start)} starts but {len(end)} ends; give as many")
    return _legs(surface, start, end, np.arange(len(start), dtype=np.int32), threads, tick)


def polyline(
    surface: Surface,
    points: SurfacePoints,
    curve: ArrayLike,
    *,
    threads: int | None = None,
    tick: Tick | None = None,
) -> tuple[CurvePieces, NDArray[np.float64]]:
    """Curves through points in order, by the shortest path from each to the next.

    Parameters
    ----------
    surface : Surface
        Where to walk.
    points : SurfacePoints
        n points.
    curve : (n,) int
        Curve of each point, never falling; repeat a first point at the end to close a curve.
    threads : int, optional
        None means every core; the result does not depend on it.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    pieces : CurvePieces
        Numbered by `curve`.
    length_mm : (c,) float64
        Of curves 0 to the highest number; inf where one passes to another component.

    Raises
    ------
    SurfaceError
        If the numbers fall, or a point lies on a face that does not exist.
    """
    number = checked(curve, "curve", (len(points),), np.int32, error=SurfaceError)
    falls = np.flatnonzero(np.diff(number) < 0)
    if len(falls) or (len(number) and number[0] < 0):
        at = int(falls[0]) + 1 if len(falls) else 0
        raise SurfaceError(
            f"curve numbers fall at {max(len(falls), 1)} points; the first is point {at}, of curve {number[at]}. "
            "Sort the points by curve"
        )
    along = np.flatnonzero(np.diff(number) == 0)
    start = SurfacePoints.trusted(points.face[along], points.barycentric[along])
    end = SurfacePoints.trusted(points.face[along + 1], points.barycentric[along + 1])
    pieces, leg = _legs(surface, start, end, number[along], threads, tick)
    total = np.zeros(int(number[-1]) + 1 if len(number) else 0)
    np.add.at(total, number[along], leg)
    if not np.isfinite(leg).all():
        gone = np.isin(pieces.curve, number[along][~np.isfinite(leg)])
        pieces = CurvePieces.of(
            pieces.face[~gone], pieces.start[~gone], pieces.end[~gone], pieces.curve[~gone]
        )
    return pieces, total


def _legs(
    surface: Surface,
    start: SurfacePoints,
    end: SurfacePoints,
    line: NDArray[np.int32],
    threads: int | None,
    tick: Tick | None,
) -> tuple[CurvePieces, NDArray[np.float64]]:
    """Walk from each start to its end; legs with one line follow one another."""
    start.check_on(surface)
    end.check_on(surface)
    length = np.full(len(start), np.inf)
    joined = surface.component[start.face] == surface.component[end.face]
    rows = np.flatnonzero(joined)
    begin, goal_face = np.array(start.face[rows], np.int32), np.array(end.face[rows], np.int32)
    place, goal = inside_place(surface, start)[rows], inside_place(surface, end)[rows]
    lines = np.array(line[rows], np.int32)
    ground = PathGround(surface)

    def walk(first: int, last: int) -> tuple[NDArray[Any], ...]:
        part = slice(first, last)
        return ground.walk(begin[part], place[part], goal_face[part], goal[part], lines[part])

    # Slices end between lines, so that each can sum its own lengths.
    cuts = (
        np.concatenate([[0], np.flatnonzero(np.diff(lines)) + 1, [len(lines)]])
        if len(lines)
        else np.zeros(1, int)
    )
    parts = slices(
        lambda first, last: walk(int(cuts[first]), int(cuts[last])),
        len(cuts) - 1,
        size=_SLICE,
        threads=threads,
        tick=tick,
    )
    if not parts:
        return CurvePieces.of([], np.zeros((0, 2)), np.zeros((0, 2)), []), length
    face, flat, number, before, legs = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    length[rows] = legs
    pieces = CurvePieces(
        frozen(face), frozen(flat[:, :2].copy()), frozen(flat[:, 2:].copy()), frozen(number), frozen(before)
    )
    return pieces, length


class PathGround:
    """What the path kernels read, and the room they work in.

    Parameters
    ----------
    surface : Surface
        m faces.
    """

    def __init__(self, surface: Surface) -> None:
        self.surface = surface
        self.mesh = (
            surface.flat,
            surface.transport,
            surface.faces,
            surface.neighbor,
            surface.neighbor_edge,
            surface.vertex_angle,
            surface.on_border,
            frozen(surface.vertices[surface.faces].mean(axis=1)),
        )

    def search_room(self) -> tuple[NDArray[Any], ...]:
        """Make arrays for A*: cost, seen, came, heap_key, heap_face.

        Returns
        -------
        arrays : tuple of ndarray
            For one thread.
        """
        count = len(self.surface.faces)
        return (
            np.zeros(count),
            np.zeros(count, np.int64),
            np.zeros(count, np.int64),
            np.zeros(3 * count + 3),
            np.zeros(3 * count + 3, np.int32),
        )

    def strip_room(self, size: int) -> tuple[NDArray[Any], ...]:
        """Make arrays for strips: strip, spare, kept, gate, gate_vertex, bend, bend_gate, blocked, share.

        Parameters
        ----------
        size : int
            Longest strip.

        Returns
        -------
        arrays : tuple of ndarray
            For one thread.
        """
        return (
            np.zeros(size, np.int64),
            np.zeros(size, np.int64),
            np.zeros(size, np.int64),
            np.zeros((size + 1, 4)),
            np.zeros((size + 1, 2), np.int64),
            np.zeros((size + 2, 2)),
            np.zeros(size + 2, np.int64),
            np.zeros(64, np.int64),
            np.zeros(size),
        )

    def walk(
        self,
        begin: NDArray[np.int32],
        start: NDArray[np.float64],
        end: NDArray[np.int32],
        goal: NDArray[np.float64],
        line: NDArray[np.int32],
    ) -> tuple[NDArray[Any], ...]:
        """Find the ways of some legs.

        Parameters
        ----------
        begin : (n,) int32
            Faces of the starts.
        start : (n, 2) float64
            Starts in their frames.
        end : (n,) int32
            Faces of the ends.
        goal : (n, 2) float64
            Ends in their frames.
        line : (n,) int32
            Curve of each leg.

        Returns
        -------
        arrays : tuple of ndarray
            Piece faces, places (p, 4), curves, lengths before; and the length of each leg.
        """
        return self._run(0, begin, start, end, goal, line)[:5]

    def halfway(
        self,
        begin: NDArray[np.int32],
        start: NDArray[np.float64],
        end: NDArray[np.int32],
        goal: NDArray[np.float64],
    ) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        """Find the middles of ways.

        Parameters
        ----------
        begin : (n,) int32
            Faces of the starts.
        start : (n, 2) float64
            Starts in their frames.
        end : (n,) int32
            Faces of the ends, on the same component.
        goal : (n, 2) float64
            Ends in their frames.

        Returns
        -------
        face : (n,) int32
            Faces of the middles.
        place : (n, 2) float64
            Middles in their frames.
        """
        face, place = self._run(1, begin, start, end, goal, np.zeros(len(begin), np.int32))[5:]
        return face, place

    def _run(self, halves: int, begin, start, end, goal, line) -> tuple[NDArray[Any], ...]:
        """Run the kernel over some legs, with more room whenever it asks."""
        from surftex.kernels.paths import ways

        count = len(begin)
        search, strips = self.search_room(), self.strip_room(1024)
        room = 256 + (0 if halves else 16 * count)
        pieces = (np.zeros(room, np.int32), np.zeros((room, 4)), np.zeros(room, np.int32), np.zeros(room))
        middles = np.zeros(count, np.int32), np.zeros((count, 2))
        length, state = np.zeros(count), np.zeros(2, np.int64)
        legs = begin, start, end, goal, line, state
        done = 0
        while True:
            done = ways(*self.mesh, done, count, *legs, *search, *strips, halves, *middles, *pieces, length)
            if done == count:
                break
            # The kernel does not tell which was too short; both are cheap to double.
            pieces = tuple(np.concatenate([array, np.zeros_like(array)]) for array in pieces)
            strips = self.strip_room(2 * len(strips[0]))
        kept = int(state[1])
        face, place, number, before = (array[:kept] for array in pieces)
        return face, place, number, before, length, *middles
