import numpy as np
import pytest
from scipy.spatial import cKDTree

from surftex.features.poisson import Sites, poisson_disk
from surftex.features.uniform import scatter
from surftex.features.voronoi_graph import VoronoiGraph
from surftex.geodesics.windows import flood_points, nearest
from surftex.kernels.voronoi import lay_out
from surftex.randomness import stream
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import cylinder, plane, sphere, torus
from surftex.surface.surface import Surface
from tests.oracles.features import corners_inside


def placed(points: SurfacePoints, size_mm: float) -> Sites:
    return Sites(points, np.full((len(points), 2), size_mm), np.zeros(len(points)))


def cube(side_mm=20.0):
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) * side_mm
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6],
             [0, 6, 4], [1, 5, 7], [1, 7, 3]]  # fmt: skip
    return Surface.from_arrays(corners, faces)


def needles(columns=48, radius_mm=8.0, length_mm=150.0):
    """A closed tube whose wall is triangles from end to end."""
    turn = 2 * np.pi * np.arange(columns) / columns
    ring = np.stack([radius_mm * np.cos(turn), radius_mm * np.sin(turn)], axis=1)
    points = [
        *([x, y, 0.0] for x, y in ring),
        *([x, y, length_mm] for x, y in ring),
        [0, 0, 0],
        [0, 0, length_mm],
    ]
    faces = []
    for i in range(columns):
        j = (i + 1) % columns
        low, high = 2 * columns, 2 * columns + 1
        faces += [
            [i, j, columns + j],
            [i, columns + j, columns + i],
            [low, j, i],
            [high, columns + i, columns + j],
        ]
    return Surface.from_arrays(points, faces)


CASES = {
    "several faces a cell": (lambda: sphere(20.0, subdivisions=5), 3.0, 1.0, 2),
    "several cells a face": (lambda: sphere(20.0, subdivisions=1), 1.5, 1.0, 2),
    "twelve faces": (cube, 1.0, 1.0, 2),
    "long cells": (lambda: sphere(20.0, subdivisions=4), 3.0, 2.0, 2),
    "needles": (needles, 2.0, 1.0, 2),
    "a hole": (lambda: torus(15.0, 6.0, columns=60, rows=30), 2.0, 1.0, 0),
}


@pytest.mark.parametrize("case", CASES)
def test_cells_fill_a_closed_surface_and_meet_in_threes(case):
    make, spacing, ratio, euler = CASES[case]
    surface = make()
    sites = poisson_disk(surface, spacing, stream(1, case), ratio=ratio)
    graph = VoronoiGraph.of(surface, sites)
    assert len(np.unique(graph.edge_region)) == len(sites)
    assert (graph.edge_vertex >= 0).all()
    assert (np.bincount(graph.edge_vertex.ravel()) == 3).all()
    assert len(graph.vertices) - len(graph.edge_vertex) + len(sites) == euler


@pytest.mark.parametrize("case", CASES)
def test_both_sites_of_a_border_are_nearest_all_along_it(case):
    make, spacing, ratio, _ = CASES[case]
    surface = make()
    sites = poisson_disk(surface, spacing, stream(1, case), ratio=ratio)
    graph = VoronoiGraph.of(surface, sites)
    records = flood_points(surface, sites.points, 1.1 * spacing)
    regions = graph.edge_region[graph.pieces.curve]
    for share in (0.0, 0.3, 0.5, 0.8):
        site, distance = nearest(records, graph.pieces.points(surface, share), 2)
        assert (distance[:, 1] - distance[:, 0]).max() < 1e-4 * spacing / ratio
        if share > 0:
            assert (np.sort(site, axis=1) == regions).all(axis=1).mean() > 0.999
    site, distance = nearest(records, graph.vertices, 3)
    assert (distance[:, 2] - distance[:, 0]).max() < 1e-8 * spacing
    assert (np.sort(site, axis=1) == graph.vertex_region).all(axis=1).mean() > 0.999


def test_borders_across_needles_are_not_cut_to_pieces():
    surface = needles()
    graph = VoronoiGraph.of(surface, poisson_disk(surface, 2.0, stream(1, "needles")))
    assert np.bincount(graph.pieces.curve).mean() < 60  # 34; 365 where needles were cut into four needles


def test_pieces_of_a_border_hang_together_with_the_lower_region_on_the_left():
    surface = sphere(20.0, subdivisions=4)
    sites = poisson_disk(surface, 3.0, stream(2, "together"))
    graph = VoronoiGraph.of(surface, sites)
    start, end = (graph.pieces.points(surface, share).positions(surface) for share in (0.0, 1.0))
    first, last = graph.edge_bounds[:, 0], graph.edge_bounds[:, 1] - 1
    inner = np.setdiff1d(np.arange(len(graph.pieces)), first)
    assert np.abs(start[inner] - end[inner - 1]).max() < 1e-9
    corners = graph.vertices.positions(surface)
    assert np.abs(start[first] - corners[graph.edge_vertex[:, 0]]).max() < 1e-9
    assert np.abs(end[last] - corners[graph.edge_vertex[:, 1]]).max() < 1e-9
    middle = (first + last) // 2
    place = sites.points.positions(surface)
    to_left = place[graph.edge_region[:, 0]] - place[graph.edge_region[:, 1]]
    turn = np.cross(surface.frame[graph.pieces.face[middle], 2], end[middle] - start[middle])
    assert ((turn * to_left).sum(axis=1) > 0).all()


