"""Saving a bake: maps, GLB, features, report, the displaced mesh and more where wanted; all of them or nothing."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from surftex.bake.stages import Progress
from surftex.files.output import check_output, whole_output

if TYPE_CHECKING:
    from surftex.bake.displacing import Baked
    from surftex.maps.mapset import MapSet
    from surftex.recipe.model import BakeSettings

More = tuple[Sequence[str], Callable[[Path], None]]
"""Names of further files, and what writes them into a folder."""


def save(
    baked: "Baked",
    folder: str | Path,
    *,
    more: More | None = None,
    overwrite: bool = False,
    threads: int | None = None,
    progress: Progress | None = None,
) -> list[Path]:
    """Write everything that a bake gave.

    Parameters
    ----------
    baked : Baked
        From `surftex.bake.bake.run`.
    folder : path
        Made when it is missing; files of other names in it stay.
    more : (names, write), optional
        Further files, and what writes them.
    overwrite : bool
        Whether files of the same names may be replaced.
    threads : int, optional
        None means every core; cannot change a byte.
    progress : callable, optional
        ``progress(stage, share)``; may raise to cancel.

    Returns
    -------
    paths : list of Path
        What was written.

    Raises
    ------
    InputError
        If the folder is a file or a link, or holds one of the files.
    WorkError
        If the disk does not take them.
    """
    told = progress or (lambda stage, share: None)
    displaced = baked.recipe.bake.displaced
    names = [*([baked.displaced_name] if displaced else []), *(more[0] if more else [])]

    def write(workplace: Path) -> None:
        if displaced:
            from surftex.bake.displacing import write_displaced

            told("displace", 0.0)
            write_displaced(baked, workplace, threads=threads, tick=lambda share: told("displace", share))
            told("displace", 1.0)
        if more:
            more[1](workplace)

    return save_maps(
        baked.maps, folder, baked.recipe.bake,
        more=(names, write), overwrite=overwrite, threads=threads, progress=progress,
    )  # fmt: skip


def save_maps(
    maps: "MapSet",
    folder: str | Path,
    settings: "BakeSettings",
    *,
    more: More | None = None,
    overwrite: bool = False,
    threads: int | None = None,
    progress: Progress | None = None,
) -> list[Path]:
    """Write maps and further files, which the report names too.

    Parameters
    ----------
    maps : MapSet
        What was made.
    folder : path
        As for `save`.
    settings : BakeSettings
        Say whether MaterialX and USD are wanted too.
    more : (names, write), optional
        As for `save`.
    overwrite : bool
        As for `save`.
    threads : int, optional
        As for `save`.
    progress : callable, optional
        As for `save`.

    Returns
    -------
    paths : list of Path
        What was written.

    Raises
    ------
    InputError
        As `save`.
    WorkError
        As `save`.
    """
    from surftex.maps.exchange import exchange_names

    told = progress or (lambda stage, share: None)
    names, write = more or ((), lambda workplace: None)
    names = [*maps.file_names, *exchange_names(maps.stem, **settings.exchange), *names]
    check_output(folder, names, overwrite=overwrite)
    with whole_output(folder, overwrite=overwrite) as workplace:
        write(workplace)
        told("save", 0.0)
        maps.write(workplace, **settings.exchange, threads=threads)
        written = sorted(path.name for path in workplace.iterdir())
    told("save", 1.0)
    return [Path(folder) / name for name in written]
