"""Unwraps: what holds for every one of them, and a child process that can be stopped."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from surftex.charts import xatlas_run
from surftex.charts.atlas import Atlas
from surftex.charts.gate import gate
from surftex.charts.quality import face_quality
from surftex.charts.unwrap import SPARSE_COVERAGE, unwrap
from surftex.errors import InputError
from surftex.surface.shapes import cylinder, plane, sphere, torus
from surftex.surface.surface import Surface

SHAPES = {
    "ball": sphere(subdivisions=3),
    "ring": torus(columns=40, rows=20),
    "tube": cylinder(),
    "sheet": plane(),
}


def needles():
    """A fan of ordinary faces with needles of 1e-7 of their length between them."""
    angle = np.repeat(np.linspace(0, 5.5, 12), 2) + np.tile([0, 1e-7], 12)
    rim = 50 * np.stack([np.cos(angle), np.sin(angle), 0.2 * np.sin(3 * angle)], axis=1)
    faces = [[0, i + 1, i + 2] for i in range(23)]
    return Surface.from_arrays(np.vstack([[0, 0, 0], rim]), faces)


def band(half_turns):
    """A closed strip with half turns; an odd number of them makes it a cut Moebius strip."""
    count = 40
    turn = np.linspace(0, 2 * np.pi, count + 1)
    tilt = half_turns * turn / 2
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    across = np.stack([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)], axis=1)
    points = np.stack([30 * ring - 6 * across, 30 * ring + 6 * across], axis=1).reshape(-1, 3)
    i = 2 * np.arange(count)
    faces = np.concatenate([np.stack([i, i + 2, i + 1], axis=1), np.stack([i + 1, i + 2, i + 3], axis=1)])
    return Surface.from_arrays(points, faces)


@pytest.mark.parametrize("method", ["xatlas", "uvunwrap"])
@pytest.mark.parametrize("name", SHAPES)
def test_every_unwrap_passes_the_gate(name, method):
    surface = SHAPES[name]
    atlas = unwrap(surface, method=method, resolution=512)
    assert atlas.unwrapper == method
    assert atlas.gutter_px == 4
    report = gate(surface, atlas, 512, gap_px=2 * atlas.gutter_px)
    assert report.passed, report.problems
    assert report.mirrored_faces == report.flat_faces == report.outside_faces == 0
    assert report.worst_anisotropy < 1.6
    assert report.coverage > 0.3
    again = unwrap(surface, method=method, resolution=512)
    assert again.corner_uv.tobytes() == atlas.corner_uv.tobytes()


@pytest.mark.parametrize("method", ["xatlas", "uvunwrap"])
@pytest.mark.parametrize(
    "surface",
    [needles(), band(1), band(2), Surface.from_arrays([[0, 0, 0], [9, 0, 0], [2, 5, 1]], [[0, 1, 2]])],
    ids=["needles", "moebius", "two half turns", "one face"],
)
def test_awkward_surfaces_pass_too(surface, method):
    atlas = unwrap(surface, method=method, resolution=256)
    report = gate(surface, atlas, 256, gap_px=2 * atlas.gutter_px)
    assert report.passed, report.problems
    assert report.worst_anisotropy <= 4
    assert report.mirrored_faces == report.flat_faces == 0


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_scale_does_not_matter(scale):
    ball = SHAPES["ball"]
    scaled = Surface.from_arrays(ball.vertices * scale, ball.faces)
    atlas = unwrap(scaled, method="uvunwrap", resolution=256)
    assert gate(scaled, atlas, 256, gap_px=2 * atlas.gutter_px).passed
    unscaled = unwrap(ball, method="uvunwrap", resolution=256)
    assert atlas.chart_count == pytest.approx(unscaled.chart_count, abs=3)


def test_texels_are_equally_large_everywhere():
    atlas = unwrap(SHAPES["sheet"], method="uvunwrap", resolution=256)
    quality = face_quality(SHAPES["sheet"], atlas.corner_uv)
    assert quality.anisotropy.max() < 1.001
    assert np.ptp(quality.density) < 1e-3 * quality.density.mean()


def many_balls():
    """64 balls beside each other: at least as many charts."""
    ball = sphere(10.0, subdivisions=1)
    points = np.concatenate([np.add(ball.vertices, [30 * i, 30 * j, 0]) for i in range(8) for j in range(8)])
    faces = np.concatenate([ball.faces + k * len(ball.vertices) for k in range(64)])
    return Surface.from_arrays(points, faces)


def test_a_full_page_gets_smaller_gaps_and_says_so():
    atlas = unwrap(many_balls(), method="uvunwrap", resolution=128, gutter_px=24)
    assert atlas.gutter_px < 24
    assert any("no room for 24 free texels" in note for note in atlas.notes)


def test_gutters_that_leave_little_of_the_page_are_told_of():
    many = many_balls()
    sparse = unwrap(many, method="uvunwrap", resolution=128, gutter_px=2)
    share = many.area_mm2 * (sparse.texels_per_mm(many, 128) / 128) ** 2
    assert share < SPARSE_COVERAGE
    (note,) = sparse.notes
    assert f"covers {100 * share:.2g} % of the page at 128" in note
    assert f"gutters of 2 texels around {sparse.chart_count} charts" in note
    for resolution, gutter_px in ((512, None), (128, 0)):
        assert unwrap(many, method="uvunwrap", resolution=resolution, gutter_px=gutter_px).notes == ()


def test_long_thin_charts_are_no_matter_of_gutters():
    rod = cylinder(1.0, 1000.0)
    atlas = unwrap(rod, method="uvunwrap", resolution=512)
    assert rod.area_mm2 * (atlas.texels_per_mm(rod, 512) / 512) ** 2 < SPARSE_COVERAGE
    assert atlas.notes == ()


def test_atlas_finds_seams_by_both_ends():
    sheet = plane(cells=4)
    uv = sheet.corner_uv.copy()
    right = uv.mean(axis=1)[:, 0] > 0.5
    uv[right] += [1e-8, 0]
    assert Atlas.of(sheet, uv).chart_count == 1
    uv[right] += [0.1, 0]
    atlas = Atlas.of(sheet, uv)
    assert atlas.chart_count == 2
    assert atlas.seam_length_mm(sheet) == pytest.approx(10.0)
    assert (atlas.chart[right] != atlas.chart[~right][0]).all()


def test_folded_pages_are_cut_along_the_fold():
    sheet = plane(cells=4)
    uv = sheet.corner_uv.copy()
    uv[..., 0] = np.minimum(uv[..., 0], 1 - uv[..., 0])
    assert Atlas.of(sheet, uv).chart_count == 2


def test_xatlas_over_its_budget_gives_way():
    atlas = unwrap(sphere(subdivisions=4), method="xatlas", resolution=256, budget_s=0.05)
    assert atlas.unwrapper == "uvunwrap"
    assert atlas.notes[0] == "xatlas was not done after 0.05 s; uvunwrap took over"


def test_a_crash_of_xatlas_gives_way(monkeypatch, tmp_path):
    broken = tmp_path / "python"
    broken.write_text("#!/bin/sh\necho 'Segmentation fault' >&2\nexit 139\n")
    broken.chmod(0o755)
    monkeypatch.setattr(xatlas_run.sys, "executable", str(broken))
    atlas = unwrap(sphere(subdivisions=2), method="auto", resolution=256)
    assert atlas.unwrapper == "uvunwrap"
    assert atlas.notes[0] == "xatlas failed with code 139: Segmentation fault; uvunwrap took over"


def children():
    """Processes whose parent is this one."""
    found = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == os.getpid() and fields[0] != "Z":
            found.append(int(status.parent.name))
    return set(found)


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc")
@pytest.mark.parametrize("method", ["xatlas", "uvunwrap"])
def test_cancel_leaves_no_child_behind(method):
    before = children()
    ticks = []

    def interrupt(share):
        ticks.append(share)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        unwrap(sphere(subdivisions=6), method=method, resolution=256, tick=interrupt)
    assert len(ticks) == 1
    assert children() <= before


def test_progress_runs_from_zero_to_one():
    told = []
    unwrap(sphere(subdivisions=5), method="uvunwrap", resolution=512, tick=told.append)
    assert told == sorted(told)
    assert 0 <= told[0] <= told[-1] <= 1


def test_works_from_a_script_without_a_guard_and_without_stdin(tmp_path):
    script = tmp_path / "plain.py"
    script.write_text(
        "from surftex.charts.unwrap import SPARSE_COVERAGE, unwrap\n"
        "from surftex.surface.shapes import sphere\n"
        "print(unwrap(sphere(subdivisions=2), method='xatlas', resolution=128).unwrapper)\n"
    )
    start = time.monotonic()
    done = subprocess.run(
        [sys.executable, str(script)], stdin=subprocess.DEVNULL, capture_output=True, text=True, cwd=tmp_path
    )
    assert done.stdout.split() == ["xatlas"], done.stderr
    assert time.monotonic() - start < 60


def test_options_are_checked():
    with pytest.raises(InputError, match="unwrapper is 'lscm'; it takes one of auto, xatlas, uvunwrap"):
        unwrap(SHAPES["sheet"], method="lscm")
    with pytest.raises(InputError, match="gutter_px is 64"):
        unwrap(SHAPES["sheet"], resolution=256, gutter_px=64)
