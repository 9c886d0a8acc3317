"""The nearest point: known on a plane and a ball, and no sample of the surface is nearer."""

import numpy as np
import pytest

from surftex.errors import SurfaceError
from surftex.randomness import stream
from surftex.surface.closest import closest_points
from surftex.surface.shapes import plane, sphere, torus


def test_on_a_plane_it_is_the_projection():
    places = stream(1, "test").uniform(200, 3) * [10, 10, 6] - [0, 0, 3]
    points, distance = closest_points(plane(10.0), places)
    np.testing.assert_allclose(points.positions(plane(10.0))[:, :2], places[:, :2], atol=1e-9)
    np.testing.assert_allclose(distance, np.abs(places[:, 2]), atol=1e-9)


@pytest.mark.parametrize("surface", [sphere(20.0, subdivisions=2), torus()], ids=["sphere", "torus"])
def test_no_vertex_is_nearer_and_the_distance_is_to_the_point(surface):
    places = stream(2, "test").uniform(100, 3) * 80 - 40
    points, distance = closest_points(surface, places)
    np.testing.assert_allclose(
        np.linalg.norm(points.positions(surface) - places, axis=1), distance, atol=1e-7
    )
    nearest_vertex = np.linalg.norm(surface.vertices[None] - places[:, None], axis=2).min(axis=1)
    assert (distance <= nearest_vertex + 1e-9).all()
    assert distance.mean() < nearest_vertex.mean() - 0.1


def test_one_place_and_none():
    points, distance = closest_points(sphere(20.0), [[0.0, 0.0, 50.0]])
    assert len(points) == len(distance) == 1
    assert len(closest_points(sphere(20.0), np.zeros((0, 3)))[0]) == 0
    for far in (1e9, 1e200, -1e308):
        with pytest.raises(SurfaceError, match=r"positions\[1\] .* lies off a surface of 69.28 mm"):
            closest_points(sphere(20.0), [[0.0, 0.0, 1e6], [0.0, far, 0.0]])
    with pytest.raises(SurfaceError, match="not finite"):
        closest_points(sphere(20.0), [[np.nan, 0, 0]])
