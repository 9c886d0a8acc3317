"""Results that are kept between runs, by what they came from: unwraps, and features that were placed.

The shelf is a convenience: a file that is damaged, or a folder that cannot be written, only means that the work is
done again. Files appear by rename, so that many processes may share a shelf; the longest unused go when it is full.
What several processes want at once is made by one of them (`alone`). Files of other names in its folder are not ours:
they are not counted, and never deleted.
"""

import hashlib
import io
import os
import re
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
from numpy.typing import NDArray

from surftex.files.locks import locked

MOST_BYTES = 2 * 2**30
"""Size of a full shelf."""

_DIGEST = 32
_POLL_S = 0.05
_OURS = re.compile(r"[0-9a-f]{64}(\.lock)?|draft-[a-z0-9_]{8}")
"""Results, locks of those that are being made, and drafts of them."""

_MOST_OF_ALL = 4
"""A result larger than the shelf over this is not kept."""


def folder() -> Path:
    """Tell where results are kept.

    Returns
    -------
    folder : Path
        ``SURFTEX_CACHE_DIR`` where that is set, else the user's cache folder.
    """
    given = os.environ.get("SURFTEX_CACHE_DIR")
    return (Path(given) if given else Path(platformdirs.user_cache_dir("surftex"))) / "results"


def kept(key: str) -> dict[str, NDArray[Any]] | None:
    """Look for a result.

    Parameters
    ----------
    key : str
        Of everything that decides it, 64 hexadecimal digits.

    Returns
    -------
    arrays : dict of str to array, or None
        None where there is none, or it is damaged; then it is thrown away.
    """
    path = folder() / key
    try:
        data = path.read_bytes()
    except OSError:
        return None
    try:
        if hashlib.sha256(data[_DIGEST:]).digest() != data[:_DIGEST]:
            raise ValueError("damaged")
        with np.load(io.BytesIO(data[_DIGEST:]), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
    except (ValueError, OSError, KeyError):
        with suppress(OSError):
            path.unlink()
        return None
    with suppress(OSError):
        os.utime(path)
    return arrays


def keep(key: str, arrays: Mapping[str, NDArray[Any]], *, most_bytes: int = MOST_BYTES) -> None:
    """Keep a result; nothing happens where that is not possible.

    Parameters
    ----------
    key : str
        Of everything that decides it, 64 hexadecimal digits.
    arrays : mapping of str to array
        The result.
    most_bytes : int
        Size of a full shelf.
    """
    if sum(array.nbytes for array in arrays.values()) > most_bytes // _MOST_OF_ALL:
        return
    memory = io.BytesIO()
    np.savez(memory, allow_pickle=False, **dict(arrays))
    data = memory.getvalue()
    with suppress(OSError):
        folder().mkdir(parents=True, exist_ok=True)
        handle, draft = tempfile.mkstemp(prefix="draft-", dir=folder())
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(hashlib.sha256(data).digest() + data)
            Path(draft).replace(folder() / key)
        except BaseException:
            Path(draft).unlink(missing_ok=True)
            raise
        _make_room(most_bytes)


@contextmanager
def alone(
    key: str, waiting: Callable[[], None] = lambda: None, *, patience_s: float = 120.0
) -> Iterator[None]:
    """Let others who want the same result wait until this process has made and kept it.

    Parameters
    ----------
    key : str
        Of the result, 64 hexadecimal digits.
    waiting : callable
        Called several times a second while another process is at it; may raise to give up.
    patience_s : float
        After that long, or where there are no locks, the work is done side by side.

    Yields
    ------
    nothing : None
        Look for the result once more: it may have been made meanwhile.
    """
    path, lock = folder() / f"{key}.lock", None
    end = time.monotonic() + patience_s
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
    while True:
        try:
            lock = locked(path)
        except OSError:  # no leave to write, or no locks
            break
        if lock is not None or time.monotonic() >= end:
            break
        waiting()
        time.sleep(_POLL_S)
    try:
        yield
    finally:
        if lock is not None:
            with lock, suppress(OSError):
                path.unlink()


def held() -> tuple[int, int]:
    """Measure the shelf.

    Returns
    -------
    count : int
        Results.
    size : int
        Bytes.
    """
    files = _files()
    return len(files), sum(size for _, size, _ in files)


def clear() -> int:
    """Throw every result away, and the folder where nothing else is in it.

    Returns
    -------
    count : int
        Results that were there.
    """
    files = _files()
    for _, _, path in files:
        with suppress(OSError):
            path.unlink()
    with suppress(OSError):
        folder().rmdir()
    return len(files)


def _files() -> list[tuple[float, int, Path]]:
    """When each file of ours was last used, its size, its path; the longest unused first."""
    found = []
    with suppress(OSError):
        for entry in os.scandir(folder()):
            with suppress(OSError):
                if _OURS.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                    status = entry.stat(follow_symlinks=False)
                    found.append((status.st_mtime, status.st_size, Path(entry.path)))
    return sorted(found)


def _make_room(most_bytes: int) -> None:
    """Throw away the longest unused while there is too much; drafts of the dead are among them."""
    files = _files()
    size = sum(each for _, each, _ in files)
    for _, each, path in files:
        if size <= most_bytes:
            return
        with suppress(OSError):
            path.unlink()
        size -= each
