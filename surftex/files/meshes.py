"""Meshes from files: OBJ, PLY, STL, OFF, GLB and glTF become surfaces in millimetres.

Files may be hostile: counts are checked against the bytes that are there, only the file itself is opened (and
the buffers of a .gltf, in its own folder), and each mistake is one line that says where it is.
"""

import hashlib
import os
from pathlib import Path

import numpy as np

from surftex.errors import MeshFileError, SurfaceError
from surftex.files.building import surface_of
from surftex.files.gltf import buffer_files, read_gltf
from surftex.files.obj import read_obj
from surftex.files.off import read_off
from surftex.files.ply import read_ply
from surftex.files.polygons import Polygons
from surftex.files.reading import printable, read_bytes
from surftex.files.scaling import is_own, named_unit
from surftex.files.stl import read_stl
from surftex.surface.surface import Surface

FORMATS = (".obj", ".ply", ".stl", ".glb", ".gltf", ".off")
"""Suffixes of the files that can be read."""


def load(
    path: str | os.PathLike[str],
    *,
    units: str | None = None,
    size: str | float | None = None,
    part: str | None = None,
) -> Surface:
    """Read a mesh file and mend it into a surface.

    Parameters
    ----------
    path : path
        Of an OBJ, PLY, STL, OFF, GLB or glTF file.
    units : str, optional
        What a unit of the file is: "mm", "cm", "m" or "in". Without it metres for glTF, and millimetres for what surftex
        has written. For other files, with a warning, what comments at the head of the file name, or the one of m, cm and
        mm that puts the longest side nearest to 300 mm by ratio, if that lies between 20 mm and 5 m.
    size : str or float, optional
        Length of the longest side of the whole file, such as "300 mm"; overrules `units`.
    part : str, optional
        Material slot, group or node to keep; its scale is that of the whole file.

    Returns
    -------
    surface : Surface
        In millimetres around `origin_mm`; `warnings` says what was mended.

    Raises
    ------
    MeshFileError
        If the file cannot be read, or holds no surface.
    RecipeError
        If `units` or `size` does not read.
    """
    shown = printable(os.fspath(path))
    suffix = Path(os.fspath(path)).suffix.lower()
    if not os.fspath(path):
        raise MeshFileError("the path of the mesh is empty; name a file")
    if suffix not in FORMATS and Path(path).is_file():
        raise MeshFileError(
            f"{shown}: unknown format {suffix or '(no suffix)'!r}; known are {', '.join(FORMATS)}"
        )
    data = read_bytes(path)
    if not data:
        raise MeshFileError(f"{shown}: is empty")
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            polygons = read_polygons(data, suffix, shown, Path(path).parent)
        if polygons.mm_per_unit is None and is_own(data):
            polygons.mm_per_unit = 1.0
        polygons.named_unit = named_unit(data)
        name = "".join(c if c.isprintable() else "_" for c in Path(path).stem)
        digest = hashlib.sha256(data).hexdigest()
        del data
        return surface_of(polygons, shown, name=name, sha256=digest, units=units, size=size, part=part)
    except SurfaceError as problem:
        raise MeshFileError(f"{shown}: {problem}") from None
    except MemoryError:
        raise MeshFileError(f"{shown}: needs more memory than there is; decimate it first") from None


def mesh_files(path: str | os.PathLike[str]) -> list[Path]:
    """List the files that make a mesh.

    Parameters
    ----------
    path : path
        Of the mesh file.

    Returns
    -------
    paths : list of Path
        The file itself, then the buffers that a .gltf has beside it.

    Raises
    ------
    MeshFileError
        If a .gltf cannot be read, or names a buffer outside its folder.
    """
    own = Path(path)
    if own.suffix.lower() != ".gltf":
        return [own]
    return [own, *buffer_files(read_bytes(own), printable(os.fspath(path)), own.parent)]


def read_polygons(data: bytes, suffix: str, where: str, folder: Path) -> Polygons:
    """Parse the bytes of a mesh file.

    Parameters
    ----------
    data : bytes
        The file.
    suffix : str
        One of `FORMATS`.
    where : str
        File name for messages.
    folder : Path
        Where buffers of a .gltf may lie.

    Returns
    -------
    polygons : Polygons
        What the file says, in its own unit.

    Raises
    ------
    MeshFileError
        Naming what is wrong, and where.
    """
    if suffix in (".glb", ".gltf"):
        return read_gltf(data, where, folder)
    readers = {".obj": read_obj, ".ply": read_ply, ".stl": read_stl, ".off": read_off}
    if suffix not in readers:
        raise MeshFileError(
            f"{where}: unknown format {suffix or '(no suffix)'!r}; known are {', '.join(FORMATS)}"
        )
    return readers[suffix](data, where)
