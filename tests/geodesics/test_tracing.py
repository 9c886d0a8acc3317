"""Straight lines: against closed forms, against the walk in space, under motion, and through bad places."""

import numpy as np
import pytest

from surftex.errors import SurfaceError
from surftex.geodesics.tracing import BORDER, FACES, WHOLE, trace
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import cylinder, plane, sphere, torus
from surftex.surface.surface import Surface
from tests.oracles.straight_lines import walk_in_space


def scattered(surface, count, seed=0):
    """Random points, the same for the same seed."""
    random = np.random.default_rng(seed)
    return SurfacePoints(random.integers(0, len(surface.faces), count), random.dirichlet([1, 1, 1], count))


def in_space(surface, face, angle):
    """Unit vectors in space from angles in the faces' frames."""
    frame = surface.frame[face]
    return np.cos(angle)[:, None] * frame[:, 0] + np.sin(angle)[:, None] * frame[:, 1]


def angle_of(surface, face, direction):
    """Angles in the faces' frames from vectors in space."""
    return np.arctan2(*np.einsum("nki,ni->kn", surface.frame[face, :2], direction)[::-1])


def cone(faces=10, deficit=1.0, side=500.0):
    """A cone of flat triangles around its tip, vertex 0; the angle at the tip is 2 pi - deficit."""
    tip = (2 * np.pi - deficit) / faces
    radius = side * np.sin(tip / 2) / np.sin(np.pi / faces)
    turn = np.arange(faces) * 2 * np.pi / faces
    height = np.full(faces, -np.sqrt(side**2 - radius**2))
    ring = np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=1)
    index = np.arange(faces)
    return Surface.from_arrays(
        np.vstack([[0, 0, 0], ring]), np.stack([0 * index, index + 1, (index + 1) % faces + 1], axis=1)
    )


def test_on_a_plane_lines_are_lines():
    sheet = plane(10.0, cells=12)
    points = scattered(sheet, 200)
    start = points.positions(sheet)
    direction = np.random.default_rng(1).normal(size=(200, 3)) * [1, 1, 0]
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    walk = trace(sheet, points, angle_of(sheet, points.face, direction), 3.0)
    whole = walk.reason == WHOLE
    assert 60 < whole.sum() < 190
    np.testing.assert_allclose(walk.end.positions(sheet)[whole], (start + 3 * direction)[whole], atol=1e-12)
    np.testing.assert_allclose(in_space(sheet, walk.end.face, walk.angle_rad), direction, atol=1e-12)
    stopped = walk.end.positions(sheet)[~whole]
    assert (walk.reason[~whole] == BORDER).all()
    assert np.minimum(np.abs(stopped), np.abs(stopped - 10))[:, :2].min(axis=1).max() < 1e-12


def test_on_a_cylinder_the_line_unrolls_to_a_helix():
    columns, slope, turns = 32, 0.1, 2.5
    tube = cylinder(20.0, 60.0, columns=columns, rows=9)
    around_mm = columns * 2 * 20 * np.sin(np.pi / columns)
    start = SurfacePoints([8], [[0.3, 0.3, 0.4]])
    here = start.positions(tube)[0]
    level = np.cross([0, 0, 1], tube.frame[8, 2])
    direction = np.cos(slope) * level + np.sin(slope) * np.array([0, 0, 1])
    walk = trace(tube, start, angle_of(tube, start.face, direction[None]), turns * around_mm / np.cos(slope))
    rise = turns * around_mm * np.tan(slope)
    np.testing.assert_allclose(walk.end.positions(tube)[0], [-here[0], -here[1], here[2] + rise], atol=1e-9)
    end = in_space(tube, walk.end.face, walk.angle_rad)[0]
    np.testing.assert_allclose(end, direction * [-1, -1, 1], atol=1e-12)


def test_on_a_sphere_lines_converge_to_great_circles():
    worst, edge = [], []
    for subdivisions in (2, 3, 4):
        ball = sphere(40.0, subdivisions=subdivisions)
        points = scattered(ball, 400)
        angle = np.linspace(0, 6, 400)
        start = points.positions(ball)
        start /= np.linalg.norm(start, axis=1, keepdims=True)
        direction = in_space(ball, points.face, angle)
        direction -= (direction * start).sum(1, keepdims=True) * start
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        there = trace(ball, points, angle, 40.0).end.positions(ball)
        there /= np.linalg.norm(there, axis=1, keepdims=True)
        expected = np.cos(1) * start + np.sin(1) * direction
        worst.append(40 * np.quantile(np.linalg.norm(there - expected, axis=1), 0.95))
        edge.append(ball.mean_edge_mm)
    order = np.polyfit(np.log(edge), np.log(worst), 1)[0]
    assert order > 0.8
    assert worst[-1] < 0.03 * 40


