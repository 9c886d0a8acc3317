"""How finished files appear in a folder.

A new folder appears by one rename. A folder that holds only files is exchanged for one with the new files and links to
the others, in one step where the system has such a step (Linux). Otherwise files are moved one after the other; who is
killed on the way has left a note, by which the next run into that folder moves on.
"""

import ctypes
import errno
import os
import shutil
import sys
from contextlib import suppress
from pathlib import Path

from surftex.files.workplace import Workplace

_HERE, _EXCHANGE = -100, 2
"""AT_FDCWD and RENAME_EXCHANGE of renameat2(2)."""

_FEW = 100
"""Files of other names up to which a folder is exchanged."""


def publish(workplace: Workplace, folder: Path, *, overwrite: bool) -> None:
    """Let all staged files appear in a folder, or none.

    Parameters
    ----------
    workplace : Workplace
        Its staged files, all of which are on the disk.
    folder : Path
        Its parent must exist.
    overwrite : bool
        Whether files of the same names may be replaced.

    Raises
    ------
    FileExistsError
        If one is there and must not be replaced.
    OSError
        If they cannot be moved; the folder is as it was.
    """
    names = {path.name for path in workplace.staged.iterdir()}
    for name in names:  # who may read a file stays as it was
        with suppress(OSError):
            shutil.copymode(folder / name, workplace.staged / name)
    if not folder.exists():
        try:
            workplace.staged.rename(folder)
        except OSError:
            if not folder.exists():
                raise
        else:
            return
    if not _swapped(workplace.staged, folder, names, overwrite=overwrite):
        _moved(workplace, folder, sorted(names), overwrite=overwrite)


def _swapped(staged: Path, folder: Path, names: set[str], *, overwrite: bool) -> bool:
    """Exchange a folder for one with the staged files and links to its others; False, with all as it was, if that cannot be."""
    others = _others(staged, folder, names)
    if others is None:
        return False
    try:
        for name in others:
            (staged / name).hardlink_to(folder / name)
        shutil.copystat(folder, staged)
        _exchange(staged, folder)
    except OSError:
        for name in others:
            (staged / name).unlink(missing_ok=True)
        return False
    if not overwrite and any(os.path.lexists(staged / name) for name in names):
        _exchange(staged, folder)
        raise FileExistsError
    os.utime(folder)
    for entry in list(os.scandir(staged)):  # what others have put there in the meantime
        if entry.name not in names and others.get(entry.name) != entry.inode():
            Path(entry.path).replace(folder / entry.name)
    return True


def _others(staged: Path, folder: Path, names: set[str]) -> dict[str, int] | None:
    """List the other files of a folder, with their numbers; None where it had better not be exchanged."""
    mine, there = staged.stat(), folder.stat()
    if (mine.st_dev, mine.st_uid, mine.st_gid) != (there.st_dev, there.st_uid, there.st_gid):
        return None
    with suppress(OSError):
        if folder.samefile("."):
            return None
    entries = list(os.scandir(folder))
    others = {entry.name: entry.inode() for entry in entries if entry.name not in names}
    plain = all(entry.is_file(follow_symlinks=False) for entry in entries)
    return others if plain and len(others) <= _FEW else None


def _exchange(one: Path, other: Path) -> None:
    """Exchange two folders in one step."""
    library = ctypes.CDLL(None, use_errno=True) if sys.platform.startswith("linux") else None
    rename = getattr(library, "renameat2", None)
    if rename is None:
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS))
    if rename(_HERE, os.fsencode(one), _HERE, os.fsencode(other), _EXCHANGE):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def _moved(workplace: Workplace, folder: Path, names: list[str], *, overwrite: bool) -> None:
    """Move staged files into a folder, those that they replace aside; put all back if one cannot be moved."""
    staged, aside = workplace.staged, workplace.aside
    aside.mkdir()
    workplace.begin_moving()
    try:
        for name in names:
            if os.path.lexists(folder / name):
                if not overwrite:
                    raise FileExistsError
                (folder / name).rename(aside / name)
            (staged / name).rename(folder / name)
    except BaseException:
        for name in names:  # new ones first: who is killed here as well has lost none of them
            if not (staged / name).exists() and (folder / name).exists():
                (folder / name).replace(staged / name)
            if (aside / name).exists():
                (aside / name).replace(folder / name)
        workplace.end_moving()
        raise
