"""Bytes of a file that a user named, and names that are safe to print.

Only regular files are read: folders, pipes, devices and links that lead nowhere are refused before a byte is
asked for, so that nothing can hang.
"""

import os
import stat
from pathlib import Path

from surftex.errors import InputError, MeshFileError

LARGEST_BYTES = 4 * 2**30
"""Files beyond this are refused: arrays of their contents would not fit beside a bake."""


def printable(text: str, *, longest: int = 200) -> str:
    r"""Make text from a file or a path safe for one line of a terminal.

    Parameters
    ----------
    text : str
        Anything, control characters and undecodable bytes included.
    longest : int
        Characters kept; the middle of longer text gives way to an ellipsis.

    Returns
    -------
    text : str
        Without control characters, which appear as escapes.

    Examples
    --------
    >>> print(printable("a\x1b[2Jb"))
    a\x1b[2Jb
    """
    if len(text) > longest:
        text = text[: longest // 2] + "…" + text[-(longest // 2 - 1) :]
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def read_bytes(
    path: str | os.PathLike[str], *, purpose: str = "mesh file", error: type[InputError] = MeshFileError
) -> bytes:
    """Read a whole regular file.

    Parameters
    ----------
    path : path
        Of the file; links are followed.
    purpose : str
        What messages call it.
    error : type
        Which failure to raise.

    Returns
    -------
    data : bytes
        All of it.

    Raises
    ------
    InputError
        Of the given type, if there is no such file, it is no regular file, may not be read, or is absurdly large.
    """
    shown = printable(os.fspath(path))
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except FileNotFoundError:
        raise error(f"{shown}: no such {purpose}; check the path") from None
    except IsADirectoryError:
        raise error(f"{shown}: is a folder, not a {purpose}; name a file in it") from None
    except PermissionError:
        place = "is a folder" if Path(path).is_dir() else "may not be read; check its permissions"
        raise error(f"{shown}: {place}") from None
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or str(problem)
        raise error(f"{shown}: cannot be opened as a {purpose} ({reason}); check the path") from None
    try:
        status = os.fstat(handle)
        if stat.S_ISDIR(status.st_mode):
            raise error(f"{shown}: is a folder, not a {purpose}; name a file in it")
        if not stat.S_ISREG(status.st_mode):
            raise error(f"{shown}: is a pipe or device, not a {purpose}; write it to a file first")
        if status.st_size > LARGEST_BYTES:
            raise error(
                f"{shown}: holds {status.st_size} bytes, more than the {LARGEST_BYTES} that surftex reads"
            )
        with os.fdopen(handle, "rb", closefd=False) as file:
            return file.read(LARGEST_BYTES)
    except OSError as problem:
        raise error(f"{shown}: cannot be read to its end ({problem.strerror})") from None
    finally:
        os.close(handle)
