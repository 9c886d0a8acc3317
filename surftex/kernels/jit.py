"""The one place that decides how numba compiles: serial, cached, releasing the interpreter lock, no fastmath.

Parallelism is slices of the work in a thread pool (`surftex.kernels.pool`), so that a kernel compiles fast,
progress and cancel come for free, and the thread count cannot change a byte. The compiled code is kept in the
user's cache folder, where it outlives a reinstall.
"""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import platformdirs

os.environ.setdefault("NUMBA_CACHE_DIR", str(Path(platformdirs.user_cache_dir("surftex")) / "kernels"))

import numba  # after the line above: the cache folder is read when numba is imported

Result = TypeVar("Result")
Decorator = Callable[[Callable[..., Result]], Callable[..., Result]]

_ALL: dict[str, Any] = {"error_model": "numpy", "nogil": True}
_INNER: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "forceinline": True}

kernel: Decorator = numba.njit(cache=True, **_ALL)
"""Decorator of every kernel. Arguments are checked by numba, by the types of the arrays that come in."""

part: Decorator = numba.njit(**_ALL, **_INNER)
"""Decorator of what only kernels call: compiled into them, without the door that Python would need."""
