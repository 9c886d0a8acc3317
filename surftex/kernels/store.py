"""The folder that keeps compiled kernels: where it is, whether it serves this version, how to empty it."""

import hashlib
import os
import re
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


def is_warm(work: str = "bake") -> bool:
    """Tell whether the kernels of this version have been compiled and kept.

    Parameters
    ----------
    work : str
        What they are for; a bake compiles most of them.

    Returns
    -------
    warm : bool
        False before the first bake, and after an update that changed a kernel.
    """
    return _marker(work).exists()


def mark_warm(work: str = "bake") -> None:
    """Note that the kernels of this version are compiled; a folder that cannot be written stays cold.

    Parameters
    ----------
    work : str
        As for `is_warm`.
    """
    if is_warm(work):
        return
    try:
        folder().mkdir(parents=True, exist_ok=True)
        _marker(work).touch()
    except OSError:
        return


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
    return [path for place in places for path in _files(place) if path.suffix in (".nbi", ".nbc")]


def _own_folder() -> Path:
    return Path(platformdirs.user_cache_dir("surftex")) / "kernels"


def _files(where: Path) -> list[Path]:
    return [path for path in where.iterdir() if path.is_file()] if where.is_dir() else []


def _marker(work: str) -> Path:
    return folder() / f"warm-{_version()}{'' if work == 'bake' else f'-{work}'}"


@cache
def _version() -> str:
    """Hash of the kernels' sources."""
    digest = hashlib.blake2b(digest_size=8)
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.name.encode() + source.read_bytes())
    return digest.hexdigest()
