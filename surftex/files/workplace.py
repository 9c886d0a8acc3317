"""Hidden folders that output is made in, and what becomes of those whose process was killed.

A workplace lies beside its output folder, or inside where there it could not be renamed from. Its process holds the
lock of a file in it; who finds a workplace whose lock is free knows that its process is dead. What was being moved out
of it is moved on, everything else is deleted.
"""

import os
import shutil
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from surftex.files.locks import locked

_LOCK, _NEW, _OLD, _MOVING = "lock", "new", "old", "moving"
DRAFT = ".surftex-draft"
"""End of the name of a file that is being written."""

PROBE = ".surftex-"
"""Begin of the name of a folder that is made for a moment, to see whether it can be."""

_YOUNG_S = 60.0
RANDOM = 8
"""Letters that `tempfile` puts at the end of a name."""


@dataclass(frozen=True)
class Workplace:
    """A hidden folder.

    Attributes
    ----------
    root : Path
        The folder.
    lock : file or None
        Its lock, held; None where the file system has none.
    """

    root: Path
    lock: BinaryIO | None

    @property
    def staged(self) -> Path:
        """Folder for what is to appear."""
        return self.root / _NEW

    @property
    def aside(self) -> Path:
        """Folder for what is replaced."""
        return self.root / _OLD

    def begin_moving(self) -> None:
        """Note that from here on what is staged belongs into the output, whoever moves it."""
        (self.root / _MOVING).touch()

    def end_moving(self) -> None:
        """Take the note back."""
        (self.root / _MOVING).unlink(missing_ok=True)

    def leave(self) -> None:
        """Delete the folder with all that is in it."""
        _delete(self.root)
        if self.lock is not None:
            self.lock.close()
        if self.root.exists():  # Windows deletes no file that is open
            shutil.rmtree(self.root, ignore_errors=True)


def workplace_name(folder: Path, end: str = "") -> str:
    """Name a workplace.

    Parameters
    ----------
    folder : Path
        Of the output.
    end : str
        `RANDOM` letters; how all such names begin, without them.

    Returns
    -------
    name : str
        Hidden.
    """
    return f".{folder.name}-{end}"


def make_workplace(folder: Path) -> Workplace:
    """Make a hidden folder for output, on the same disk.

    Parameters
    ----------
    folder : Path
        Where the output is to appear; need not exist, its parent must.

    Returns
    -------
    workplace : Workplace
        Nobody else's.

    Raises
    ------
    OSError
        If it cannot be made.
    """
    place = folder.resolve()
    inside = place.is_dir() and (place.is_mount() or not os.access(place.parent, os.W_OK | os.X_OK))
    while True:
        root = Path(tempfile.mkdtemp(prefix=workplace_name(place), dir=place if inside else place.parent))
        with suppress(
            FileNotFoundError
        ):  # somebody took it for the remains of a dead process, and cleared it
            workplace = Workplace(root, _own_lock(root))
            workplace.staged.mkdir()
            return workplace


def _own_lock(root: Path) -> BinaryIO | None:
    """Take the lock of a new workplace; None where the file system has no locks."""
    try:
        lock = locked(root / _LOCK)
    except FileNotFoundError:
        raise
    except OSError:
        return None
    if lock is None:
        raise FileNotFoundError(root)
    return lock


def clear_remains(folder: Path) -> None:
    """Clear what killed processes left of their output into a folder: finish what was moving, delete the rest.

    Parameters
    ----------
    folder : Path
        Where output is to appear; need not exist.
    """
    place = folder.resolve()
    start = workplace_name(place)
    for parent in (place.parent, place):
        with suppress(OSError):
            for entry in list(os.scandir(parent)):
                if not entry.is_dir(follow_symlinks=False):
                    continue
                with suppress(OSError):
                    if _alike(entry.name, start):
                        _clear(Path(entry.path), place)
                    elif _alike(entry.name, PROBE):
                        _clear_probe(Path(entry.path))


def clear_drafts(target: Path) -> None:
    """Clear drafts of a file that killed processes left.

    Parameters
    ----------
    target : Path
        The file; need not exist.
    """
    with suppress(OSError):
        for entry in list(os.scandir(target.absolute().parent)):
            ours = entry.name.startswith(f".{target.name}.") and entry.name.endswith(DRAFT)
            if ours and entry.stat().st_mtime < time.time() - _YOUNG_S:  # younger ones may not be locked yet
                lock = locked(Path(entry.path))
                if lock is not None:
                    with lock:
                        Path(entry.path).unlink()


def _alike(name: str, start: str) -> bool:
    return name.startswith(start) and len(name) == len(start) + RANDOM


def _clear(root: Path, folder: Path) -> None:
    """Clear one workplace, unless its process lives or it is none."""
    names = {path.name for path in root.iterdir()}
    if not names:  # made, but not locked yet, when its process was killed
        root.rmdir()
        return
    if _LOCK not in names or not names <= {_LOCK, _NEW, _OLD, _MOVING}:
        return
    lock = locked(root / _LOCK)
    if lock is None:
        return
    with lock:
        if _MOVING in names and folder.is_dir():
            for path in sorted((root / _NEW).iterdir()):
                path.replace(folder / path.name)
        _delete(root)


def _delete(root: Path) -> None:
    """Delete a workplace, its lock last: without one, nobody could tell whose the rest is."""
    with suppress(OSError):
        (root / _MOVING).unlink(missing_ok=True)
    for name in (_NEW, _OLD):
        shutil.rmtree(root / name, ignore_errors=True)
    shutil.rmtree(root, ignore_errors=True)


def _clear_probe(root: Path) -> None:
    """Clear the folders, all empty, with which a killed process asked what the disk allows."""
    if root.stat().st_mtime > time.time() - _YOUNG_S or any(files for _, _, files in os.walk(root)):
        return
    for path, _, _ in os.walk(root, topdown=False):
        Path(path).rmdir()
