"""Distances by heat: the order of convergence, one absolute bound, signs, components, and poor meshes."""

import numpy as np
import pytest

from surftex.errors import SurfaceError
from surftex.geodesics.distance import geodesic_distance
from surftex.geodesics.heat import SMALL_FACES, HeatSolver
from surftex.geodesics.pieces import CurvePieces
from surftex.geodesics.tracing import trace
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import plane, sphere
from surftex.surface.surface import Surface


def scattered(surface, count, seed=0):
    """Random points, the same for the same seed."""
    random = np.random.default_rng(seed)
    return SurfacePoints(random.integers(0, len(surface.faces), count), random.dirichlet([1, 1, 1], count))


def great_circle_mm(ball, source, at, radius=40.0):
    """Closed form on a sphere."""
    x, y = source.positions(ball)[0], at.positions(ball)
    return radius * np.arctan2(np.linalg.norm(np.cross(x, y), axis=1), y @ x)


def joined(*surfaces):
    """Several surfaces as components of one."""
    count = np.cumsum([0] + [len(surface.vertices) for surface in surfaces])
    return Surface.from_arrays(
        np.vstack([surface.vertices for surface in surfaces]),
        np.vstack([surface.faces + k for surface, k in zip(surfaces, count, strict=False)]),
    )


def equator(ball, turns=1.0):
    """A great circle eastwards, from the middle of a face."""
    middle = ball.vertices[ball.faces].mean(axis=1)
    face = int(np.argmin(np.abs(middle[:, 2]) + np.abs(middle[:, 1]) - 0.1 * middle[:, 0]))
    east = np.arctan2(ball.frame[face, 1, 1], ball.frame[face, 0, 1])
    return trace(ball, SurfacePoints([face], [[1 / 3] * 3]), east, turns * 2 * np.pi * 40).pieces


def test_distance_converges_to_the_great_circle():
    edge, mean, worst = [], [], []
    for subdivisions in (3, 4, 5):
        ball = sphere(40.0, subdivisions=subdivisions)
        source, at = SurfacePoints([7], [[0.2, 0.3, 0.5]]), scattered(ball, 2000)
        error = np.abs(HeatSolver(ball).distance(source, at) - great_circle_mm(ball, source, at))
        edge.append(ball.mean_edge_mm)
        mean.append(error.mean())
        worst.append(error.max())
    assert np.polyfit(np.log(edge), np.log(mean), 1)[0] > 0.7
    assert np.polyfit(np.log(edge), np.log(worst), 1)[0] > 0.7
    assert worst[-1] < 0.8
    assert mean[-1] < 0.25


def test_near_a_source_it_is_exact_and_at_the_source_zero():
    ball = sphere(40.0, subdivisions=4)
    source = SurfacePoints([100], [[0.2, 0.3, 0.5]])
    near = trace(ball, SurfacePoints([100] * 20, [[0.2, 0.3, 0.5]] * 20), np.arange(20) * 0.3, 2.5).end
    np.testing.assert_allclose(HeatSolver(ball).distance(source, near), 2.5, rtol=2e-3)
    assert HeatSolver(ball).distance(source, source)[0] == pytest.approx(0, abs=1e-9)
    corner = SurfacePoints([100], [[0, 1, 0]])
    assert HeatSolver(ball).distance(corner, corner)[0] == pytest.approx(0, abs=1e-6)


def test_components_without_a_source_are_out_of_reach():
    ball = sphere(40.0, subdivisions=3)
    far = Surface.from_arrays(ball.vertices + np.array([200, 0, 0]), ball.faces)
    alone = Surface.from_arrays([[500, 0, 0], [501, 0, 0], [500, 1, 0]], [[0, 1, 2]])
    both, count = joined(ball, far, alone), len(ball.faces)
    source = SurfacePoints([3, 2 * count], [[0.2, 0.3, 0.5], [1.0, 0.0, 0.0]])
    at = SurfacePoints([900, count + 900, 2 * count], [[0.1, 0.2, 0.7], [0.1, 0.2, 0.7], [0.0, 1.0, 0.0]])
    distance = HeatSolver(both).distance(source, at)
    one = HeatSolver(ball).distance(
        SurfacePoints([3], [[0.2, 0.3, 0.5]]), SurfacePoints([900], [[0.1, 0.2, 0.7]])
    )
    assert distance[0] == pytest.approx(one[0], rel=1e-6)
    assert np.isinf(distance[1])
    assert distance[2] == pytest.approx(1.0, abs=1e-6)
    every = HeatSolver(both).vertex_distance(source)
    assert np.isfinite(every).sum() == len(ball.vertices) + 3
    assert not np.isnan(every).any()


