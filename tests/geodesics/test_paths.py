"""Shortest paths: against closed forms, exact windows and Dijkstra, under motion, and through bad places."""

import numpy as np
import pytest

from surftex.errors import SurfaceError
from surftex.geodesics.paths import PathGround, polyline, shortest_path
from surftex.geodesics.tracing import trace
from surftex.geodesics.windows import flood_points, nearest
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import cylinder, plane, sphere, torus
from surftex.surface.surface import Surface
from tests.oracles.short_ways import sown_distance


def scattered(surface, count, seed=0):
    """Random points, the same for the same seed."""
    random = np.random.default_rng(seed)
    return SurfacePoints(random.integers(0, len(surface.faces), count), random.dirichlet([1, 1, 1], count))


def bumpy(subdivisions=3):
    """A ball without symmetry."""
    ball = sphere(40.0, subdivisions=subdivisions)
    x, y, z = ball.vertices.T / 40
    swell = 1 + 0.2 * np.sin(3 * x + 1) + 0.15 * np.cos(2 * y - z) + 0.1 * z**3
    return Surface.from_arrays(ball.vertices * swell[:, None], ball.faces)


def exact(surface, start, end, reach):
    """Distances of pairs by the exact windows."""
    result = np.zeros(len(start))
    for i in range(len(start)):
        one = SurfacePoints(start.face[[i]], start.barycentric[[i]])
        two = SurfacePoints(end.face[[i]], end.barycentric[[i]])
        result[i] = nearest(flood_points(surface, one, reach), two, 1)[1][0, 0]
    return result


def assert_joined(surface, pieces, start, end):
    """Pieces lead from start to end without gaps and know their lengths."""
    first = np.flatnonzero(np.concatenate([[True], np.diff(pieces.curve) > 0]))
    last = np.concatenate([first[1:] - 1, [len(pieces) - 1]])
    tail, head = (
        pieces.points(surface, 0.0).positions(surface),
        pieces.points(surface, 1.0).positions(surface),
    )
    number = pieces.curve[first]
    np.testing.assert_allclose(tail[first], start.positions(surface)[number], atol=1e-9)
    np.testing.assert_allclose(head[last], end.positions(surface)[number], atol=1e-9)
    inner = np.setdiff1d(np.arange(len(pieces)), first)
    np.testing.assert_allclose(tail[inner], head[inner - 1], atol=1e-9)
    np.testing.assert_allclose(
        pieces.start_mm[inner], (pieces.start_mm + pieces.length_mm)[inner - 1], atol=1e-9
    )


def test_on_a_plane_paths_are_straight():
    sheet = plane(10.0, cells=20)
    start, end = scattered(sheet, 400, 1), scattered(sheet, 400, 2)
    pieces, length = shortest_path(sheet, start, end)
    np.testing.assert_allclose(
        length, np.linalg.norm(start.positions(sheet) - end.positions(sheet), axis=1), rtol=1e-12
    )
    assert_joined(sheet, pieces, start, end)


@pytest.mark.parametrize("kind", ["edge", "vertex"])
def test_paths_between_places_on_edges_and_vertices_are_straight(kind):
    """A funnel that starts at a corner must not take its one side for the other."""
    sheet = plane(8.0, cells=8)
    ends = []
    for seed in (1, 2):
        points, rows = scattered(sheet, 1500, seed), np.arange(1500)
        corner = np.random.default_rng(seed).integers(0, 3, 1500)
        weight = points.barycentric.copy()
        weight[rows, corner] = 0
        ends.append(
            SurfacePoints(
                points.face, np.eye(3)[corner] if kind == "vertex" else weight / weight.sum(1)[:, None]
            )
        )
    _, length = shortest_path(sheet, *ends)
    straight = np.linalg.norm(ends[0].positions(sheet) - ends[1].positions(sheet), axis=1)
    ratio = length[straight > 0.3] / straight[straight > 0.3]
    assert ratio.max() < 1 + 1e-9


def test_on_a_cylinder_paths_unroll():
    tube = cylinder(20.0, 60.0, columns=40, rows=20)
    side = 2 * 20 * np.sin(np.pi / 40)
    start, end = scattered(tube, 300, 3), scattered(tube, 300, 4)

    def unrolled(points):
        x, y, z = points.positions(tube).T
        column = np.floor(np.mod(np.arctan2(y, x), 2 * np.pi) / (2 * np.pi / 40) + 1e-12)
        corner = 20 * np.stack([np.cos(column * 2 * np.pi / 40), np.sin(column * 2 * np.pi / 40)], axis=1)
        return column * side + np.linalg.norm(np.stack([x, y], axis=1) - corner, axis=1), z

    (a, z), (b, w) = unrolled(start), unrolled(end)
    around = np.abs(a - b)
    across = np.minimum(around, 40 * side - around)
    near = across < 0.35 * 40 * side
    _, length = shortest_path(tube, start, end)
    np.testing.assert_allclose(length[near], np.hypot(across, z - w)[near], rtol=1e-9)