@pytest.mark.parametrize("deficit", [0.3, 1.0, 2.5, 3.0])
@pytest.mark.parametrize("lean", [0.2, 0.45])
def test_two_ways_around_a_cone_enclose_its_curvature(deficit, lean):
    # Gauss-Bonnet: the two inner angles of a figure with two straight sides add up to the curvature inside.
    hat = cone(deficit=deficit)
    start = SurfacePoints([3], [[0.98, 0.01, 0.01]])
    away = hat.flat[3, 0] - start.flat(hat)[0]
    toward, reach = np.arctan2(away[1], away[0]), np.linalg.norm(away)
    inner = lean * deficit / 2
    far = deficit / 2 - inner
    length = reach * np.sin(np.pi - deficit / 2) / np.sin(far)
    both = SurfacePoints([3, 3], np.repeat(start.barycentric, 2, axis=0))
    walk = trace(hat, both, [toward + inner, toward - inner], length)
    assert (walk.reason == WHOLE).all()
    assert (walk.end.face == 8).all()
    ends = walk.end.positions(hat)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)
    between = np.abs(np.angle(np.exp(1j * (walk.angle_rad[0] - walk.angle_rad[1]))))
    assert between == pytest.approx(2 * far, abs=1e-12)


def test_three_right_angles_on_a_sphere_turn_by_an_eighth_of_its_curvature():
    ball = sphere(40.0, subdivisions=5)
    points, angle = scattered(ball, 40), np.linspace(0, 6, 40)
    first = points.positions(ball)
    quarter = 40 * np.pi / 2
    carried = angle
    start_face, start_angle = points.face, angle
    for _ in range(3):
        walk = trace(ball, points, carried, quarter)
        points, carried = walk.end, walk.angle_rad + np.pi / 2
    back = in_space(ball, points.face, carried)
    began = in_space(ball, start_face, start_angle)
    assert np.quantile(np.linalg.norm(points.positions(ball) - first, axis=1), 0.9) < 1.5
    assert np.quantile(np.linalg.norm(back - began, axis=1), 0.9) < 0.06


def test_the_walk_in_space_agrees():
    ring = torus(30.0, 12.0, columns=20, rows=11)
    points = scattered(ring, 60, seed=3)
    angle = np.linspace(-3, 3, 60)
    walk = trace(ring, points, angle, 70.0)
    positions, directions = points.positions(ring), in_space(ring, points.face, angle)
    ends, onward = walk.end.positions(ring), in_space(ring, walk.end.face, walk.angle_rad)
    for i in range(60):
        face, position, direction = walk_in_space(
            ring.vertices, ring.faces, ring.neighbor, points.face[i], positions[i], directions[i], 70.0
        )
        assert face == walk.end.face[i]
        np.testing.assert_allclose(ends[i], position, atol=1e-9)
        np.testing.assert_allclose(onward[i], direction, atol=1e-10)


def test_pieces_join_up_and_sum_to_the_length():
    ring = torus(30.0, 12.0)
    walk = trace(ring, scattered(ring, 100), 1.0, np.linspace(0, 80, 100))
    pieces = walk.pieces
    np.testing.assert_allclose(pieces.curve_length_mm, np.linspace(0, 80, 100), atol=1e-9)
    np.testing.assert_allclose(np.bincount(pieces.curve, minlength=100) > 0, np.arange(100) > 0)
    start, end = pieces.points(ring, 0.0).positions(ring), pieces.points(ring, 1.0).positions(ring)
    same = np.flatnonzero(pieces.curve[1:] == pieces.curve[:-1])
    np.testing.assert_allclose(end[same], start[same + 1], atol=1e-9)
    np.testing.assert_allclose(
        pieces.start_mm[same + 1], (pieces.start_mm + pieces.length_mm)[same], atol=1e-9
    )


def test_walking_back_returns_even_through_vertices():
    ball = sphere(40.0, subdivisions=3)
    corner = SurfacePoints(np.arange(300), np.eye(3)[np.arange(300) % 3])
    there = trace(ball, corner, np.arange(300) * 0.1, 35.0)
    assert (there.reason == WHOLE).all()
    np.testing.assert_allclose(there.pieces.curve_length_mm, 35.0, atol=1e-9)
    points = scattered(ball, 500)
    there = trace(ball, points, np.linspace(0, 6, 500), 50.0)
    back = trace(ball, there.end, there.angle_rad + np.pi, 50.0)
    np.testing.assert_allclose(back.end.positions(ball), points.positions(ball), atol=1e-8)


