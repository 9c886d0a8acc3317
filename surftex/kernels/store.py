"""The folder that keeps compiled kernels: where it is, whether it serves this version, how to empty it."""

import hashlib
import os
import re
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path

import platformdirs

_MARKER = re.compile(r"warm-[0-9a-f]{16}(-[a-z]+)?")


def folder() -> Path:
    """Tell where compiled kernels are kept.

    Returns
    -------
    folder : Path
        ``NUMBA_CACHE_DIR`` where that is set, else the user's cache folder.
    """
    given = os.environ.get("NUMBA_CACHE_DIR")
    return Path(given) if given else _own_folder()


def cold(kinds: Iterable[str]) -> tuple[str, ...]:
    """Tell for which kinds of material the kernels of this version have not been compiled and kept.

    Parameters
    ----------
    kinds : iterable of str
        Such as "leather".

    Returns
    -------
    cold : tuple of str
        Those before the first bake of their kind, and after an update that changed a kernel; sorted.
    """
    return tuple(kind for kind in sorted(set(kinds)) if not _marker(kind).exists())


def mark_warm(kinds: Iterable[str]) -> None:
    """Note that the kernels of this version are compiled; a folder that cannot be written stays cold.

    Parameters
    ----------
    kinds : iterable of str
        As for `cold`.
    """
    for kind in cold(kinds):
        with suppress(OSError):
            folder().mkdir(parents=True, exist_ok=True)
            _marker(kind).touch()


def clear() -> int:
    """Delete the compiled kernels; what other programs keep in the same folder stays.

    Returns
    -------
    count : int
        Files that were deleted.
    """
    ours = [*_compiled(), *(path for path in _files(folder()) if _MARKER.fullmatch(path.name))]
    for path in ours:
        with suppress(OSError):
            path.unlink()
    for emptied in [*{path.parent for path in ours} - {folder()}, folder()]:
        with suppress(OSError):
            emptied.rmdir()
    return len(ours)


def _compiled() -> list[Path]:
    """Kernels on disk: numba keeps those of each folder of sources together, in one named by that folder's path."""
    from numba.core.caching import UserProvidedCacheLocator

    if folder() == _own_folder():  # those of installations that are gone as well
        places = [path for path in folder().glob("*_*") if path.is_dir()]
    else:
        sources = Path(__file__).parent.parent.rglob("*.py")
        named = UserProvidedCacheLocator.get_suitable_cache_subpath
        places = [folder() / name for name in sorted({named(str(source)) for source in sources})]
    ours = (".nbi", ".nbc")
    return [
        path for place in places for path in _files(place) if {*path.suffixes} & {*ours}
    ]  # or begun: .nbc.tmp.1f


def _own_folder() -> Path:
    return Path(platformdirs.user_cache_dir("surftex")) / "kernels"


def _files(where: Path) -> list[Path]:
    return [path for path in where.iterdir() if path.is_file()] if where.is_dir() else []


def _marker(kind: str) -> Path:
    return folder() / f"warm-{_version()}-{kind}"


@cache
def _version() -> str:
    """Hash of the kernels' sources."""
    digest = hashlib.blake2b(digest_size=8)
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.name.encode() + source.read_bytes())
    return digest.hexdigest()
