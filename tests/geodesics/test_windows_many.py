"""Many sources: cells over large faces, bounds for the k nearest, and floods that do not fit."""

import numpy as np
import pytest

from surftex.errors import InputError, WorkError
from surftex.geodesics import bounds, flooding
from surftex.geodesics.bounds import nearest_bound
from surftex.geodesics.buckets import Buckets
from surftex.geodesics.distance import geodesic_distance
from surftex.geodesics.windows import flood_points, nearest, within
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import midpoint_subdivided, plane, sphere, torus
from surftex.surface.surface import Surface
from tests.oracles.geodesics import at_most, exact_distance, random_points, walk_bound

CUBE = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5],
        [3, 7, 5]]  # fmt: skip


def cube():
    """Twelve faces."""
    return Surface.from_arrays([[x, y, z] for z in (0, 10) for y in (0, 10) for x in (0, 10)], CUBE)


@pytest.mark.parametrize("shape", [cube(), plane(10.0, cells=1), torus()], ids=["cube", "square", "torus"])
def test_cells_change_nothing_but_the_work(shape):
    sources, targets = random_points(shape, 900, 1), random_points(shape, 3000, 2)
    radius = 2.0 * np.sqrt(shape.area_mm2 / 900)
    one = flood_points(shape, sources, radius, buckets=Buckets.of(shape))
    many = flood_points(shape, sources, radius)
    for a, b in zip(
        nearest(one, targets, 5, vectors=True), nearest(many, targets, 5, vectors=True), strict=True
    ):
        assert np.array_equal(a, b)
    for a, b in zip(within(one, targets), within(many, targets), strict=True):
        assert np.array_equal(a, b)
    tested = [np.diff(records.start)[records.buckets.find(targets)].mean() for records in (one, many)]
    if len(shape.faces) <= 12:
        assert len(many.buckets) > 200
        assert tested[1] < 70 < tested[0] / 1.5


@pytest.mark.parametrize("spread", [0.3, 2.0])
@pytest.mark.parametrize("k", [1, 3, 5])
@pytest.mark.parametrize(
    "shape", [cube(), sphere(10.0, subdivisions=1), torus()], ids=["cube", "ball", "torus"]
)
def test_the_sample_before_changes_no_answer(shape, k, spread):
    sources, points = random_points(shape, 300, 1), random_points(shape, 2000, 2)
    radius = spread * np.sqrt(shape.area_mm2 / 300) * np.random.default_rng(3).uniform(0.5, 1.5, 300)
    records = flood_points(shape, sources, radius)
    order = np.argsort(records.buckets.find(points), kind="stable")  # whole runs in one bucket
    points = SurfacePoints(points.face[order], points.barycentric[order])
    every = nearest(records, points, k)
    apart = np.argsort(np.random.default_rng(4).random(len(points)))
    mixed = nearest(records, SurfacePoints(points.face[apart], points.barycentric[apart]), k)
    for together, alone in zip(every, mixed, strict=True):
        assert np.array_equal(together[apart], alone)
    start, source, distance, _ = within(records, points)
    for i in range(0, len(points), 7):
        listed = distance[start[i] : start[i + 1]][:k]
        assert np.array_equal(every[1][i, : len(listed)], listed)
        assert np.array_equal(every[0][i, : len(listed)], source[start[i] : start[i + 1]][:k])
        assert np.isinf(every[1][i, len(listed) :]).all()


