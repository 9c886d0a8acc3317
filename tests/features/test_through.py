"""Smooth curves through points: they meet each, bend evenly, and are as short-jointed as wished."""

import numpy as np
import pytest

from surftex.errors import SurfaceError
from surftex.features.through import curves_through
from surftex.surface.closest import closest_points
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import plane, sphere
from surftex.surface.surface import Surface


def at(surface, places):
    return closest_points(surface, np.asarray(places, np.float64))[0]


def joints(surface, pieces):
    return np.concatenate(
        [pieces.points(surface, 0.0).positions(surface), pieces.points(surface, 1.0).positions(surface)[-1:]]
    )


def turns(way):
    step = np.diff(way, axis=0)
    step = step[np.linalg.norm(step, axis=1) > 1e-4]
    step /= np.linalg.norm(step, axis=1, keepdims=True)
    return np.degrees(np.arccos(np.clip((step[1:] * step[:-1]).sum(axis=1), -1, 1)))


@pytest.mark.parametrize("cells", [1, 13])
def test_a_curve_passes_through_its_points_and_has_no_kinks(cells):
    sheet = plane(60.0, cells=cells)
    places = [[5, 5, 0], [30, 50, 0], [55, 10, 0], [40, 5, 0], [42, 12, 0]]
    pieces = curves_through(sheet, at(sheet, places), np.zeros(5, int), chord_mm=[0.5])
    way = joints(sheet, pieces)
    for place in places:
        assert np.linalg.norm(way - place, axis=1).min() < 0.02
    np.testing.assert_allclose(way[[0, -1]], np.array(places)[[0, -1]], atol=0.01)
    assert turns(way).max() < 15
    assert pieces.length_mm.max() < 1.0
    assert pieces.curve_length_mm[0] < 1.35 * np.linalg.norm(np.diff(places, axis=0), axis=1).sum()


def test_points_of_a_circle_on_a_ball_make_a_circle_that_closes_smoothly():
    ball = sphere(20.0, subdivisions=4)
    angle = np.linspace(0, 2 * np.pi, 9)
    ring = np.stack([16 * np.cos(angle), 16 * np.sin(angle), 0 * angle + 12], axis=1)
    pieces = curves_through(ball, at(ball, ring), np.zeros(9, int), chord_mm=[0.5])
    way = joints(ball, pieces)
    away = np.hypot(way[:, 0], way[:, 1])
    assert 15.7 < away.min() <= away.max() < 16.2
    assert np.linalg.norm(way[0] - way[-1]) < 0.02
    assert turns(np.concatenate([way, way[1:4]])).max() < 5
    half = curves_through(ball, at(ball, ring[:5]), np.zeros(5, int), chord_mm=[0.5])
    assert np.linalg.norm(joints(ball, half)[[0, -1]] - ring[[0, 4]], axis=1).max() < 0.3


def test_numbers_are_kept_and_places_twice_or_alone_do_no_harm():
    sheet = plane(60.0, cells=7)
    line = [[5, 5, 0], [5, 5, 0], [25, 25, 0], [25, 25, 0], [45, 45, 0]]
    places = [*line, [9, 50, 0], *line[::-1], [50, 5, 0], [50, 5, 0]]
    number = [2] * 5 + [4] + [7] * 5 + [8] * 2
    pieces = curves_through(sheet, at(sheet, places), number, chord_mm=np.full(9, 2.0))
    assert np.unique(pieces.curve).tolist() == [2, 7]
    np.testing.assert_allclose(pieces.curve_length_mm[[2, 7]], np.hypot(40, 40), rtol=1e-3)
    straight = curves_through(sheet, at(sheet, places[1:3]), [0, 0], chord_mm=[1.0])
    np.testing.assert_allclose(straight.curve_length_mm[0], np.hypot(20, 20), rtol=1e-3)
    nothing = curves_through(sheet, SurfacePoints([], np.zeros((0, 3))), [], chord_mm=[])
    assert len(nothing) == 0
    with pytest.raises(SurfaceError, match="numbers of curves fall"):
        curves_through(sheet, at(sheet, line), [1, 1, 0, 0, 0], chord_mm=[1, 1])


def test_curves_over_several_components_are_left_out_and_threads_change_no_byte():
    one = plane(20.0, cells=3)
    pair = Surface.from_arrays(
        np.concatenate([one.vertices, one.vertices + np.array([30.0, 0, 0])]),
        np.concatenate([one.faces, one.faces + len(one.vertices)]),
    )
    places = [[1, 1, 0], [19, 1, 0], [31, 2, 0], [39, 9, 0], [31, 3, 0], [45, 9, 0], [40, 18, 0]]
    numbers = [0, 0, 0, 0, 1, 1, 1]
    both = [
        curves_through(pair, at(pair, places), numbers, chord_mm=[1, 1], threads=threads)
        for threads in (1, 2)
    ]
    assert np.unique(both[0].curve).tolist() == [1]
    assert both[0].start.tobytes() == both[1].start.tobytes()
