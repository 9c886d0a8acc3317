"""Lattices on surfaces: walks end where straight lines end, texels are as large everywhere, pictures have no seam."""

import numpy as np
import pytest

from surftex.charts.oriented import oriented
from surftex.charts.seams import probe, seam_samples
from surftex.charts.surface_lattice import SurfaceLattice
from surftex.charts.unwrap import unwrap
from surftex.errors import InputError, WorkError
from surftex.geodesics.directions import DirectionField
from surftex.geodesics.tracing import WHOLE, trace
from surftex.randomness import stream
from surftex.surface.shapes import plane, sphere, torus

OFFSETS = np.array([(1, 0), (-1, 0), (0, 1), (0, -1), (5, 2), (-3, 7)])


@pytest.fixture(scope="module")
def ring():
    surface = torus(12.0, 5.0, columns=48, rows=24)
    return SurfaceLattice.of(surface, DirectionField.smoothest(surface), 0.5)


def test_on_a_sheet_offsets_are_steps_to_the_right_and_down():
    sheet = plane(20.0, cells=4)
    lattice = SurfaceLattice.of(sheet, DirectionField.constant(sheet, 0.4 + np.pi / 2), 0.5)
    table = lattice.table(OFFSETS, stream(1, "test"))
    place = lattice.points.positions(sheet)[:, :2]
    right, down = np.array([np.cos(0.4), np.sin(0.4)]), np.array([np.sin(0.4), -np.cos(0.4)])
    for (across, below), column in zip(OFFSETS, table.T, strict=True):
        inside = column[:-1] < len(lattice)
        step = place[column[:-1][inside]] - place[inside]
        assert np.abs(step - 0.5 * (across * right + below * down)).max() < 1e-6
        goal = place[~inside] + 0.5 * (across * right + below * down)
        assert (
            np.abs(goal - 10.0).max(axis=1) > 10.0 - 0.36
        ).all()  # half a texel's diagonal from the border


def test_walks_end_where_straight_lines_end(ring):
    table = ring.table(OFFSETS, stream(1, "test"))
    away = []
    for (across, below), column in zip(OFFSETS, table.T, strict=True):
        angle = ring.angle_rad + np.arctan2(-below, across) - np.pi / 2
        walked = trace(ring.surface, ring.points, angle, 0.5 * np.hypot(across, below))
        assert (walked.reason == WHOLE).all()
        some = column[:-1] < len(ring)
        end, site = (
            walked.end.positions(ring.surface)[some],
            ring.points.positions(ring.surface)[column[:-1][some]],
        )
        away.append(np.linalg.norm(end - site, axis=1) / 0.5)
    away = np.concatenate(away)
    assert np.median(away) < 0.6  # a step of up to half a texel each way is added before rounding
    assert np.quantile(away, 0.999) < 1.6


def test_texels_are_as_large_as_asked_and_follow_the_field(ring):
    assert len(ring) == pytest.approx(ring.surface.area_mm2 / 0.25, rel=0.05)
    jacobian = ring.atlas.jacobian_mm(ring.surface, ring.side)
    up = np.arctan2(jacobian[:, 1, 1], jacobian[:, 0, 1])
    turn = np.angle(np.exp(1j * (up - DirectionField.smoothest(ring.surface).angle_rad)))
    area = ring.surface.face_area_mm2
    chart_turn = np.bincount(ring.atlas.chart, turn * area) / np.bincount(ring.atlas.chart, area)
    assert np.abs(chart_turn).max() < 0.2


def test_threads_change_no_byte(ring):
    surface = ring.surface
    again = SurfaceLattice.of(surface, DirectionField.smoothest(surface), 0.5, threads=1)
    assert again.site.tobytes() == ring.site.tobytes()
    one, three = (ring.table(OFFSETS, stream(1, "test"), threads=n) for n in (1, 3))
    assert one.tobytes() == three.tobytes()


def test_a_picture_on_a_lattice_has_no_seam():
    ball = sphere(20.0, subdivisions=4)
    lattice = SurfaceLattice.of(ball, DirectionField.smoothest(ball), 0.4)
    truth = probe(ball, lattice.points, 8.0)
    picture = lattice.image(truth)
    assert np.abs(picture.at(lattice.points) - truth).max() < 0.05
    samples = seam_samples(ball, lattice.atlas, lattice.side)
    assert len(samples) > 100
    jump = picture.at(samples.here) - picture.at(samples.there)
    assert np.sqrt((jump**2).mean()) < 0.01 * truth.std()


def test_a_wide_footprint_reads_means():
    ball = sphere(20.0, subdivisions=3)
    lattice = SurfaceLattice.of(ball, DirectionField.smoothest(ball), 0.5)
    noise = stream(2, "test").uniform(len(lattice))[:, 0]
    picture = lattice.image(noise, even=False)
    spread = [
        picture.at(lattice.points, np.full(len(lattice), width)).std() / noise.std()
        for width in (0.5, 1.0, 2.0)
    ]
    assert spread[0] == pytest.approx(1.0, abs=1e-3)
    assert spread[2] < 0.6 * spread[1] < 0.3


def test_pitches_that_cannot_be_are_refused():
    ball = sphere(20.0, subdivisions=2)
    up = DirectionField.smoothest(ball)
    with pytest.raises(WorkError, match="at most"):
        oriented(ball, unwrap(ball, resolution=256), up.angle_rad, texel_mm=1e-3, gutter_px=4)
    with pytest.raises(InputError, match="make pixels smaller"):
        SurfaceLattice.of(ball, up, 4000.0)
