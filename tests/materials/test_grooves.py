"""Grooves of drawn lines: where they meet, and where they taper, the relief has no steps."""

import numpy as np
import pytest

import surftex as sx
from surftex.bake.fields import make_fields
from surftex.files.strokes import Stroke, write_strokes
from surftex.surface.closest import closest_points
from surftex.surface.points import Samples
from surftex.surface.shapes import plane

BENT = [[5, 5, 0], [30, 50, 0], [55, 10, 0]]
ACROSS = [[5, 30, 0], [25, 30, 0], [45, 28, 0]]
NEAR = [[5, 27, 0], [25, 28.5, 0], [45, 26, 0]]
STEP_MM = 0.02

MATERIALS = {
    "leather": sx.Leather(cell_size=6.0, wrinkle_density=0.0, grain_height=0.0, wrinkle_curves="lines"),
    "folded": sx.Leather(
        cell_size=6.0, wrinkle_density=0.0, grain_height=0.0, wrinkle_curves="lines", wrinkle_fold=0.5
    ),
    "cells": sx.Cells(cell_size=6.0, generations=20, grain_height=0.0, wrinkle_curves="lines"),
}


@pytest.fixture(scope="module")
def sheet():
    return plane(60.0, cells=12)


def lowered_by(material, sheet, lines, folder):
    """A function of places in the plane: by how much drawn lines lower a material there."""
    strokes = [
        Stroke(closest_points(sheet, np.subtract(line, sheet.origin_mm))[0], "", numbers)
        for line, numbers in lines
    ]
    write_strokes(folder / "lines.json", sheet, strokes)
    fields = {"lines": {"curves": str(folder / "lines.json"), "width": 2.0, "depth": 0.4}}
    names = make_fields(
        sx.Recipe.model_validate({"fields": fields, "layer": [{"material": material.kind}]}), sheet
    )
    drawn = material.place(sheet, 1, fields=names)
    plain = material.model_copy(update={"wrinkle_curves": None}).place(sheet, 1, fields=names)

    def lowered(xy):
        xyz = np.column_stack([xy, np.zeros(len(xy))]) - sheet.origin_mm
        points = closest_points(sheet, xyz)[0]
        samples = Samples(points, np.full(len(points), STEP_MM, np.float32))
        return plain.at(samples)["height_mm"] - drawn.at(samples)["height_mm"]

    return lowered


@pytest.fixture(params=MATERIALS)
def sunk(request, sheet, tmp_path):
    lines = [
        (BENT, {}),
        (ACROSS, {"width_mm": 4.0, "depth_mm": 0.5}),
        (NEAR, {"width_mm": 1, "depth_mm": 0.8}),
    ]
    return lowered_by(MATERIALS[request.param], sheet, lines, tmp_path)


def test_where_lines_of_unequal_width_and_depth_meet_there_is_no_step(sunk):
    """`valley` is (1 - x)^4 (4 x + 1), so that no groove's wall is steeper than 2.2 depth / width; a fold adds to it."""
    for x in np.linspace(8, 52, 23):
        down = np.column_stack([np.full(2200, x), 8 + STEP_MM * np.arange(2200)])
        height = sunk(down)
        assert height.max() > 0.2
        assert np.abs(np.diff(height)).max() < 1.2 * 2.2 * STEP_MM * 0.8


def test_the_deepest_of_grooves_that_meet_counts(sunk):
    middle = sunk(np.array(BENT[:1])[:, :2] + [[0.02, 0.02]])
    assert middle[0] < 0.4
    for place, depth in (([25.0, 30.0], 0.5), ([25.0, 28.5], 0.8)):
        near = sunk(np.add(place, np.mgrid[-1:1:41j, -1:1:41j].reshape(2, -1).T))
        assert 0.7 * depth < near.max()  # a fold beside it lifts some


ENDLESS = {
    "leather": sx.Leather(
        cell_size=6.0, wrinkle_density=0.0, grain_height=0.0, wrinkle_taper=9.0, wrinkle_curves="lines"
    ),
    "folded": MATERIALS["folded"],
    "cells": sx.Cells(cell_size=6.0, generations=20, grain_height=0.0, wrinkle_curves="lines"),
    "skin": sx.Skin(wrinkle_curves="lines", wrinkle_fold=0.0),
}


@pytest.mark.parametrize("name", ENDLESS)
def test_a_closed_line_has_no_ends(name, sheet, tmp_path):
    turn = np.linspace(0, 2 * np.pi, 25)
    ring = np.stack([30 + 15 * np.cos(turn), 30 + 15 * np.sin(turn), 0 * turn], axis=1)
    around = np.linspace(0, 2 * np.pi, 400)
    at = np.column_stack([30 + 15 * np.cos(around), 30 + 15 * np.sin(around)])
    closed = lowered_by(ENDLESS[name], sheet, [(ring, {})], tmp_path)(at)
    assert 0.36 < closed.min() <= closed.max() < 0.44
    if name != "folded":
        opened = lowered_by(ENDLESS[name], sheet, [(ring[:-1], {})], tmp_path)(at)
        assert opened.min() < 0.1