def test_along_edges_and_through_vertices_of_a_plane():
    sheet = plane(10.0, cells=10)
    lower = np.flatnonzero((sheet.vertices[sheet.faces].mean(axis=1)[:, :2] < 1).all(axis=1))[0]
    corner = np.flatnonzero((sheet.vertices[sheet.faces[lower]] == 0).all(axis=1))[0]
    start = SurfacePoints([lower] * 4, [np.eye(3)[corner]] * 4)
    direction = np.array([[1, 0, 0], [0, 1, 0], [1, 1, 0], [1, 2, 0]]) / np.sqrt([[1], [1], [2], [5]])
    walk = trace(sheet, start, angle_of(sheet, start.face, direction), [9.0, 9.0, 12.0, 10.0])
    stays = walk.reason == WHOLE
    assert stays[2:].all()
    expected = direction * np.array([[9.0], [9.0], [12.0], [10.0]])
    np.testing.assert_allclose(walk.end.positions(sheet)[stays], expected[stays], atol=1e-12)


def test_a_fan_of_five_hundred_slivers_is_passed():
    hat = cone(faces=500, deficit=0.5, side=10.0)
    start = SurfacePoints([0] * 50, np.tile([0.5, 0.25, 0.25], (50, 1)))
    away = hat.flat[0, 0] - start.flat(hat)[0]
    angle = np.arctan2(away[1], away[0]) + np.concatenate([[0.0], 10.0 ** np.linspace(-17, -1, 49)])
    walk = trace(hat, start, angle, 7.0)
    assert (walk.reason == WHOLE).all()
    # The unrolled line ends at the same distance from the tip whichever side it passes.
    reach = np.linalg.norm(away)
    missed_by = reach * np.sin(angle - angle[0])
    expected = np.hypot(7 - reach * np.cos(angle - angle[0]), missed_by)
    np.testing.assert_allclose(np.linalg.norm(walk.end.positions(hat), axis=1), expected, atol=0.01)


def test_a_single_triangle_and_a_face_limit():
    alone = Surface.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    corners = SurfacePoints([0] * 12, np.repeat(np.eye(3), 4, axis=0))
    walk = trace(alone, corners, np.tile([0.1, 2.0, 3.5, 5.0], 3), 5.0)
    assert (walk.reason == BORDER).all()
    assert (walk.pieces.curve_length_mm <= 2**0.5 + 1e-12).all()
    ring = torus()
    limited = trace(ring, scattered(ring, 5), 0.3, 1e3, most_faces=7)
    assert (limited.reason == FACES).all()
    assert (np.bincount(limited.pieces.curve) <= 7).all()


def test_rigid_motion_and_renumbering_move_the_lines_along():
    ring = torus(30.0, 12.0, columns=24, rows=12)
    points, angle = scattered(ring, 50), np.linspace(0, 6, 50)
    walk = trace(ring, points, angle, 60.0)
    random = np.random.default_rng(4)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    order = random.permutation(len(ring.faces))
    rename = random.permutation(len(ring.vertices))
    moved = np.zeros_like(ring.vertices)
    moved[rename] = ring.vertices @ turn.T + [5, -3, 2]
    faces = rename[np.roll(ring.faces, 1, axis=1)][order]
    other = Surface.from_arrays(moved, faces)
    where = np.argsort(order)
    face = where[points.face]
    weights = np.roll(points.barycentric, 1, axis=1)
    direction = in_space(ring, points.face, angle) @ turn.T
    again = trace(other, SurfacePoints(face, weights), angle_of(other, face, direction), 60.0)
    np.testing.assert_allclose(
        again.end.positions(other), walk.end.positions(ring) @ turn.T + [5, -3, 2], atol=1e-8
    )


def test_threads_and_slices_change_nothing():
    ring = torus()
    points = scattered(ring, 3000)
    one, two = (trace(ring, points, 0.7, 55.0, threads=threads) for threads in (1, 2))
    assert one.pieces.start.tobytes() == two.pieces.start.tobytes()
    assert one.end.barycentric.tobytes() == two.end.barycentric.tobytes()
    some = trace(ring, SurfacePoints(points.face[2000:2010], points.barycentric[2000:2010]), 0.7, 55.0)
    assert some.angle_rad.tobytes() == one.angle_rad[2000:2010].tobytes()


def test_nothing_to_walk_and_wrong_input():
    ring = torus()
    nothing = trace(ring, SurfacePoints(np.zeros(0, int), np.zeros((0, 3))), 0.0, 1.0)
    assert len(nothing.pieces) == len(nothing.end) == 0
    points = scattered(ring, 3)
    with pytest.raises(SurfaceError, match="negative"):
        trace(ring, points, 0.0, [1.0, -2.0, 1.0])
    with pytest.raises(SurfaceError, match="not finite"):
        trace(ring, points, [0.0, np.nan, 0.0], 1.0)
    with pytest.raises(SurfaceError, match="faces outside"):
        trace(ring, SurfacePoints([10**6], [[1, 0, 0]]), 0.0, 1.0)
