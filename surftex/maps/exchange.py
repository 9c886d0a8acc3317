"""A bake for other programs than glTF viewers: its material as MaterialX, its mesh and material as USD."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from surftex.errors import InputError, WorkError
from surftex.maps.encode import file_name

if TYPE_CHECKING:
    from surftex.maps.mapset import MapSet

Usd = Literal["usda", "usdc", "usdz"]
"""Formats of USD: text, binary, one file with the pictures inside."""


def exchange_names(stem: str, *, materialx: bool = False, usd: Usd | None = None) -> list[str]:
    """Name the files that `write_exchange` writes; refuse early what it could not.

    Parameters
    ----------
    stem : str
        Start of file names.
    materialx : bool
        Whether MaterialX is wanted.
    usd : {"usda", "usdc", "usdz"}, optional
        Whether USD is wanted, and how.

    Returns
    -------
    names : list of str
        Those of the GLB, with other endings.

    Raises
    ------
    InputError
        If the format is unknown, or the library of USD is missing.
    """
    if usd:
        from surftex.files.usd import FORMATS, check_usd

        if usd not in FORMATS:
            raise InputError(f"usd is {usd!r}; it takes {', '.join(FORMATS)}")
        check_usd()
    return [f"{stem}.{kind}" for kind in (["mtlx"] if materialx else []) + ([usd] if usd else [])]


def write_exchange(maps: "MapSet", folder: Path, *, materialx: bool = False, usd: Usd | None = None) -> None:
    """Write MaterialX and USD beside the pictures, which are there.

    Parameters
    ----------
    maps : MapSet
        What a bake gave.
    folder : Path
        Holds the files of the maps.
    materialx : bool
        Whether MaterialX is wanted.
    usd : {"usda", "usdc", "usdz"}, optional
        Whether USD is wanted, and how.

    Raises
    ------
    InputError
        If the library of USD is missing, or a .usdz is asked for with several pages.
    WorkError
        If a file cannot be written.
    """
    pictures = {base: _picture(maps, name) for name in maps for base in [name.partition(".")[0]]}
    if materialx:
        from surftex.files.materialx import materialx_bytes

        parts = list(maps.surface.slot_names(maps.stem).values())
        paged = any("." in name for name in maps)
        data = materialx_bytes(pictures, parts, name=maps.stem, tiles=maps.atlas.tiles if paged else ())
        try:
            (folder / f"{maps.stem}.mtlx").write_bytes(data)
        except OSError as problem:
            raise WorkError(f"{maps.stem}.mtlx: cannot write: {problem.strerror or problem}") from None
    if usd:
        from surftex.files.usd import write_usd

        path = folder / f"{maps.stem}.{usd}"
        write_usd(path, maps.surface, maps.atlas.corner_uv, pictures, name=maps.stem)


def _picture(maps: "MapSet", name: str) -> str:
    """Name the file of a map, or those of all its pages."""
    base, paged, _ = name.partition(".")
    return file_name(maps.stem, f"{base}.<UDIM>" if paged else base)
