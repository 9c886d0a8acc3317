"""Kernels that blend a skin's features, beside their slow twins."""

from types import SimpleNamespace

import numpy as np
import pytest

from surftex.features.curves import curve_table
from surftex.features.growth import spline
from surftex.features.uniform import scatter
from surftex.materials.skin.curves import CurveKind
from surftex.materials.skin.kinds import STATE
from surftex.materials.skin.lines import LINE
from surftex.materials.skin.model import Skin
from surftex.materials.skin.points import PointKind
from surftex.randomness import stream
from surftex.surface.closest import closest_points
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.shapes import plane
from tests.oracles import skin as oracle


def sheet_and_samples(footprint_mm, count=600):
    sheet = plane(20.0)
    points = scatter(sheet, stream(8, "samples"), count=count)
    return sheet, Samples(points, np.full(count, footprint_mm, np.float32))


@pytest.mark.parametrize("footprint_mm", [0.01, 0.7])
@pytest.mark.parametrize("name", ["mole", "follicle", "cyst"])
def test_points_blend_as_their_twin(name, footprint_mm):
    sheet, samples = sheet_and_samples(footprint_mm)
    count = 9
    skin = Skin(mole_irregularity=0.9, follicle_lean=2.5, follicle_count=count, cyst_height=(0.1, 0.3))
    features = stream(4, "features").uniform(count, 4)
    names = ("radius_mm", "melanin", "angle_rad", "height_mm")
    table = np.zeros(count, [("face", "i4"), ("barycentric", "f8", 3), *[(key, "f4") for key in names]])
    places = scatter(sheet, stream(5, "features"), count=count)
    table["face"], table["barycentric"] = places.face, places.barycentric
    for i, key in enumerate(names):
        table[key] = (0.5, 0.0, 0.0, 0.1)[i] + (2.5, 0.3, 6.0, 0.2)[i] * features[:, i]
    kind = PointKind.build(skin, sheet, name, table, None, stream(6, "outline"), None)
    state = np.full((len(samples), len(STATE)), 0.3, np.float32)
    kind.blend(samples, state)
    twin = SimpleNamespace(
        finest_mm=kind.finest_mm, size=kind.size, outline=kind.outline, turned=kind.turned, spread=kind.spread,
        amount=kind.amount, table=kind.table, changes=[STATE.index(change.channel) for change in kind.changes],
        rules={STATE.index(change.channel): change.rule for change in kind.changes},
    )  # fmt: skip
    away = samples.points.positions(sheet)[:, None] - places.positions(sheet)
    offset = np.einsum("nfx,fax->nfa", away, sheet.frame[places.face][:, :2])
    wanted = np.array([oracle.blended(row, footprint_mm, twin, [0.3] * len(STATE)) for row in offset])
    changed = np.abs(wanted - 0.3).max(axis=1) > 1e-4
    assert changed.mean() > 0.05
    assert np.abs(state - wanted).max() < 2e-5


@pytest.mark.parametrize(("footprint_mm", "fade"), [(0.01, 0.0), (0.01, 1.0), (0.8, 1.0)])
def test_curves_crease_as_their_twin(footprint_mm, fade):
    """Three that cross, bend and fold to either side."""
    sheet, samples = sheet_and_samples(footprint_mm, 2500)
    middle = sheet.vertices.mean(axis=0)
    drawn = [
        ([(-7, -3), (0, -3), (7, -3)], 1.5, 0.4, 1.0),
        ([(-5, 5), (0, 1), (4, -6)], 1.0, 0.3, -1.0),
        ([(-6, -6), (-4, 0), (-5, 7)], 0.7, 0.2, 1.0),
    ]
    controls = np.concatenate([np.c_[np.array(line[0], float), np.zeros(3)] for line in drawn]) + middle
    points, _ = closest_points(sheet, controls)
    pieces = spline(sheet, points, np.repeat(np.arange(3), 3))
    width, depth, side = (np.array([line[i] for line in drawn]) for i in (1, 2, 3))
    table = curve_table(sheet, pieces, width_mm=width, depth_mm=depth, side=side)
    assert set(table.dtype.names) == set(LINE.names)
    kind = CurveKind.build(sheet, table, "valley", None, fold=0.25, fade=fade)
    got = kind.at(samples)
    lines = []
    for i, (_, half, deep, to) in enumerate(drawn):
        rows = table[table["curve"] == i]
        ends = [
            SurfacePoints(rows["face"], rows[key]).positions(sheet)
            for key in ("barycentric", "end_barycentric")
        ]
        lines.append((np.concatenate([ends[0], ends[1][-1:]])[:, :2], half, deep, 0.25 * deep, to))
    twin = np.array(
        [
            oracle.creased(place[:2], footprint_mm, lines, *kind.table, kind.spread, fade)
            for place in samples.points.positions(sheet)
        ]
    )
    assert (twin > 0.01).any(axis=0).all()
    assert np.abs(np.stack(got, axis=1) - twin).max() < 1e-4


def test_curves_that_cross_leave_no_ridge():
    """Where two equal creases cross, the floor is no higher than either and less than a fifth deeper."""
    sheet = plane(10.0)
    middle = sheet.vertices.mean(axis=0)
    controls = np.array([(-4, 0, 0), (0, 0, 0), (4, 0, 0), (0, -4, 0), (0, 0, 0), (0, 4, 0)]) + middle
    points, _ = closest_points(sheet, controls)
    table = curve_table(
        sheet,
        spline(sheet, points, np.repeat([0, 1], 3)),
        width_mm=np.ones(2),
        depth_mm=np.ones(2),
        side=np.ones(2),
    )
    kind = CurveKind.build(sheet, table, "valley", None)
    at, _ = closest_points(sheet, middle + np.linspace(-1, 1, 201)[:, None] * np.array([1.0, 0, 0]))
    depth, _ = kind.at(Samples(at, np.full(201, 0.001, np.float32)))
    assert 1.0 <= depth[100] < 1.2
    assert (depth[80:121] > 0.7).all()
    assert np.abs(np.diff(depth)).max() < 0.05
