"""The gate: each way to fail is seen and named; usable UVs are kept."""

import numpy as np
import pytest

import surftex as sx
from surftex.charts.atlas import Atlas
from surftex.charts.gate import choose_atlas, gate, keep_own
from surftex.errors import InputError
from surftex.surface.shapes import plane, sphere
from surftex.surface.surface import Surface

SIDE = 256


def with_uv(change):
    """A sheet whose own unwrap is inset by a tenth and then changed."""
    sheet = plane(cells=8)
    uv = 0.1 + 0.8 * sheet.corner_uv
    return Surface.from_arrays(sheet.vertices, sheet.faces, corner_uv=change(uv), name="sheet")


def halves(uv):
    return (uv.mean(axis=1)[:, 0] > 0.5)[:, None, None]


FAILURES = {
    "leave 0..1": lambda uv: np.add(uv, [0.5, 0]),
    "no area on the page": lambda uv: 0 * uv + 0.5,
    "stretched more than 4 times": lambda uv: uv * [1, 0.2],
    "denser or sparser than the rest": lambda uv: np.where(halves(uv), uv * 0.05, uv),
    "charts cover 0 % of the page at 256 texels": lambda uv: uv * 1e-30,
    "charts cover 0.00[1-9]+ % of the page": lambda uv: uv * 0.008,
    "lie in several faces": lambda uv: np.where(halves(uv), uv - [0.3, 0], uv),
}


USE = r'Use uv = "unwrap" \(--uv unwrap\)$'


@pytest.mark.parametrize("reason", FAILURES)
def test_what_cannot_be_baked_on_is_refused_by_name(reason):
    surface = with_uv(FAILURES[reason])
    for insist in (False, True):
        with pytest.raises(InputError, match=rf"UVs of sheet cannot be baked on: .*{reason}.*{USE}"):
            keep_own(surface, resolution=SIDE, insist=insist)
    with pytest.raises(InputError, match=reason):
        choose_atlas(surface, uv="keep", resolution=SIDE)
    anew = choose_atlas(surface, uv="auto", method="uvunwrap", resolution=SIDE)
    assert anew.unwrapper == "uvunwrap"
    assert anew.notes[0].startswith("unwrapped anew: the UVs of sheet cannot be baked on: ")
    assert gate(surface, anew, SIDE, gap_px=2 * anew.gutter_px).passed


FLAWS = {
    "charts are only 2.0 texels apart at 256 texels; a bake takes 3": lambda uv: np.where(
        halves(uv), np.add(uv, [2.5 / SIDE, 0]), uv
    ),
    "1 of 128 faces have no area on the page; the first is face 9": lambda uv: shrunk(uv, 0.0),
    "0.8 % of the area is stretched more than 4 times": lambda uv: shrunk(uv, [0.3, 0.03]),
    "0.8 % of the area is over 4 times denser or sparser than the rest": lambda uv: shrunk(uv, 0.1),
}


def shrunk(uv, share):
    """One face drawn in towards its middle."""
    uv = uv.copy()
    uv[9] = uv[9].mean(axis=0) + np.multiply(uv[9] - uv[9].mean(axis=0), share)
    return uv


@pytest.mark.parametrize("flaw", FLAWS)
def test_who_insists_on_his_uvs_is_warned_of_flaws_with_their_figures(flaw):
    surface = with_uv(FLAWS[flaw])
    with pytest.raises(
        InputError, match=rf'UVs of sheet are kept only with uv = "keep" \(--uv keep\): {flaw}. {USE}'
    ):
        keep_own(surface, resolution=SIDE)
    atlas = choose_atlas(surface, uv="keep", resolution=SIDE)
    assert atlas.unwrapper == "own"
    assert atlas.notes[0] == f"the file's own UVs are kept as asked, though {flaw}"
    anew = choose_atlas(surface, uv="auto", method="uvunwrap", resolution=SIDE)
    assert (
        anew.notes[0]
        == f'unwrapped anew: the UVs of sheet are kept only with uv = "keep" (--uv keep): {flaw}'
    )
    maps = sx.bake(surface, sx.Leather(cell_size=2.0), resolution=SIDE, uv="keep", maps="height,normal")
    assert maps.report["warnings"][0] == atlas.notes[0]
    assert all(np.isfinite(maps[name]).all() for name in maps)


def test_usable_uvs_are_kept():
    surface = with_uv(lambda uv: np.where(halves(uv), np.add(uv, [0.05, 0]), uv))
    atlas = choose_atlas(surface, resolution=SIDE)
    assert atlas.unwrapper == "own"
    assert atlas.corner_uv.tobytes() == surface.corner_uv.tobytes()
    assert atlas.chart_count == 2
    assert choose_atlas(surface, uv="unwrap", method="uvunwrap", resolution=SIDE).unwrapper == "uvunwrap"


def test_the_gutter_fits_the_gap():
    surface = with_uv(lambda uv: np.where(halves(uv), np.add(uv, [6 / 1024, 0]), uv))
    atlas = keep_own(surface, resolution=1024)
    assert atlas.gutter_px == 3
    assert "leave room for a gutter of 3 texels at 1024" in atlas.notes[0]
    assert gate(surface, atlas, 1024).gap_px == pytest.approx(6, abs=0.5)


def test_mirrored_charts_are_kept_and_counted():
    surface = with_uv(lambda uv: uv * [-1, 1] + [1, 0])
    report = gate(surface, Atlas.of(surface, surface.corner_uv), SIDE)
    assert report.passed
    assert report.mirrored_faces == len(surface.faces)
    assert "are mirrored" in keep_own(surface, resolution=SIDE).notes[0]


def test_a_few_bad_faces_do_not_count():
    sheet = plane(cells=40)
    uv = 0.05 + 0.9 * sheet.corner_uv
    uv[7] = uv[7].mean(axis=0)
    surface = Surface.from_arrays(sheet.vertices, sheet.faces, corner_uv=uv)
    assert gate(surface, Atlas.of(surface, uv), 512).flat_faces == 1
    assert keep_own(surface, resolution=512).unwrapper == "own"


def test_measures_are_exact_on_a_stretched_sheet():
    surface = with_uv(lambda uv: uv * [1, 0.5])
    report = gate(surface, Atlas.of(surface, surface.corner_uv), SIDE)
    assert report.worst_anisotropy == pytest.approx(2)
    assert report.texels_per_mm == pytest.approx(SIDE * 0.08 * 0.5**0.5)
    assert report.coverage == pytest.approx(0.32, abs=0.01)
    assert report.gap_px == np.inf


def test_keep_needs_uvs():
    with pytest.raises(InputError, match=r'sphere has no UVs of its own; use uv = "unwrap" \(--uv unwrap\)$'):
        choose_atlas(sphere(subdivisions=1), uv="keep")
    with pytest.raises(InputError, match="uv is 'mine'; it takes one of auto, keep, unwrap"):
        choose_atlas(sphere(subdivisions=1), uv="mine")
