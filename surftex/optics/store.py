"""Tables of skin as files."""

import os
from pathlib import Path

from surftex.errors import InputError
from surftex.optics.table import SkinTable
from surftex.words import sort_of


def load_table(path: str | Path) -> SkinTable:
    """Read a table of skin that ``surftex match`` has made.

    Parameters
    ----------
    path : path
        Of the ``.npz``.

    Returns
    -------
    table : SkinTable
        For ``sx.optics.lookup(..., table=table)``; a recipe's skin names the file as its ``table``.

    Raises
    ------
    InputError
        If there is no such file, or it is no table, or damaged.
    """
    from surftex.files.reading import printable, read_bytes

    if not isinstance(path, (str, os.PathLike)):
        raise InputError(f"a table of skin is read from a path; this is {sort_of(path)}")
    data = read_bytes(path, purpose="table of skin", error=InputError)
    return SkinTable.from_bytes(data, printable(os.fspath(path)))
