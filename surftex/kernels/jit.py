"""The one place that decides how numba compiles: serial, cached, releasing the interpreter lock, no fastmath.

Parallelism is slices of the work in a thread pool (`surftex.kernels.pool`), so that a kernel compiles fast,
progress and cancel come for free, and the thread count cannot change a byte. The compiled code is kept in the
user's cache folder, where it outlives a reinstall.
"""

import hashlib
import os
import re
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import platformdirs

from surftex.interrupts import undisturbed

os.environ.setdefault("NUMBA_CACHE_DIR", str(Path(platformdirs.user_cache_dir("surftex")) / "kernels"))

import numba  # after the line above: the cache folder is read when numba is imported
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.types import unliteral

Result = TypeVar("Result")

_ALL: dict[str, Any] = {"error_model": "numpy", "nogil": True}
_OUTER: dict[str, Any] = {"no_cfunc_wrapper": True}
_INNER: dict[str, Any] = {
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "forceinline": True,
    "_nrt": False,  # arrays are lent to parts: counting references to them took two thirds of a flood
}


class _Files(IndexDataCacheFile):
    """Files of a kernel, each named by what is in it, so that processes that compile at once cannot mistake them.

    numba numbers them, and tells of one before it is there.
    """

    def save(self, key: Any, data: Any) -> None:
        """Keep what was compiled, then tell of it."""
        what = hashlib.blake2b(repr((self._source_stamp, key)).encode(), digest_size=8).hexdigest()
        name = f"{Path(self._index_name).stem}.{what}.nbc"
        self._save_data(name, data)
        self._save_index({**self._load_index(), key: name})


class _Cache(FunctionCache):
    """Compiled code on disk, which is a convenience: what cannot be read or written is compiled again.

    It holds for the sources that it was made from: the kernel's own file, and all that it takes parts from.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        source = Path(function.__code__.co_filename)
        if source.is_file():  # the cell of a notebook has a stamp of its own
            impl: Any = self._impl
            self._cache_file = _Files(
                cache_path=self._cache_path,
                filename_base=impl.filename_base,
                source_stamp=source_stamp(source),
            )

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load what was compiled for a signature; None where there is nothing, or it is damaged."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # noqa: BLE001  (whatever a damaged pickle raises)
            self._forget()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled, where there is room."""
        try:
            super().save_overload(sig, data)
        except Exception:  # noqa: BLE001  (a full disk, or a damaged index)
            self._forget()

    def _forget(self) -> None:
        with suppress(OSError):
            self.flush()


@cache
def source_stamp(file: Path) -> str:
    """Tell apart the sources of a file of kernels.

    Parameters
    ----------
    file : path
        Of the kernels.

    Returns
    -------
    stamp : str
        Another one as soon as the file, or one in its folder that it takes parts or numbers from, is another.
    """
    text, seen = hashlib.sha256(), set()
    todo = [file]
    while todo:
        one = todo.pop()
        if one in seen or not one.is_file():
            continue
        seen.add(one)
        content = one.read_bytes()
        text.update(content)
        names = re.findall(rb"^from surftex\.kernels\.(\w+) import", content, re.MULTILINE)
        todo += [file.with_name(name.decode() + ".py") for name in names]
    return text.hexdigest()


def kernel(function: Callable[..., Result]) -> Callable[..., Result]:
    """Compile a kernel when it is first called, by the types of its arguments, and keep it on disk.

    Parameters
    ----------
    function : callable
        Arrays and numbers in, arrays filled; see the rules in ARCHITECTURE.md.

    Returns
    -------
    kernel : callable
        Of the same arguments.
    """
    compiled: Any = numba.njit(**_ALL, **_OUTER)(function)
    usual = compiled.compile

    def compile_undisturbed(signature: Any) -> Any:
        """Compile or load; an interrupt that hits the compiler as it calls back to Python would be lost."""
        with undisturbed():
            return usual(signature)

    compiled.compile = compile_undisturbed
    with suppress(RuntimeError):  # no folder can be written: compiled anew in every process
        compiled._cache = _Cache(function)
    return _once_for_all_numbers(compiled)


def part(function: Callable[..., Result]) -> Callable[..., Result]:
    """Compile what only kernels call into them, without the door that Python would need.

    Parameters
    ----------
    function : callable
        It makes no arrays, and returns none.

    Returns
    -------
    part : callable
        Of the same arguments.
    """
    return _once_for_all_numbers(numba.njit(**_ALL, **_INNER)(function))


def _once_for_all_numbers(compiled: Any) -> Any:
    """Keep numba from typing and lowering a function anew for each number that is written out in a call of it."""
    usual = compiled.get_call_template

    def template(arguments: Any, named: Any) -> Any:
        plain = tuple(map(unliteral, arguments))
        return usual(plain, {name: unliteral(kind) for name, kind in named.items()})

    compiled.get_call_template = template
    return compiled
