"""Wrinkles: chains of furrows that keep to the direction of the stress, and cut across a plate where none does.

Section 4.1.3 of Sakurai et al. From a random furrow, a wrinkle walks on: where two furrows lead onward it takes the
one nearer to the stress; if that turns away by more than the allowed angle, it cuts straight across the plate along the
stress instead, to the furrow on the other side, and goes on from there.
"""

from dataclasses import dataclass
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
from surftex.materials.leather.crossing import Crossing, Piece
from surftex.randomness import Stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_AT_ONCE = 1 << 15
"""Furrows whose directions are looked up at a time."""

Option = tuple[int, int, list[Piece], float]
"""A furrow, the end it is walked from, its pieces, and the angle to the stress."""


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
    walks = [_Walk(furrows, angle_rad, length_mm, int(start)) for start in starts]
    waiting = [walk for walk in walks if walk.follow()]
    while waiting:  # cuts of all walks side by side: asked one by one they would take ten times as long
        _cut(surface, regions, stress, reach_mm, waiting)
        waiting = [walk for walk in waiting if walk.follow()]
    rows = [(number, piece) for number, walk in enumerate(walks) for piece in walk.pieces]
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
    count: int

    @staticmethod
    def of(surface: Surface, graph: VoronoiGraph, stress: DirectionField) -> "_Furrows":
        pieces = graph.pieces
        first = np.flatnonzero(np.diff(pieces.curve, prepend=-1))
        last = np.append(first[1:], len(pieces)) - 1
        number = pieces.curve[first].astype(np.int64)
        ahead, back = pieces.end[first] - pieces.start[first], pieces.start[last] - pieces.end[last]
        leaving = np.stack([np.arctan2(ahead[:, 1], ahead[:, 0]), np.arctan2(back[:, 1], back[:, 0])], axis=1)
        for low in range(0, len(first), _AT_ONCE):
            rows = slice(low, low + _AT_ONCE)
            for side, row in ((0, first[rows]), (1, last[rows])):
                leaving[rows, side] -= stress.at(_along(surface, pieces, row, side))
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


class _Walk:
    """One wrinkle: it follows furrows by itself, and waits where it must cut across a plate.

    Parameters
    ----------
    furrows : _Furrows
        Where it walks.
    angle_rad : float
        To the stress beyond which it cuts.
    length_mm : float
        Its own.
    edge : int
        Furrow that it starts with.
    """

    def __init__(self, furrows: _Furrows, angle_rad: float, length_mm: float, edge: int) -> None:
        self.furrows, self.angle_rad, self.left_mm = furrows, angle_rad, length_mm
        self.pieces: list[Piece] = []
        self.seen: set[int] = set()
        side = 0 if np.cos(furrows.leaving[edge, 0]) >= 0 else 1
        self.options: list[Option] = [(edge, side, furrows.along(edge, side), 0.0)]

    def follow(self) -> bool:
        """Walk on until a cut is needed: true; or until the length is used up, or a border or the wrinkle itself is met."""
        furrows = self.furrows
        while self.left_mm > 0 and self.options:
            edge, side, pieces, turn = min(self.options, key=lambda option: option[3])
            if turn >= self.angle_rad and self.pieces:
                return True
            if edge in self.seen:
                return False
            self.seen.add(edge)
            self.append(pieces)
            self.options = self._onward(int(furrows.graph.edge_vertex[furrows.number[edge], 1 - side]), edge)
        return False

    def append(self, pieces: list[Piece]) -> None:
        """Walk along pieces, as far as the length lasts."""
        for face, start, end in pieces:
            length = float(np.hypot(*(end - start)))
            if length >= self.left_mm:
                self.pieces.append((face, start, start + (end - start) * (self.left_mm / length)))
                self.left_mm = 0.0
                return
            self.left_mm -= length
            self.pieces.append((face, start, end))

    def _onward(self, vertex: int, came: int) -> list[Option]:
        """Furrows that lead on from a vertex, with their angles to the stress."""
        furrows = self.furrows
        return [
            (edge, side, furrows.along(edge, side), _turn(furrows.leaving[edge, side]))
            for edge, side in furrows.at_vertex(vertex)
            if edge != came
        ]

    def halves(self, surface: Surface, regions: tuple[int, int]) -> list[tuple[int, int, list[Piece]]]:
        """Both ways along the furrow between two regions, from where the walk has met it."""
        furrows = self.furrows
        candidates = [edge for edge in furrows.between(*regions) if edge not in self.seen]
        if not candidates:
            return []
        face, _, place = self.pieces[-1]
        here = _positions(surface, np.array([face]), place[None])[0]
        pieces = furrows.graph.pieces
        rows = np.concatenate([np.arange(furrows.first[edge], furrows.last[edge]) for edge in candidates])
        edges = np.repeat(candidates, [furrows.last[edge] - furrows.first[edge] for edge in candidates])
        face = pieces.face[rows]
        begin, end = (_positions(surface, face, place[rows]) for place in (pieces.start, pieces.end))
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
                options.append((edge, side, half))
        return options


