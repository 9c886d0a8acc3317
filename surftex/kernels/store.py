"""The folder that keeps compiled kernels: where it is, whether it serves this version, how to empty it."""

import hashlib
import os
import shutil
from functools import cache
from pathlib import Path

import platformdirs


def folder() -> Path:
    """Tell where compiled kernels are kept.

    Returns
    -------
    folder : Path
        ``NUMBA_CACHE_DIR`` where that is set, else the user's cache folder.
    """
    given = os.environ.get("NUMBA_CACHE_DIR")
    return Path(given) if given else Path(platformdirs.user_cache_dir("surftex")) / "kernels"


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
    """Delete the compiled kernels.

    Returns
    -------
    count : int
        Files that were deleted.
    """
    where = folder()
    kept = [path for path in where.rglob("*") if path.is_file()] if where.is_dir() else []
    ours = [path for path in kept if path.suffix in (".nbi", ".nbc") or path.name.startswith("warm-")]
    if len(ours) == len(kept):
        shutil.rmtree(where, ignore_errors=True)
    else:
        for path in ours:
            path.unlink(missing_ok=True)
    return len(ours)


def _marker(work: str) -> Path:
    return folder() / f"warm-{_version()}{'' if work == 'bake' else f'-{work}'}"


@cache
def _version() -> str:
    """Hash of the kernels' sources."""
    digest = hashlib.blake2b(digest_size=8)
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.name.encode() + source.read_bytes())
    return digest.hexdigest()
