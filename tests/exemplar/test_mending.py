"""Holes are filled and borders knitted: what is outside stays, what is inside looks like what is around."""

import numpy as np
import pytest

import surftex as sx
from surftex.errors import InputError
from tests.exemplar.pictures import noise, patchwork, pebbles

STONES = pebbles(160)


@pytest.fixture(scope="module")
def hole():
    down, right = np.mgrid[:160, :160]
    return (down - 80) ** 2 / 25**2 + (right - 70) ** 2 / 35**2 < 1


@pytest.fixture(scope="module")
def filled(hole):
    return sx.fill(np.where(hole, 0, STONES).astype(np.uint8), hole, seed=2)


def test_a_hole_is_filled_with_what_is_around_it(hole, filled):
    assert (filled[~hole] == STONES[~hole]).all()
    assert filled[hole].mean() == pytest.approx(STONES[~hole].mean(), abs=8)
    assert filled[hole].std() == pytest.approx(STONES[~hole].std(), rel=0.2)


def test_the_rim_of_the_hole_does_not_show(hole, filled):
    across = np.abs(np.diff(filled.astype(float), axis=1))
    rim = hole[:, 1:] != hole[:, :-1]
    inside = hole[:, 1:] & hole[:, :-1]
    assert across[rim].mean() < 1.25 * across[inside].mean()


def test_threads_change_no_byte(hole, filled):
    again = sx.fill(np.where(hole, 0, STONES).astype(np.uint8), hole, seed=2, threads=1)
    assert again.tobytes() == filled.tobytes()


def test_a_border_is_knitted():
    left, right = STONES[:, :80], np.ascontiguousarray(STONES[::-1, 60:140])
    knitted = sx.knit(left, right, width=8, seed=1)
    plain = np.concatenate([left, right], axis=1)
    assert (knitted[:, :72] == plain[:, :72]).all()
    assert (knitted[:, 88:] == plain[:, 88:]).all()
    zone = np.abs(np.diff(np.stack([plain, knitted]).astype(float), axis=2))
    usual = zone[0, :, :72].mean()
    assert zone[0, :, 79].mean() > 1.4 * usual
    assert zone[1, :, 72:87].mean() < 1.15 * usual
    assert zone[1, :, 79].mean() < 0.85 * zone[0, :, 79].mean()


def test_pictures_are_knitted_downwards_and_in_colour():
    tint = np.array([1.0, 0.8, 0.6])
    above, below = (
        (patchwork(np.zeros((64, 96), int) + k, k)[..., None] * tint).astype(np.uint8) for k in (0, 1)
    )
    knitted = sx.knit(above, below, side="below", order="pair", pairs=4, sweeps=20)
    assert knitted.shape == (128, 96, 3)
    assert (knitted[:50] == above[:50]).all()


@pytest.mark.parametrize(
    ("work", "what"),
    [
        (lambda: sx.fill(noise(64), np.zeros((64, 64))), "the mask is empty"),
        (lambda: sx.fill(noise(64), np.ones((32, 64))), "must be aligned"),
        (lambda: sx.fill(noise(64), np.ones((64, 64))), "leaves 0 pixels"),
        (lambda: sx.knit(noise(64), noise(48)), "as high"),
        (lambda: sx.knit(noise(64), noise(64, bands=3)), "1 and 3 bands"),
        (lambda: sx.knit(noise(64), noise(64), width=30), "1 to zone - 1"),
        (
            lambda: sx.fill(
                noise(64, bands=3), np.eye(64), model=sx.learn_texture(noise(64), order="pair", pairs=2)
            ),
            "the model draws grey",
        ),
    ],
)
def test_what_cannot_be_mended_is_told_in_a_line(work, what):
    with pytest.raises(InputError, match=what) as told:
        work()
    assert "\n" not in str(told.value)
