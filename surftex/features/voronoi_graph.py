"""The Voronoi graph of sites on a surface: its vertices, and the borders between regions as polylines.

The surface is cut into triangles smaller than the cells, and each corner asks for its nearest site. An edge of
that net with two owners holds one point of a border, a triangle with three owners holds a vertex; both are
found from exact distances. The graph is complete by construction: every border is a chain that ends at
vertices, at the border of the surface, or in itself. Details finer than the net are left out.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.features.poisson import Sites
from surftex.geodesics.bounds import nearest_bound
from surftex.geodesics.pieces import CurvePieces
from surftex.geodesics.records import Records
from surftex.geodesics.windows import Buckets, flood_points, nearest
from surftex.surface.points import SurfacePoints
from surftex.surface.subdivide import Subdivided, subdivided
from surftex.surface.surface import Surface

STEP = 0.4
"""Longest edge of the net, in minor semi-axes of the sites."""

REACH = 2.0
"""How far each site is asked for, in major semi-axes."""

_KNOWN = 4
"""Nearest sites that each corner of the net knows."""


@dataclass(frozen=True, eq=False)
class VoronoiGraph:
    """Vertices and borders of the regions of s sites.

    Attributes
    ----------
    vertices : SurfacePoints
        v points, each as far from three sites.
    vertex_region : (v, 3) int32
        Those sites, ascending.
    edge_vertex : (e, 2) int32
        Vertices at the start and the end of each border; -1 at the border of the surface, and on rings.
    edge_region : (e, 2) int32
        The two sites that a border parts, ascending.
    pieces : CurvePieces
        The borders: curve i is border i, walked from its first vertex to its second.
    """

    vertices: SurfacePoints
    vertex_region: NDArray[np.int32]
    edge_vertex: NDArray[np.int32]
    edge_region: NDArray[np.int32]
    pieces: CurvePieces

    @staticmethod
    def of(surface: Surface, sites: Sites, *, threads: int | None = None) -> "VoronoiGraph":
        """Find the graph of some sites.

        Parameters
        ----------
        surface : Surface
            Where they lie.
        sites : Sites
            At least one; the net is as fine as their smallest minor semi-axis asks.
        threads : int, optional
            None means every core; cannot change the result.

        Returns
        -------
        graph : VoronoiGraph
            By walking distance, whatever the axes of the sites.

        Raises
        ------
        InputError
            If the net would take more than 20 million triangles.
        """
        fine = subdivided(surface, STEP * float(np.quantile(sites.axis_mm[:, 1], 0.02)))
        records = flood_points(
            surface,
            sites.points,
            REACH * sites.axis_mm[:, 0],
            buckets=Buckets.of(surface, float(np.median(sites.axis_mm[:, 1]))),
            bound_mm=nearest_bound(surface, sites.points, _KNOWN),
            threads=threads,
        )
        known, distance = nearest(records, fine.points, _KNOWN, threads=threads)
        return _assembled(surface, _Net.of(fine, records, known, distance**2, threads))


@dataclass(frozen=True, eq=False)
class _Net:
    """The triangles with several owners, and the point of a border on each of their edges that has two."""

    known: NDArray
    square: NDArray
    owner: NDArray
    corner: NDArray
    parent: NDArray
    weight: NDArray
    crossing: NDArray
    first: NDArray
    second: NDArray
    share: NDArray

    @staticmethod
    def of(
        fine: Subdivided, records: Records, known: NDArray, square: NDArray, threads: int | None
    ) -> "_Net":
        owner = known[fine.faces, 0]
        mixed = np.flatnonzero((owner != owner[:, :1]).any(axis=1) & (owner >= 0).all(axis=1))
        corner, owner = fine.faces[mixed].astype(np.int64), owner[mixed]
        ends = np.stack([corner, np.roll(corner, -1, axis=1)], axis=2).reshape(-1, 2)
        parted = known[ends[:, 0], 0] != known[ends[:, 1], 0]
        low, high = np.sort(ends[parted], axis=1).T
        edge, index = np.unique(low * len(known) + high, return_inverse=True)
        crossing = np.full(3 * len(mixed), -1)
        crossing[parted] = index
        seen_in = np.zeros(len(edge), np.int64)
        seen_in[index[::-1]] = np.flatnonzero(parted)[::-1]
        first, second = edge // len(known), edge % len(known)
        parent, weight = fine.parent[mixed], fine.weight[mixed]
        triangle, side = seen_in // 3, seen_in % 3
        begin, end = weight[triangle, side], weight[triangle, (side + 1) % 3]
        turned = (corner[triangle, side] != first)[:, None]
        share = _equal(
            records, known, square, first, second, parent[triangle],
            np.where(turned, end, begin), np.where(turned, begin, end), threads,
        )  # fmt: skip
        return _Net(
            known, square, owner, corner, parent, weight, crossing.reshape(-1, 3), first, second, share
        )


def _assembled(surface: Surface, net: _Net) -> VoronoiGraph:
    """Chain the segments of the net's triangles into borders."""
    known, square, owner, corner, crossing = net.known, net.square, net.owner, net.corner, net.crossing
    parent, weight, first, second = net.parent, net.weight, net.first, net.second
    # triangles with two owners hold a segment, those with three a vertex and three segments
    three = (crossing >= 0).all(axis=1)
    two = np.flatnonzero(~three)
    star = np.flatnonzero(three)
    node_count = len(first)
    pair = np.sort(np.where(crossing[two] >= 0, crossing[two], -1), axis=1)[:, 1:]
    segment = np.concatenate(
        [pair, np.stack([crossing[star].ravel(), node_count + np.repeat(np.arange(len(star)), 3)], axis=1)]
    )
    triangle = np.concatenate([two, np.repeat(star, 3)])

    order, flipped, chain, count = _chained(segment, node_count, len(star))
    walked = np.where(flipped[:, None] == 1, segment[order, ::-1], segment[order])
    triangle = triangle[order]
    middle = _vertices(owner[star], corner[star], known, square)
    place = np.stack([_place(surface, net, side, triangle, middle) for side in walked.T], axis=1)
    pieces = CurvePieces.of(parent[triangle], place[:, 0], place[:, 1], chain)
    starts = np.flatnonzero(np.diff(chain, prepend=-1))
    stops = np.append(starts[1:], len(chain)) - 1 if count else starts
    tips = np.stack([walked[starts, 0], walked[stops, 1]], axis=1) if count else np.zeros((0, 2), np.int64)
    # the two regions beside a border: the owners at the ends of an edge of the net that it crosses
    inner = (
        np.where(walked[starts, 0] < node_count, walked[starts, 0], walked[starts, 1])
        if count
        else np.zeros(0, np.int64)
    )
    region = np.sort(np.stack([known[first[inner], 0], known[second[inner], 0]], axis=1), axis=1)
    return VoronoiGraph(
        SurfacePoints.trusted(frozen(parent[star]), frozen(np.einsum("vc,vck->vk", middle, weight[star]))),
        frozen(np.sort(owner[star], axis=1).astype(np.int32)),
        frozen(np.where(tips >= node_count, tips - node_count, -1).astype(np.int32)),
        frozen(region.astype(np.int32)),
        pieces,
    )


