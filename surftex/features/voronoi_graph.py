"""The Voronoi graph of sites on a surface: its vertices, and the borders between regions as polylines.

A border holds the places that have two nearest sites, by distance along the surface. Borders are followed with
exact distances from face to face, so each is one polyline across any number of faces. Neighbouring faces share
its nodes, and the graph is complete by construction: every border ends at vertices, at the border of the
surface, or in itself.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.features.poisson import Sites
from surftex.geodesics.pieces import CurvePieces, barycentric_of
from surftex.geodesics.records import Records
from surftex.geodesics.windows import Buckets, flood_points, nearest
from surftex.kernels.pool import slices
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

REACH = 1.02
"""First radius of the search, in the largest semi-axis nearby: a full surface has a site within one."""

_EDGES, _FACES = 16384, 1024
_DOUBLINGS = 40


@dataclass(frozen=True, eq=False)
class VoronoiGraph:
    """Vertices and borders of the regions of s sites; make one with `VoronoiGraph.of`.

    Attributes
    ----------
    vertices : SurfacePoints
        v points, each as far from three sites.
    vertex_region : (v, 3) int32
        Those sites, ascending.
    edge_vertex : (e, 2) int32
        Vertices at the start and the end of each border; -1 at the border of the surface, and on rings.
    edge_region : (e, 2) int32
        The sites on its left and on its right, ascending. Two borders may part the same two.
    pieces : CurvePieces
        The borders: curve i is border i, walked from its first vertex to its second.
    """

    vertices: SurfacePoints
    vertex_region: NDArray[np.int32]
    edge_vertex: NDArray[np.int32]
    edge_region: NDArray[np.int32]
    pieces: CurvePieces

    @staticmethod
    def of(
        surface: Surface, sites: Sites, *, records: Records | None = None, threads: int | None = None
    ) -> "VoronoiGraph":
        """Find the graph of some sites.

        Parameters
        ----------
        surface : Surface
            Where they lie.
        sites : Sites
            Any number; details much smaller than their minor semi-axes may be left out.
        records : Records, optional
            Flooded from the sites, each over all of its region; made here without it.
        threads : int, optional
            None means every core; cannot change the result.

        Returns
        -------
        graph : VoronoiGraph
            By walking distance, whatever the axes of the sites: on a border the distances to its two sites
            agree to 1e-4 of the smaller minor semi-axis.
        """
        if len(sites) < 2:
            return _empty()
        radius = REACH * _reach(sites, surface) if records is None else records.radius_mm
        for _ in range(_DOUBLINGS):
            if records is None:
                buckets = Buckets.of(surface, float(np.sqrt(np.median(sites.axis_mm.prod(axis=1)))))
                records = flood_points(surface, sites.points, radius, buckets=buckets, threads=threads)
            found = _Tracing(surface, sites, records, threads).run()
            if found is not None:
                return found
            radius, records = 2 * radius, None
        return _empty()

    @cached_property
    def edge_bounds(self) -> NDArray[np.int64]:
        """(e, 2) the pieces of border i are those from [i, 0] to before [i, 1]."""
        number = np.arange(len(self.edge_vertex))
        first = np.searchsorted(self.pieces.curve, number, side="left")
        return frozen(np.stack([first, np.searchsorted(self.pieces.curve, number, side="right")], axis=1))

    @cached_property
    def vertex_edge(self) -> tuple[NDArray[np.int64], ...]:
        """Borders at each vertex: start (v + 1,), border, and which end of it is there (0 or 1)."""
        edge, side = np.nonzero(self.edge_vertex >= 0)
        return _listed(self.edge_vertex[edge, side], len(self.vertices), edge, side)

    @cached_property
    def region_edge(self) -> tuple[NDArray[np.int64], ...]:
        """Borders around each site, up to the last site with any: start, border, and the region's side of it."""
        edge, side = np.nonzero(self.edge_region >= 0)
        count = int(self.edge_region.max()) + 1 if len(self.edge_region) else 0
        return _listed(self.edge_region[edge, side], count, edge, side)

    def leave(self, vertex: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
        """Tell how one can walk on from a vertex.

        Parameters
        ----------
        vertex : int
            Which one.

        Returns
        -------
        edge : (k,) int64
            Its borders, three as a rule.
        side : (k,) int64
            0 where the border is walked from its start, 1 from its end.
        angle_rad : (k,) float64
            Direction of each at the vertex, in the frame of the vertex's face.
        """
        start, edges, sides = self.vertex_edge
        edge, side = edges[start[vertex] : start[vertex + 1]], sides[start[vertex] : start[vertex + 1]]
        row = np.where(side == 0, self.edge_bounds[edge, 0], self.edge_bounds[edge, 1] - 1)
        away = np.where(side == 0, 1.0, -1.0)[:, None] * (self.pieces.end[row] - self.pieces.start[row])
        return edge, side, np.arctan2(away[:, 1], away[:, 0])


def _empty() -> VoronoiGraph:
    none = frozen(np.zeros((0, 2), np.int32))
    points = SurfacePoints.trusted(frozen(np.zeros(0, np.int32)), frozen(np.zeros((0, 3))))
    return VoronoiGraph(points, frozen(np.zeros((0, 3), np.int32)), none, none, CurvePieces.joined([]))


def _listed(owner: NDArray, count: int, *columns: NDArray) -> tuple[NDArray[np.int64], ...]:
    """Sort rows by owner: start of each owner's rows, and the columns."""
    order = np.argsort(owner, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=count))]).astype(np.int64)
    return (frozen(start), *(frozen(column[order].astype(np.int64)) for column in columns))