def test_of_sources_equally_far_the_lower_number_comes_first():
    shape = plane(10.0, cells=4)
    at = shape.vertices[shape.faces].mean(axis=1)
    sources = SurfacePoints(np.arange(len(shape.faces)), np.full((len(shape.faces), 3), 1 / 3))
    records = flood_points(shape, sources, 6.0)
    face = np.repeat(np.arange(len(shape.faces)), 40)
    share = np.random.default_rng(5).integers(0, 5, (len(face), 1)) / 4
    points = SurfacePoints(face, np.concatenate([0.5 * share, 0.5 * share, 1 - share], axis=1))
    source, distance = nearest(records, points, 5)
    apart = np.argsort(np.random.default_rng(6).random(len(points)))
    alone = nearest(records, SurfacePoints(points.face[apart], points.barycentric[apart]), 5)
    assert np.array_equal(alone[0], source[apart])
    tied = distance[:, 1:] == distance[:, :-1]
    assert tied.sum() > 100
    assert (source[:, 1:] > source[:, :-1])[tied].all()
    away = np.linalg.norm(points.positions(shape)[:, None] - at[source], axis=2)
    assert np.allclose(away, distance)


def test_every_point_finds_a_bucket_of_its_own_face():
    shape = cube()
    buckets = Buckets.of(shape, 0.7)
    points = random_points(shape, 5000, 3, margin=0.0)
    found = buckets.find(points)
    assert (found >= buckets.first[points.face]).all()
    assert (found < buckets.first[points.face + 1]).all()
    assert len(np.unique(found)) > 1300


@pytest.mark.parametrize("cell", [0.0, -1.0, np.nan])
def test_refuses_cells_without_size(cell):
    with pytest.raises(InputError, match="positive"):
        Buckets.of(cube(), cell)


@pytest.mark.parametrize("k", [1, 2, 5])
def test_a_bound_saves_rows_and_changes_no_answer(k):
    coarse = rough(torus(columns=30, rows=15))
    shape = Surface.from_arrays(*midpoint_subdivided(coarse.vertices, coarse.faces))
    sources, targets = random_points(shape, 250, 1), random_points(shape, 4000, 2)
    free = flood_points(shape, sources, 40.0)
    bounded = flood_points(shape, sources, 40.0, bound_mm=nearest_bound(shape, sources, k))
    assert len(bounded.row) < len(free.row) / 2
    one, two = nearest(free, targets, k), nearest(bounded, targets, k)
    assert np.array_equal(one[0], two[0])
    np.testing.assert_allclose(one[1], two[1], rtol=1e-9)


def rough(shape):
    moved = np.random.default_rng(1).normal(0, 0.4, shape.vertices.shape)
    return Surface.from_arrays(shape.vertices + moved, shape.faces)


SHAPES = {
    "cube": cube(),
    "rough torus": rough(torus(columns=20, rows=10)),
    "rough sheet": rough(plane(20.0, cells=9)),
    "two parts": Surface.from_arrays(
        np.vstack([cube().vertices, plane(9.0, cells=3).vertices + 50]),
        np.vstack([cube().faces, plane(9.0, cells=3).faces + 8]),
    ),
}


@pytest.mark.parametrize("k", [1, 2, 6])
@pytest.mark.parametrize("count", [1, 7, 150])
@pytest.mark.parametrize("name", SHAPES)
def test_bounds_are_those_of_the_shortest_walks(name, count, k):
    sources = random_points(SHAPES[name], count, 3)
    told, walked = nearest_bound(SHAPES[name], sources, k), walk_bound(SHAPES[name], sources, k)
    np.testing.assert_array_equal(np.isinf(told), np.isinf(walked))
    np.testing.assert_allclose(told, walked, rtol=1e-8)
    assert np.all(told >= walked)


def test_bounds_need_no_room_beforehand_and_no_order(monkeypatch):
    """Room that is too small is doubled; however far walks go on together, their lengths are the same."""
    shape = SHAPES["rough torus"]
    sources = random_points(shape, 40, 3)
    told = nearest_bound(shape, sources, 3)
    for step in (0.0, 0.1, 1e9):
        monkeypatch.setattr(bounds, "_STEP", step)
        np.testing.assert_array_equal(nearest_bound(shape, sources, 3), told)
    monkeypatch.setattr(bounds, "_room", lambda vertices, sources: 1)
    np.testing.assert_array_equal(nearest_bound(shape, sources, 3), told)


