"""Seams: the gutter makes both sides agree, dilation does not, equalising does better still."""

import numpy as np
import pytest

from surftex.charts.equalise import equalise
from surftex.charts.seams import probe, probe_seams, seam_jumps, seam_report, seam_samples
from surftex.charts.texels import texels
from surftex.charts.unwrap import unwrap
from surftex.surface.shapes import cylinder, plane, sphere, torus

SIDE = 512


@pytest.fixture(
    scope="module", params=[sphere(subdivisions=4), torus(), cylinder()], ids=["ball", "ring", "tube"]
)
def subject(request):
    atlas = unwrap(request.param, method="uvunwrap", resolution=SIDE, gutter_px=8)
    return request.param, atlas


def test_jumps_stay_below_the_interior_error(subject):
    surface, atlas = subject
    levels = probe_seams(surface, atlas, texels(surface, atlas, SIDE))
    assert len(levels) == 3
    for level, limit in zip(levels, (1.2, 2.0, 2.0), strict=True):
        assert 0 < level["ratio"] <= limit


def test_dilation_jumps_ten_times_as_far(subject):
    surface, atlas = subject
    levels = probe_seams(surface, atlas, texels(surface, atlas, SIDE, gutter_px=0), mips=1)
    assert levels[0]["ratio"] > 10


def test_both_sides_of_a_sample_are_one_place(subject):
    surface, atlas = subject
    samples = seam_samples(surface, atlas, SIDE)
    np.testing.assert_allclose(samples.here.positions(surface), samples.there.positions(surface), atol=1e-9)
    assert samples.length_mm.sum() == pytest.approx(atlas.seam_length_mm(surface))


def test_report_tells_every_map_in_its_unit(subject):
    surface, atlas = subject
    page = texels(surface, atlas, SIDE)
    wave = probe(surface, page.points, 12.0)
    image = page.image(wave.astype(np.float32))
    codes = page.image(np.round(wave * 65535).astype(np.uint16))
    report = seam_report(
        surface, atlas, {"height": 10 * image, "mask": codes, "normal": np.dstack([image] * 3)}
    )
    assert report["maps"]["height"]["rms"] == pytest.approx(10 * report["maps"]["mask"]["rms"], rel=0.02)
    assert report["maps"]["normal"]["max"] == pytest.approx(
        3**0.5 * report["maps"]["height"]["max"] / 10, rel=1e-4
    )
    assert len(report["maps"]["height"]["mips"]) == 3
    assert report["max"] >= report["rms"] > 0
    decoded = seam_report(
        surface, atlas, {"height": image}, decode={"height": lambda value, points: 0 * value}
    )
    assert decoded["maps"]["height"]["max"] == 0


def test_equalising_lowers_jumps_and_says_what_moved(subject):
    surface, atlas = subject
    page = texels(surface, atlas, SIDE)
    image = page.image(
        probe(surface, page.points, 24 / atlas.texels_per_mm(surface, SIDE)).astype(np.float32)
    )
    samples = seam_samples(surface, atlas, SIDE)
    result = equalise(samples, image)
    for before, after in zip(seam_jumps(samples, image), seam_jumps(samples, result.image), strict=True):
        assert after.rms < 0.8 * before.rms
    moved = np.abs(result.image - image)
    assert result.moved_max == pytest.approx(moved.max(), rel=1e-3)
    assert (moved > 0).sum() <= result.moved_texels < image.size / 2


def test_one_chart_has_no_seams():
    sheet = plane()
    atlas = unwrap(sheet, method="uvunwrap", resolution=64)
    samples = seam_samples(sheet, atlas, 64)
    image = np.ones((64, 64), np.float32)
    assert len(samples) == 0
    assert seam_jumps(samples, image)[0].max == 0
    assert equalise(samples, image).moved_texels == 0
