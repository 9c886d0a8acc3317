"""The one place that decides how numba compiles: serial, cached, releasing the interpreter lock, no fastmath.

Parallelism is slices of the work in a thread pool (`surftex.kernels.pool`), so that a kernel compiles fast,
progress and cancel come for free, and the thread count cannot change a byte. The compiled code is kept in the
user's cache folder, where it outlives a reinstall.
"""

import os
from pathlib import Path

import platformdirs

os.environ.setdefault("NUMBA_CACHE_DIR", str(Path(platformdirs.user_cache_dir("surftex")) / "kernels"))

import numba  # noqa: E402  (the cache folder is read when numba is imported)

kernel = numba.njit(cache=True, error_model="numpy", nogil=True)
"""Decorator of every kernel."""

part = numba.njit(error_model="numpy", nogil=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)
"""Decorator of what only kernels call: compiled into them, without the door that Python would need."""
