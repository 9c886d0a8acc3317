"""What a bake promises: threads, tiles, the unwrap and the resolution decide nothing about the leather."""

import numpy as np
import pytest

import surftex as sx
from surftex.charts.lookup import bilinear
from surftex.features.uniform import scatter
from surftex.randomness import stream
from surftex.surface.shapes import cylinder, torus

LEATHER = {"cell_size": 2.5, "wrinkle_count": 2, "wrinkle_length": 12, "pore_density": 0.3, "pore_width": 0.5,
           "sulcus_width": 0.6, "pocket_width": 0.5, "wrinkle_width": 0.9, "grain_height": 0}  # fmt: skip


def baked(surface, **options):
    leather = sx.Leather.preset("calf", **LEATHER)
    options = {"resolution": 256, "seed": 4, "unwrapper": "uvunwrap", **options}
    return sx.bake(
        surface, leather, maps="base_color,roughness,normal,height,ambient_occlusion,region", **options
    )


def same(first, second):
    for name in first:
        assert first[name].tobytes() == second[name].tobytes(), name
    assert set(first.features) == set(second.features)
    for kind, table in first.features.items():
        assert table.tobytes() == second.features[kind].tobytes(), kind


@pytest.fixture(scope="module")
def tube():
    return baked(cylinder(10.0, 25.0), threads=1)


@pytest.mark.parametrize("options", [{"threads": 2}, {"tile": 61, "threads": 2}, {"tile": 256}])
def test_threads_and_tiles_change_no_byte(tube, options):
    same(tube, baked(cylinder(10.0, 25.0), **options))


def test_a_bake_from_a_features_file_gives_the_same_bytes(tube, tmp_path):
    tube.save(tmp_path / "out")
    same(tube, baked(cylinder(10.0, 25.0), features=tmp_path / "out" / "features.npz"))


def test_features_are_the_same_at_every_resolution_and_under_every_unwrap(tube):
    other = baked(cylinder(10.0, 25.0), resolution=64, unwrapper="xatlas")
    for kind, table in tube.features.items():
        assert table.tobytes() == other.features[kind].tobytes(), kind


def test_the_unwrap_moves_texels_and_never_heights():
    ring = torus(12.0, 5.0)
    places = scatter(ring, stream(1, "test"), count=5000)
    heights = []
    for unwrapper in ("uvunwrap", "xatlas"):
        maps = baked(ring, resolution=1024, unwrapper=unwrapper, seed=1)
        uv = np.einsum("pk,pkc->pc", places.barycentric, maps.atlas.corner_uv[places.face])
        heights.append(bilinear(maps["height"], uv))
    relief = heights[0].std()
    assert relief > 0.01
    assert np.quantile(np.abs(heights[0] - heights[1]), 0.99) < 0.05 * relief


def test_another_seed_is_another_leather(tube):
    other = baked(cylinder(10.0, 25.0), seed=5)
    assert (
        len(other.features["cell"]) != len(tube.features["cell"])
        or (other.features["cell"]["face"] != tube.features["cell"]["face"]).any()
    )
