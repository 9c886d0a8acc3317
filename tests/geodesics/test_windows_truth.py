"""Exact windows against closed forms: prisms unrolled, cones, saddles, spheres, and hard meshes."""

import numpy as np
import pytest

from surftex.geodesics.windows import flood_points, nearest, within
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import cylinder, midpoint_subdivided, plane, sphere, torus
from surftex.surface.surface import Surface
from tests.oracles.geodesics import at_most, exact_distance, random_points


def distances(surface, sources, targets, radius=np.inf):
    """(targets, sources) mm."""
    start, source, distance, _ = within(flood_points(surface, sources, radius), targets)
    result = np.full((len(targets), len(sources)), np.inf)
    result[np.repeat(np.arange(len(targets)), np.diff(start)), source] = distance
    return result


def fan(latitude, *, zigzag, count=12):
    """Triangles around an apex at the origin, corners at distance 1; and the angle of each at the apex."""
    longitude = np.arange(count) * 2 * np.pi / count
    tilt = latitude * (np.where(np.arange(count) % 2, -1, 1) if zigzag else 1)
    ring = np.stack(
        [np.cos(tilt) * np.cos(longitude), np.cos(tilt) * np.sin(longitude), np.sin(tilt) + 0 * longitude], 1
    )
    faces = [[0, 1 + i, 1 + (i + 1) % count] for i in range(count)]
    return Surface.from_arrays(np.vstack([np.zeros(3), ring]), faces), float(np.arccos(ring[0] @ ring[1]))


def polar(shape, points, angle):
    """Distance from the apex and angle around it."""
    place = points.flat(shape)
    return np.hypot(*place.T), points.face * angle + np.arctan2(place[:, 1], place[:, 0])


@pytest.mark.parametrize(("latitude", "zigzag"), [(0.9, False), (0.3, False), (0.35, True), (0.8, True)])
def test_around_a_cone_and_a_saddle_distances_unroll(latitude, zigzag):
    shape, angle = fan(latitude, zigzag=zigzag)
    rng = np.random.default_rng(1)
    face = rng.integers(0, 12, 80)
    share = rng.uniform(0.02, 0.3, (80, 2))
    points = SurfacePoints(face, np.column_stack([1 - share.sum(axis=1), share]))
    radius, around = polar(shape, points, angle)
    total = 12 * angle
    assert (total > 2 * np.pi) == zigzag
    apart = np.abs(around[:, None] - around[None])
    apart = np.minimum(apart, total - apart)
    a, b = radius[:, None], radius[None]
    straight = np.sqrt(np.maximum(a**2 + b**2 - 2 * a * b * np.cos(np.minimum(apart, np.pi)), 0))
    np.testing.assert_allclose(distances(shape, points, points), straight, rtol=1e-9, atol=1e-10)
    assert (apart > np.pi).any() == zigzag


def test_a_prism_unrolls():
    shape = cylinder(20.0, 60.0, columns=17, rows=9)
    sources, targets = random_points(shape, 15, 1), random_points(shape, 200, 2)
    chord = 2 * 20.0 * np.sin(np.pi / 17)

    def unrolled(points):
        place = points.positions(shape)
        side = np.floor(np.mod(np.arctan2(place[:, 1], place[:, 0]), 2 * np.pi) / (2 * np.pi / 17))
        turn = side * 2 * np.pi / 17
        begin = 20.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        return side * chord + np.linalg.norm(place[:, :2] - begin, axis=1), place[:, 2]

    (s, z), (t, w) = unrolled(sources), unrolled(targets)
    around = np.abs(t[:, None] - s[None])
    around = np.minimum(around, 17 * chord - around)
    truth = np.hypot(around, w[:, None] - z[None])
    np.testing.assert_allclose(distances(shape, sources, targets), truth, rtol=1e-9)


def test_a_sphere_is_met_at_second_order():
    edge, worst = [], []
    for subdivisions in (2, 3, 4):
        ball = sphere(40.0, subdivisions=subdivisions)
        sources, targets = random_points(ball, 3, 1), random_points(ball, 400, 2)
        a, b = sources.positions(ball), targets.positions(ball)
        cosine = (b @ a.T) / np.linalg.norm(b, axis=1)[:, None] / np.linalg.norm(a, axis=1)
        great_circle = 40.0 * np.arccos(np.clip(cosine, -1, 1))
        worst.append(np.abs(distances(ball, sources, targets) - great_circle).max())
        edge.append(ball.mean_edge_mm)
    order = np.polyfit(np.log(edge), np.log(worst), 1)[0]
    assert order == pytest.approx(2.0, abs=0.25)
    assert worst[-1] < 0.25


def test_tangent_vectors_on_a_plane_are_displacements():
    shape = plane(10.0, cells=6)
    sources, targets = random_points(shape, 12, 3), random_points(shape, 150, 4)
    source, distance, vector = nearest(flood_points(shape, sources, 20.0), targets, 12, vectors=True)
    np.testing.assert_allclose(np.linalg.norm(vector, axis=2), distance, rtol=1e-12)
    frame = shape.frame[sources.face[source]]
    lifted = vector[..., :1] * frame[:, :, 0] + vector[..., 1:] * frame[:, :, 1]
    truth = targets.positions(shape)[:, None] - sources.positions(shape)[source]
    np.testing.assert_allclose(lifted, truth, atol=1e-8)


