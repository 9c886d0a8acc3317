"""Curves that grow: straight where the field is, circles where it turns, smooth everywhere, as long as asked."""

import numpy as np
import pytest

from surftex.errors import SurfaceError
from surftex.features.curves import curve_pieces, curve_table
from surftex.features.growth import grow, grown_controls, spline
from surftex.features.uniform import scatter
from surftex.geodesics.curves import flood_curves, nearest_curve
from surftex.randomness import stream
from surftex.surface.closest import closest_points
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import plane, sphere
from surftex.surface.surface import Surface


def laid(surface, vectors):
    """A field of vectors in space, as one on the surface."""

    def field(points):
        return np.einsum("pki,pi->pk", surface.frame[points.face, :2], vectors(points.positions(surface)))

    return field


def at(surface, *places):
    return closest_points(surface, np.array(places, float))[0]


def test_a_constant_field_grows_straight_lines_of_its_length():
    sheet = plane(40.0, cells=13)
    starts = scatter(sheet, stream(1, "grow"), count=60)
    pieces = grow(sheet, starts, laid(sheet, lambda p: np.tile([3.0, 4.0, 0.0], (len(p), 1))))
    begin = starts.positions(sheet)
    inside = np.flatnonzero((begin[:, 0] < 36.9) & (begin[:, 1] < 35.9))
    assert len(inside) > 30
    np.testing.assert_allclose(pieces.curve_length_mm[inside], 5.0, rtol=1e-9)
    last = np.append(np.flatnonzero(np.diff(pieces.curve)), len(pieces) - 1)
    end = pieces.points(sheet, 1.0).positions(sheet)[last]
    at_end = dict(zip(pieces.curve[last].tolist(), end, strict=True))
    for curve in inside.tolist():
        np.testing.assert_allclose(at_end[curve], begin[curve] + [3, 4, 0], atol=1e-6)
    outside = np.setdiff1d(np.unique(pieces.curve), inside)
    assert (pieces.curve_length_mm[outside] < 5.0).all()  # they end at the border


def test_a_turning_field_grows_circles_the_closer_the_more_steps():
    sheet = plane(40.0, cells=20)
    turn = laid(sheet, lambda p: np.stack([-(p[:, 1] - 20), p[:, 0] - 20, 0 * p[:, 0]], axis=1) * 1.5)
    worst = []
    for steps in (9, 18, 36):
        pieces = grow(sheet, at(sheet, [30.0, 20.0, 0.0]), turn, steps=steps)
        assert pieces.curve_length_mm[0] == pytest.approx(15.0, rel=0.02)
        away = np.linalg.norm(pieces.points(sheet, 0.5).positions(sheet) - [20, 20, 0], axis=1)
        worst.append(np.abs(away - 10).max())
    assert worst[0] < 1.5
    assert worst[2] < worst[1] < worst[0]


def test_curves_on_a_ball_have_no_kinks_and_know_where_they_are():
    ball = sphere(radius_mm=30.0, subdivisions=4)
    starts = scatter(ball, stream(2, "grow"), count=20)
    pieces = grow(ball, starts, laid(ball, lambda p: np.cross([0.3, 0.2, 1.0], p) * 0.8), steps=7)
    begin, end = (pieces.points(ball, share).positions(ball) for share in (0.0, 1.0))
    same = pieces.curve[1:] == pieces.curve[:-1]
    long = np.minimum(pieces.length_mm[1:], pieces.length_mm[:-1]) > 1e-3
    a, b = (end - begin)[:-1][same & long], (end - begin)[1:][same & long]
    cosine = (a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
    # the ball itself bends by 4 degrees at an edge; a joint adds none to it
    assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).max() < 9
    records = flood_curves(ball, pieces, 4.0)
    for curve in (0, 7, 19):
        rows = np.flatnonzero(pieces.curve == curve)
        middle = SurfacePoints(pieces.face[rows], pieces.points(ball, 0.5).barycentric[rows])
        piece, distance, along, _ = nearest_curve(records, middle)
        assert distance.max() < 1e-6
        mine = pieces.curve[piece] == curve
        expected = pieces.start_mm[rows] + 0.5 * pieces.length_mm[rows]
        np.testing.assert_allclose(along[mine], expected[mine], atol=1e-5)


