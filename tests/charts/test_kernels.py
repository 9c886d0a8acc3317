"""Kernels of the charts room against their slow twins."""

import numpy as np
import pytest

from surftex.arrays import frozen
from surftex.charts.atlas import SAME_UV, Atlas
from surftex.charts.fill import fill_nearest, nearest_mapped
from surftex.charts.lookup import bilinear, half
from surftex.charts.overlap import MARGIN_PX, overlapping_faces
from surftex.charts.texels import texels
from surftex.charts.unwrap import unwrap
from surftex.errors import InputError
from surftex.kernels.gutter import close_up, find_leaders, nearest_edge_band
from surftex.kernels.notches import mark_notches
from surftex.kernels.raster import raster_band
from surftex.randomness import stream
from surftex.surface.shapes import cylinder, sphere
from tests.oracles import charts as oracle

SIDE = 24


def triangles(seed, count):
    return frozen(stream(seed, "test").uniform(count, 6).reshape(count, 3, 2) * (SIDE + 8) - 4)


@pytest.mark.parametrize("seed", range(4))
def test_raster_gives_texels_to_the_lowest_face(seed):
    corner = triangles(seed, 9)
    face, weight = np.full((SIDE, SIDE), -1, np.int32), np.zeros((SIDE, SIDE, 3))
    raster_band(corner, frozen(np.arange(9, dtype=np.int32)), 0, face, weight)
    expected, expected_weight = oracle.owners(corner, SIDE, SIDE)
    assert np.array_equal(face, expected)
    np.testing.assert_allclose(weight, expected_weight, atol=1e-9)


