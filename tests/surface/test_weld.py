"""Rows that are equal have one number, counted as they first appear."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from surftex.kernels.rows import number_rows
from surftex.surface.weld import equal_rows


def by_appearance(rows):
    """Number rows by looking each up among those before it."""
    seen = {}
    return [seen.setdefault(tuple(row), len(seen)) for row in rows.tolist()]


@given(st.lists(st.tuples(*[st.sampled_from([-1.5, -0.0, 0.0, 2.0**-149, 3.0])] * 2), max_size=40))
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_equal_rows_are_those_of_equal_values(dtype, rows):
    rows = np.array(rows, dtype).reshape(-1, 2)
    assert equal_rows(rows).tolist() == by_appearance(rows)
    assert equal_rows(np.asfortranarray(rows)).tolist() == by_appearance(rows)


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 3)), max_size=31))
def test_rows_are_told_apart_where_the_slots_are_few(rows):
    word, number = np.array(rows, np.uint32).reshape(-1, 2), np.zeros(len(rows), np.int64)
    count = number_rows(word, np.full(32, -1), number)
    assert number.tolist() == by_appearance(word)
    assert count == len(set(rows))
