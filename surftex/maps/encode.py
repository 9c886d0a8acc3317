"""Maps to files: which format each map takes, and the GLB that wires them. Pictures are packed once."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import WorkError
from surftex.files.glb import glb_bytes
from surftex.files.images import normal_codes, png_bytes, srgb_codes, unit_codes, write_exr, write_png
from surftex.kernels.pool import slices
from surftex.paged import blocks, in_file

if TYPE_CHECKING:
    from surftex.maps.mapset import MapSet

_CODES: dict[str, Callable[[NDArray[Any]], NDArray[Any]]] = {
    "base_color": srgb_codes,
    "normal": normal_codes,
    "roughness": unit_codes,
    "ambient_occlusion": unit_codes,
    "specular": unit_codes,
    "metallic": unit_codes,
    "subsurface": unit_codes,
}


_TEXTURES: dict[str, tuple[str, ...]] = {
    "orm": ("ambient_occlusion", "roughness", "metallic"),
    "specular_color": ("specular",),
}
"""Pictures that only the GLB has, and the maps that they are made of."""

_MISSING = {"ambient_occlusion": 255, "roughness": 128, "metallic": 0}
"""Open, half rough, no metal."""


def file_name(stem: str, name: str) -> str:
    """Name the file of a map.

    Parameters
    ----------
    stem : str
        Start of the name.
    name : str
        Of the map; with the number of its page where there are several.

    Returns
    -------
    file_name : str
        PNG for what viewers draw, EXR for numbers.
    """
    base = name.partition(".")[0]
    return f"{stem}_{name}.{'png' if base in _CODES or base in _TEXTURES else 'exr'}"


def textures_beside(maps: "MapSet") -> list[str]:
    """Name the pictures that lie beside a GLB for it alone.

    Parameters
    ----------
    maps : MapSet
        What a bake gave.

    Returns
    -------
    names : list of str
        None where the GLB holds its pictures.
    """
    if not _large(maps):
        return []
    return [
        role + suffix
        for suffix in _suffixes(maps)
        for role, parts in _TEXTURES.items()
        if any(part + suffix in maps for part in parts)
    ]


def write_maps(maps: "MapSet", folder: Path, *, threads: int | None = None) -> None:
    """Write every map and the GLB.

    The GLB holds its pictures, unless there are several pages or they have more than
    `surftex.paged.LARGEST_IN_MEMORY` texels: then it names them, and they lie beside.

    Parameters
    ----------
    maps : MapSet
        What a bake gave.
    folder : Path
        Where; files of the same names are overwritten.
    threads : int, optional
        None means every core; it cannot change a byte.

    Raises
    ------
    WorkError
        If a file cannot be written.
    """
    large = _large(maps)
    jobs: list[Callable[[], tuple[str, bytes | str] | None]] = [
        partial(_written, maps, name, folder, large=large) for name in maps
    ]
    jobs += [
        partial(_texture, maps, role, suffix, folder, large=large)
        for suffix in _suffixes(maps)
        for role, parts in _TEXTURES.items()
        if any(part + suffix in maps for part in parts)
    ]
    packed = slices(
        lambda first, last: [job() for job in jobs[first:last]],
        len(jobs), size=1, threads=1 if large else threads,
    )  # fmt: skip
    pictures = dict(picture for part in packed for picture in part if picture is not None)
    document = glb_bytes(
        maps.surface,
        maps.atlas.corner_uv,
        maps.tangents,
        pictures,
        tile=maps.atlas.tile if len(maps.atlas.tiles) > 1 else None,
        name=maps.stem,
        occluded=any(name.partition(".")[0] == "ambient_occlusion" for name in maps),
        extras={suffix.removeprefix("."): _extras(maps, suffix) for suffix in _suffixes(maps)},
    )
    _write(folder / f"{maps.stem}.glb", document)


def _suffixes(maps: "MapSet") -> list[str]:
    """End of the names of each page's maps."""
    return sorted({"".join(name.partition(".")[1:]) for name in maps})


def _large(maps: "MapSet") -> bool:
    return any("." in name or in_file(image.shape) for name, image in maps.items())


def _write(path: Path, data: bytes) -> None:
    """Write bytes, telling failures in a line."""
    try:
        path.write_bytes(data)
    except OSError as problem:
        raise WorkError(f"{path.name}: cannot write: {problem.strerror or problem}") from None


def _written(maps: "MapSet", name: str, folder: Path, *, large: bool) -> tuple[str, bytes | str] | None:
    """Write one map; hand on what the GLB takes as it is."""
    base, path = name.partition(".")[0], folder / file_name(maps.stem, name)
    if base not in _CODES:
        write_exr(path, maps[name])
        return None
    picture = _packed(path, name, _CODES[base], [maps[name]], large=large)
    return picture if base in ("base_color", "normal") else None


def _texture(maps: "MapSet", role: str, suffix: str, folder: Path, *, large: bool) -> tuple[str, bytes | str]:
    """Make a picture that only the GLB has; it lies beside only where it is large."""
    parts = _TEXTURES[role]
    known = [part for part in parts if part + suffix in maps]

    def codes(*rows: NDArray[Any]) -> NDArray[Any]:
        if role == "specular_color":
            return srgb_codes(rows[0])
        given = dict(zip(known, rows, strict=True))
        shape = rows[0].shape
        return np.stack(
            [
                unit_codes(given[part]) if part in given else np.full(shape, _MISSING[part], np.uint8)
                for part in parts
            ],
            axis=-1,
        )

    path = folder / file_name(maps.stem, role + suffix) if large else None
    return _packed(path, role + suffix, codes, [maps[part + suffix] for part in known], large=large)


def _packed(
    path: Path | None,
    role: str,
    codes: Callable[..., NDArray[Any]],
    images: list[NDArray[Any]],
    *,
    large: bool,
) -> tuple[str, bytes | str]:
    """Pack a picture into a file, if it has one; hand it on by its role, as bytes or, where large, by name."""
    if large and path is not None:
        write_png(path, codes, *images)
        return role, path.name
    data = png_bytes(codes(*images))
    if path is not None:
        _write(path, data)
    return role, data


def _extras(maps: "MapSet", suffix: str) -> dict[str, Any]:
    """Tell what glTF itself has no place for: the height map with its unit, and how far light wanders below the surface."""
    extras: dict[str, Any] = {}
    if "height" + suffix in maps:
        height = maps["height" + suffix]
        ends = np.array([(height[rows].min(), height[rows].max()) for rows in blocks(height)])
        extras["surftex_height"] = {
            "file": file_name(maps.stem, "height" + suffix),
            "unit": "mm",
            "least": float(ends[:, 0].min()),
            "greatest": float(ends[:, 1].max()),
        }
    if maps.report.get("subsurface"):
        extras["surftex_subsurface"] = dict(maps.report["subsurface"])
    return extras