def test_raster_of_a_band_is_that_part_of_the_page():
    corner = triangles(7, 12)
    listed = frozen(np.arange(12, dtype=np.int32))
    page, part = np.full((SIDE, SIDE), -1, np.int32), np.full((5, SIDE), -1, np.int32)
    page_weight, part_weight = np.zeros((SIDE, SIDE, 3)), np.zeros((5, SIDE, 3))
    raster_band(corner, listed, 0, page, page_weight)
    raster_band(corner, listed, 9, part, part_weight)
    assert np.array_equal(part, page[9:14])
    assert part_weight[part >= 0] == pytest.approx(page_weight[9:14][part >= 0], abs=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_overlap_counts_the_faces_around_a_texel(seed):
    corner = triangles(seed, 6)
    count, pairs = overlapping_faces(corner, SIDE)
    held = oracle.holders(corner, SIDE, SIDE, MARGIN_PX)
    assert count == (held > 1).sum() > 0
    assert (pairs[:, 0] < pairs[:, 1]).all()


@pytest.mark.parametrize("seed", range(4))
def test_gutter_finds_the_nearest_edge(seed):
    corner = triangles(seed, 2)
    edges = [(f, i) for f in range(2) for i in range(3)]
    edge_face, edge_side = (frozen(np.array(part, np.int32)) for part in zip(*edges, strict=True))
    face, weight = np.full((SIDE, SIDE), -1, np.int32), np.zeros((SIDE, SIDE, 3))
    raster_band(corner, frozen(np.arange(2, dtype=np.int32)), 0, face, weight)
    near, square = np.full(face.shape, np.inf), np.full(face.shape, -np.inf)
    owner = np.full(face.shape, -1, np.int32)
    listed = frozen(np.arange(6, dtype=np.int32))
    nearest_edge_band(corner, edge_face, edge_side, listed, 6.0, 0, face, near, square, owner)
    assert np.array_equal(owner, oracle.nearest_edges(corner, edges, 6.0, face))
    assert (owner >= 0).any()


@pytest.mark.parametrize(
    "surface", [sphere(subdivisions=2), cylinder(columns=14, rows=7)], ids=["ball", "tube"]
)
def test_charts_end_where_the_two_sides_of_an_edge_part(surface):
    corner = np.round(surface.vertices[surface.faces] @ [[1, 0], [0, 1], [0.3, 0.2]], 3) / 100
    beyond = surface.vertices[surface.faces].mean(axis=1) > 0.1
    moved = np.zeros((4, *surface.faces.shape, 1))
    for k, far in enumerate((0.25, 1.5 * SAME_UV, 0.5 * SAME_UV)):
        moved[k, beyond[:, k]] = far
    moved[3, ::7, 1] = 0.25
    for far in moved:
        atlas = Atlas.of(surface, corner + far)
        assert np.array_equal(atlas.seam, oracle.seams(surface.faces, atlas.corner_uv, SAME_UV))
        assert np.array_equal(atlas.chart, oracle.parts(surface.neighbor, atlas.seam))
        assert atlas.chart_count > 1


@pytest.mark.parametrize("slots", [1, 256])
def test_notches_are_near_on_the_page_and_far_in_space(slots):
    draw = stream(slots, "samples")
    page, place = draw.uniform(150, 2) * 30 - 15, draw.uniform(150, 3) * 2
    face = (np.arange(150) % 40).astype(np.int64)
    chart, area = (np.arange(40) % 3).astype(np.int32), np.arange(40) // 2 % 7 * 1.0
    expected, marked = oracle.notches(page, place, face, chart, area, 2.5, 1.0), np.zeros(40, bool)
    room = np.full(slots, -1), np.zeros(150, np.int64)
    assert mark_notches(page, place, face, chart, area, 2.5, 1.0, *room, marked)
    assert np.array_equal(marked, expected)
    assert 0 < marked.sum() < 40
    room[0][:] = -1
    assert not mark_notches(page, place, face, chart, area, 2.5, 9.0, *room, marked)


WALKS = {
    "ball": (sphere(subdivisions=2), 96, 5),
    "many small faces": (sphere(subdivisions=4), 64, 6),
    "tube": (cylinder(columns=14, rows=7), 96, 5),
}


@pytest.mark.parametrize("name", WALKS)
def test_gutter_walks_as_triangles_laid_out_by_their_lengths(name):
    surface, side, gutter_px = WALKS[name]
    atlas = unwrap(surface, method="uvunwrap", resolution=side, gutter_px=gutter_px)
    page = texels(surface, atlas, side)
    corner = atlas.corner_px(side)
    gutter = np.flatnonzero(~page.core)
    foot = page.host_points.flat(surface)
    compared = 0
    for k in gutter[::5]:
        host = int(page.host[k])
        centre = np.array([page.texel[k] % side + 0.5, page.texel[k] // side + 0.5, 1])
        weight = np.linalg.solve(np.vstack([corner[host].T, np.ones(3)]), centre)
        if np.sort(page.host_points.barycentric[k])[1] < 1e-9:
            continue
        face, there, turn = oracle.straight_walk(surface, host, foot[k], weight @ surface.flat[host])
        expected = there @ surface.vertices[surface.faces[face]]
        found = page.points.barycentric[k] @ surface.vertices[surface.faces[page.points.face[k]]]
        np.testing.assert_allclose(found, expected, atol=1e-6)
        if face == page.points.face[k]:
            assert np.exp(1j * page.turn_rad[k]) == pytest.approx(np.exp(1j * turn), abs=1e-5)
        compared += 1
    assert compared > 50


@pytest.mark.parametrize("seed", range(4))
def test_fill_takes_the_nearest_mapped_texel(seed):
    mapped = stream(seed, "holes").uniform(19 * 31)[:, 0].reshape(19, 31) < 0.03
    mapped[4, 7] = True
    source = nearest_mapped(mapped)
    assert mapped.ravel()[source].all()
    row, column = np.indices(mapped.shape)
    away = np.hypot(source // 31 - row, source % 31 - column)
    np.testing.assert_allclose(away, oracle.nearest_mapped_distance(mapped), atol=1e-12)


def test_fill_refuses_an_empty_page():
    with pytest.raises(InputError, match="no texel of the 4 x 3 page is mapped"):
        fill_nearest([np.zeros((3, 4))], np.zeros((3, 4), bool))


@pytest.mark.parametrize("channels", [(), (3,)])
def test_lookup_mixes_four_texels_and_halving_averages_them(channels):
    draw = stream(3, "picture").uniform(8 * 12, 3).astype(np.float32)
    image = draw.reshape(8, 12, 3) if channels else draw[:, 0].reshape(8, 12)
    uv = stream(4, "places").uniform(200, 2) * 1.2 - 0.1
    np.testing.assert_allclose(bilinear(image, uv), oracle.bilinear(image, uv), atol=1e-12)
    smaller = half(image)
    assert smaller.shape == (4, 6, *channels)
    np.testing.assert_allclose(smaller, image.reshape(4, 2, 6, 2, *channels).mean(axis=(1, 3)), rtol=1e-6)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("channels", [(), (3,)])
def test_lookup_in_a_mip_is_lookup_in_the_halved_picture(channels, dtype, monkeypatch):
    image = stream(5, "picture").uniform(24 * 16, 3).astype(dtype).reshape(24, 16, 3)
    image = image if channels else image[..., 0]
    uv = stream(6, "places").uniform(300, 2) * 1.2 - 0.1
    smaller = image
    for mip in (1, 2, 3):
        smaller = half(smaller)
        np.testing.assert_array_equal(bilinear(image, uv, mip), bilinear(smaller, uv))
        with monkeypatch.context() as patch:
            patch.setattr("surftex.charts.lookup._KEPT", 2)
            np.testing.assert_array_equal(bilinear(image, uv, mip), bilinear(smaller, uv))
            patch.setattr("surftex.paged.LARGEST_IN_MEMORY", 1)
            patch.setattr("surftex.paged._BLOCK_BYTES", 4 * image[:1].nbytes)
            np.testing.assert_array_equal(bilinear(image, uv, mip), bilinear(smaller, uv))
    np.testing.assert_allclose(bilinear(image, uv, 3), oracle.bilinear(smaller, uv), atol=1e-6)


@pytest.mark.parametrize("covered", [0.0, 0.3, 1.0])
def test_texels_with_a_face_are_closed_up_in_their_order(covered):
    numbers = stream(3, "test").uniform(500, 6)
    there = numbers[:, 0] < covered
    face = np.where(there, 1000 * numbers[:, 1], -1).astype(np.int32)
    host, follows = (1000 * numbers[:, 2]).astype(np.int32), (4 * numbers[:, 3]).astype(np.int8)
    parts = [
        face,
        host,
        numbers[:, :3].copy(),
        numbers[:, 4].astype(np.float32),
        numbers[:, 5] < 0.5,
        follows,
    ]
    expected = [part[there] for part in parts]
    texel = np.zeros(len(expected[0]), np.int64)
    close_up(7000, *parts, texel)
    np.testing.assert_array_equal(texel, 7000 + np.flatnonzero(there))
    for part, kept in zip(parts, expected, strict=True):
        np.testing.assert_array_equal(part[: len(texel)], kept)


def test_leaders_are_the_first_of_their_blocks():
    width, side = 24, np.zeros((24, 24), np.int8)
    side[4:12, 8:24], side[16:20, 0:4], side[12:14, 2:6] = 4, 4, 2
    there = (side > 0) | (stream(5, "test").uniform(24 * 24).reshape(24, 24) < 0.5)
    texel = np.flatnonzero(there)
    row, column = texel // width, texel % width
    block = np.maximum(side[row, column], 1)
    leader = row // block * block * width + column // block * block
    source = np.zeros(len(texel), np.int32)
    find_leaders(texel, width, side[row, column], source)
    np.testing.assert_array_equal(texel[source], leader)
