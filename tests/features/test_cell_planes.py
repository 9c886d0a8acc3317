"""Cells in planes of their own: logs along the shortest of all ways, and outlines that bend with the surface."""

import numpy as np
import pytest
from scipy.spatial import KDTree

from surftex.features.cell_outlines import outlined
from surftex.features.cell_planes import CellPlanes, straight_bends
from surftex.features.near_logs import near_logs
from surftex.geodesics.paths import shortest_path
from surftex.materials.cells.model import Cells
from surftex.randomness import stream
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.shapes import plane, sphere
from surftex.surface.surface import Surface


def scattered(surface, count, seed):
    random = np.random.Generator(np.random.PCG64(seed))
    face = random.choice(len(surface.faces), count, p=surface.face_area_mm2 / surface.area_mm2)
    return SurfacePoints(face, random.dirichlet([1, 1, 1], count))


def squashed(subdivisions, *scale):
    ball = sphere(9.0, subdivisions=subdivisions)
    return Surface.from_arrays(ball.vertices * np.array(scale), ball.faces)


def test_logs_on_a_plane_are_differences():
    sheet = plane(10.0, cells=5)
    points = scattered(sheet, 40, 1)
    first, second = np.arange(40), np.roll(np.arange(40), 7)
    vector, distance = near_logs(sheet, points, points, first, second)
    where = points.positions(sheet)
    frame = sheet.frame[points.face]
    step = np.einsum("pi,pik->pk", vector, frame[:, :2])
    np.testing.assert_allclose(step, where[second] - where[first], atol=1e-7)
    np.testing.assert_allclose(distance, np.linalg.norm(where[second] - where[first], axis=1), atol=1e-7)


def test_logs_find_the_shorter_way_around_an_edge():
    lens = squashed(1, 1.0, 0.5, 0.15)
    points = scattered(lens, 400, 2)
    first, second = np.arange(400), np.roll(np.arange(400), 1)
    vector, distance = near_logs(lens, points, points, first, second)
    path = shortest_path(lens, points, points.taken(second))[1]
    assert (distance <= path).all()
    assert (distance < 0.98 * path).sum() > 5
    back = near_logs(lens, points, points, second, first)[1]
    np.testing.assert_allclose(back, distance, rtol=1e-6)
    np.testing.assert_allclose(np.hypot(*vector.T), distance, rtol=1e-6)


def rho_of(planes, place):
    """Gauge of a place in the outline of one cell that is not shrunk."""
    outlines = outlined(
        planes, gap=0.0, rounding=1e-3, taper=0.5, blob_density=0.0, blob_radius=0.1, blob_variation=0.0,
        random=stream(0, "none"),
    )  # fmt: skip
    assert outlines.edges[0] <= 24
    edge = outlines.edge[0, : outlines.edges[0]]
    return (edge @ (np.asarray(place) - outlines.middle[0])).max()


def test_a_side_that_bends_outward_takes_its_middle_along():
    corner = np.array([[[-1.0, -1], [1, -1], [1, 1], [-1, 1]]])
    bend = straight_bends(corner)

    def planes(bend):
        return CellPlanes(corner, bend, np.array([4]), np.eye(3)[None, :2], np.ones(1))

    assert rho_of(planes(bend), [1.0, 0.0]) == pytest.approx(1, abs=1e-6)
    out = bend.copy()
    out[0, 1] = [1.5, 0.2]
    assert rho_of(planes(out), [1.5, 0.2]) == pytest.approx(1, abs=2e-3)
    assert rho_of(planes(out), [0.0, 0.99]) < 1
    inward = bend.copy()
    inward[0, 1] = [0.6, 0.0]
    assert rho_of(planes(inward), [0.8, 0.0]) == pytest.approx(1, abs=1e-6)
    assert rho_of(planes(inward), [-1.0, 0.0]) == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("lens", [(0, 1.0, 1.0, 0.25), (2, 1.0, 0.5, 0.15)])
def test_no_place_of_a_sharp_coarse_mesh_is_far_from_cells(lens):
    surface = squashed(*lens)
    points = scattered(surface, 30_000, 3)
    pattern = Cells(cell_size=2.0, waviness=0.0).place(surface, 0)
    place = pattern.gather(Samples(points, np.full(len(points), 0.02, np.float32)))
    bald = (place.owner < 0) | (place.rho > 1)
    where = np.concatenate([points.positions(surface), surface.frame[points.face, 2]], axis=1)
    far = KDTree(where[~bald]).query(where[bald])[0]
    assert (
        far.max() < 0.3 * 2.0
    )  # measured 0.26 and 0.24 cell sizes; 0.40 with straight sides and paths that are not shortest