def test_on_a_sphere_lengths_converge_to_great_circles():
    worst, edge = [], []
    for subdivisions in (2, 3, 4):
        ball = sphere(40.0, subdivisions=subdivisions)
        start, end = scattered(ball, 300, 5), scattered(ball, 300, 6)
        a, b = (
            p.positions(ball) / np.linalg.norm(p.positions(ball), axis=1, keepdims=True) for p in (start, end)
        )
        circle = 40 * np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))
        near = circle < 60
        _, length = shortest_path(ball, start, end)
        worst.append(np.abs(length - circle)[near].max())
        edge.append(ball.mean_edge_mm)
    assert np.polyfit(np.log(edge), np.log(worst), 1)[0] == pytest.approx(2, abs=0.5)
    assert worst[-1] < 0.06


@pytest.mark.parametrize(("spans", "share", "excess"), [(1, 0.98, 0.01), (3, 0.92, 0.05)])
def test_near_pairs_are_exact_and_none_is_too_short(spans, share, excess):
    shape = bumpy()
    start = scattered(shape, 150, 7)
    end = trace(shape, start, np.arange(150) * 0.7, spans * shape.mean_edge_mm).end
    pieces, length = shortest_path(shape, start, end)
    truth = exact(shape, start, end, 1.2 * spans * shape.mean_edge_mm)
    over = length / truth - 1
    assert over.min() > -1e-9
    assert (over < 1e-6).mean() >= share
    assert over.max() < excess
    assert_joined(shape, pieces, start, end)


def test_dijkstra_over_sown_points_finds_nothing_shorter():
    shape = bumpy(1)
    start = scattered(shape, 10, 8)
    end = trace(shape, start, np.arange(10) * 0.7, 1.5 * shape.mean_edge_mm).end
    _, length = shortest_path(shape, start, end)
    for i in range(10):
        bound = sown_distance(
            shape.vertices,
            shape.faces,
            start.face[i],
            start.barycentric[i],
            end.face[i],
            end.barycentric[i],
            12,
        )
        assert length[i] <= bound * (1 + 1e-9)
        assert length[i] >= bound * (1 - 0.03)


def test_paths_are_straight_lines():
    # Traced from its start in its first direction, a path that passes no vertex is met again.
    ring = torus(30.0, 12.0, columns=40, rows=20)
    start = scattered(ring, 80, 10)
    end = trace(ring, start, np.arange(80) * 0.9, 4 * ring.mean_edge_mm).end
    pieces, length = shortest_path(ring, start, end)
    first = np.searchsorted(pieces.curve, np.arange(80))
    way = (pieces.end - pieces.start)[first]
    again = trace(ring, start, np.arctan2(way[:, 1], way[:, 0]), length)
    gap = np.linalg.norm(again.end.positions(ring) - end.positions(ring), axis=1)
    assert np.median(gap) < 1e-9
    assert (gap < 1e-6).mean() > 0.7


def test_a_valley_is_passed_by_its_saddle_and_a_notch_by_its_corner():
    # An L of flat squares: the path bends about the inner corner, where the border is.
    corners = [[x, y, 0] for y in range(3) for x in range(3)]
    squares = [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6)]
    faces = [f for a, b, c, d in squares for f in ((a, b, c), (a, c, d))]
    notch = Surface.from_arrays(np.array(corners)[:8], faces)
    middle = notch.vertices[notch.faces].mean(axis=1)
    one, two = int(np.argmax(middle[:, 0])), int(np.argmax(middle[:, 1]))
    start, end = SurfacePoints([one], [[1 / 3] * 3]), SurfacePoints([two], [[1 / 3] * 3])
    _, length = shortest_path(notch, start, end)
    expected = np.linalg.norm(middle[one] - [1, 1, 0]) + np.linalg.norm(middle[two] - [1, 1, 0])
    assert length[0] == pytest.approx(expected, rel=1e-12)


def test_components_points_and_counts():
    ball = sphere(10.0, subdivisions=2)
    count = len(ball.vertices)
    apart = Surface.from_arrays(
        np.vstack([ball.vertices, [[100, 0, 0], [101, 0, 0], [100, 1, 0]]]),
        np.vstack([ball.faces, [[count, count + 1, count + 2]]]),
    )
    alone = len(ball.faces)
    start = SurfacePoints([0, alone, 5], [[1, 0, 0]] * 3)
    end = SurfacePoints([alone, alone, 5], [[1, 0, 0], [0, 1, 0], [1, 0, 0]])
    pieces, length = shortest_path(apart, start, end)
    np.testing.assert_allclose(length, [np.inf, 1.0, 0.0])
    np.testing.assert_array_equal(pieces.curve, [1])
    with pytest.raises(SurfaceError, match="3 starts but 1 ends"):
        shortest_path(apart, start, SurfacePoints([0], [[1, 0, 0]]))
    nothing = SurfacePoints(np.zeros(0, int), np.zeros((0, 3)))
    assert len(shortest_path(apart, nothing, nothing)[0]) == 0