def test_behind_a_saddle_tangent_vectors_point_at_it():
    shape, angle = fan(0.8, zigzag=True)
    points = SurfacePoints([0, 6], [[0.6, 0.2, 0.2], [0.5, 0.25, 0.25]])
    assert 5 * angle > np.pi
    _, distance, vector = nearest(flood_points(shape, points, np.inf), at_most(points, 1), 2, vectors=True)
    apex = -points.flat(shape)[0]
    np.testing.assert_allclose(vector[0, 1], apex / np.hypot(*apex) * distance[0, 1], rtol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_paths_along_straight_chains_of_corners_are_not_lost(seed):
    rng = np.random.default_rng(seed)
    rough = torus(columns=18, rows=9)
    rough = Surface.from_arrays(rough.vertices + rng.normal(0, 1.0, rough.vertices.shape), rough.faces)
    fine = Surface.from_arrays(*midpoint_subdivided(*midpoint_subdivided(rough.vertices, rough.faces)))
    sources, targets = random_points(fine, 3, seed), random_points(fine, 150, seed + 9)
    truth = np.stack([exact_distance(fine, at_most(sources, i), targets) for i in range(3)], axis=1)
    np.testing.assert_allclose(distances(fine, sources, targets), truth, rtol=1e-9)


def test_flat_parts_send_one_window_through_an_edge():
    coarse, fine = plane(10.0, cells=2), plane(10.0, cells=16)
    sources = random_points(fine, 5, 0)
    rows = len(flood_points(fine, sources, np.inf).row)
    assert rows < 2.5 * 5 * len(fine.faces)
    assert len(coarse.faces) < len(fine.faces)


@pytest.mark.parametrize("scale", [1e-8, 1e8])
def test_size_does_not_matter(scale):
    shape = torus(columns=20, rows=10)
    scaled = Surface.from_arrays(shape.vertices * scale, shape.faces)
    sources, targets = random_points(shape, 10, 1), random_points(shape, 100, 2)
    here, there = distances(shape, sources, targets, 30.0), distances(scaled, sources, targets, 30.0 * scale)
    inside = np.isfinite(here)
    assert np.array_equal(inside, np.isfinite(there))
    np.testing.assert_allclose(there[inside], scale * here[inside], rtol=1e-11)


def test_slivers_and_crowded_corners_are_flat_too():
    rng = np.random.default_rng(0)
    turn = np.sort(rng.uniform(0, 2 * np.pi, 500))
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    hub = Surface.from_arrays(
        np.vstack([np.zeros(3), ring]), [[0, 1 + i, 1 + (i + 1) % 500] for i in range(500)]
    )
    thin = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 1e-7, 0.0], [0.5, 2e-7, 0]], float)
    needles = Surface.from_arrays(thin, [[0, 1, 4], [4, 1, 5], [0, 4, 5], [5, 1, 2], [5, 2, 3], [0, 5, 3]])
    for shape in (hub, needles):
        points = random_points(shape, 60, 1)
        place = points.positions(shape)
        truth = np.linalg.norm(place[:, None] - place[None], axis=2)
        np.testing.assert_allclose(distances(shape, points, points), truth, rtol=1e-7, atol=1e-9)


def test_around_a_hole_paths_bend_at_its_corners():
    shape = plane(9.0, cells=9)
    middle = shape.vertices[shape.faces].mean(axis=1)
    outside = ~((np.abs(middle[:, 0] - 4.5) < 1.5) & (np.abs(middle[:, 1] - 4.5) < 1.5))
    shape = Surface.from_arrays(shape.vertices, shape.faces[outside])
    sources, targets = random_points(shape, 4, 2), random_points(shape, 60, 3)
    truth = np.stack([exact_distance(shape, at_most(sources, i), targets) for i in range(4)], axis=1)
    found = distances(shape, sources, targets)
    np.testing.assert_allclose(found, truth, rtol=1e-9)
    straight = np.linalg.norm(targets.positions(shape)[:, None] - sources.positions(shape)[None], axis=2)
    assert (found > straight * (1 + 1e-6)).sum() > 20


def test_a_moebius_band_cut_open_keeps_its_cut():
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 41), np.linspace(-1, 1, 5), indexing="ij")
    away = 3 + v * np.cos(u / 2)
    band = np.stack([away * np.cos(u), away * np.sin(u), v * np.sin(u / 2)], axis=-1).reshape(-1, 3)
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(40), np.arange(4), indexing="ij"))
    a, b, c, d = 5 * i + j, 5 * i + j + 5, 5 * i + j + 6, 5 * i + j + 1
    shape = Surface.from_arrays(band, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))
    sources, targets = random_points(shape, 3, 1), random_points(shape, 60, 2)
    truth = np.stack([exact_distance(shape, at_most(sources, i), targets) for i in range(3)], axis=1)
    np.testing.assert_allclose(distances(shape, sources, targets), truth, rtol=1e-9)
    assert truth.max() > 12


def test_sources_on_edges_and_corners_see_all_around():
    shape = torus(columns=24, rows=12)
    on_corner = SurfacePoints([7, 7, 40], [[1, 0, 0], [0.5, 0.5, 0], [0, 0, 1]])
    targets = random_points(shape, 200, 2)
    just_inside = SurfacePoints(
        [7, 7, 40], [[1 - 2e-7, 1e-7, 1e-7], [0.5, 0.5 - 1e-7, 1e-7], [1e-7, 1e-7, 1 - 2e-7]]
    )
    truth = np.stack([exact_distance(shape, at_most(just_inside, i), targets) for i in range(3)], axis=1)
    np.testing.assert_allclose(distances(shape, on_corner, targets), truth, rtol=1e-5, atol=1e-5)
