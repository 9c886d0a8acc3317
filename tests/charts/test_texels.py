"""Texels: truth on flat ground, and the same bytes for any threads and bands."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from surftex.charts.atlas import Atlas
from surftex.charts.texels import texels
from surftex.charts.unwrap import unwrap
from surftex.errors import InputError
from surftex.surface.shapes import plane, sphere, torus

SIDE = 128


def cut_plane():
    """A plane cut in two charts; the right one is turned by a third of a right angle, both at one scale."""
    sheet = plane(10.0, cells=8)
    place = sheet.vertices[sheet.faces][..., :2]
    right = place.mean(axis=1)[:, 0] > 5
    scale = 0.04
    uv = np.add(place * scale, 0.05)
    turn = np.exp(1j * np.pi / 6)
    moved = ((place - [7.5, 5]) @ np.array([1, 1j])) * turn * scale
    uv[right] = (np.stack([moved.real, moved.imag], axis=2) + 0.7)[right]
    return sheet, Atlas.of(sheet, uv, resolution=SIDE, gutter_px=8), right, scale, turn


def test_gutter_shows_what_lies_beyond_the_seam():
    sheet, atlas, right, scale, turn = cut_plane()
    page = texels(sheet, atlas, SIDE)
    assert atlas.chart_count == 2
    centre = np.stack([page.texel % SIDE + 0.5, SIDE - (page.texel // SIDE + 0.5)], axis=1) / SIDE
    straight = (centre - 0.05) / scale
    back = ((centre - 0.7) @ np.array([1, 1j])) / turn / scale
    turned = np.add(np.stack([back.real, back.imag], axis=1), [7.5, 5])
    expected = np.where(right[page.host][:, None], turned, straight)
    inside = ((expected > 0) & (expected < 10)).all(axis=1)
    found = page.points.positions(sheet)[:, :2]
    assert (inside & ~page.core).sum() > 100
    np.testing.assert_allclose(found[inside], expected[inside], atol=1e-9)
    crossed = right[page.points.face] != right[page.host]
    assert (crossed & ~page.core & inside).sum() > 100
    beyond = ~inside
    assert beyond.any()
    np.testing.assert_allclose(found[beyond], np.clip(expected, 0, 10)[beyond], atol=0.4)


@pytest.mark.parametrize(("exact_px", "sides"), [(4.0, [2]), (2.0, [2, 4])])
def test_far_gutter_texels_share_the_place_between_them(exact_px, sides):
    sheet, atlas, *_ = cut_plane()
    exact = texels(sheet, atlas, SIDE, gutter_px=14)
    page = texels(sheet, atlas, SIDE, gutter_px=14, exact_px=exact_px)
    np.testing.assert_array_equal(page.texel, exact.texel)
    np.testing.assert_array_equal(exact.source, np.arange(len(exact)))
    leads = page.source == np.arange(len(page))
    np.testing.assert_array_equal(page.points.face, page.points.face[page.source])
    np.testing.assert_array_equal(page.points.barycentric, page.points.barycentric[page.source])
    count = np.bincount(page.source, minlength=len(page))
    assert leads[page.source].all()
    assert set(count[leads]) == {1, *(side * side for side in sides)}
    place, alone, away = page.points.positions(sheet), exact.points.positions(sheet), _away_px(exact)
    row, column = page.texel // SIDE, page.texel % SIDE
    np.testing.assert_array_equal(place[count[page.source] == 1], alone[count[page.source] == 1])
    for side in sides:
        shared = count[page.source] == side * side
        leader = page.source[shared]
        assert shared.sum() > 300
        assert away[shared].min() > exact_px * (side / 2) ** 2 - 1
        np.testing.assert_array_equal(
            page.texel[leader], ((row - row % side) * SIDE + column - column % side)[shared]
        )
        several = np.stack([alone[page.source == first].mean(axis=0) for first in np.unique(leader)])
        middle = np.linalg.norm(place[np.unique(leader)] - several, axis=1)
        # but where they lie beyond different edges, or beyond the border
        assert np.quantile(middle, 0.8) < 1e-9


def _away_px(page):
    """Texels between each texel and the core."""
    core = np.zeros((SIDE, SIDE), bool)
    core.ravel()[page.texel[page.core]] = True
    return distance_transform_edt(~core).ravel()[page.texel]


def test_turn_carries_directions_from_host_to_face():
    sheet, atlas, *_ = cut_plane()
    page = texels(sheet, atlas, SIDE)
    direction = np.stack([np.cos(page.turn_rad), np.sin(page.turn_rad)], axis=1)
    carried = np.einsum("tk,tki->ti", direction, sheet.frame[page.points.face][:, :2])
    np.testing.assert_allclose(carried, sheet.frame[page.host][:, 0], atol=1e-6)
    assert np.all(page.turn_rad[page.core] == 0)
    assert np.array_equal(page.host[page.core], page.points.face[page.core])


def test_jacobian_turns_texels_into_millimetres():
    sheet, atlas, right, scale, turn = cut_plane()
    jacobian = atlas.jacobian_mm(sheet, SIDE)
    step = np.einsum("fk,fki->fi", jacobian[:, :, 0], sheet.frame[:, :2])[:, :2] @ np.array([1, 1j])
    expected = np.where(right, 1 / turn, 1.0) / (scale * SIDE)
    np.testing.assert_allclose(step, expected, atol=1e-12)
    page = texels(sheet, atlas, SIDE)
    np.testing.assert_allclose(page.footprint_mm, 1 / (scale * SIDE), rtol=1e-6)


@pytest.mark.parametrize("exact_px", [np.inf, 2.0])
def test_same_bytes_for_any_threads_and_rows(exact_px):
    surface = torus(columns=30, rows=15)
    atlas = unwrap(surface, method="uvunwrap", resolution=200)
    whole = texels(surface, atlas, 200, exact_px=exact_px, threads=1)
    fields = {
        "texel": lambda t: t.texel,
        "face": lambda t: t.points.face,
        "barycentric": lambda t: t.points.barycentric,
        "footprint": lambda t: t.footprint_mm,
        "core": lambda t: t.core,
        "host": lambda t: t.host,
        "turn": lambda t: t.turn_rad,
    }
    again = texels(surface, atlas, 200, exact_px=exact_px, threads=3)
    bounds = ((0, 37), (37, 128), (128, 129), (129, 200))
    parts = [texels(surface, atlas, 200, exact_px=exact_px, rows=rows) for rows in bounds]
    for name, take in fields.items():
        assert take(again).tobytes() == take(whole).tobytes(), name
        assert np.concatenate([take(part) for part in parts]).tobytes() == take(whole).tobytes(), name


def test_blocks_of_the_far_gutter_are_the_same_wherever_rows_are_cut():
    sheet, atlas, *_ = cut_plane()
    whole = texels(sheet, atlas, SIDE, gutter_px=14, exact_px=2.0)
    cuts = (0, 5, 37, 38, 67, 71, SIDE)
    parts = [texels(sheet, atlas, SIDE, gutter_px=14, exact_px=2.0, rows=rows) for rows in pairwise(cuts)]
    assert (np.bincount(whole.source) == 16).sum() > 20
    for take in (
        lambda t: t.texel, lambda t: t.points.face, lambda t: t.points.barycentric, lambda t: t.host, lambda t: t.turn_rad
    ):  # fmt: skip
        np.testing.assert_array_equal(np.concatenate([take(part) for part in parts]), take(whole))
    for part in parts:
        np.testing.assert_array_equal(part.points.barycentric, part.points.barycentric[part.source])
        assert (part.source <= np.arange(len(part))).all()


def test_positions_agree_across_seams_where_texels_meet():
    ball = sphere(40.0, subdivisions=4)
    atlas = unwrap(ball, method="uvunwrap", resolution=512, gutter_px=4)
    page = texels(ball, atlas, 512)
    radius = np.linalg.norm(page.points.positions(ball), axis=1)
    assert radius.min() > 39.5
    assert page.points.barycentric.min() >= 0
    np.testing.assert_allclose(page.points.barycentric.sum(axis=1), 1, atol=1e-12)
    assert page.texel[0] >= 0
    assert np.all(np.diff(page.texel) > 0)


def test_image_has_no_holes_and_keeps_type():
    surface = sphere(subdivisions=2)
    page = texels(surface, unwrap(surface, method="uvunwrap", resolution=64), 64)
    image = page.image(np.arange(1, len(page) + 1, dtype=np.int32))
    assert image.shape == (64, 64)
    assert image.dtype == np.int32
    assert image.min() >= 1
    assert np.array_equal(image.ravel()[page.texel], np.arange(1, len(page) + 1))
    assert page.image(np.ones((len(page), 3), np.float32)).shape == (64, 64, 3)
    with pytest.raises(InputError, match="values has shape"):
        page.image(np.ones(len(page) + 1))


def test_mismatches_are_refused():
    surface, other = sphere(subdivisions=1), sphere(subdivisions=2)
    atlas = unwrap(surface, method="uvunwrap", resolution=64)
    with pytest.raises(InputError, match="atlas has 80 faces, the surface 320"):
        texels(other, atlas, 64)
    with pytest.raises(InputError, match="rows 60 to 70 lie outside"):
        texels(surface, atlas, 64, rows=(60, 70))