def test_from_vertex_to_vertex_through_a_wheel_of_slivers():
    fan = 500
    turn = np.arange(fan) * 2 * np.pi / fan
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    index = np.arange(fan)
    wheel = Surface.from_arrays(
        np.vstack([[0, 0, 0], ring]), np.stack([0 * index, index + 1, (index + 1) % fan + 1], axis=1)
    )
    start = SurfacePoints(np.zeros(50, int), np.tile([0.0, 1.0, 0.0], (50, 1)))
    end = SurfacePoints(np.arange(50) * 10, np.tile([0.0, 1.0, 0.0], (50, 1)))
    pieces, length = shortest_path(wheel, start, end)
    chord = np.linalg.norm(start.positions(wheel) - end.positions(wheel), axis=1)
    np.testing.assert_allclose(length, chord, rtol=1e-9)
    corners = SurfacePoints(np.arange(300), np.eye(3)[np.arange(300) % 3])
    others = SurfacePoints(np.arange(300)[::-1], np.eye(3)[np.arange(300) % 3])
    shape = bumpy(2)
    pieces, length = shortest_path(shape, corners, others)
    assert np.isfinite(length).all()
    assert_joined(shape, pieces, corners, others)


def test_needles_do_not_break_it():
    random = np.random.default_rng(3)
    sheet = plane(10.0, cells=20)
    vertices = sheet.vertices.copy()
    inner = ~sheet.on_border
    vertices[inner, 0] = np.round(vertices[inner, 0] / 2.5) * 2.5 + (vertices[inner, 0] - 5) * 1e-4
    vertices[:, 2] = 1e-3 * random.normal(size=len(vertices))
    squeezed = Surface.from_arrays(vertices, sheet.faces)
    start, end = scattered(squeezed, 300, 1), scattered(squeezed, 300, 2)
    pieces, length = shortest_path(squeezed, start, end)
    assert np.isfinite(length).all()
    assert_joined(squeezed, pieces, start, end)
    assert (
        length >= np.linalg.norm(start.positions(squeezed) - end.positions(squeezed), axis=1) - 1e-9
    ).all()


def test_rigid_motion_and_renumbering_change_no_length():
    shape = bumpy()
    start = scattered(shape, 60, 1)
    end = trace(shape, start, np.arange(60) * 0.7, 2 * shape.mean_edge_mm).end
    random = np.random.default_rng(4)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    order, rename = random.permutation(len(shape.faces)), random.permutation(len(shape.vertices))
    moved = np.zeros_like(shape.vertices)
    moved[rename] = shape.vertices @ turn.T + [5, -3, 2]
    other = Surface.from_arrays(moved, rename[np.roll(shape.faces, 1, axis=1)][order])
    where = np.argsort(order)
    ends = [SurfacePoints(where[p.face], np.roll(p.barycentric, 1, axis=1)) for p in (start, end)]
    np.testing.assert_allclose(shortest_path(other, *ends)[1], shortest_path(shape, start, end)[1], rtol=1e-9)


def test_threads_slices_and_short_arrays_change_nothing(monkeypatch):
    ring = torus()
    start, end = scattered(ring, 1500, 1), scattered(ring, 1500, 2)
    one, two = (shortest_path(ring, start, end, threads=threads) for threads in (1, 2))
    assert one[0].start.tobytes() == two[0].start.tobytes()
    assert one[1].tobytes() == two[1].tobytes()
    room = PathGround.strip_room
    monkeypatch.setattr(PathGround, "strip_room", lambda self, size: room(self, 2 if size == 1024 else size))
    narrow = shortest_path(ring, start, end)
    assert narrow[0].start.tobytes() == one[0].start.tobytes()


def test_a_polyline_passes_its_points_in_order():
    ring = torus()
    points = scattered(ring, 9, 1)
    curve = [0, 0, 0, 2, 2, 2, 2, 3, 3]
    pieces, length = polyline(ring, points, curve)
    legs = shortest_path(
        ring,
        SurfacePoints(points.face[[0, 1, 3, 4, 5, 7]], points.barycentric[[0, 1, 3, 4, 5, 7]]),
        SurfacePoints(points.face[[1, 2, 4, 5, 6, 8]], points.barycentric[[1, 2, 4, 5, 6, 8]]),
    )[1]
    np.testing.assert_allclose(length, [legs[:2].sum(), 0, legs[2:5].sum(), legs[5]])
    np.testing.assert_allclose(pieces.curve_length_mm, length)
    inner = np.flatnonzero(np.diff(pieces.curve) == 0)
    np.testing.assert_allclose(
        pieces.start_mm[inner + 1], (pieces.start_mm + pieces.length_mm)[inner], atol=1e-9
    )
    with pytest.raises(SurfaceError, match="curve numbers fall at 1"):
        polyline(ring, points, [0, 0, 1, 1, 0, 2, 2, 2, 2])