def _equal(
    records: Records, known: NDArray, square: NDArray, first: NDArray, second: NDArray,
    face: NDArray, begin: NDArray, end: NDArray, threads: int | None,
) -> NDArray[np.float64]:  # fmt: skip
    """Where along each edge its two owners are as far.

    Squared distances differ linearly in the plane: the first guess is exact there, two more narrow it elsewhere.
    """
    a, b = known[first, 0], known[second, 0]
    left = square[first, 0] - _square_of(b, known[first], square[first])
    right = _square_of(a, known[second], square[second]) - square[second, 0]
    low, high = np.zeros(len(first)), np.ones(len(first))
    share = np.clip(left / np.minimum(left - right, -1e-300), 0.0, 1.0)
    for _ in range(2):
        points = SurfacePoints.trusted(face, begin + share[:, None] * (end - begin))
        near, distance = nearest(records, points, _KNOWN, threads=threads)
        here = _square_of(a, near, distance**2) - _square_of(b, near, distance**2)
        sound = _has(a, near) & _has(b, near)
        before, after = sound & (here < 0), sound & (here >= 0)
        low, left = np.where(before, share, low), np.where(before, here, left)
        high, right = np.where(after, share, high), np.where(after, here, right)
        share = np.where(sound, low + (high - low) * left / np.minimum(left - right, -1e-300), share)
    return np.clip(share, 1e-6, 1 - 1e-6)