def test_the_nearest_of_several_sources_counts_on_each_component():
    ball = sphere(40.0, subdivisions=4)
    far = Surface.from_arrays(ball.vertices + np.array([200, 0, 0]), ball.faces)
    both, count = joined(ball, far), len(ball.faces)
    at = SurfacePoints([500, count + 500], [[0.1, 0.2, 0.7]] * 2)
    sources = SurfacePoints([3, 2000, count + 3], [[0.2, 0.3, 0.5]] * 3)
    alone = [great_circle_mm(ball, SurfacePoints([k], [[0.2, 0.3, 0.5]]), SurfacePoints([500], [[0.1, 0.2, 0.7]]))[0]
             for k in (3, 2000)]  # fmt: skip
    distance = HeatSolver(both).distance(sources, at)
    np.testing.assert_allclose(distance, [min(alone), alone[0]], rtol=0.06)


def test_slivers_are_borne():
    random = np.random.default_rng(3)
    sheet = plane(10.0, cells=20)
    vertices = sheet.vertices.copy()
    inner = ~sheet.on_border
    vertices[inner, 0] = np.round(vertices[inner, 0] / 2.5) * 2.5 + (vertices[inner, 0] - 5) * 1e-3
    vertices[:, 2] = 1e-3 * random.normal(size=len(vertices))
    squeezed = Surface.from_arrays(vertices, sheet.faces)
    assert squeezed.corner_angle.min() < 1e-2
    source, at = scattered(squeezed, 1), scattered(squeezed, 300, 1)
    heat = HeatSolver(squeezed).distance(source, at)
    assert np.isfinite(heat).all()
    assert (heat >= 0).all()


def test_signed_distance_from_a_great_circle():
    worst, edge = [], []
    for subdivisions in (3, 4, 5):
        ball = sphere(40.0, subdivisions=subdivisions)
        at = scattered(ball, 1000)
        unit = at.positions(ball) / np.linalg.norm(at.positions(ball), axis=1, keepdims=True)
        distance = HeatSolver(ball).signed_distance(equator(ball), at)
        worst.append(np.abs(distance - 40 * np.arcsin(unit[:, 2])).max())
        edge.append(ball.mean_edge_mm)
    assert worst[1] < 2.0
    assert worst[2] < 0.8


def test_pieces_in_faces_that_do_not_touch_do_not_crash():
    ball = sphere(40.0, subdivisions=3)
    pieces = CurvePieces.of([0, 700, 33], [[1, 1], [1, 1], [2, 1]], [[2, 1], [1, 1.5], [2, 1]], [0, 0, 0])
    distance = HeatSolver(ball).signed_distance(pieces, scattered(ball, 50))
    assert np.isfinite(distance).all()


def test_signs_on_a_component_too_small_for_heat():
    sheet = plane(10.0, cells=10)
    assert len(sheet.faces) <= SMALL_FACES
    start = SurfacePoints([110], [[0.2, 0.3, 0.5]])
    here = start.positions(sheet)[0]
    pieces = trace(sheet, start, -np.arctan2(sheet.frame[110, 0, 1], sheet.frame[110, 0, 0]), 3.0).pieces
    place = trace(sheet, start, np.arctan2(sheet.frame[110, 1, 1], sheet.frame[110, 0, 1]), 1.0).end
    distance = HeatSolver(sheet).signed_distance(pieces, place)
    assert place.positions(sheet)[0, 1] - here[1] == pytest.approx(1)
    np.testing.assert_allclose(distance, [1.0], atol=1e-6)


def test_the_front_door_leads_here():
    ball = sphere(40.0, subdivisions=4)
    source, at = SurfacePoints([7], [[0.2, 0.3, 0.5]]), scattered(ball, 50)
    np.testing.assert_array_equal(
        geodesic_distance(ball, source, at, method="heat"), HeatSolver(ball).distance(source, at)
    )


def test_wrong_input_is_named():
    ball = sphere(40.0, subdivisions=2)
    nothing = SurfacePoints(np.zeros(0, int), np.zeros((0, 3)))
    with pytest.raises(SurfaceError, match="no sources"):
        HeatSolver(ball).distance(nothing, nothing)
    with pytest.raises(SurfaceError, match="faces outside"):
        HeatSolver(ball).distance(SurfacePoints([99999], [[1, 0, 0]]), nothing)
    with pytest.raises(SurfaceError, match="pieces lie on faces outside"):
        HeatSolver(ball).signed_distance(CurvePieces.of([99999], [[0, 0]], [[1, 0]], [0]), nothing)
    with pytest.raises(SurfaceError, match="has a length"):
        HeatSolver(ball).signed_distance(CurvePieces.of([0], [[1, 1]], [[1, 1]], [0]), nothing)
