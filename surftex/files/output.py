"""Output that is whole or not there: files are made in a hidden folder beside, and appear by rename.

Whatever goes wrong on the way (a full disk, Ctrl-C, a failure of the work), the output folder stays as it was; what
a killed process leaves behind is cleared by the next run into that folder. Files that are already there are replaced
only when told, and files of other names are never touched.
"""

import errno
import hashlib
import os
import secrets
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from surftex.errors import InputError, SurftexError, WorkError
from surftex.files.locks import locked_where_possible
from surftex.files.publishing import publish
from surftex.files.workplace import (
    DRAFT,
    PROBE,
    RANDOM,
    Workplace,
    clear_drafts,
    clear_remains,
    make_workplace,
    workplace_name,
)
from surftex.interrupts import undisturbed

_FULL = (errno.ENOSPC, errno.EDQUOT)
"""Failures that are none of the place, but of what is on it."""


def check_output(folder: str | Path, names: Iterable[str] = (), *, overwrite: bool = False) -> Path:
    """Refuse, before any work, an output folder that could not be written in the end.

    What a killed process left half moved into it is moved on first, and other remains of the dead are cleared.

    Parameters
    ----------
    folder : path
        Where files are to appear; need not exist.
    names : iterable of str
        File names that will appear.
    overwrite : bool
        Whether files of these names may be replaced.

    Returns
    -------
    folder : Path
        As given.

    Raises
    ------
    InputError
        If the folder is a file or a symbolic link, holds one of the names already, or cannot be made or written to.
    WorkError
        If the disk is full.
    """
    folder = Path(folder)
    check_room(folder)
    if folder.is_symlink():
        raise InputError(f"{folder} is a symbolic link; name the folder that it points to")
    clear_remains(folder)
    present = [name for name in names if os.path.lexists(folder / name)]
    for name in present:
        if (folder / name).is_symlink() or not (folder / name).is_file():
            raise InputError(f"{folder / name} is a link or a folder; move it away before writing there")
    if present and not overwrite:
        held = present[0] if len(present) == 1 else f"{present[0]} and others of the files to write"
        raise InputError(
            f"{folder} holds {held} already. Choose another folder, or allow it with overwrite (--overwrite)"
        )
    return folder


def check_room(folder: Path) -> None:
    """Check before any work that files can be put into a folder, which may still have to be made.

    Folders of the same names are made for a moment, in a hidden one: who may do what, a disk says only when asked to.

    Parameters
    ----------
    folder : Path
        Need not exist.

    Raises
    ------
    InputError
        If it is a file, or the nearest folder that exists takes no such folder.
    WorkError
        If the disk is full.
    """
    place = folder.absolute()
    nearest = place
    while not os.path.lexists(nearest) and nearest != nearest.parent:
        nearest = nearest.parent
    if not nearest.is_dir():
        if nearest == place and not nearest.is_symlink():
            raise InputError(f"{folder} is a file; name a folder for the output")
        raise InputError(f"{folder}: cannot write in {nearest}: it is no folder; choose another folder")
    made: list[Path] = []
    try:
        with undisturbed():
            made.append(Path(tempfile.mkdtemp(prefix=PROBE, dir=nearest)))
            _make_folders(made[0] / place.relative_to(nearest) / workplace_name(place, "_" * RANDOM), made)
            _remove(made)
    except OSError as problem:
        reason = problem.strerror or problem
        if problem.errno in _FULL:
            raise WorkError(f"{folder}: cannot write in {nearest}: {reason}") from None
        raise InputError(f"{folder}: cannot write in {nearest}: {reason}; choose another folder") from None
    finally:
        with suppress(OSError):
            _remove(made)


