"""Kernels behind the order in which samples are asked: against their obvious twins."""

import numpy as np
import pytest

from surftex.arrays import frozen
from surftex.kernels.ordering import order_by_face


@pytest.mark.parametrize("count", [0, 1, 1000])
def test_order_by_face_is_a_stable_sort(count):
    face = np.random.default_rng(count).integers(0, 40, count).astype(np.int32)
    order = np.zeros(count, np.int32)
    order_by_face(frozen(face), np.zeros(41, np.int64), order)
    np.testing.assert_array_equal(order, np.argsort(face, kind="stable"))
