"""Exact windows against libigl's exact geodesics, closed forms, and their own promises."""

import numpy as np
import pytest

from surftex.errors import InputError, SurfaceError
from surftex.geodesics.windows import flood_points, nearest, within
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import cylinder, plane, sphere, torus
from surftex.surface.surface import Surface
from tests.oracles.geodesics import at_most, exact_distance, random_points


def table(records, points, sources):
    """(points, sources) mm from `within`."""
    start, source, distance, _ = within(records, points)
    result = np.full((len(points), sources), np.inf)
    result[np.repeat(np.arange(len(points)), np.diff(start)), source] = distance
    return result


@pytest.mark.parametrize(
    "shape", [sphere(subdivisions=2), torus(columns=36, rows=18), cylinder(columns=24, rows=12)]
)
def test_distances_are_those_of_exact_geodesics_and_nothing_is_missed(shape):
    sources, targets = random_points(shape, 4, 1), random_points(shape, 50, 2)
    truth = np.stack([exact_distance(shape, at_most(sources, i), targets) for i in range(4)], axis=1)
    for radius in (3 * shape.mean_edge_mm, np.inf):
        found = table(flood_points(shape, sources, radius), targets, 4)
        assert np.array_equal(np.isfinite(found), truth <= radius)
        inside = np.isfinite(found)
        assert inside.sum() > 3
        np.testing.assert_allclose(found[inside], truth[inside], rtol=1e-12)


def test_nearest_orders_what_within_lists():
    shape = torus()
    sources, targets = random_points(shape, 200, 3), random_points(shape, 500, 4)
    records = flood_points(shape, sources, 12.0)
    source, distance = nearest(records, targets, 4)
    everything = table(records, targets, 200)
    assert np.array_equal(distance, np.sort(everything, axis=1)[:, :4])
    known = source >= 0
    assert np.array_equal(everything[np.nonzero(known)[0], source[known]], distance[known])
    assert (~known == np.isinf(distance)).all()
    assert known.mean() > 0.5


def test_distance_on_a_plane_is_straight():
    shape = plane(10.0, cells=7)
    sources, targets = random_points(shape, 20, 5), random_points(shape, 300, 6)
    truth = np.linalg.norm(targets.positions(shape)[:, None] - sources.positions(shape)[None], axis=2)
    np.testing.assert_allclose(table(flood_points(shape, sources, np.inf), targets, 20), truth, rtol=1e-9)


def test_refuses_what_it_cannot_flood():
    shape = plane(cells=1)
    inside = SurfacePoints([0], [[0.2, 0.3, 0.5]])
    with pytest.raises(InputError, match="not positive"):
        flood_points(shape, inside, 0.0)
    with pytest.raises(SurfaceError, match="outside"):
        flood_points(shape, SurfacePoints([2], [[0.2, 0.3, 0.5]]), 1.0)
    with pytest.raises(InputError, match="at least 1"):
        nearest(flood_points(shape, inside, 1.0), inside, 0)


def test_no_sources_reach_nothing():
    shape = plane(cells=2)
    nobody = SurfacePoints(np.zeros(0, int), np.zeros((0, 3)))
    records = flood_points(shape, nobody, 1.0)
    source, distance, vector = nearest(records, random_points(shape, 5), 2, vectors=True)
    assert (source == -1).all()
    assert np.isinf(distance).all()
    assert (vector == 0).all()
    assert within(records, random_points(shape, 5))[0][-1] == 0


def test_one_thread_or_two_the_same_bytes():
    shape = torus()
    sources, targets = random_points(shape, 700, 3), random_points(shape, 70_000, 4)
    results = []
    for threads in (1, 2):
        records = flood_points(shape, sources, 6.0, threads=threads)
        results.append(
            (
                records.row,
                records.row_id,
                records.entry_row,
                *nearest(records, targets, 3, vectors=True, threads=threads),
            )
        )
    for one, two in zip(*results, strict=True):
        assert np.array_equal(one, two)


def test_neither_a_rigid_motion_nor_renumbering_changes_distances():
    shape = torus(columns=24, rows=12)
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    vertex, face = rng.permutation(len(shape.vertices)), rng.permutation(len(shape.faces))
    moved = np.zeros_like(shape.vertices)
    moved[vertex] = shape.vertices @ turn.T + [5.0, -3.0, 100.0]
    spin = rng.integers(0, 3, len(face))
    columns = (np.arange(3) + spin[:, None]) % 3
    faces = np.take_along_axis(vertex[shape.faces][face], columns, axis=1)
    other = Surface.from_arrays(moved, faces)
    new_face = np.argsort(face)

    def carried(points):
        return SurfacePoints(
            new_face[points.face],
            np.take_along_axis(points.barycentric, columns[new_face[points.face]], axis=1),
        )

    sources, targets = random_points(shape, 30, 1), random_points(shape, 200, 2)
    here = table(flood_points(shape, sources, 25.0), targets, 30)
    there = table(flood_points(other, carried(sources), 25.0), carried(targets), 30)
    assert np.array_equal(np.isfinite(here), np.isfinite(there))
    inside = np.isfinite(here)
    np.testing.assert_allclose(here[inside], there[inside], rtol=1e-11)


def test_what_is_no_surface_and_no_points_is_told_by_name():
    from surftex.geodesics.distance import geodesic_distance

    ball = sphere(20.0, subdivisions=2)
    points = SurfacePoints(np.zeros(1, np.int32), np.full((1, 3), 1 / 3))
    for surface, sources, at, said in (
        (ball.vertices, points, points, "surface is an array; make a Surface of it"),
        (ball, ball.vertices, points, "sources is an array; it takes SurfacePoints"),
        (ball, points, None, "at is None; it takes SurfacePoints"),
    ):
        with pytest.raises(InputError, match=said):
            geodesic_distance(surface, sources, at)
