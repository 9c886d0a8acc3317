"""Growing particles: births by their law, forces as their twin has them, packed in the end, the same for any threads."""

import numpy as np
import pytest

from surftex.errors import InputError
from surftex.features.growth_law import GrowthLaw
from surftex.features.growth_plane import PlaneGround
from surftex.features.growth_surface import SurfaceGround
from surftex.features.particle_growth import SLICE, Particles, grow, near_lists
from surftex.kernels.particles import plane_forces
from surftex.materials.cells.model import Cells
from surftex.randomness import stream
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import plane, sphere
from tests.oracles.particles import accelerations

LAW = Cells().law
BIRTHS = stream(5, "births")


def grown(ground, law=LAW, **options):
    return grow(ground, law, BIRTHS, **options)


def test_births_follow_the_double_exponential():
    rate = [LAW.rate(g) for g in range(300)]
    assert rate[0] == pytest.approx(1, abs=0.01)
    assert LAW.rate(int(LAW.births_end)) == pytest.approx(np.exp(-1))
    assert sum(rate) * LAW.births * 100 == pytest.approx(LAW.total_births(100), rel=0.02)
    numbers = [LAW.born(g, 100.0) for g in range(300)]
    assert all(numbers[g][1] == numbers[g + 1][0] for g in range(299))  # no birth is lost or told twice
    assert numbers[-1][1] == pytest.approx(LAW.total_births(100), rel=0.02)


@pytest.mark.parametrize("pull", [0.0, 0.6])
def test_forces_are_those_of_the_twin(pull):
    numbers = stream(1, "test").uniform(40, 9)
    side, law = 5.0, np.array([1.4, pull, 0.03, 1.2])
    place = np.concatenate([side * numbers[:, :2], 1.2 * numbers[:, 2:3]], axis=1)
    velocity, push = numbers[:, 3:6] - 0.5, np.concatenate([numbers[:, 6:8] - 0.5, np.zeros((40, 1))], axis=1)
    radius, scale = 0.3 + 0.3 * numbers[:, 8], np.ones(40)
    aspect, axis = np.ones(40), np.tile([1.0, 0.0], (40, 1))
    everyone = np.array([[j for j in range(40) if j != i] for i in range(40)], np.int32)
    found = np.zeros((40, 3))
    plane_forces(
        0, 40, place, velocity, radius, aspect, axis, scale, push, everyone, np.full(40, 39), side, law, found
    )
    np.testing.assert_allclose(
        found, accelerations(place, velocity, radius, scale, push, side, law), atol=1e-12
    )


def test_neighbours_are_all_pairs_within_reach():
    numbers = stream(2, "test").uniform(500, 4)
    position, size = 6 * numbers[:, :3], 0.1 + 0.3 * numbers[:, 3]
    near = near_lists(position, np.arange(500), 500, size, 1.5, 0.05, 2)
    distance = np.linalg.norm(position[:, None] - position[None], axis=2)
    expected = distance < 1.5 * (size[:, None] + size[None]) + 0.05
    np.fill_diagonal(expected, False)
    for i in range(500):
        assert sorted(near.index[i, : near.count[i]]) == list(np.flatnonzero(expected[i]))


def test_a_growth_ends_packed_between_floor_and_ceiling():
    particles = grown(PlaneGround(12.0, 1.0))
    radius = particles.radius(LAW)
    assert 200 < len(particles) < 400
    assert (particles.place >= 0).all()
    assert (particles.place < 12).all()
    assert particles.height.min() > 0
    assert (particles.height + 0.5 * radius).max() < 1.3 * LAW.ceiling
    near = PlaneGround(12.0, 1.0).neighbours(particles, radius, 1.0, 0.0, None)
    row = np.arange(near.index.shape[1])[None] < near.count[:, None]
    first, second = np.nonzero(row)[0], near.index[row]
    step = particles.place[first] - particles.place[second]
    step -= 12 * np.round(step / 12)
    apart = np.sqrt((step**2).sum(axis=1) + (particles.height[first] - particles.height[second]) ** 2)
    overlap = 1 - apart / (radius[first] + radius[second])
    assert np.median(overlap) < 0.35
    assert near.count.min() >= 1
    assert np.linalg.norm(particles.velocity, axis=1).max() < 0.3  # it has come to rest


def test_threads_change_no_byte_and_a_growth_goes_on_where_it_was():
    ground = PlaneGround(80.0, 1.0)
    law = GrowthLaw(**{**LAW.__dict__, "generations": 30})
    one, two = grown(ground, law, threads=1), grown(ground, law, threads=2)
    assert len(one) > SLICE
    half = grown(ground, law, until=17)
    on = grown(ground, law, start=half)
    for name in ("place", "height", "velocity", "diameter", "born"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
        np.testing.assert_array_equal(getattr(one, name), getattr(on, name))


def test_too_many_births_are_refused_before_any():
    with pytest.raises(InputError, match="would be born, more than the 1000 allowed"):
        grown(PlaneGround(1000.0, 1.0), most=1000)


def test_particles_never_push_through_a_thin_part():
    surface = sphere(10.0, subdivisions=3)
    inner = sphere(9.8, subdivisions=3)
    from surftex.surface.surface import Surface

    shell = Surface.from_arrays(
        np.concatenate([surface.vertices, inner.vertices]),
        np.concatenate([surface.faces, inner.faces[:, ::-1] + len(surface.vertices)]),
    )
    ground = SurfaceGround(shell, 2.0)
    particles = grown(ground, GrowthLaw(**{**LAW.__dict__, "generations": 40}))
    outside = particles.face < len(surface.faces)
    assert 0 < outside.sum() < len(particles)
    near = ground.neighbours(particles, particles.radius(LAW), 1.0, 0.1, None)
    for i in range(len(particles)):
        assert (outside[near.index[i, : near.count[i]]] == outside[i]).all()


def test_particles_stay_on_a_surface_with_borders():
    surface = plane(20.0, cells=10)
    particles = grown(SurfaceGround(surface, 1.5))
    points = SurfaceGround(surface, 1.5).points(particles)
    SurfacePoints(points.face, points.barycentric)  # checks that the weights lie in their faces
    assert len(particles) > 200
    place = points.positions(surface) + surface.origin_mm
    reach = np.minimum(place[:, :2], 20 - place[:, :2]).min(axis=1)
    assert reach.min() > -1e-6
    density = [
        np.count_nonzero((reach >= a) & (reach < a + 1.5)) / (4 * 1.5 * (20 - 2 * a - 1.5))
        for a in (0, 1.5, 3)
    ]
    assert min(density) > 0.6 * max(density)  # borders are neither empty nor crowded


def test_none_is_none():
    assert len(Particles.none()) == 0


def test_particles_live_on_average_as_long_as_they_are_counted():
    ground = PlaneGround(20.0, 1.0)
    for changes in ({}, {"life": 30}, {"generations": 30}):
        law, alive = GrowthLaw(**changes), []
        grow(
            ground,
            law,
            stream(0, "births"),
            watch=lambda particles, alive=alive: alive.append(len(particles)),
        )
        born = law.born(law.generations - 1, ground.area)[1]
        assert sum(alive) / born == pytest.approx(law.mean_life(), rel=0.01)
