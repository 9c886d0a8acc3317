"""Triangles of a polygon cover it exactly: signed areas sum to its area, and none is turned over."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from surftex.errors import SurfaceError
from surftex.randomness import stream
from surftex.surface.triangulate import triangulate


def signed_areas(places, triangles):
    a, b, c = (places[triangles[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)


def polygon_area(flat):
    x, y = flat.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def star(seed, count):
    """A polygon that sees its middle: radii at random, angles in order."""
    radius = 0.1 + stream(seed, "radius").uniform(count)[:, 0]
    angle = (np.arange(count) + 0.9 * stream(seed, "angle").uniform(count)[:, 0]) * 2 * np.pi / count
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


@given(st.integers(0, 2**30), st.integers(3, 40))
def test_a_polygon_is_covered_once(seed, count):
    flat = star(seed, count)
    turn = stream(seed, "turn").uniform(3, 3) - 0.5
    basis, _ = np.linalg.qr(turn)
    places = flat @ basis[:, :2].T
    normal = np.cross(basis[:, 0], basis[:, 1])
    triangles, polygon = triangulate(places, np.arange(count), np.array([0, count]))
    areas = signed_areas(places, triangles) @ normal
    assert len(triangles) == count - 2
    assert (polygon == 0).all()
    assert areas.sum() == pytest.approx(polygon_area(flat), rel=1e-9)
    assert (areas > -1e-12).all()


def test_a_comb_of_many_teeth():
    teeth = 40
    top = np.column_stack([np.arange(2 * teeth)[::-1], np.where(np.arange(2 * teeth) % 2, 1.0, 5.0)])
    flat = np.concatenate([[[0, 0], [2 * teeth - 1, 0]], top])
    places = np.column_stack([flat, 0 * flat[:, 0]])
    triangles, _ = triangulate(places, np.arange(len(flat)), np.array([0, len(flat)]))
    areas = signed_areas(places, triangles)[:, 2]
    assert areas.sum() == pytest.approx(polygon_area(flat))
    assert (areas >= 0).all()


def test_a_concave_quad_is_cut_at_its_reflex_corner():
    for shift in range(4):
        places = np.roll(np.array([[0, 0, 0], [4, 0, 0], [1, 1, 0], [0, 4, 0]], float), shift, axis=0)
        triangles, _ = triangulate(places, np.arange(4), np.array([0, 4]))
        assert (signed_areas(places, triangles)[:, 2] > 0).all()


def test_a_square_is_cut_from_its_first_corner():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    assert triangulate(square, np.arange(4), np.array([0, 4]))[0].tolist() == [[0, 1, 2], [0, 2, 3]]


def test_a_hole_joined_by_a_bridge():
    outer, inner = [[0, 0], [6, 0], [6, 6], [0, 6]], [[2, 2], [2, 4], [4, 4], [4, 2]]
    flat = np.array([*outer, outer[0], *inner, inner[0]], float)
    places = np.column_stack([flat, 0 * flat[:, 0]])
    triangles, _ = triangulate(places, np.arange(10), np.array([0, 10]))
    areas = signed_areas(places, triangles)[:, 2]
    assert areas.sum() == pytest.approx(32)
    assert np.abs(areas).sum() == pytest.approx(32)


def test_a_polygon_without_area_gives_triangles_without_area():
    places = np.column_stack([np.arange(6.0), np.zeros(6), np.zeros(6)])
    triangles, _ = triangulate(places, np.arange(6), np.array([0, 6]))
    assert len(triangles) == 4


def test_mixed_sizes_keep_their_order():
    corner = np.array([0, 1, 2, 0, 1, 2, 3, 4, 0, 1, 2, 3])
    places = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [-1, 1, 0]], float)
    triangles, polygon = triangulate(places, corner, np.array([0, 3, 8, 12]))
    assert polygon.tolist() == [0, 1, 1, 1, 2, 2]
    assert (triangles[polygon == 1] >= 3).all()
    assert (triangles[polygon == 1] < 8).all()


def test_a_huge_convex_polygon_is_fine_and_a_huge_concave_one_is_refused():
    angle = np.arange(5000) * 2 * np.pi / 5000
    round_ = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    triangles, _ = triangulate(round_, np.arange(5000), np.array([0, 5000]))
    assert signed_areas(round_, triangles)[:, 2].sum() == pytest.approx(np.pi, rel=1e-5)
    with pytest.raises(SurfaceError, match="5000 corners"):
        triangulate(
            round_ * np.where(np.arange(5000) % 2, 1, 0.9)[:, None], np.arange(5000), np.array([0, 5000])
        )