def test_lines_keep_their_sense_and_nothing_grows_from_nothing():
    sheet = plane(40.0, cells=8)

    def flipping(points):
        sense = np.where(points.positions(sheet)[:, 0] % 5 < 2.5, 1.0, -1.0)
        return laid(sheet, lambda p: sense[:, None] * [6.0, 0.0, 0.0])(points)

    pieces = grow(sheet, at(sheet, [11.0, 9.0, 0.0], [26.0, 9.0, 0.0]), flipping, steps=6)
    np.testing.assert_allclose(pieces.curve_length_mm, 6.0)
    nothing = grow(sheet, at(sheet, [11.0, 9.0, 0.0]), lambda p: np.zeros((len(p), 2)))
    assert len(nothing) == 0
    assert len(grow(sheet, SurfacePoints([], np.zeros((0, 3))), flipping)) == 0


def test_drawn_controls_of_any_number_make_a_curve():
    sheet = plane(40.0, cells=9)
    for count in (2, 3, 4, 5, 8, 9):
        x = np.linspace(5, 35, count)
        places = np.stack([x, 20 + 8 * np.sin(x / 5), 0 * x], axis=1)
        pieces = spline(sheet, at(sheet, *places), np.zeros(count, int))
        spots = pieces.points(sheet, 0.0).positions(sheet)
        np.testing.assert_allclose(spots[0], places[0], atol=1e-5)
        np.testing.assert_allclose(pieces.points(sheet, 1.0).positions(sheet)[-1], places[-1], atol=1e-5)
        reach = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
        assert np.linalg.norm(places[-1] - places[0]) - 1e-6 <= pieces.curve_length_mm[0] <= reach + 1e-6
    two = [*places, *(places - np.array([0, 3, 0]))]
    pieces = spline(sheet, at(sheet, *two, [1, 1, 0]), [*([3] * count), *([5] * count), 9])
    assert np.unique(pieces.curve).tolist() == [3, 5]


def test_a_sharp_zigzag_has_no_kinks_either():
    sheet = plane(40.0, cells=1)
    places = np.stack([np.linspace(5, 35, 8), np.where(np.arange(8) % 2, 28.0, 12.0), np.zeros(8)], axis=1)
    turns = []
    for depth in (4, 6):
        pieces = spline(sheet, at(sheet, *places), np.zeros(8, int), depth=depth)
        step = (pieces.points(sheet, 1.0).positions(sheet) - pieces.points(sheet, 0.0).positions(sheet))[
            :, :2
        ]
        step = step[np.linalg.norm(step, axis=1) > 1e-6]
        heading = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
        turns.append(np.degrees(np.abs(np.diff(heading)).max()))
    assert turns[1] < 0.4 * turns[0] < 20


def test_curves_over_several_components_are_left_out():
    one = plane(10.0, cells=2)
    pair = Surface.from_arrays(
        np.concatenate([one.vertices, one.vertices + np.array([30, 0, 0])]),
        np.concatenate([one.faces, one.faces + len(one.vertices)]),
    )
    pieces = spline(pair, at(pair, [1, 1, 0], [39, 1, 0], [31, 2, 0], [39, 9, 0]), [0, 0, 1, 1])
    assert np.unique(pieces.curve).tolist() == [1]


def test_threads_change_no_byte_and_tables_keep_their_columns():
    ball = sphere(radius_mm=30.0, subdivisions=3)
    starts = scatter(ball, stream(3, "grow"), count=150)
    field = laid(ball, lambda p: np.cross([0.0, 0.2, 1.0], p) * 0.4)
    one, two = (grow(ball, starts, field, threads=threads) for threads in (1, 2))
    assert one.start.tobytes() == two.start.tobytes()
    assert one.face.tobytes() == two.face.tobytes()
    width = np.arange(one.curve_count, dtype=float)
    table = curve_table(ball, one, width_mm=width, depth_mm=0.2)
    assert (table["width_mm"] == table["curve"]).all()
    assert (table["depth_mm"] == 0.2).all()
    back = curve_pieces(ball, table)
    np.testing.assert_allclose(back.start, one.start, atol=1e-9)
    np.testing.assert_array_equal(back.curve, one.curve)


def test_mistakes_are_named():
    sheet = plane(10.0)
    start = at(sheet, [5, 5, 0])
    with pytest.raises(SurfaceError, match="at least 1"):
        grow(sheet, start, lambda p: np.ones((len(p), 2)), steps=0)
    with pytest.raises(SurfaceError, match="not finite"):
        grow(sheet, start, lambda p: np.full((len(p), 2), np.nan))
    with pytest.raises(SurfaceError, match="fall at 1 controls"):
        spline(sheet, at(sheet, [5, 5, 0], [6, 6, 0]), [1, 0])
    points, curve = grown_controls(sheet, start, lambda p: np.ones((len(p), 2)), steps=4)
    assert len(points) == len(curve) == 5
