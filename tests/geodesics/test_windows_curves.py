"""Distances to curves: closed forms in the plane, dense points on rough surfaces, ends, bends and sides."""

import numpy as np
import pytest

from surftex.errors import InputError, SurfaceError
from surftex.geodesics.buckets import Buckets
from surftex.geodesics.curves import flood_curves, nearest_curve, nearest_curves
from surftex.geodesics.pieces import CurvePieces
from surftex.geodesics.tracing import trace
from surftex.geodesics.windows import flood_points, nearest
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import midpoint_subdivided, plane, torus
from surftex.surface.surface import Surface
from tests.oracles.geodesics import distance_to_polyline, pieces_of_plane_polyline, random_points


@pytest.mark.parametrize("cells", [1, 4, 9])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_distance_to_a_polyline_on_a_plane(cells, seed):
    shape = plane(10.0, cells=cells)
    turns = np.random.default_rng(seed).uniform(1, 9, (5, 2))
    pieces = pieces_of_plane_polyline(shape, turns)
    targets = random_points(shape, 2000, seed)
    piece, distance, along, _ = nearest_curve(flood_curves(shape, pieces, 20.0), targets)
    truth, truth_along = distance_to_polyline(turns, targets.positions(shape)[:, :2])
    np.testing.assert_allclose(distance, truth, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(along, truth_along, atol=1e-6)
    assert (pieces.curve[piece] == 0).all()
    inside = (along >= pieces.start_mm[piece] - 1e-8) & (
        along <= pieces.start_mm[piece] + pieces.length_mm[piece] + 1e-8
    )
    assert inside.all()


def test_sides_of_a_straight_curve_and_beyond_its_ends():
    shape = plane(10.0, cells=6)
    pieces = pieces_of_plane_polyline(shape, np.array([[2.1, 3.3], [7.7, 6.4]]))
    targets = random_points(shape, 1500, 1)
    _, distance, along, side = nearest_curve(flood_curves(shape, pieces, 3.0), targets)
    offset = targets.positions(shape)[:, :2] - [2.1, 3.3]
    truth = np.sign(5.6 * offset[:, 1] - 3.1 * offset[:, 0])
    reached = np.isfinite(distance)
    assert np.array_equal(side[reached], truth[reached])
    assert (side[~reached] == 0).all()
    assert (along[~reached] == 0).all()
    assert 0.2 < reached.mean() < 0.9


def rough():
    """A torus with dents, its faces cut in four."""
    shape = torus(columns=20, rows=10)
    dents = np.random.default_rng(3).normal(0, 1.0, shape.vertices.shape)
    return Surface.from_arrays(*midpoint_subdivided(shape.vertices + dents, shape.faces))


def test_behind_saddles_distance_is_that_to_dense_points_on_the_curve():
    shape = rough()
    pieces = trace(shape, random_points(shape, 4, 5), np.array([0.3, 1.7, 2.9, 4.4]), 40.0).pieces
    targets = random_points(shape, 1500, 6)
    piece, distance, along, side = nearest_curve(flood_curves(shape, pieces, 25.0), targets)
    share = np.linspace(0, 1, 60)
    step = pieces.length_mm.max() / 59
    dense = [pieces.points(shape, s) for s in share]
    points = SurfacePoints(
        np.concatenate([d.face for d in dense]), np.concatenate([d.barycentric for d in dense])
    )
    source, truth = (a[:, 0] for a in nearest(flood_points(shape, points, 25.0), targets, 1))
    inside = np.isfinite(distance)
    assert inside.mean() > 0.5
    assert np.isfinite(truth[~inside]).sum() == 0
    assert (truth[inside] >= distance[inside] - 1e-8).all()
    near_end = np.hypot(distance[inside], 0.6 * step)
    assert (truth[inside] <= near_end + 1e-8).all()
    same = inside & (pieces.curve[piece] == pieces.curve[source % len(pieces)])
    dense_along = (
        pieces.start_mm[source % len(pieces)]
        + share[source // len(pieces)] * pieces.length_mm[source % len(pieces)]
    )
    assert np.median(np.abs(along - dense_along)[same]) < step
    assert set(np.unique(side[inside])) == {-1, 1}


def test_numbering_and_threads_leave_distances_alone():
    shape = rough()
    pieces = trace(shape, random_points(shape, 300, 5), np.linspace(0, 6, 300), 6.0).pieces
    targets = random_points(shape, 3000, 6)
    one = nearest_curve(flood_curves(shape, pieces, 4.0, threads=1), targets, threads=1)
    two = nearest_curve(flood_curves(shape, pieces, 4.0, threads=2), targets, threads=2)
    for a, b in zip(one, two, strict=True):
        assert np.array_equal(a, b)
    halves = [pieces.selected(np.arange(0, 150)), pieces.selected(np.arange(150, 300))]
    apart = np.minimum(*(nearest_curve(flood_curves(shape, half, 4.0), targets)[1] for half in halves))
    assert np.array_equal(apart, one[1])


def test_the_nearest_curves_are_those_of_each_curve_alone():
    shape = rough()
    pieces = trace(shape, random_points(shape, 12, 5), np.linspace(0, 6, 12), 30.0).pieces
    targets = random_points(shape, 3000, 6)
    piece, distance, along, side = nearest_curves(flood_curves(shape, pieces, 12.0), targets, 3)
    alone = [nearest_curve(flood_curves(shape, pieces.selected([c]), 12.0), targets) for c in range(12)]
    order = np.argsort([found[1] for found in alone], axis=0, kind="stable")[:3].T
    each = np.arange(len(targets))
    for rank in range(3):
        truth = [np.array([found[i] for found in alone])[order[:, rank], each] for i in range(4)]
        assert np.array_equal(distance[:, rank], truth[1])
        reached = np.isfinite(truth[1])
        assert 0.05 < reached.mean() < 1
        assert np.array_equal(pieces.curve[piece[reached, rank]], order[reached, rank])
        np.testing.assert_allclose(along[reached, rank], truth[2][reached], atol=1e-9)
        assert np.array_equal(side[:, rank], truth[3])
        assert (piece[~reached, rank] == -1).all()
    with pytest.raises(InputError, match="k is 0"):
        nearest_curves(flood_curves(shape, pieces, 1.0), targets, 0)


def test_a_curve_without_length_is_a_point():
    shape = plane(10.0, cells=5)
    where = random_points(shape, 3, 1)
    place = where.flat(shape)
    targets = random_points(shape, 200, 2)
    pieces = CurvePieces.of(where.face, place, place, [0, 1, 2])
    found = nearest_curve(flood_curves(shape, pieces, 20.0), targets)[1]
    np.testing.assert_allclose(
        found, nearest(flood_points(shape, where, 20.0), targets, 1)[1][:, 0], rtol=1e-12
    )


def test_no_curves_reach_nothing_and_faces_are_checked():
    shape = plane(cells=2)
    records = flood_curves(shape, CurvePieces.joined([]), 1.0)
    piece, distance, _, side = nearest_curve(records, random_points(shape, 4))
    assert (piece == -1).all()
    assert np.isinf(distance).all()
    assert (side == 0).all()
    with pytest.raises(SurfaceError, match="1 of 1 pieces lie on faces outside"):
        flood_curves(shape, CurvePieces.of([99], [[0, 0]], [[1, 0]], [0]), 1.0)


@pytest.mark.parametrize("cell_mm", [0.5, 50.0])
def test_faces_that_a_curve_reaches_are_those_on_which_it_is_found(cell_mm):
    shape = rough()
    pieces = trace(shape, random_points(shape, 4, 5), np.array([0.3, 1.7, 2.9, 4.4]), 40.0).pieces
    records = flood_curves(shape, pieces, 2.0, buckets=Buckets.of(shape, cell_mm))
    targets = random_points(shape, 60_000, 7)
    found = nearest_curve(records, targets)[0] >= 0
    assert records.reached[targets.face[found]].all()
    seen = np.bincount(targets.face, found, len(shape.faces)) > 0
    assert 0.02 < (records.reached & seen).sum() / len(shape.faces) < 0.5
    assert (records.reached & ~seen).sum() < 0.2 * seen.sum()
