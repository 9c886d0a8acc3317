"""Large arrays that lie in a file without a name: what is not looked at takes no memory, and a killed run leaves nothing.

A page of a map grows with the square of its side; beyond `LARGEST_IN_MEMORY` texels it is written row by row and read row by
row, and rows that were passed are let go of. The values are those of any other array.

Smaller pages lie in memory that outlives them: to clear new memory costs a system more than to fill a page, so the memory
of a page that nobody holds any more waits for the next of its size. The system may have it back whenever it runs short.
"""

import mmap
import os
import tempfile
import weakref
from collections import deque
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from surftex.errors import WorkError

LARGEST_IN_MEMORY = 4096 * 4096
"""Texels of a page beyond which it lies in a file."""

_BLOCK_BYTES = 1 << 25
_KEPT_BYTES = range(1 << 20, (1 << 26) + 1)
"""Sizes of pages whose memory is kept."""

_KEPT: deque[mmap.mmap] = deque(maxlen=6)
_KEEPING = hasattr(mmap, "MADV_FREE")


def in_file(shape: tuple[int, ...]) -> bool:
    """Tell whether a page of that size lies in a file.

    Parameters
    ----------
    shape : tuple of int
        Rows, columns, and channels where there are any.

    Returns
    -------
    large : bool
        Whether it has more than `LARGEST_IN_MEMORY` texels.
    """
    return shape[0] * shape[1] > LARGEST_IN_MEMORY


def page(shape: tuple[int, ...], dtype: DTypeLike) -> NDArray[Any]:
    """Make an array of zeros.

    Parameters
    ----------
    shape : tuple of int
        Rows, columns, and channels where there are any.
    dtype : dtype
        Of its numbers.

    Returns
    -------
    array : ndarray
        In a file of the folder for temporary files where it is large.

    Raises
    ------
    WorkError
        If that folder has no room.
    """
    size = int(np.prod(shape, dtype=np.int64)) * np.dtype(dtype).itemsize
    if not in_file(shape):
        if not _KEEPING or size not in _KEPT_BYTES:
            return np.zeros(shape, dtype)
        return np.asarray(_Lease(size)).view(dtype).reshape(shape)
    try:
        with tempfile.TemporaryFile(prefix="surftex-") as file:
            file.truncate(size)
            if hasattr(
                os, "posix_fallocate"
            ):  # or a full disk would be found by a signal that nothing survives
                os.posix_fallocate(file.fileno(), 0, size)
            return np.asarray(np.memmap(file, dtype, "r+", shape=shape))
    except OSError as problem:
        raise WorkError(
            f"{tempfile.gettempdir()}: no room for {size >> 20} MiB of maps: {problem.strerror or problem}; "
            "let TMPDIR name another folder"
        ) from None


class _Lease:
    """Memory, all zeros, for as long as an array lies in it; then it is kept."""

    def __init__(self, size: int) -> None:
        memory = _taken(size)
        if memory is None:
            try:
                memory = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
            except OSError as problem:
                raise MemoryError(f"no room for a page of {size >> 20} MiB") from problem
            if hasattr(mmap, "MADV_HUGEPAGE"):
                memory.madvise(mmap.MADV_HUGEPAGE)
        else:
            np.frombuffer(memory, np.uint8).fill(0)
        self.__array_interface__ = np.frombuffer(memory, np.uint8).__array_interface__
        weakref.finalize(self, _keep, memory).atexit = False


def _taken(size: int) -> mmap.mmap | None:
    """Take memory of that size from what is kept; None where there is none."""
    # One step at a time: the last holder of a page may let it go at any moment, in any thread.
    for _ in range(len(_KEPT)):
        try:
            memory = _KEPT.popleft()
        except IndexError:
            return None
        if len(memory) == size:
            return memory
        _KEPT.append(memory)
    return None


def _keep(memory: mmap.mmap) -> None:
    """Keep memory that nobody looks at, and tell the system that what it holds is of no use."""
    memory.madvise(mmap.MADV_FREE)
    _KEPT.append(memory)


def let_go(array: NDArray[Any]) -> None:
    """Take the memory of a page that lies in a file back; its values stay.

    Parameters
    ----------
    array : ndarray
        A page, or a view of one; others are left alone.
    """
    base: Any = array
    while isinstance(base, np.ndarray):
        if isinstance(base, np.memmap):
            base = getattr(base, "_mmap", None)  # numpy has no public name for it
            break
        base = base.base
    if isinstance(base, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
        base.madvise(mmap.MADV_DONTNEED)


def blocks(array: NDArray[Any], *, multiple: int = 2) -> Iterator[slice]:
    """Walk over the rows of a page a few at a time, letting go of what was passed.

    Parameters
    ----------
    array : (height, ...) ndarray
        A page.
    multiple : int
        Blocks have a multiple of so many rows, but for the last.

    Yields
    ------
    rows : slice
        From the first to the last.
    """
    row_bytes = max(1, array[:1].nbytes)
    step = max(1, _BLOCK_BYTES // (row_bytes * multiple)) * multiple
    for first in range(0, len(array), step):
        yield slice(first, min(first + step, len(array)))
        let_go(array)
