"""Kernels behind the order in which samples are asked: against their obvious twins."""

import numpy as np
import pytest

from surftex.arrays import frozen
from surftex.kernels.ordering import order_by_face
from surftex.kernels.rows import index_rows, put_rows, repeat_rows, sum_rows
from surftex.surface.points import Samples, SurfacePoints


@pytest.mark.parametrize("count", [0, 1, 1000])
def test_order_by_face_is_a_stable_sort(count):
    face = np.random.default_rng(count).integers(0, 40, count).astype(np.int32)
    order = np.zeros(count, np.int32)
    order_by_face(frozen(face), np.zeros(41, np.int64), order)
    np.testing.assert_array_equal(order, np.argsort(face, kind="stable"))


@pytest.mark.parametrize("columns", [1, 3])
def test_rows_are_put_repeated_and_summed_as_numpy_does(columns):
    random = np.random.default_rng(columns)
    row = random.permutation(50)[:30].astype(np.int64)
    value = random.random((30, columns)).astype(np.float32)
    table, expected = np.zeros((50, columns), np.float32), np.zeros((50, columns), np.float32)
    put_rows(frozen(row), 10, 40, frozen(value), table)
    own = (row >= 10) & (row < 40)
    expected[row[own]] = value[own]
    np.testing.assert_array_equal(table, expected)
    free, kept = np.arange(0, 50, 2), random.permutation(25)[:25] * 2 + 1
    source = np.arange(50)
    source[free] = kept
    repeat_rows(frozen(free), frozen(source[free]), table)
    expected[free] = expected[kept]
    np.testing.assert_array_equal(table, expected)
    total = np.ones(columns)
    sum_rows(frozen(row), table, total)
    np.testing.assert_allclose(total, 1 + expected[row].sum(axis=0, dtype=float), rtol=1e-14)


def test_rows_are_found_by_their_place():
    random = np.random.default_rng(7)
    row, without = random.permutation(50)[:30].astype(np.int64) + 100, random.random(30) < 0.3
    index = np.full(50, -1, np.int32)
    index_rows(frozen(row), 100, frozen(without), index)
    expected = [next((i for i in range(30) if row[i] == 100 + k and not without[i]), -1) for k in range(50)]
    assert index.tolist() == expected


def test_samples_are_taken_in_any_order():
    random = np.random.default_rng(5)
    weight = random.dirichlet([1, 1, 1], 40)
    points = SurfacePoints(random.integers(0, 9, 40), weight)
    samples, rows = Samples(points, random.random(40).astype(np.float32)), random.integers(0, 40, 70)
    taken = samples.taken(rows)
    np.testing.assert_array_equal(taken.points.face, points.face[rows])
    np.testing.assert_array_equal(taken.points.barycentric, points.barycentric[rows])
    np.testing.assert_array_equal(taken.footprint_mm, samples.footprint_mm[rows])
