"""Warps by landmarks: a similarity where one does, landmarks that meet, no bend far away."""

import numpy as np
import pytest

from surftex.errors import SurfaceError
from surftex.features.landmarks import Warp


@pytest.fixture
def places():
    return np.random.Generator(np.random.PCG64(1)).normal(size=(9, 3))


def turned(places):
    angle = 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
    return 2.5 * places @ turn.T + [10, -3, 0.5]


def test_a_similarity_is_found(places):
    warp = Warp.between(places, turned(places))
    assert warp.scale == pytest.approx(2.5)
    anywhere = np.random.Generator(np.random.PCG64(2)).normal(size=(50, 3)) * 5
    np.testing.assert_allclose(warp(anywhere), turned(anywhere), atol=1e-9)


def test_landmarks_meet_and_what_is_far_is_not_bent(places):
    target = turned(places)
    target[0] += [0.4, 0, 0]
    warp = Warp.between(places, target)
    np.testing.assert_allclose(warp(places), target, atol=1e-6)
    far = places + 1000.0
    straight = warp.scale * far @ warp.turn.T + warp.shift
    np.testing.assert_allclose(warp(far), straight, atol=1e-9)


def test_no_way_becomes_longer_than_its_bound(places):
    warp = Warp.between(places, turned(places) + np.random.Generator(np.random.PCG64(3)).normal(size=(9, 3)))
    random = np.random.Generator(np.random.PCG64(4))
    start = random.normal(size=(2000, 3))
    step = 1e-4 * random.normal(size=(2000, 3))
    longer = np.linalg.norm(warp(start + step) - warp(start), axis=1) / np.linalg.norm(step, axis=1)
    assert (longer <= warp.steepness(start, np.full(2000, 1e-3))).all()
    assert warp.steepness(start + 1e6, np.ones(2000)).max() == pytest.approx(warp.scale)


def test_mirrors_are_never_taken(places):
    warp = Warp.between(places, places * [-1, 1, 1])
    assert np.linalg.det(warp.turn) == pytest.approx(1)


@pytest.mark.parametrize(
    ("source", "says"),
    [
        (np.eye(3), "3 landmarks are too few"),
        (np.outer(np.arange(5.0), [1, 2, 3]), "lie on one line"),
        (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0.0]]), "two landmarks lie on one place"),
    ],
)
def test_what_cannot_be_is_said(source, says):
    with pytest.raises(SurfaceError, match=says):
        Warp.between(source, source)
