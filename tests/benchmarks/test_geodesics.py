"""How the work of floods and gathers grows: three sizes each, the exponent read and asserted loosely."""

import numpy as np
import pytest

from surftex.features.through import curves_through
from surftex.geodesics.bounds import nearest_bound
from surftex.geodesics.curves import flood_curves, nearest_curves
from surftex.geodesics.directions import DirectionField
from surftex.geodesics.tracing import trace
from surftex.geodesics.windows import flood_points, nearest
from surftex.surface.shapes import sphere
from surftex.surface.surface import Surface
from tests.benchmarks.growth import exponent
from tests.oracles.geodesics import random_points

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def ball():
    surface = sphere(40.0, subdivisions=5)
    sources = random_points(surface, 50, 0)
    nearest(flood_points(surface, sources, 5.0, bound_mm=nearest_bound(surface, sources, 2)), sources, 2)
    return surface


def test_gather_grows_with_the_samples(ball):
    records = flood_points(ball, random_points(ball, 2000, 1), 6.0)
    points = {size: random_points(ball, size, 2) for size in (100_000, 300_000, 900_000)}
    assert exponent(lambda size: nearest(records, points[size], 2, threads=1), list(points)) < 1.25


def test_flood_for_the_two_nearest_grows_slower_than_the_sources(ball):
    sources = {size: random_points(ball, size, 3) for size in (1000, 4000, 16_000)}

    def work(size):
        bound = nearest_bound(ball, sources[size], 2)
        flood_points(ball, sources[size], 40.0, bound_mm=bound, threads=1)

    assert exponent(work, list(sources)) < 0.9


def test_flood_grows_with_the_area_it_covers(ball):
    sources = random_points(ball, 20, 4)
    assert exponent(lambda radius: flood_points(ball, sources, radius, threads=1), [8.0, 16.0, 32.0]) < 3.3


@pytest.mark.parametrize("count", [500, 2000, 8000])
def test_flood(benchmark, ball, count):
    sources = random_points(ball, count, 5)
    benchmark(flood_points, ball, sources, 4.0, threads=1)


@pytest.mark.parametrize("count", [30_000, 100_000, 300_000])
def test_nearest(benchmark, ball, count):
    records = flood_points(ball, random_points(ball, 2000, 6), 6.0)
    benchmark(nearest, records, random_points(ball, count, 7), 2, threads=1)


@pytest.fixture(scope="module")
def lines(ball):
    return trace(ball, random_points(ball, 200, 8), np.linspace(0, 6, 200), 25.0).pieces


def test_gather_of_the_nearest_curves_grows_with_the_samples(ball, lines):
    records = flood_curves(ball, lines, 2.0)
    points = {size: random_points(ball, size, 9) for size in (100_000, 300_000, 900_000)}
    assert exponent(lambda size: nearest_curves(records, points[size], 3, threads=1), list(points)) < 1.25


@pytest.mark.parametrize("count", [30_000, 100_000, 300_000])
def test_nearest_curves(benchmark, ball, lines, count):
    records = flood_curves(ball, lines, 2.0)
    benchmark(nearest_curves, records, random_points(ball, count, 10), 3, threads=1)


@pytest.mark.parametrize("count", [50, 200, 800])
def test_curves_through(benchmark, ball, count):
    walks = trace(ball, random_points(ball, count, 11), np.linspace(0, 6, count), 20.0)
    points = walks.pieces.points(ball, 0.5)
    benchmark(curves_through, ball, points, walks.pieces.curve, chord_mm=np.full(count, 1.0), threads=1)


@pytest.fixture(scope="module")
def bumpy():
    """Balls without symmetry, by their subdivisions."""
    result = {}
    for subdivisions in (4, 5, 6):
        even = sphere(40.0, subdivisions=subdivisions)
        x, y, z = even.vertices.T / 40
        swell = 1 + 0.2 * np.sin(3 * x + 1) + 0.15 * np.cos(2 * y - z) + 0.1 * z**3
        result[subdivisions] = Surface.from_arrays(even.vertices * swell[:, None], even.faces)
        DirectionField.smoothest(result[subdivisions], 2)  # what the surface keeps is not asked again
    return result


def test_smoothest_field_grows_with_the_faces(bumpy):
    by_faces = {len(shape.faces): shape for shape in bumpy.values()}
    assert exponent(lambda faces: DirectionField.smoothest(by_faces[faces], 2), list(by_faces)) < 1.2


@pytest.mark.parametrize("subdivisions", [4, 5, 6])
def test_smoothest_field(benchmark, bumpy, subdivisions):
    benchmark(DirectionField.smoothest, bumpy[subdivisions], 2)
