"""BLAS keeps to one thread in blocks that may overlap, and has its own number again afterwards."""

import sys
import types

import scipy.linalg  # noqa: F401  (brings its BLAS)
from threadpoolctl import threadpool_info, threadpool_limits

from surftex.kernels import pool
from surftex.kernels.pool import one_blas_thread


def threads():
    return [each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"]


def test_the_last_of_overlapping_blocks_sets_back_what_was_there_before():
    with threadpool_limits(limits=2, user_api="blas"):
        before = threads()
        first, second = one_blas_thread(), one_blas_thread()
        first.__enter__()
        second.__enter__()
        assert set(threads()) == {1}
        first.__exit__(None, None, None)
        assert set(threads()) == {1}
        second.__exit__(None, None, None)
        assert threads() == before
        assert 2 in before


def test_a_library_that_comes_later_is_kept_to_one_thread_too(monkeypatch):
    """Promise: what is known of the libraries is looked up again once a module was imported."""
    with one_blas_thread():
        known = pool._libraries()
        assert pool._libraries() is known
        monkeypatch.setitem(sys.modules, "surftex_tests_a_later_module", types.ModuleType("later"))
        assert pool._libraries() is not known
        with one_blas_thread():
            assert set(threads()) == {1}
