"""Pairs of triangles: every triangle is in one cell, and no star is left, nor any exchange that would mend one."""

import numpy as np
import pytest

from surftex.arrays import frozen
from surftex.features.cell_mesh import paired
from surftex.features.cells_plane import plane_triangles
from surftex.kernels.star_knots import untie_stars
from surftex.materials.cells.model import Cells

SIDE = 30.0


def scattered(count, seed, closest):
    """Places of a tile, hardly two of them nearer than `closest`: worse than any growth."""
    random = np.random.Generator(np.random.PCG64(seed))
    place = np.zeros((0, 2))
    for one in random.uniform(0, SIDE, (20 * count, 2)):
        away = np.abs(place - one)
        if len(place) < count and (np.hypot(*np.minimum(away, SIDE - away).T) > closest).all():
            place = np.vstack([place, one])
    return place


@pytest.fixture(scope="module")
def triangles():
    place = scattered(500, 1, 0.7)
    return plane_triangles(place, SIDE, np.ones(len(place)), np.zeros(len(place)))


def test_every_triangle_is_in_one_cell(triangles):
    cells = paired(triangles, share=0.6, most_rad=np.radians(40))
    quads = cells[:, 3] >= 0
    assert 2 * quads.sum() + (~quads).sum() == len(triangles)
    halves = np.concatenate([cells[quads][:, [0, 1, 3]], cells[quads][:, [1, 2, 3]], cells[~quads][:, :3]])
    other = np.concatenate([cells[quads][:, [0, 1, 2]], cells[quads][:, [0, 2, 3]], cells[~quads][:, :3]])
    have = {tuple(sorted(row)) for row in triangles.corner}
    assert all(
        tuple(sorted(a)) in have or tuple(sorted(b)) in have for a, b in zip(halves, other, strict=True)
    )


def around(cells, count):
    """Number of cells, and of lone triangles, at each particle."""
    meeting = np.bincount(cells[cells >= 0], minlength=count)
    return meeting, np.bincount(cells[cells[:, 3] < 0][:, :3].ravel(), minlength=count)


def test_stars_are_untied_where_particles_lie_at_random(triangles, monkeypatch):
    import surftex.kernels.star_knots as knots

    count = int(triangles.corner.max()) + 1
    meeting, lone = around(paired(triangles, share=0.6, most_rad=np.radians(40)), count)
    monkeypatch.setattr(knots, "untie_stars", lambda *given: 0)
    before = around(paired(triangles, share=0.6, most_rad=np.radians(40)), count)
    assert (before[0] >= 7).sum() + (before[1] >= 4).sum() > 20
    assert (meeting >= 7).sum() + (lone >= 4).sum() <= 3


def test_untying_ends_where_no_exchange_helps_and_keeps_mates_mutual():
    # a hexagon around particle 0, of six lone triangles, with six more outside
    corner = [[0, k, k % 6 + 1] for k in range(1, 7)] + [[k % 6 + 1, k, 6 + k] for k in range(1, 7)]
    corner = np.array(corner, np.int64)
    twin = np.full((12, 3), -1, np.int64)
    for k in range(6):
        twin[k] = 3 * ((k - 1) % 6) + 2, 3 * (6 + k), 3 * ((k + 1) % 6)
        twin[6 + k, 0] = 3 * k + 1
    angle = np.full((12, 3), np.pi / 3)
    angle[:6] = np.radians([30.0, 75.0, 75.0])
    worst = np.where(twin >= 0, np.radians(30.0), np.inf)
    mate = np.full(12, -1, np.int64)
    spoke = np.argsort(corner.ravel(), kind="stable")
    start = np.append(0, np.cumsum(np.bincount(corner.ravel())))
    given = frozen(corner), frozen(twin), angle, worst, np.full((12, 3), 1.0), mate, start, spoke
    assert untie_stars(*given) >= 2
    paired_up = np.flatnonzero(mate >= 0)
    for t in paired_up:
        other, side = divmod(int(mate[t]), 3)
        assert mate[other] // 3 == t
        assert twin[other, side] == mate[other]
    assert (mate[:6] < 0).sum() <= 2
    assert untie_stars(*given) == 0


@pytest.mark.parametrize("name", ["cells", "mixed", "milled"])
def test_hardly_a_star_is_left_in_a_preset(name):
    cells = Cells.preset(name, cell_size=1.0, blob_density=0.0).tile(30.0, 1).features["cell"]["corner"]
    meeting, lone = around(cells.astype(np.int64), int(cells.max()) + 1)
    assert (meeting >= 7).mean() < 0.005
    assert (lone >= 4).mean() < 0.005