@pytest.mark.parametrize("cells", [1, 3, 40])
def test_vertices_are_those_of_the_plane(cells):
    sheet = plane(10.0, cells=cells)
    points = scatter(sheet, stream(3, "plane"), count=150)
    graph = VoronoiGraph.of(sheet, placed(points, 0.5))
    truth = corners_inside(points.positions(sheet)[:, :2], 10.0)
    found = graph.vertices.positions(sheet)[:, :2]
    # cells of a square also reach each other only by way of its inside: the same vertices, all of them
    assert len(found) == len(truth)
    assert cKDTree(truth).query(found)[0].max() < 1e-8


def test_leaving_a_vertex_leads_along_its_borders():
    surface = sphere(20.0, subdivisions=3)
    graph = VoronoiGraph.of(surface, poisson_disk(surface, 4.0, stream(4, "leave")))
    for vertex in range(0, len(graph.vertices), 7):
        edge, side, angle = graph.leave(vertex)
        assert (graph.edge_vertex[edge, side] == vertex).all()
        assert len(edge) == 3
        turns = np.diff(np.sort(angle), append=np.sort(angle)[0] + 2 * np.pi)
        assert turns.max() < np.pi + 1e-6


def test_borders_around_a_narrow_tube_are_rings_or_end_at_its_rims():
    tube = cylinder(0.5, 60.0, columns=24, rows=40)
    graph = VoronoiGraph.of(tube, poisson_disk(tube, 5.0, stream(5, "tube")))
    assert len(graph.vertices) == 0
    assert (graph.edge_vertex == -1).all()
    place = [graph.pieces.points(tube, share).positions(tube) for share in (0.0, 1.0)]
    first, last = graph.edge_bounds[:, 0], graph.edge_bounds[:, 1] - 1
    assert np.abs(place[0][first] - place[1][last]).max() < 1e-9
    assert np.allclose(graph.pieces.curve_length_mm, np.pi, rtol=0.05)


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_few_sites(count):
    surface = sphere(10.0, subdivisions=2)
    points = scatter(surface, stream(6, "few"), count=count)
    graph = VoronoiGraph.of(surface, placed(points, 3.0))
    assert len(graph.edge_vertex) == (0, 0, 1, 3)[count]
    assert len(graph.vertices) == (0, 0, 0, 2)[count]


def test_components_without_sites_have_no_borders():
    one = plane(10.0, cells=4)
    both = Surface.from_arrays(
        np.concatenate([one.vertices, one.vertices + 20]),
        np.concatenate([one.faces, one.faces + len(one.vertices)]),
    )
    points = scatter(one, stream(7, "parts"), count=9)
    graph = VoronoiGraph.of(both, placed(points, 2.0))
    assert len(graph.pieces)
    assert (graph.pieces.face < len(one.faces)).all()


def test_threads_and_numbering_change_nothing():
    surface = sphere(20.0, subdivisions=5)
    sites = poisson_disk(surface, 2.0, stream(8, "threads"))
    one, two = (VoronoiGraph.of(surface, sites, threads=threads) for threads in (1, 2))
    assert one.pieces.start.tobytes() == two.pieces.start.tobytes()
    assert one.edge_vertex.tobytes() == two.edge_vertex.tobytes()
    order = np.argsort(stream(9, "order").uniform(len(surface.faces))[:, 0])
    shuffled = Surface.from_arrays(surface.vertices, surface.faces[order])
    back = np.argsort(order).astype(np.int32)
    moved = Sites(
        SurfacePoints(back[sites.points.face], sites.points.barycentric), sites.axis_mm, sites.angle_rad
    )
    other = VoronoiGraph.of(shuffled, moved)
    assert {tuple(row) for row in one.vertex_region} == {tuple(row) for row in other.vertex_region}
    length = [np.sort(graph.pieces.curve_length_mm) for graph in (one, other)]
    assert np.abs(length[0] - length[1]).max() < 1e-3


def test_pieces_are_laid_out_curve_by_curve_and_turned_to_their_walk():
    random = np.random.default_rng(3)
    count, first = 60, np.array([0, 1, 9, 30])
    piece, piece_id = random.random((count, 4)), random.integers(0, 99, (count, 5)).astype(np.int32)
    order, flipped = random.permutation(count).astype(np.int32), random.integers(0, 2, count).astype(np.uint8)
    backwards = np.array([1, 0, 1, 0], np.uint8)
    face, start, end = np.zeros(count, np.int32), np.zeros((count, 2)), np.zeros((count, 2))
    lay_out(piece, piece_id, order, flipped, first, backwards, face, start, end)
    walks = np.split(np.arange(count), first[1:])
    at = np.concatenate([walk[::-1] if back else walk for walk, back in zip(walks, backwards, strict=True)])
    turned = flipped[at].astype(bool) ^ np.repeat(backwards, np.diff([*first, count])).astype(bool)
    expected = piece[order[at]]
    expected[turned] = expected[turned][:, [2, 3, 0, 1]]
    assert (face == piece_id[order[at], 0]).all()
    assert (np.hstack([start, end]) == expected).all()
