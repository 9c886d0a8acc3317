"""Evening out: regions become alike, whatever the threads; few samples are held at a time."""

import numpy as np
import pytest

from surftex.features.poisson import poisson_disk
from surftex.features.relax import relaxed, samples_per_site
from surftex.features.uniform import area_points
from surftex.geodesics.windows import flood_points, nearest
from surftex.materials.leather.cells import shape_length
from surftex.randomness import stream
from surftex.surface.shapes import sphere
from tests.oracles.features import owners_slowly


@pytest.fixture(scope="module")
def ball():
    surface = sphere(20.0, subdivisions=3)
    return surface, poisson_disk(surface, 2.0, stream(0, "sites"))


def area_spread(surface, sites):
    records = flood_points(surface, sites.points, 1.6 * sites.axis_mm[:, 0])
    samples = area_points(surface, stream(2, "areas").uniform(400 * len(sites), 3))
    share = np.bincount(nearest(records, samples, 1)[0][:, 0], minlength=len(sites))
    return share.std() / share.mean()


def test_rounds_make_regions_alike(ball):
    surface, sites = ball
    spread = [area_spread(surface, relaxed(surface, sites, stream(1, "even"), rounds=n)) for n in (0, 3, 12)]
    assert spread[1] < 0.8 * spread[0]
    assert spread[2] < 0.95 * spread[1]


@pytest.mark.parametrize("shape", ["round", "box"])
def test_same_bytes_for_any_threads(ball, shape):
    surface, sites = ball
    length = None if shape == "round" else shape_length(shape, sites)
    one, three = (
        relaxed(surface, sites, stream(1, "even"), rounds=2, length=length, threads=threads)
        for threads in (1, 3)
    )
    assert one.points.barycentric.tobytes() == three.points.barycentric.tobytes()
    assert one.angle_rad.tobytes() == three.angle_rad.tobytes()


def test_a_round_moves_sites_to_the_middle_of_what_is_theirs(ball):
    from surftex.features import relax

    surface, sites = ball
    records = flood_points(surface, sites.points, 1.6 * sites.axis_mm[:, 0])
    samples = area_points(surface, stream(1, "even").uniform(5000, 3))
    owner, move = relax._owners(records, samples, None, sites.angle_rad, None, None)
    near, _, vector = nearest(records, samples, 1, vectors=True)
    np.testing.assert_array_equal(owner, near[:, 0])
    np.testing.assert_array_equal(move, vector[:, 0])
    length = shape_length("box", sites)
    owner, _ = relax._owners(records, samples, length, sites.angle_rad, None, None)
    np.testing.assert_array_equal(owner, owners_slowly(records, samples, length, sites.angle_rad))
    assert (owner != near[:, 0]).any()


def test_watched_rounds_tell_a_share_that_grows_to_one(ball):
    surface, sites = ball
    shares = []
    relaxed(surface, sites, stream(1, "even"), rounds=5, tick=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert len(shares) >= 10


def test_samples_are_few_in_rounds_that_others_follow():
    assert [samples_per_site(rounds) for rounds in (0, 1, 3, 5)] == [0, 64, 192, 224]
