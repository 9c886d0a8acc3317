from dataclasses import replace

import numpy as np
import pytest

from surftex.exemplar import relaxation
from surftex.exemplar.cliques import quad_pool
from surftex.exemplar.lattice import Plane, Table
from surftex.exemplar.learn import learn_texture
from surftex.exemplar.measure import pair_shares, quad_shares
from surftex.exemplar.relaxation import Relaxation
from surftex.exemplar.target import quarters
from surftex.randomness import stream
from tests.exemplar.pictures import pebbles
from tests.oracles import exemplar as slow


def shares(count):
    return count / np.maximum(count.sum(axis=-1, keepdims=True), 1)


def levels(bands, height, width, most=32, seed=3):
    numbers = most * stream(seed, "test", "levels").uniform(bands * height * width)
    return numbers.reshape(bands, height, width).astype(np.uint8)


PAIRS = np.array([(0, 0, 1, 0), (0, 0, -2, 3), (0, 1, 0, 0), (1, 0, 4, -1)], np.int32)


@pytest.mark.parametrize("wrap", [True, False])
@pytest.mark.parametrize("joint", [True, False])
def test_pairs_are_counted_as_their_twin_counts_them(wrap, joint):
    picture = levels(2, 9, 12, 8 if joint else 32)
    picture[:, 2, 3] = 255
    label = levels(1, 9, 12, 3, seed=5)[0]
    plane = Plane.of(9, 12, 4, wrap=wrap)
    found = pair_shares(
        plane, plane.hold(picture), PAIRS, code=(8, 0) if joint else (-1, 31),
        group=plane.hold(label[None], 0)[0], groups=3,
    )  # fmt: skip
    assert found == pytest.approx(
        shares(slow.pair_counts(picture, PAIRS, wrap=wrap, joint=joint, label=label))
    )


@pytest.mark.parametrize("wrap", [True, False])
def test_quads_are_counted_as_their_twin_counts_them(wrap):
    picture = levels(1, 10, 11)
    picture[0, 4, 4] = 255
    plane = Plane.of(10, 11, 6, wrap=wrap)
    quarter = quarters(np.full((1, 32), 1 / 32))
    band, shape = quad_pool((0,), (1, 2))
    found = quad_shares(plane, plane.hold(picture), band, shape, quarter[None])[0]
    assert found == pytest.approx(shares(slow.quad_counts(picture, band, shape, quarter, wrap=wrap)))


@pytest.mark.parametrize("order", ["pair", "quad"])
def test_a_sweep_draws_what_its_twin_draws(order):
    model = learn_texture(pebbles(64, 6), order=order, pairs=5, spacings=(1, 2), radius=5)
    picture = levels(1, 14, 17)
    plane = Plane.of(14, 17, max(6, model.target.radius), wrap=True)
    drawn = Relaxation(model.target, plane, plane.hold(picture), stream(4, "test"), threads=1)
    for _ in range(3):
        drawn.sweep()
        drawn.follow()
    before = plane.picture(drawn.level)
    expected = slow.sweep(drawn, before)
    drawn.sweep()
    assert (plane.picture(drawn.level) == expected).all()
    assert (expected != before).mean() > 0.5


def test_the_order_of_quads_changes_no_byte():
    model = learn_texture(
        np.stack([pebbles(64, 6, seed) for seed in (1, 2, 3)], axis=-1), pairs=3, spacings=(1,), radius=4
    )
    mixed = np.argsort(stream(1, "test", "order").uniform(len(model.target.quad_band))[:, 0])
    part = {name: getattr(model.target, name) for name in ("quad", "quad_used", "quad_band", "quad_shape")}
    other = {name: each[:, mixed] if each.shape[0] == 1 else each[mixed] for name, each in part.items()}
    assert (np.diff(other["quad_band"]) < 0).any()
    drawn = [
        replace(model, target=replace(model.target, **each)).synthesize(24, 20, sweeps=4)
        for each in (part, other)
    ]
    assert drawn[0].tobytes() == drawn[1].tobytes()


def test_of_many_sites_some_are_counted_and_tell_the_same(monkeypatch):
    model = learn_texture(pebbles(64, 6), pairs=4, spacings=(1,), radius=4)
    plane = Plane.of(64, 64, model.target.radius, wrap=True)
    drawn = Relaxation(model.target, plane, plane.hold(pebbles(64, 6)[None] // 8), stream(1, "test"))
    whole = pair_shares(plane, drawn.level, model.target.pair_type)[0]
    monkeypatch.setattr(relaxation, "_MOST_COUNTED", 1024)
    some = []
    for drawn.turn in range(30):
        site = drawn._counted()
        assert len(np.unique(site)) == 1024
        some.append(pair_shares(plane, drawn.level, model.target.pair_type, site=site)[0])
    assert np.abs(np.array(some) - whole).max(axis=0).mean() > 1e-3  # each time others
    assert np.mean(some, axis=0) == pytest.approx(whole, abs=4e-3)


def test_a_table_of_a_torus_draws_like_the_plane_counts():
    model = learn_texture(pebbles(64, 6), pairs=4, spacings=(1,), radius=4)
    height, width = 20, 24
    offsets = np.array([(u, v) for v in range(-8, 9) for u in range(-8, 9)], np.int32)
    row, column = np.divmod(np.arange(height * width), width)
    table = np.column_stack([((row + v) % height) * width + (column + u) % width for u, v in offsets]).astype(
        np.int32
    )
    table = np.vstack([table, np.full((1, len(offsets)), height * width, np.int32)])
    lattice = Table(offsets, table)
    level = np.append(levels(1, height, width).ravel(), 255).astype(np.uint8)[None]
    plane = Plane.of(height, width, 8, wrap=True)
    held = plane.hold(level[:, :-1].reshape(1, height, width))
    kinds = model.target.pair_type
    assert pair_shares(lattice, level, kinds) == pytest.approx(pair_shares(plane, held, kinds))
    drawn = Relaxation(model.target, lattice, level, stream(1, "test"))
    course = drawn.run(30)
    assert course[-1][0] < 0.5 * course[0][0]
    assert level[0, -1] == 255
