"""Bézier curves on surfaces: the plane's own, the ends and tangents, and a thousand that all succeed."""

import numpy as np
import pytest

from surftex.errors import SurfaceError
from surftex.geodesics.bezier import bezier, bezier_points
from surftex.geodesics.tracing import trace
from surftex.surface.closest import closest_points
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import cylinder, plane, sphere, torus
from surftex.surface.surface import Surface


def controls(surface, count, spacing, seed=0):
    """Four random controls for each curve, each a straight walk from the one before."""
    random = np.random.default_rng(seed)
    points = [
        SurfacePoints(random.integers(0, len(surface.faces), count), random.dirichlet([1, 1, 1], count))
    ]
    for _ in range(3):
        points.append(trace(surface, points[-1], random.random(count) * 6.28, spacing).end)
    return SurfacePoints(
        np.stack([p.face for p in points], axis=1).ravel(),
        np.stack([p.barycentric for p in points], axis=1).reshape(-1, 3),
    )


def test_on_a_plane_they_are_the_plane_curves():
    sheet = plane(10.0, cells=20)
    given = controls(sheet, 50, 2.0)
    points, curve = bezier_points(sheet, given, depth=3)
    p = given.positions(sheet).reshape(-1, 4, 3)
    t = np.linspace(0, 1, 9)[None, :, None]
    a, b, c, d = (p[:, None, k] for k in range(4))
    expected = (1 - t) ** 3 * a + 3 * t * (1 - t) ** 2 * b + 3 * t**2 * (1 - t) * c + t**3 * d
    np.testing.assert_allclose(points.positions(sheet), expected.reshape(-1, 3), atol=1e-9)
    np.testing.assert_array_equal(curve, np.repeat(np.arange(50), 9))


def test_a_thousand_random_curves_all_succeed():
    ball = sphere(40.0, subdivisions=3)
    x, y, z = ball.vertices.T / 40
    noise = 0.02 * np.random.default_rng(1).normal(size=len(x))
    rough = Surface.from_arrays(
        ball.vertices * (1 + 0.2 * np.sin(3 * x + 1) + 0.15 * np.cos(2 * y - z) + noise)[:, None], ball.faces
    )
    for surface, spacing in ((rough, 3.0), (torus(), 5.0), (cylinder(), 3.0), (plane(10.0), 2.0)):
        given = controls(surface, 250, spacing * surface.mean_edge_mm)
        pieces, length = bezier(surface, given)
        assert np.isfinite(length).all()
        np.testing.assert_allclose(pieces.curve_length_mm, length, rtol=1e-9)
        first = np.searchsorted(pieces.curve, np.arange(250))
        starts = pieces.points(surface, 0.0).positions(surface)[first]
        np.testing.assert_allclose(starts, given.positions(surface).reshape(-1, 4, 3)[:, 0], atol=1e-7)


def test_they_settle_as_they_are_halved_more_often():
    ring = torus()
    given = controls(ring, 40, 4 * ring.mean_edge_mm)
    lengths = [bezier(ring, given, depth=depth)[1] for depth in (2, 4, 6)]
    coarse, fine = np.abs(lengths[0] - lengths[2]), np.abs(lengths[1] - lengths[2])
    assert np.median(fine) < 0.2 * np.median(coarse)
    np.testing.assert_allclose(lengths[1], lengths[2], rtol=0.02)


def test_threads_change_nothing_and_components_part():
    ring = torus()
    given = controls(ring, 150, 5.0)
    one, two = (bezier(ring, given, threads=threads) for threads in (1, 2))
    assert one[0].start.tobytes() == two[0].start.tobytes()
    count = len(ring.vertices)
    apart = Surface.from_arrays(
        np.vstack([ring.vertices, [[100, 0, 0], [101, 0, 0], [100, 1, 0]]]),
        np.vstack([ring.faces, [[count, count + 1, count + 2]]]),
    )
    alone = len(ring.faces)
    mixed = SurfacePoints(
        [0, 0, 0, alone] + [alone] * 4, [[0.2, 0.3, 0.5]] * 4 + [*np.eye(3), [0.3, 0.3, 0.4]]
    )
    pieces, length = bezier(apart, mixed)
    assert np.isinf(length[0])
    assert 0 < length[1] < 2
    assert (pieces.curve == 1).all()


def test_wrong_input_is_named():
    ring = torus()
    with pytest.raises(SurfaceError, match="6 controls"):
        bezier(ring, SurfacePoints([0] * 6, [[1, 0, 0]] * 6))
    with pytest.raises(SurfaceError, match="depth is 11"):
        bezier(ring, SurfacePoints([0] * 4, [[1, 0, 0]] * 4), depth=11)
    nothing = SurfacePoints(np.zeros(0, int), np.zeros((0, 3)))
    assert len(bezier(ring, nothing)[0]) == 0


def test_no_second_compilation():
    from surftex.kernels.paths import ways

    ring = torus()
    bezier(ring, controls(ring, 3, 5.0))
    assert len(ways.signatures) == 1


def test_curves_are_halved_until_their_chords_are_as_short_as_wished():
    sheet = plane(60.0, cells=1)
    long, short = (
        [[5, 5, 0], [20, 50, 0], [40, 50, 0], [55, 10, 0]],
        [[5, 5, 0], [6, 6, 0], [7, 6, 0], [8, 5, 0]],
    )
    both = closest_points(sheet, np.array([*long, *short], float))[0]
    plain, plain_length = bezier(sheet, both)
    pieces, length = bezier(sheet, both, chord_mm=[0.6, 9.0])
    longest = [[each.length_mm[each.curve == c].max() for c in (0, 1)] for each in (plain, pieces)]
    assert longest[0][0] > 4
    assert 0.3 < longest[1][0] < 1.0
    assert longest[1][1] == longest[0][1]
    np.testing.assert_allclose(length, plain_length, rtol=2e-3)
    with pytest.raises(SurfaceError, match="chord_mm"):
        bezier(sheet, both, chord_mm=[1.0])