def _cut(
    surface: Surface, regions: Records, stress: DirectionField, reach_mm: float, walks: list[_Walk]
) -> None:
    """Take walks across their plates along the stress; the two halves of the furrow that each meets are its options."""
    origin = _points(surface, [(face, place) for face, _, place in (walk.pieces[-1] for walk in walks)])
    far = np.array([min(reach_mm, walk.left_mm) for walk in walks])
    crossing = trace(surface, origin, stress.at(origin), far).pieces
    bounds = np.searchsorted(crossing.curve, np.arange(len(walks) + 1)).tolist()
    cuts = [Crossing(crossing, *bounds[i : i + 2]) for i in range(len(walks))]
    for _ in range(3):
        asked = [cut for cut in cuts if not cut.done]
        if not asked:
            break
        face, place = (np.concatenate(part) for part in zip(*(cut.asked() for cut in asked), strict=True))
        points = SurfacePoints.trusted(face, barycentric_of(surface, face, place))
        owner = nearest(regions, points, 1, threads=1)[0].reshape(len(asked), -1)
        for cut, row in zip(asked, owner, strict=True):
            cut.narrow(row)
    found: list[tuple[_Walk, tuple[int, int, list[Piece]]]] = []
    for walk, cut in zip(walks, cuts, strict=True):
        walk.append(cut.pieces())
        walk.options = []
        if cut.regions is None:
            walk.left_mm = 0.0
        elif walk.left_mm > 0:
            found += [(walk, half) for half in walk.halves(surface, cut.regions)]
    if found:
        first = [half[2][0] for _, half in found]
        heading = stress.at(_points(surface, [(face, start) for face, start, _ in first]))
        for (walk, half), (_, start, end), angle in zip(found, first, heading, strict=True):
            step = end - start
            walk.options.append((*half, _turn(np.arctan2(step[1], step[0]) - float(angle))))


def _pair(low: Any, high: Any) -> Any:
    """One number for two regions; int or int64 arrays."""
    return low * 2**32 + high


def _turn(angle: float) -> float:
    """Size of an angle, 0 to pi."""
    return float(abs((angle + np.pi) % (2 * np.pi) - np.pi))


def _along(surface: Surface, pieces: CurvePieces, rows: NDArray[np.integer], share: float) -> SurfacePoints:
    """Find the places on some pieces, a share of the way along each."""
    chosen = CurvePieces(
        pieces.face[rows], pieces.start[rows], pieces.end[rows], pieces.curve[rows], pieces.start_mm[rows]
    )
    return chosen.points(surface, share)


def _positions(
    surface: Surface, face: NDArray[np.integer], place: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Millimetres in space of places in the frames of faces."""
    axes = surface.frame[face]
    return surface.vertices[surface.faces[face, 0]] + place[:, :1] * axes[:, 0] + place[:, 1:] * axes[:, 1]


def _points(surface: Surface, places: list[tuple[int, NDArray[np.float64]]]) -> SurfacePoints:
    """Make points of faces and places in their frames."""
    face = np.array([face for face, _ in places], np.int32)
    return SurfacePoints.trusted(
        face, barycentric_of(surface, face, np.array([place for _, place in places]))
    )
