"""Ambient occlusion of a relief: right in a trench, blind to tilts, unwraps and seams."""

import numpy as np
import pytest

from surftex.charts.atlas import Atlas
from surftex.charts.texels import texels
from surftex.charts.unwrap import unwrap
from surftex.errors import InputError
from surftex.maps.occlusion import ambient_occlusion
from surftex.surface.shapes import plane, sphere
from tests.maps.test_normal import bilinear, seam_points
from tests.oracles import maps as oracle


def unwrapped_plane(turn=0.0, stretch=(0.7, 0.7)):
    flat = plane(20.0, cells=8)
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    return flat, Atlas.of(flat, (flat.corner_uv - 0.5) @ rotation * stretch + 0.5)


def cells(position):
    return np.prod(np.sin(position * 2.2 + [0.3, 0.9, 0.1]), axis=1).astype(np.float32)


def test_equals_the_twin():
    flat, atlas = unwrapped_plane(0.4, (0.7, -0.4))
    page = texels(flat, atlas, 64, gutter_px=0)
    height = 4 * cells(page.points.positions(flat))
    expected = oracle.open_sky(flat, atlas, page, height, [1, 2, 3, 4, 6], 3.4)
    found = ambient_occlusion(flat, atlas, page, height, radius_mm=3.4)
    assert 5.5 < 3.4 / np.median(page.footprint_mm) < 6.5
    np.testing.assert_allclose(found, expected, atol=1e-5)
    assert found.min() < 0.8


@pytest.mark.parametrize("turn", [0.0, 0.5])
@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_bottom_of_a_trench_sees_what_geometry_says(ratio, turn):
    """The middle of a long trench, `ratio` half widths deep, sees 1 / sqrt(1 + ratio^2) of the light."""
    flat, atlas = unwrapped_plane(turn)
    page = texels(flat, atlas, 512)
    x = page.points.positions(flat)[:, 0] - 10
    half = 0.27
    height = np.where(np.abs(x) < half, 0, ratio * half).astype(np.float32)
    sky = ambient_occlusion(flat, atlas, page, height, radius_mm=1.0)
    middle = sky[page.core & (np.abs(x) < 0.04)].mean()
    near, far = (1 / np.sqrt(1 + (ratio / times) ** 2) for times in (1.0, 1.85))
    assert near - 0.03 < middle < far
    assert sky[page.core & (np.abs(x) > 1.3)].min() > 0.999


def test_tilted_planes_are_open():
    flat, atlas = unwrapped_plane(0.3)
    page = texels(flat, atlas, 256)
    place = page.points.positions(flat)
    sky = ambient_occlusion(flat, atlas, page, place[:, 0] * 0.8 - place[:, 1] * 0.3, radius_mm=2.0)
    assert sky.min() > 0.9999


def test_unwraps_do_not_change_the_light():
    means = []
    for turn, stretch in ((0.0, (0.6, 0.6)), (0.7, (0.6, 0.6)), (0.3, (0.6, 0.4))):
        flat, atlas = unwrapped_plane(turn, stretch)
        page = texels(flat, atlas, 768)
        place = page.points.positions(flat)
        sky = ambient_occlusion(flat, atlas, page, cells(place), radius_mm=0.6)
        low = page.core & (cells(place) < -0.05) & (np.abs(place[:, :2] - 10).max(axis=1) < 9)
        means.append(1 - sky[low].mean())
    assert min(means) > 0.001
    np.testing.assert_allclose(means, means[0], rtol=0.1)


def test_no_step_along_seams_and_furrows_are_darker():
    ball = sphere(20.0, subdivisions=4)
    atlas = unwrap(ball, method="uvunwrap", resolution=1024)
    page = texels(ball, atlas, 1024)
    height = cells(page.points.positions(ball))
    sky = ambient_occlusion(ball, atlas, page, height, radius_mm=0.5)
    assert sky[height < -0.5].mean() < sky[np.abs(height) < 0.1].mean() < 1
    assert np.median(sky[height > 0.5]) > 0.999
    image = page.image(sky)
    face, here, other, there = seam_points(ball, atlas)
    sides = [
        bilinear(image[..., None], np.einsum("pk,pki->pi", weight, atlas.corner_uv[on]))[:, 0]
        for on, weight in ((face, here), (other, there))
    ]
    step = np.abs(sides[0] - sides[1])
    assert np.sqrt((step**2).mean()) < 0.1 * sky[page.core].std()
    assert step.max() < 0.03


def test_same_bytes_for_threads_and_bands():
    ball = sphere(20.0, subdivisions=3)
    atlas = unwrap(ball, method="uvunwrap", resolution=512)
    page = texels(ball, atlas, 512)
    height = cells(page.points.positions(ball))
    whole = ambient_occlusion(ball, atlas, page, height, radius_mm=1.0, threads=1)
    assert whole.tobytes() == ambient_occlusion(ball, atlas, page, height, radius_mm=1.0, threads=2).tobytes()


def test_refuses_a_radius_that_is_none():
    flat, atlas = unwrapped_plane()
    page = texels(flat, atlas, 32)
    for radius in (0.0, -1.0, np.nan):
        with pytest.raises(InputError, match="radius_mm"):
            ambient_occlusion(flat, atlas, page, np.zeros(len(page)), radius_mm=radius)