@contextmanager
def whole_output(folder: str | Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Lend a hidden folder; what it holds when the block ends well appears in the output folder.

    Parameters
    ----------
    folder : path
        Where files are to appear; made when it is missing.
    overwrite : bool
        Whether files of the same names may be replaced.

    Yields
    ------
    workplace : Path
        An empty folder on the same disk. It is gone afterwards.

    Raises
    ------
    InputError
        As `check_output`.
    WorkError
        If the disk is full or does not let us write.
    """
    folder = check_output(folder, overwrite=overwrite)
    made: list[Path] = []
    workplace: Workplace | None = None
    try:
        with _told_in_a_line(folder):
            with undisturbed():
                _make_folders(folder.absolute().parent, made)
                workplace = make_workplace(folder)
            yield workplace.staged
            for path in workplace.staged.iterdir():
                _sync(path)
            with undisturbed(f"interrupted, but {folder} is written, and whole"):
                _publish(workplace, folder, overwrite)
                made.clear()
                workplace.leave()
    finally:
        with undisturbed():
            if workplace is not None:
                workplace.leave()
            _remove(made)


def write_whole(path: str | Path, data: bytes, *, parents: bool = False) -> None:
    """Write one file, whole or not at all; a file of that name is replaced.

    Parameters
    ----------
    path : path
        Of the file.
    data : bytes
        What it will hold.
    parents : bool
        Make its folder where that is missing; it is gone again where the file cannot be written.

    Raises
    ------
    InputError
        If the path is a folder.
    WorkError
        If it cannot be written.
    """
    target = Path(path)
    if target.is_dir():
        raise InputError(f"{target} is a folder; name a file")
    clear_drafts(target)
    draft = target.with_name(f".{target.name}.{secrets.token_hex(4)}{DRAFT}")
    made: list[Path] = []
    try:
        if parents:
            _make_folders(target.absolute().parent, made)
        with locked_where_possible(draft):
            draft.write_bytes(data)
            _sync(draft)
        with suppress(OSError):
            shutil.copymode(target, draft)
        draft.replace(target)
        made.clear()
    except OSError as problem:
        raise WorkError(f"{target}: cannot write: {problem.strerror or problem}") from None
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)
            _remove(made)


def check_place(path: str | Path) -> None:
    """Refuse, before any work, a file that could not be written in the end.

    Parameters
    ----------
    path : path
        Of the file; it is not touched.

    Raises
    ------
    InputError
        If nothing can be written beside it.
    """
    target = Path(path)
    try:
        with tempfile.NamedTemporaryFile(prefix=f".{target.name}.", dir=target.absolute().parent):
            pass
    except OSError as problem:
        reason = problem.strerror or problem
        raise InputError(
            f"{target}: cannot write in {target.absolute().parent} ({reason}); choose another folder"
        ) from None


def file_hashes(folder: str | Path) -> dict[str, str]:
    """Tell the files of a folder by their bytes.

    Parameters
    ----------
    folder : path
        Its files, not those of folders inside.

    Returns
    -------
    sha256 : dict of str to str
        By file name, in order of names.
    """
    result = {}
    for path in sorted(Path(folder).iterdir()):
        if path.is_file():
            with path.open("rb") as file:
                result[path.name] = hashlib.file_digest(file, "sha256").hexdigest()
    return result


@contextmanager
def _told_in_a_line(folder: Path) -> Iterator[None]:
    """Turn failures of the disk into a WorkError."""
    try:
        yield
    except WorkError as problem:  # of a file in it, told by its name alone
        raise WorkError(f"{folder}: {problem}; nothing was left there") from None
    except SurftexError:
        raise
    except OSError as problem:
        reason = problem.strerror or problem
        raise WorkError(f"{folder}: cannot write: {reason}; nothing was left there") from None


def _make_folders(folder: Path, made: list[Path]) -> None:
    """Make a folder and its parents, noting which were missing, outermost first."""
    if not folder.is_dir():
        _make_folders(folder.parent, made)
        folder.mkdir()
        made.append(folder)


def _remove(made: list[Path]) -> None:
    """Remove folders that `_make_folders` has made, all of which are empty again."""
    while made:
        made.pop().rmdir()


def _sync(path: Path) -> None:
    """Wait until a file is on the disk."""
    handle = os.open(path, os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _publish(workplace: Workplace, folder: Path, overwrite: bool) -> None:
    """Let all staged files appear in the folder, unless it has come to hold some of them."""
    names = [path.name for path in workplace.staged.iterdir()]
    check_output(folder, names, overwrite=overwrite)
    try:
        publish(workplace, folder, overwrite=overwrite)
    except FileExistsError:
        check_output(folder, names, overwrite=overwrite)
        raise
