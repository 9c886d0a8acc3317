"""Noise: against its twin, smooth, of the wavelength that was asked, and gone where it cannot be seen."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from surftex.errors import RecipeError
from surftex.fields.noise import Noise, several
from surftex.randomness import stream
from tests.oracles import fields as oracle


@given(
    st.lists(st.tuples(*[st.floats(-500, 500)] * 3), min_size=1, max_size=5),
    st.floats(0, 3),
    st.integers(1, 3),
    st.integers(0, 99),
)
def test_noise_equals_its_slow_twin(points, footprint_mm, octaves, seed):
    noise = Noise(stream(seed, "test"), wavelength_mm=5.0, octaves=octaves, gain=0.6)
    footprints = [footprint_mm] * len(points)
    expected = oracle.gradient_noise(points, footprints, *noise._octaves())
    np.testing.assert_allclose(noise.at(np.array(points), footprint_mm), expected, atol=2e-6)


@given(st.lists(st.tuples(st.floats(0, 2), st.floats(0, 4)), min_size=2, max_size=9), st.integers(1, 12))
def test_noises_at_once_are_those_of_one_after_the_other(places, octaves):
    """Whatever shows at one point and has faded at the next: octaves come and go within a cell of the lattice."""
    noises = [Noise(stream(seed, "test"), 4.0 + seed, (octaves + 5 * seed) % 12 + 1) for seed in range(3)]
    points = np.array([[along, 0.1, 0.2] for along, _ in places])
    footprints = np.array([footprint for _, footprint in places], np.float32)
    expected = [oracle.gradient_noise(points, footprints, *noise._octaves()) for noise in noises]
    together = several(noises, points, footprints)
    np.testing.assert_allclose(together, expected, atol=2e-6)
    for noise, values in zip(noises, together, strict=True):
        np.testing.assert_array_equal(noise.at(points, footprints), values)


def _page(noise, cells, side_mm, footprint_mm=0.0):
    x = np.arange(cells) * side_mm / cells
    u, v = np.meshgrid(x, x)
    return noise.at(np.stack([u.ravel(), v.ravel(), 0 * u.ravel()], axis=1), footprint_mm).reshape(
        cells, cells
    )


def test_mean_wavelength_and_strength_are_as_promised():
    cells, side_mm = 256, 64.0
    frequency = np.fft.fftfreq(cells, side_mm / cells)
    radius = np.hypot(*np.meshgrid(frequency, frequency))
    window = np.outer(np.hanning(cells), np.hanning(cells))
    mean, rms = [], []
    for seed in range(6):
        page = _page(Noise(stream(seed, "test"), 2.0), cells, side_mm)
        power = np.abs(np.fft.fft2(page * window)) ** 2
        mean.append((power * radius).sum() / power.sum())
        rms.append(page.std())
        assert np.abs(page).max() < 1.3
    assert 1 / np.mean(mean) == pytest.approx(2.0, rel=0.05)
    assert np.mean(rms) == pytest.approx(0.31, rel=0.06)


def test_noise_is_smooth_across_lattice_cells():
    noise = Noise(stream(1, "test"), 2.0)
    curvature = []
    for step_mm in (1e-2, 5e-3):
        line = np.arange(0, 20, step_mm)
        value = noise.at(np.stack([line, 0.3 * line, 0.7 * line], axis=1)).astype(float)
        curvature.append(np.abs(np.diff(value)).max() / step_mm)
    assert curvature[1] == pytest.approx(curvature[0], rel=0.02)  # a jump would double it


def test_fine_detail_fades_with_the_footprint_and_coarse_detail_stays():
    noise = Noise(stream(2, "test"), 4.0, octaves=3)
    coarse = Noise(stream(2, "test"), 4.0)
    everything, nothing = _page(noise, 64, 20.0), _page(noise, 64, 20.0, footprint_mm=2.0)
    assert everything.std() > 0.2
    assert (nothing == 0).all()
    one = _page(noise, 64, 20.0, footprint_mm=1.0)  # octaves of 2 mm and 1 mm are gone, 4 mm is whole
    np.testing.assert_allclose(one, _page(coarse, 64, 20.0) / np.sqrt(1 + 0.25 + 0.0625), atol=1e-6)


def test_read_only_and_writable_places_give_the_same():
    noise = Noise(stream(2, "test"), 4.0)
    places = np.random.RandomState(1).uniform(-9, 9, (50, 3))
    first = noise.at(places)
    places.flags.writeable = False
    assert first.tobytes() == noise.at(places).tobytes()


@pytest.mark.parametrize(
    "wrong",
    [
        {"wavelength_mm": 0.0},
        {"wavelength_mm": np.nan},
        {"wavelength_mm": 1.0, "octaves": 0},
        {"wavelength_mm": 1.0, "gain": 0.0},
    ],
)
def test_impossible_noise_is_refused(wrong):
    with pytest.raises(RecipeError, match="it takes"):
        Noise(stream(1, "test"), **wrong)