def _reach(sites: Sites, surface: Surface) -> NDArray[np.float64]:
    """(n,) how far a region may go on a full surface: the largest semi-axis of a site that may lie beside it."""
    from scipy.spatial import KDTree

    major = sites.axis_mm[:, 0]
    reach = np.array(major)
    group = np.ceil(np.log(major / major.min()) / np.log(1.25) - 1e-9).astype(np.int64)
    if group.max() == 0:
        return np.full(len(sites), float(major.max()))
    position = sites.points.positions(surface)
    for number in np.unique(group):
        largest = float(major[group == number].max())
        tree = KDTree(position[group == number])
        near = np.isfinite(tree.query(position, distance_upper_bound=2.05 * largest)[0])
        reach[near] = np.maximum(reach[near], largest)
    return reach


class _Tracing:
    """Borders followed through all faces, from one set of records."""

    def __init__(self, surface: Surface, sites: Sites, records: Records, threads: int | None) -> None:
        self.surface, self.sites, self.records, self.threads = surface, sites, records, threads
        buckets = records.buckets
        self.found = (surface.flat, buckets.first, buckets.cells, buckets.grid, records.start, records.entry_row,
                      records.entry_least_mm, records.row, records.row_id)  # fmt: skip
        self.scale = np.array(sites.axis_mm[:, 1], dtype=np.float64)
        self.owner = self._vertex_owner()
        row = np.arange(len(surface.faces), dtype=np.int32)[:, None]
        once = (surface.neighbor < 0) | (row < surface.neighbor)
        self.edge_face, self.edge_side = (column.astype(np.int32) for column in np.nonzero(once))
        self.number = np.zeros((len(surface.faces), 3), np.int64)
        self.number[once] = np.arange(len(self.edge_face))
        self.number[~once] = self.number[surface.neighbor[~once], surface.neighbor_edge[~once]]
        self.back = (~once).astype(np.uint8)

    def run(self) -> VoronoiGraph | None:
        """Make the graph; None if some place has no owner, so that the radius was too small."""
        inhabited = np.isin(self.surface.component, self.surface.component[self.sites.points.face])
        if (self.owner[self.surface.faces[inhabited]] < 0).any():
            return None
        along = slices(self._edges, len(self.edge_face), size=_EDGES, threads=self.threads)
        nodes = [part for part in along if part is not None]
        if len(nodes) < len(along):
            return None
        counts, self.place, self.pair = (np.concatenate([part[i] for part in nodes]) for i in range(3))
        self.start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        faces = self.sites.points.face
        self.site_start, self.site = _listed(faces, len(self.surface.faces), np.arange(len(faces)))
        self.site_flat = self.sites.points.flat(self.surface)[self.site]
        across = slices(self._faces, len(self.surface.faces), size=_FACES, threads=self.threads)
        parts = [part for part in across if part is not None]
        whole = len(parts) == len(across)
        across.clear()
        return _joined(self.surface, parts, len(self.place)) if whole else None

    def _vertex_owner(self) -> NDArray[np.int64]:
        """Nearest site of each vertex; -1 where none is, and at vertices of no face."""
        faces = self.surface.faces
        face = np.full(len(self.surface.vertices), -1, np.int32)
        corner = np.zeros(len(face), np.int64)
        for i in (2, 1, 0):
            face[faces[:, i]] = np.arange(len(faces), dtype=np.int32)
            corner[faces[:, i]] = i
        used = np.flatnonzero(face >= 0)
        points = SurfacePoints.trusted(frozen(face[used]), frozen(np.eye(3)[corner[used]]))
        owner = np.full(len(face), -1, np.int64)
        owner[used] = nearest(self.records, points, 1, threads=self.threads)[0][:, 0]
        return owner

    def _edges(self, begin: int, end: int) -> tuple[NDArray, ...] | None:
        """Nodes along a slice of the mesh edges: counts, shares, owners before and after."""
        from surftex.kernels.voronoi import edge_nodes

        todo, todo_owner = np.zeros((128, 4)), np.zeros((128, 3), np.int64)
        counts, room = np.zeros(end - begin, np.int64), 2 * (end - begin) + 64
        while True:
            place, pair = np.zeros(room), np.zeros((room, 2), np.int64)
            used = edge_nodes(self.edge_face[begin:end], self.edge_side[begin:end], self.surface.faces, self.found,
                              self.scale, self.owner, todo, todo_owner, counts, place, pair)  # fmt: skip
            if used >= 0:
                return counts, place[:used], pair[:used]
            if used == -2:
                return None
            room *= 2

    def _faces(self, begin: int, end: int) -> tuple[NDArray, NDArray, NDArray, NDArray, int] | None:
        """Pieces (p, 4), their face, nodes and regions (p, 5), vertices, their face and node, inner nodes."""
        from surftex.kernels.voronoi import face_borders

        inside = np.zeros(int(np.diff(self.site_start).max()), np.int64)
        spare = np.zeros((6, 2)), np.zeros((3, 9), np.int64)
        scratch = inside, *spare, np.zeros((160, 6)), np.zeros((160, 15), np.int64)
        todo = np.zeros((128, 4)), np.zeros((128, 3), np.int64)
        counts = np.array([0, 0, 0, len(self.place)], np.int64)
        pieces = np.zeros((1024, 4)), np.zeros((1024, 5), np.int32)
        meetings = np.zeros((1024, 2)), np.zeros((1024, 2), np.int64)
        room, code = 4096, -1
        while code != 0:
            node = (
                np.zeros((room, 2)),
                np.zeros(room, np.int64),
                np.zeros((room, 2), np.int64),
                np.zeros(room),
            )
            begin, code = face_borders(
                begin, end, self.surface.faces, self.found, self.scale, self.owner, self.number, self.back, self.start,
                self.place, self.pair, self.site_start, self.site, self.site_flat, *scratch, *node, *todo, counts,
                *pieces, *meetings,
            )  # fmt: skip
            if code == 1:
                pieces = tuple(np.concatenate([array, np.zeros_like(array)]) for array in pieces)
            elif code == 2:
                meetings = tuple(np.concatenate([array, np.zeros_like(array)]) for array in meetings)
            elif code == 3:
                room *= 2
            elif code == 4:
                return None
        piece, piece_id = (array[: counts[0]].copy() for array in pieces)  # copies let go of the spare room
        meeting, meeting_id = (array[: counts[1]].copy() for array in meetings)
        return piece, piece_id, meeting, meeting_id, int(counts[2])


