"""Depths, widths and colours that change without placing anew: the same numbers as a whole new pattern."""

import numpy as np
import pytest

from surftex.features.uniform import area_points
from surftex.materials.cells import pattern as grown
from surftex.materials.cells.model import Cells
from surftex.materials.layers import Reshaping
from surftex.materials.leather import pattern as hide
from surftex.materials.leather.model import Leather
from surftex.materials.skin import pattern as living
from surftex.materials.skin.model import Skin
from surftex.randomness import stream
from surftex.surface.points import Samples
from surftex.surface.shapes import sphere

EVERYTHING = {
    "cell_size": 1.5, "wrinkle_count": 4, "wrinkle_fold": 0.2, "pore_density": 1.0, "pocket_depth": 0.01, "invasion": 0.3,
    "crown_spacing": 4.0, "crown_width": 1.2, "sulcus_variation": 0.2, "scale_overlap": 0.1, "crista_exponent": 3.0,
}  # fmt: skip


@pytest.fixture(scope="module")
def placed():
    ball = sphere(5.0, subdivisions=3)
    points = area_points(ball, stream(1, "samples").uniform(1500, 3))
    samples = Samples(points, np.full(len(points), 0.02, np.float32))
    leather = Leather.preset("calf", **EVERYTHING)
    cells = Cells(cell_size=2.0, wrinkle_count=2, generations=60)
    counts = {f"{kind}_count": 3 for kind in (*Skin().order, "vessel", "wrinkle")}
    skin = Skin(pore_lean=1.0, variation=0.0, **counts)
    return ball, samples, {
        name: (material, pattern, pattern.gather(samples))
        for name, material in (("leather", leather), ("cells", cells), ("skin", skin))
        for pattern in [material.place(ball, 3)]
    }  # fmt: skip


def changed(material, key):
    value = getattr(material, key)
    if isinstance(value, tuple):
        return material.model_copy(update={key: (0.3, 0.2, 0.1)[: len(value)]})
    return material.model_copy(update={key: 0.7 * value if value else 0.3})


@pytest.mark.parametrize(
    ("name", "key"),
    [
        (name, key)
        for name, keys in (("leather", hide.SHAPING), ("cells", grown.SHAPING), ("skin", living.SHAPING))
        for key in sorted(keys)
    ],
)
def test_reshaped_is_the_same_as_evaluated_anew(placed, name, key):
    ball, samples, made = placed
    material, pattern, gathered = made[name]
    other = changed(material, key)
    reshaped = pattern.reshaped(other)
    if reshaped is None:
        assert not getattr(material, key), key  # from nothing to something there is more to gather
        return
    assert isinstance(reshaped, Reshaping)
    quick = reshaped.shape(gathered, samples.footprint_mm)
    whole = other.place(ball, 3, features=pattern.features).at(samples)
    before = pattern.shape(gathered, samples.footprint_mm)
    for channel, values in whole.channels.items():
        np.testing.assert_array_equal(quick[channel], values, err_msg=channel)
    assert any((before[channel] != values).any() for channel, values in whole.channels.items())


def test_what_moves_elements_is_not_reshaped(placed):
    material, pattern, _ = placed[2]["leather"]
    for change in ({"cell_size": 1.6}, {"waviness": 0.5}, {"pore_width": 1.6 * material.pore_width},
                   {"grain_height": 0.0}):  # fmt: skip
        assert pattern.reshaped(material.model_copy(update=change)) is None
    assert pattern.reshaped(material) is not None


@pytest.mark.parametrize("name", ["leather", "cells", "skin"])
def test_what_is_kept_would_have_been_placed_the_same(placed, name):
    material = placed[2][name][0].model_copy(update={"wrinkle_count": 1})
    ball = sphere(4.0 if name == "skin" else 2.2, subdivisions=2)
    pattern, moved = material.place(ball, 3), 0
    for key in type(material).model_fields:
        value = getattr(material, key)
        if not isinstance(value, (int, float, tuple)) or key in ("order", "up"):
            continue
        other = changed(material, key)
        if isinstance(value, int):
            other = material.model_copy(update={key: not value if isinstance(value, bool) else value + 1})
        if pattern.keeps(other):
            anew = other.place(ball, 3).features
            assert anew.keys() == pattern.features.keys(), key
            for kind, table in anew.items():
                assert table.tobytes() == pattern.features[kind].tobytes(), key
        else:
            moved += 1
    assert moved >= 8
