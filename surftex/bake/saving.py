"""Saving a bake: maps, GLB, features, report, the displaced mesh where wanted; all of them or nothing."""

from pathlib import Path
from typing import TYPE_CHECKING

from surftex.bake.stages import Progress
from surftex.files.output import check_output, whole_output

if TYPE_CHECKING:
    from surftex.bake.displacing import Baked


def save(
    baked: "Baked",
    folder: str | Path,
    *,
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
    names = [*baked.maps.file_names, *([baked.displaced_name] if displaced else [])]
    check_output(folder, names, overwrite=overwrite)
    with whole_output(folder, overwrite=overwrite) as workplace:
        if displaced:
            from surftex.bake.displacing import write_displaced

            told("displace", 0.0)
            write_displaced(baked, workplace, threads=threads, tick=lambda share: told("displace", share))
            told("displace", 1.0)
        told("save", 0.0)
        baked.maps.write(workplace, threads=threads)
        names = sorted(path.name for path in workplace.iterdir())
    told("save", 1.0)
    return [Path(folder) / name for name in names]