def _joined(
    surface: Surface, parts: list[tuple[NDArray, NDArray, NDArray, NDArray, int]], shared: int
) -> VoronoiGraph:
    """Join the pieces of all slices, which are let go of, into borders; nodes below `shared` lie on mesh edges."""
    from surftex.kernels.voronoi import chain, lay_out

    total = shared
    for _, piece_id, _, meeting_id, inner in parts:
        for column in (piece_id[:, 1:3], meeting_id[:, 1:2]):
            column[column >= shared] += total - shared
        total += inner
    meeting, meeting_id = (np.concatenate([part[i] for part in parts]) for i in (2, 3))
    count = sum(len(part[0]) for part in parts)
    piece, piece_id = np.zeros((count, 4)), np.zeros((count, 5), np.int32)
    filled = count
    while parts:  # a part goes as soon as it is copied, so that the pieces are never held twice
        places, ids, *_ = parts.pop()
        piece[filled - len(ids) : filled], piece_id[filled - len(ids) : filled] = places, ids
        filled -= len(ids)
    vertex = np.full(total, -1, np.int32)
    vertex[meeting_id[:, 1]] = np.arange(len(meeting))
    order, curve = np.zeros(count, np.int32), np.zeros(count, np.int32)
    flipped, ends = np.zeros(count, np.uint8), np.zeros((count, 2), np.int32)
    curves = chain(
        *_incident(piece_id, total), piece_id, vertex, np.zeros(count, np.uint8), order, flipped, curve, ends
    )
    del vertex
    first = np.flatnonzero(np.diff(curve, prepend=-1))
    region, ends = piece_id[order[first], 3:5], ends[:curves].copy()
    backwards = flipped[first] == 1
    region[backwards] = region[backwards, ::-1]
    # walk every border so that the lower number lies on its left
    wrong = region[:, 0] > region[:, 1]
    region[wrong], ends[wrong] = region[wrong, ::-1], ends[wrong, ::-1]
    face, start, end = np.zeros(count, np.int32), np.zeros((count, 2)), np.zeros((count, 2))
    lay_out(piece, piece_id, order, flipped, first, wrong.view(np.uint8), face, start, end)
    del piece, piece_id, order, flipped
    kept = (start != end).any(axis=1)
    kept[first[np.bincount(curve, kept, minlength=curves) == 0]] = True
    if not kept.all():
        face, start, end, curve = face[kept], start[kept], end[kept], curve[kept]
    pieces = CurvePieces.of(face, start, end, curve)
    del face, start, end, curve, kept
    at = meeting_id[:, 0].astype(np.int32)
    points = SurfacePoints.trusted(frozen(at), frozen(barycentric_of(surface, at, meeting)))
    return VoronoiGraph(
        points, frozen(_vertex_region(len(meeting), ends, region)), frozen(ends), frozen(region), pieces
    )


