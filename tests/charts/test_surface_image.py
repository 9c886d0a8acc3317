"""Pictures on surfaces, and the promise that an unwrap moves texels and never values."""

import numpy as np
import pytest

from surftex.charts.seams import probe
from surftex.charts.surface_image import SurfaceImage
from surftex.charts.unwrap import unwrap
from surftex.errors import InputError
from surftex.randomness import stream
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import sphere


def scattered(surface, count):
    draw = stream(3, "points").uniform(count, 4)
    weight = draw[:, 1:] / draw[:, 1:].sum(axis=1, keepdims=True)
    return SurfacePoints((draw[:, 0] * len(surface.faces)).astype(int), weight)


def test_two_unwraps_move_texels_and_never_values():
    ball = sphere(20.0, subdivisions=4)
    points = scattered(ball, 20_000)
    truth = probe(ball, points, 12.0)
    read = []
    for method in ("xatlas", "uvunwrap"):
        atlas = unwrap(ball, method=method, resolution=512)
        assert atlas.unwrapper == method
        picture = SurfaceImage.baked(ball, lambda s: probe(ball, s.points, 12.0), resolution=512, atlas=atlas)
        read.append(picture.at(points))
        assert np.abs(read[-1] - truth).max() < 0.01
    assert np.sqrt(((read[0] - read[1]) ** 2).mean()) < 0.002


def test_a_finer_page_is_closer_at_second_order():
    ball = sphere(20.0, subdivisions=4)
    points = scattered(ball, 5_000)
    wrong = []
    for side in (128, 256, 512):
        atlas = unwrap(ball, method="uvunwrap", resolution=side, gutter_px=4)
        picture = SurfaceImage.baked(
            ball, lambda s: probe(ball, s.points, 25.0), resolution=side, atlas=atlas
        )
        wrong.append(np.sqrt(((picture.at(points) - probe(ball, points, 25.0)) ** 2).mean()))
    order = -np.polyfit(np.log([128, 256, 512]), np.log(wrong), 1)[0]
    assert order == pytest.approx(2.0, abs=0.3)


def test_colours_keep_their_channels():
    uv = np.tile([[0.25, 0.25], [0.75, 0.25], [0.5, 0.75]], (1, 1, 1))
    image = np.zeros((4, 4, 3))
    image[..., 1] = np.arange(4)[:, None]
    picture = SurfaceImage.of(uv, image)
    value = picture.at(SurfacePoints([0, 0], [[1, 0, 0], [0, 0, 1]]))
    np.testing.assert_allclose(value, [[0, 2.5, 0], [0, 0.5, 0]], atol=1e-6)
    with pytest.raises(InputError, match="not finite"):
        SurfaceImage.of(uv, np.full((2, 2), np.nan))