def test_more_windows_than_sound_meshes_send_are_an_error(monkeypatch):
    shape = sphere(subdivisions=3)
    monkeypatch.setattr(flooding, "MOST_WINDOWS", 100)
    with pytest.raises(WorkError, match="more than 100 windows"):
        flood_points(shape, random_points(shape, 1), np.inf)


def test_a_thousand_cells_on_one_face_keep_their_accuracy():
    shape = plane(1000.0, cells=1)
    rng = np.random.default_rng(0)
    share = 0.4 + 0.01 * rng.random((400, 2))
    points = SurfacePoints(np.zeros(400, int), np.column_stack([1 - share.sum(axis=1), share]))
    place = points.positions(shape)
    apart = np.sort(np.linalg.norm(place[:, None] - place[None], axis=2), axis=1)[:, :4]
    np.testing.assert_allclose(
        nearest(flood_points(shape, points, 2.0), points, 4)[1], apart, rtol=1e-7, atol=1e-8
    )


def test_distance_takes_the_nearest_source_and_stops_at_the_radius():
    shape = torus()
    sources, targets = random_points(shape, 3, 1), random_points(shape, 80, 2)
    truth = np.min([exact_distance(shape, at_most(sources, i), targets) for i in range(3)], axis=0)
    np.testing.assert_allclose(geodesic_distance(shape, sources, targets), truth, rtol=1e-9)
    near = geodesic_distance(shape, sources, targets, 15.0)
    assert np.array_equal(np.isfinite(near), truth <= 15.0)
    np.testing.assert_allclose(near[truth <= 15.0], truth[truth <= 15.0], rtol=1e-9)
    assert (near[truth > 15.0] == np.inf).all()


@pytest.mark.parametrize("method", ["auto", "exact", "heat"])
def test_no_path_leads_to_another_component(method):
    ball = sphere(10.0, subdivisions=2)
    there = ball.vertices + np.array([30.0, 0.0, 0.0])
    faces = np.concatenate([ball.faces, ball.faces + len(ball.vertices)])
    two = Surface.from_arrays(np.concatenate([ball.vertices, there]), faces)
    source = SurfacePoints([5], [[0.3, 0.3, 0.4]])
    at = SurfacePoints([9, 9 + len(ball.faces)], [[0.2, 0.3, 0.5]] * 2)
    near, far = geodesic_distance(two, source, at, method=method)
    assert 0 < near < 40
    assert far == np.inf


def test_distance_refuses_what_makes_no_sense():
    shape = plane(cells=2)
    point = SurfacePoints([0], [[0.3, 0.3, 0.4]])
    nobody = SurfacePoints(np.zeros(0, int), np.zeros((0, 3)))
    with pytest.raises(InputError, match="no sources"):
        geodesic_distance(shape, nobody, point)
    with pytest.raises(InputError, match="radius"):
        geodesic_distance(shape, point, point, -1.0)
    with pytest.raises(InputError, match="'exact' or 'heat'"):
        geodesic_distance(shape, point, point, method="best")  # type: ignore[arg-type]


@pytest.mark.parametrize("threads", [1, 2])
def test_rows_do_not_depend_on_the_blocks_they_are_found_in(monkeypatch, threads):
    shape = torus()
    sources = random_points(shape, 600, 8)
    whole = flood_points(shape, sources, 12.0)
    monkeypatch.setattr(flooding, "_FEW_ROWS", 16)  # less than one source finds
    monkeypatch.setattr(flooding, "_MANY_ROWS", 2048)
    pieced = flood_points(shape, sources, 12.0, threads=threads)
    assert len(whole.row) > 20 * 2048
    for name in ("row", "row_id", "start", "entry_row", "entry_least_mm"):
        assert np.array_equal(getattr(whole, name), getattr(pieced, name)), name
