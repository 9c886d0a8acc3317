"""Tables of skin as files: made piece by piece, gone on from after an interruption, whole or not there."""

import hashlib
import os
import time
from collections.abc import Iterator, MutableMapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import checked_whole
from surftex.errors import InputError
from surftex.files import shelf
from surftex.files.output import check_place, write_whole
from surftex.kernels.pool import Tick
from surftex.optics.making import Making, make_table
from surftex.optics.table import COLUMNS, MOST_REFLECTANCE, SkinTable


class ShelvedPieces(MutableMapping[str, NDArray[np.float64]]):
    """Finished pieces of a table, also those of earlier runs; each is on the disk as soon as it is there.

    Parameters
    ----------
    remember : bool
        Whether to take pieces of earlier runs, and to leave new ones to later runs.
    """

    def __init__(self, *, remember: bool = True) -> None:
        self.remember = remember
        self.pieces: dict[str, NDArray[np.float64]] = {}
        self.found = 0

    def __contains__(self, name: object) -> bool:
        if name not in self.pieces and self.remember:
            arrays = shelf.kept(_key(str(name)))
            if arrays is not None and "values" in arrays:
                self.pieces[str(name)] = arrays["values"]
                self.found += 1
        return name in self.pieces

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.pieces[name]

    def __setitem__(self, name: str, values: NDArray[np.float64]) -> None:
        self.pieces[name] = values
        if self.remember:
            shelf.keep(_key(name), {"values": values})

    def __delitem__(self, name: str) -> None:
        del self.pieces[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.pieces)

    def __len__(self) -> int:
        return len(self.pieces)


def match_to_file(
    making: Making,
    path: str | Path,
    *,
    overwrite: bool = False,
    remember: bool = True,
    threads: int | None = None,
    tick: Tick | None = None,
) -> dict[str, Any]:
    """Make a table of skin and write it.

    Parameters
    ----------
    making : Making
        How.
    path : path
        Of the ``.npz``, in a folder that is there.
    overwrite : bool
        Whether it may replace a file.
    remember : bool
        Whether to take finished pieces of earlier runs with the same settings, which are the same numbers, and to leave
        those of this run to later ones.
    threads : int, optional
        None means every core; it changes no byte.
    tick : callable, optional
        Told the finished share; may raise to stop.

    Returns
    -------
    report : dict
        What was made, what it took, and ``warnings`` of what the table does not hold.

    Raises
    ------
    InputError
        If the file is there already, its folder is not, or nothing can be written there; before any work.
    WorkError
        If it cannot be written once it is made.
    """
    if threads is not None:
        checked_whole(threads, "threads", 1)
    path = Path(path)
    if not path.name or path.is_dir():
        raise InputError(f"{path} is a folder; name the table too, such as {path / 'skin.npz'}")
    if path.suffix != ".npz":
        raise InputError(f"{path}: a table of skin is an .npz; name it {path.with_suffix('.npz').name}")
    if not path.absolute().parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}; make it first")
    if os.path.lexists(path) and not overwrite:
        raise InputError(
            f"{path} is there already; choose another name, or allow it with overwrite (--overwrite)"
        )
    check_place(path)
    pieces, wall, processor = ShelvedPieces(remember=remember), time.perf_counter(), time.process_time()
    table = make_table(making, kept=pieces, threads=threads, tick=tick)
    write_whole(path, table.to_bytes())
    return {
        "table": str(path),
        "entries": int(np.prod(table.values.shape[:-1])),
        "pieces": len(pieces),
        "pieces_of_earlier_runs": pieces.found,
        "wall_s": round(time.perf_counter() - wall, 3),
        "cpu_s": round(time.process_time() - processor, 3),
        "settings": table.settings,
        "warnings": table_warnings(making, table),
    }


def table_warnings(making: Making, table: SkinTable) -> list[str]:
    """Tell what a table does not hold, or holds at a bound.

    Parameters
    ----------
    making : Making
        How it was made.
    table : SkinTable
        What came of it.

    Returns
    -------
    warnings : list of str
        A line each.
    """
    told = [
        f"{name} has one node, {known[0]:g}: the table shows every other value as this one"
        for name, known in table.axes.items()
        if len(known) == 1
    ]
    level = table.values[..., COLUMNS.index("reflectance")]
    most = int((level >= MOST_REFLECTANCE).sum())
    if making.fit_reflectance and most:
        told.append(
            f"reflectance ends at its bound, {MOST_REFLECTANCE:g}, in {most} of {level.size} entries: there the match "
            "takes diffuse light for gloss; without --fit-reflectance it is that of the skin's index"
        )
    return told


def _key(name: str) -> str:
    return hashlib.sha256(f"table of skin {name}".encode()).hexdigest()
