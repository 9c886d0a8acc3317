"""Files that a batch names, one by one or by globs, and short names that tell them apart."""

import unicodedata
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path

from surftex.errors import RecipeError

_MARKS = "*?["


def alike(name: str) -> str:
    """Write a name in the form in which two names of one folder are the same on any disk.

    Parameters
    ----------
    name : str
        Of a file or a folder.

    Returns
    -------
    name : str
        Without case, its accents composed.
    """
    return unicodedata.normalize("NFC", name).casefold()


def matching(pattern: str, root: Path, leave_out: Callable[[Path], bool]) -> list[Path] | None:
    """List the files that a glob means.

    Parameters
    ----------
    pattern : str
        Relative to `root`.
    root : Path
        Folder of the batch.
    leave_out : callable
        Whether a file that matches is none that is meant.

    Returns
    -------
    files : list of Path, or None
        Sorted, at least one; None if the text is a plain path: it has no mark of a glob, or is the name of a
        file that is there, such as ``a[1].obj``.

    Raises
    ------
    RecipeError
        If it is no pattern, leaves the folder, or nothing matches.
    """
    if not any(mark in pattern for mark in _MARKS):
        return None
    try:
        if (root / pattern).is_file():
            return None
        if Path(pattern).is_absolute() or ".." in Path(pattern).parts:
            raise RecipeError(f"{pattern!r} leaves the batch's folder; name those files one by one")
        found = sorted(each for each in root.glob(pattern) if each.is_file() and not leave_out(each))
    except (ValueError, OSError) as problem:
        if isinstance(problem, RecipeError):
            raise
        raise RecipeError(f"{pattern!r} is no pattern: {problem}") from None
    if not found:
        raise RecipeError(f"nothing matches {pattern!r} in {root}")
    return found


def short_names(
    files: Iterable[Path], root: Path, *, taken: Iterable[str] = (), suffixes: bool = True
) -> dict[Path, str]:
    """Name each file by its stem, or, where that is not its own, by its path below a folder.

    Parameters
    ----------
    files : iterable of Path
        Absolute.
    root : Path
        Where long names start, of files that lie below.
    taken : iterable of str
        Names that others have.
    suffixes : bool
        Whether long names end as the file does.

    Returns
    -------
    names : dict of Path to str
        Such as ``left``, or ``boots-left.obj``.
    """
    each = dict.fromkeys(files)
    others = {alike(name) for name in taken}
    stems = Counter(alike(file.stem) for file in each)
    names = {}
    for file in each:
        below = file.relative_to(root) if file.is_relative_to(root) else Path(*file.parts[1:])
        long = "-".join((below if suffixes else below.with_suffix("")).parts)
        own = stems[alike(file.stem)] == 1 and alike(file.stem) not in others
        names[file] = file.stem if own else long
    return names
