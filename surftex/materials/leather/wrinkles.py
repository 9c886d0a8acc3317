"""Wrinkles: chains of furrows that keep to the direction of the stress, and cut across a plate where none does.

Section 4.1.3 of Sakurai et al. From a random furrow, a wrinkle walks on: where two furrows lead onward it takes the
one nearer to the stress; if that turns away by more than the allowed angle, it cuts straight across the plate along the
stress instead, to the furrow on the other side, and goes on from there.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.features.curves import ROW, curve_table
from surftex.features.voronoi_graph import VoronoiGraph
from surftex.geodesics.directions import DirectionField
from surftex.geodesics.pieces import CurvePieces, barycentric_of
from surftex.geodesics.records import Records
from surftex.geodesics.tracing import trace
from surftex.geodesics.windows import nearest
from surftex.randomness import Stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_STEPS = 48
"""Places along a cut at which the region is asked; the crossing is then narrowed twice by the same number."""

Piece = tuple[int, NDArray[np.float64], NDArray[np.float64]]


def wrinkles(
    surface: Surface,
    graph: VoronoiGraph,
    regions: Records,
    stress: DirectionField,
    random: Stream,
    *,
    count: int,
    length_mm: float,
    angle_rad: float,
    reach_mm: float,
) -> NDArray:
    """Walk wrinkles along the furrows.

    Parameters
    ----------
    surface : Surface
        Where they lie.
    graph : VoronoiGraph
        Its edges are the furrows.
    regions : Records
        Flooded from the sites of the graph, to tell whose region a place is in.
    stress : DirectionField
        b.
    random : Stream
        Picks the first furrows.
    count : int
        How many wrinkles.
    length_mm : float
        Of each; shorter where one meets a border or itself.
    angle_rad : float
        To the stress beyond which a wrinkle cuts across.
    reach_mm : float
        Longest cut.

    Returns
    -------
    table : (p,) structured array
        Pieces of the wrinkles, in walking order.
    """
    if len(graph.pieces) == 0 or count == 0 or length_mm <= 0:
        return np.zeros(0, ROW)
    furrows = _Furrows.of(surface, graph, stress)
    starts = np.minimum((random.uniform(count)[:, 0] * furrows.count).astype(int), furrows.count - 1)
    rows: list[tuple[int, Piece]] = []
    for number, start in enumerate(starts):
        walk = _Walk(surface, furrows, regions, stress, angle_rad, reach_mm, length_mm)
        walk.run(int(start))
        rows.extend((number, piece) for piece in walk.pieces)
    if not rows:
        return np.zeros(0, ROW)
    pieces = CurvePieces.of(
        np.array([piece[0] for _, piece in rows]),
        np.array([piece[1] for _, piece in rows]),
        np.array([piece[2] for _, piece in rows]),
        np.array([number for number, _ in rows]),
    )
    return curve_table(surface, pieces)


@dataclass(frozen=True, eq=False)
class _Furrows:
    """Edges of the graph with what a walk asks of them, once for all."""

    graph: VoronoiGraph
    number: NDArray[np.int64]
    first: NDArray[np.int64]
    last: NDArray[np.int64]
    length: NDArray[np.float64]
    leaving: NDArray[np.float64]
    vertex: NDArray[np.int32]
    vertex_end: NDArray[np.int64]
    pair: NDArray[np.int64]
    pair_edge: NDArray[np.int64]
    place: NDArray[np.float64]
    place_end: NDArray[np.float64]
    count: int

    @staticmethod
    def of(surface: Surface, graph: VoronoiGraph, stress: DirectionField) -> "_Furrows":
        pieces = graph.pieces
        first = np.flatnonzero(np.diff(pieces.curve, prepend=-1))
        last = np.append(first[1:], len(pieces)) - 1
        number = pieces.curve[first].astype(np.int64)
        ahead, back = pieces.end[first] - pieces.start[first], pieces.start[last] - pieces.end[last]
        start, end = pieces.points(surface, 0.0), pieces.points(surface, 1.0)
        leaving = np.stack(
            [
                np.arctan2(ahead[:, 1], ahead[:, 0])
                - stress.at(SurfacePoints.trusted(start.face[first], start.barycentric[first])),
                np.arctan2(back[:, 1], back[:, 0])
                - stress.at(SurfacePoints.trusted(end.face[last], end.barycentric[last])),
            ],
            axis=1,
        )
        vertex = graph.edge_vertex[number].ravel()
        vertex_end = np.argsort(vertex, kind="stable")
        low, high = np.sort(graph.edge_region[number].astype(np.int64), axis=1).T
        pair = _pair(low, high)
        pair_edge = np.argsort(pair, kind="stable")
        length = pieces.curve_length_mm[number]
        return _Furrows(
            graph,
            number,
            first,
            last + 1,
            length,
            leaving,
            vertex[vertex_end],
            vertex_end,
            pair[pair_edge],
            pair_edge,
            start.positions(surface),
            end.positions(surface),
            len(number),
        )

    def at_vertex(self, vertex: int) -> list[tuple[int, int]]:
        """Edges that end at a vertex, and which of their ends is there; none for -1."""
        if vertex < 0:
            return []
        rows = self.vertex_end[slice(*np.searchsorted(self.vertex, [vertex, vertex + 1]))]
        return [(int(row) // 2, int(row) % 2) for row in rows]

    def between(self, low: int, high: int) -> list[int]:
        """Edges between two regions."""
        pair = _pair(low, high)
        return self.pair_edge[slice(*np.searchsorted(self.pair, [pair, pair + 1]))].tolist()

    def along(self, edge: int, side: int) -> list[Piece]:
        """Pieces of an edge, walked from one of its ends."""
        pieces = self.graph.pieces
        rows = range(self.first[edge], self.last[edge])
        if side == 0:
            return [(int(pieces.face[i]), pieces.start[i], pieces.end[i]) for i in rows]
        return [(int(pieces.face[i]), pieces.end[i], pieces.start[i]) for i in reversed(rows)]


@dataclass(eq=False)
class _Walk:
    """One wrinkle."""

    surface: Surface
    furrows: _Furrows
    regions: Records
    stress: DirectionField
    angle_rad: float
    reach_mm: float
    left_mm: float
    pieces: list[Piece] = field(default_factory=list)
    seen: set[int] = field(default_factory=set)

    def run(self, edge: int) -> None:
        """Walk from a furrow until the length is used up, or a border or the wrinkle itself is met."""
        furrows = self.furrows
        side = 0 if np.cos(furrows.leaving[edge, 0]) >= 0 else 1
        options = [(edge, side, furrows.along(edge, side), 0.0)]
        while self.left_mm > 0:
            best = min(options, key=lambda option: option[3]) if options else None
            if best is None:
                return
            if best[3] < self.angle_rad or not self.pieces:
                edge, side, pieces, _ = best
                if edge in self.seen:
                    return
                self.seen.add(edge)
                self._append(pieces)
                vertex = int(furrows.graph.edge_vertex[furrows.number[edge], 1 - side])
                options = self._onward(vertex, edge)
                if not options:
                    return
            else:
                options = self._cut()

    def _append(self, pieces: list[Piece]) -> None:
        for face, start, end in pieces:
            length = float(np.hypot(*(end - start)))
            if length >= self.left_mm:
                self.pieces.append((face, start, start + (end - start) * (self.left_mm / length)))
                self.left_mm = 0.0
                return
            self.left_mm -= length
            self.pieces.append((face, start, end))

    def _onward(self, vertex: int, came: int) -> list[tuple[int, int, list[Piece], float]]:
        """Furrows that lead on from a vertex, with their angles to the stress."""
        furrows = self.furrows
        return [
            (edge, side, furrows.along(edge, side), _turn(furrows.leaving[edge, side]))
            for edge, side in furrows.at_vertex(vertex)
            if edge != came
        ]

    def _cut(self) -> list[tuple[int, int, list[Piece], float]]:
        """Cross the plate along the stress; the two halves of the furrow that is met lead on."""
        face, _, place = self.pieces[-1]
        origin = _point(self.surface, face, place)
        heading = float(self.stress.at(origin)[0])
        crossing = trace(
            self.surface, origin, np.array([heading]), np.array([min(self.reach_mm, self.left_mm)])
        ).pieces
        if len(crossing) == 0:
            self.left_mm = 0.0
            return []
        length = np.append(crossing.start_mm, crossing.start_mm[-1] + crossing.length_mm[-1])
        low, high, regions = 1e-3 * length[-1], length[-1], None
        for _ in range(3):
            far = np.linspace(low, high, _STEPS)
            owner = nearest(self.regions, _along(self.surface, crossing, length, far), 1, threads=1)[0][:, 0]
            changed = np.flatnonzero(owner[1:] != owner[:-1])
            if len(changed) == 0:
                break
            low, high = far[changed[0]], far[changed[0] + 1]
            regions = tuple(sorted((int(owner[changed[0]]), int(owner[changed[0] + 1]))))
        used = high if regions is not None else length[-1]
        pieces = []
        for i in range(len(crossing)):
            if length[i] >= used:
                break
            share = min(1.0, (used - length[i]) / max(length[i + 1] - length[i], 1e-300))
            start = crossing.start[i]
            pieces.append((int(crossing.face[i]), start, start + share * (crossing.end[i] - start)))
        self._append(pieces)
        if regions is None or self.left_mm <= 0:
            self.left_mm = 0.0
            return []
        return self._halves(regions)

    def _halves(self, regions: tuple[int, ...]) -> list[tuple[int, int, list[Piece], float]]:
        """Both ways along the furrow between two regions, from where the walk has met it."""
        furrows = self.furrows
        candidates = [edge for edge in furrows.between(regions[0], regions[1]) if edge not in self.seen]
        if not candidates:
            return []
        face, _, place = self.pieces[-1]
        here = _point(self.surface, face, place).positions(self.surface)[0]
        pieces = furrows.graph.pieces
        rows = np.concatenate([np.arange(furrows.first[edge], furrows.last[edge]) for edge in candidates])
        edges = np.repeat(candidates, [furrows.last[edge] - furrows.first[edge] for edge in candidates])
        begin, end = furrows.place[rows], furrows.place_end[rows]
        along = end - begin
        square = np.maximum((along**2).sum(axis=1), 1e-300)
        share = np.clip(((here - begin) * along).sum(axis=1) / square, 0, 1)
        met = int(np.argmin(np.linalg.norm(begin + share[:, None] * along - here, axis=1)))
        edge, row = int(edges[met]), int(rows[met])
        foot = pieces.start[row] + share[met] * (pieces.end[row] - pieces.start[row])
        options = []
        for side in (0, 1):
            tip = pieces.end[row] if side == 0 else pieces.start[row]
            rest = (row + 1, furrows.last[edge]) if side == 0 else (furrows.first[edge], row)
            half = [(int(pieces.face[row]), foot, tip)] if (foot != tip).any() else []
            half += [
                (int(pieces.face[i]), pieces.start[i], pieces.end[i])
                if side == 0
                else (int(pieces.face[i]), pieces.end[i], pieces.start[i])
                for i in (range(*rest) if side == 0 else reversed(range(*rest)))
            ]
            if half:
                step = half[0][2] - half[0][1]
                turn = np.arctan2(step[1], step[0]) - float(
                    self.stress.at(_point(self.surface, half[0][0], half[0][1]))[0]
                )
                options.append((edge, side, half, _turn(turn)))
        return options


def _pair(low: Any, high: Any) -> Any:
    """One number for two regions; int or int64 arrays."""
    return low * 2**32 + high


def _turn(angle: float) -> float:
    """Size of an angle, 0 to pi."""
    return float(abs((angle + np.pi) % (2 * np.pi) - np.pi))


def _point(surface: Surface, face: int, place: NDArray[np.float64]) -> SurfacePoints:
    index = np.array([face], np.int32)
    return SurfacePoints.trusted(index, barycentric_of(surface, index, place[None]))


def _along(surface: Surface, curve: CurvePieces, length: NDArray, far: NDArray) -> SurfacePoints:
    """Places at distances along one curve."""
    row = np.clip(np.searchsorted(length, far, side="right") - 1, 0, len(curve) - 1)
    share = np.clip((far - length[row]) / np.maximum(curve.length_mm[row], 1e-300), 0, 1)[:, None]
    place = curve.start[row] + share * (curve.end[row] - curve.start[row])
    return SurfacePoints.trusted(curve.face[row], barycentric_of(surface, curve.face[row], place))
