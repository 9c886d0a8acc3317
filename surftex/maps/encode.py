"""Maps to files: which format each map takes, and the GLB that wires them. Pictures are packed once."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import WorkError
from surftex.files.glb import glb_bytes
from surftex.files.images import normal_codes, png_bytes, srgb_codes, unit_codes, write_exr
from surftex.kernels.pool import slices

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


def file_name(stem: str, name: str) -> str:
    """Name the file of a map.

    Parameters
    ----------
    stem : str
        Start of the name.
    name : str
        Of the map.

    Returns
    -------
    file_name : str
        PNG for what viewers draw, EXR for numbers.
    """
    return f"{stem}_{name}.{'png' if name in _CODES else 'exr'}"


def write_maps(maps: "MapSet", folder: Path, *, threads: int | None = None) -> None:
    """Write every map and the GLB.

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
    jobs: list[Callable[[], tuple[str, bytes] | None]] = []
    for name, image in maps.items():
        path = folder / file_name(maps.stem, name)
        jobs.append(_png_job(path, name, image) if name in _CODES else _exr_job(path, image))
    jobs += _texture_jobs(maps)
    packed = slices(
        lambda first, last: [job() for job in jobs[first:last]], len(jobs), size=1, threads=threads
    )
    pictures = dict(picture for part in packed for picture in part if picture is not None)
    document = glb_bytes(
        maps.surface,
        maps.atlas.corner_uv,
        maps.tangents,
        pictures,
        name=maps.stem,
        occluded="ambient_occlusion" in maps,
        extras=_extras(maps),
    )
    _write(folder / f"{maps.stem}.glb", document)


def _write(path: Path, data: bytes) -> None:
    """Write bytes, telling failures in a line."""
    try:
        path.write_bytes(data)
    except OSError as problem:
        raise WorkError(f"{path.name}: cannot write: {problem.strerror or problem}") from None


def _png_job(path: Path, name: str, image: NDArray[Any]) -> Callable[[], tuple[str, bytes] | None]:
    """Pack one map; hand on what the GLB takes as it is."""

    def job() -> tuple[str, bytes] | None:
        data = png_bytes(_CODES[name](image))
        _write(path, data)
        return (name, data) if name in ("base_color", "normal") else None

    return job


def _exr_job(path: Path, image: NDArray[Any]) -> Callable[[], None]:
    """Write one map as numbers."""
    return lambda: write_exr(path, image)


def _texture_jobs(maps: "MapSet") -> list[Callable[[], tuple[str, bytes]]]:
    """Pack the pictures that only the GLB has."""
    jobs: list[Callable[[], tuple[str, bytes]]] = []
    if {"roughness", "metallic", "ambient_occlusion"} & set(maps):
        jobs.append(lambda: ("orm", png_bytes(_occlusion_roughness_metallic(maps))))
    if "specular" in maps:
        jobs.append(lambda: ("specular", png_bytes(srgb_codes(maps["specular"]))))
    return jobs


def _occlusion_roughness_metallic(maps: "MapSet") -> NDArray[np.uint8]:
    """Lay three maps into one picture; open, half rough and no metal where a map is missing."""
    size = next(iter(maps.values())).shape[:2]
    codes = np.zeros((*size, 3), np.uint8)
    for channel, (name, missing) in enumerate(
        (("ambient_occlusion", 255), ("roughness", 128), ("metallic", 0))
    ):
        codes[..., channel] = unit_codes(maps[name]) if name in maps else missing
    return codes


def _extras(maps: "MapSet") -> dict[str, Any]:
    """Tell what glTF itself has no place for: the height map with its unit, and how far light wanders below the surface."""
    extras: dict[str, Any] = {}
    if "height" in maps:
        height = maps["height"]
        extras["surftex_height"] = {
            "file": file_name(maps.stem, "height"),
            "unit": "mm",
            "least": float(height.min()),
            "greatest": float(height.max()),
        }
    if maps.report.get("subsurface"):
        extras["surftex_subsurface"] = dict(maps.report["subsurface"])
    return extras
