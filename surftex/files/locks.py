"""Locks on files that end with the process that holds them, however it dies."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import BinaryIO


def locked(path: Path) -> BinaryIO | None:
    """Take the lock of a file, if nobody holds it.

    Parameters
    ----------
    path : Path
        Of the file; made when it is missing.

    Returns
    -------
    lock : file or None
        The lock is held until it is closed; None if somebody else holds it.

    Raises
    ------
    OSError
        If the file cannot be opened, or its file system has no locks.
    """
    file = path.open("ab")
    try:
        _lock(file.fileno())
    except BaseException as problem:
        file.close()
        if isinstance(problem, BlockingIOError):
            return None
        raise
    return file


@contextmanager
def locked_where_possible(path: Path) -> Iterator[None]:
    """Hold the lock of a file that nobody else knows, if its file system has locks.

    Parameters
    ----------
    path : Path
        Of the file; made when it is missing.

    Yields
    ------
    nothing : None
        The lock ends with the block, or with the process.

    Raises
    ------
    OSError
        If the file cannot be made.
    """
    path.touch()
    lock = None
    with suppress(OSError):
        lock = locked(path)
    with lock or nullcontext():
        yield


def _lock(handle: int) -> None:
    try:
        import fcntl
    except ImportError:  # Windows
        import msvcrt

        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
        except OSError:
            raise BlockingIOError from None
        return
    fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