def _incident(piece_id: NDArray[np.int32], total: int) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """Pieces at each of `total` nodes: start (total + 1,), and the pieces."""
    from surftex.kernels.ordering import order_by_face

    node = frozen(piece_id[:, 1:3].ravel())
    place, incident = np.zeros(total + 1, np.int64), np.zeros(len(node), np.int32)
    order_by_face(node, place, incident)
    incident >>= 1
    return np.concatenate([[0], place[:-1]]), incident


def _vertex_region(count: int, ends: NDArray, region: NDArray) -> NDArray[np.int32]:
    """(v, 3) the three lowest sites at each vertex, ascending; the last one repeats where there are fewer."""
    if count == 0:
        return np.zeros((0, 3), np.int32)
    edge, side = np.nonzero(ends >= 0)
    vertex, site = np.repeat(ends[edge, side], 2).astype(np.int64), region[edge].ravel()
    pair = np.sort((vertex << 32) + site)
    vertex, site = np.divmod(pair[np.diff(pair, prepend=-1) > 0], 1 << 32)
    first = np.searchsorted(vertex, np.arange(count))
    size = np.bincount(vertex, minlength=count)
    column = np.minimum(np.arange(3), size[:, None] - 1)
    return site[first[:, None] + column].astype(np.int32)
