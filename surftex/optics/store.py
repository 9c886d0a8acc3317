"""Tables of skin as files."""

from pathlib import Path

from surftex.optics.table import SkinTable


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
        If it is none, or damaged.
    """
    from surftex.files.reading import printable, read_bytes

    return SkinTable.from_bytes(read_bytes(path, purpose="table of skin"), printable(str(path)))