def _has(site: NDArray, known: NDArray) -> NDArray[np.bool_]:
    return (known == site[:, None]).any(axis=1)


def _square_of(site: NDArray, known: NDArray, square: NDArray) -> NDArray[np.float64]:
    """Squared distance to a site among those known; that of the farthest known where it is not among them."""
    finite = np.where(np.isfinite(square), square, 0.0)
    return np.where(
        _has(site, known), np.where(known == site[:, None], finite, 0.0).sum(axis=1), finite.max(axis=1)
    )


def _vertices(owner: NDArray, corner: NDArray, known: NDArray, square: NDArray) -> NDArray[np.float64]:
    """Weights of the corners where three owners are as far, kept inside the triangle."""
    value = np.stack(
        [
            [_square_of(owner[:, k], known[corner[:, c]], square[corner[:, c]]) for c in range(3)]
            for k in range(3)
        ]
    )
    first, second = (value[0] - value[1]).T, (value[0] - value[2]).T
    weight = np.cross(first, second) if len(first) else np.zeros((0, 3))
    total = weight.sum(axis=1, keepdims=True)
    weight = np.divide(weight, total, out=np.full_like(weight, 1 / 3), where=np.abs(total) > 1e-300)
    weight = np.clip(np.nan_to_num(weight, nan=1 / 3, posinf=1.0, neginf=0.0), 0.02, 1.0)
    return weight / weight.sum(axis=1, keepdims=True)


def _chained(segment: NDArray, crossings: int, vertices: int) -> tuple[NDArray, NDArray, NDArray, int]:
    """Order of the segments along borders, which are walked backward, border of each, number of borders."""
    from surftex.kernels.chains import chains

    count = len(segment)
    meeting = np.full((crossings + vertices, 2), -1, np.int64)
    node, number = segment.ravel(), np.repeat(np.arange(count), 2)
    rank = np.argsort(node, kind="stable")
    node, number = node[rank], number[rank]
    fresh = np.concatenate([[True], node[1:] != node[:-1]]) if count else np.zeros(0, bool)
    inside = node < crossings
    meeting[node[fresh & inside], 0] = number[fresh & inside]
    meeting[node[~fresh & inside], 1] = number[~fresh & inside]
    order, flipped, chain = np.zeros(count, np.int64), np.zeros(count, np.uint8), np.zeros(count, np.int64)
    total = chains(np.ascontiguousarray(segment, dtype=np.int64), meeting, order, flipped, chain)
    return order, flipped, np.sort(chain), int(total)


def _place(
    surface: Surface, net: _Net, node: NDArray, triangle: NDArray, middle: NDArray
) -> NDArray[np.float64]:
    """Places of nodes, crossings first and then vertices, in the frame of their triangle's face."""
    local = np.zeros((len(node), 3))
    crossings = len(net.first)
    on_edge = np.flatnonzero(node < crossings)
    along = net.share[node[on_edge]]
    for end, part in ((net.first, 1 - along), (net.second, along)):
        slot = np.argmax(net.corner[triangle[on_edge]] == end[node[on_edge], None], axis=1)
        local[on_edge, slot] = part
    inner = np.flatnonzero(node >= crossings)
    local[inner] = middle[node[inner] - crossings]
    inside = np.einsum("nc,nck->nk", local, net.weight[triangle])
    return np.einsum("nk,nki->ni", inside, surface.flat[net.parent[triangle]])
