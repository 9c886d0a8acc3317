"""Meshes from files: OBJ, PLY, STL, OFF, GLB and glTF become surfaces in millimetres.

Files may be hostile: counts are checked against the bytes that are there, only the file itself is opened (and
the buffers of a .gltf, in its own folder), and each mistake is one line that says where it is.
"""

import hashlib
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from surftex.errors import MeshFileError, SurfaceError
from surftex.files.gltf import read_gltf
from surftex.files.obj import read_obj
from surftex.files.off import read_off
from surftex.files.parts import chosen_faces, part_labels
from surftex.files.ply import read_ply
from surftex.files.polygons import Polygons, check_face_count
from surftex.files.reading import printable, read_bytes
from surftex.files.scaling import mm_per_unit
from surftex.files.stl import read_stl
from surftex.surface.repair import extent, repair
from surftex.surface.surface import Surface
from surftex.surface.triangulate import triangulate

FORMATS = (".obj", ".ply", ".stl", ".glb", ".gltf", ".off")
"""Suffixes of the files that can be read."""

_UV_ROUNDING = 1e-4


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
        What a unit of the file is: "mm", "cm", "m" or "in". Without it metres for glTF; for other formats the
        first of m, cm and mm that puts the longest side between 20 mm and 5 m, with a warning.
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
        return _surface(read_polygons(data, suffix, shown, Path(path).parent), data, path, units, size, part)
    except SurfaceError as problem:
        raise MeshFileError(f"{shown}: {problem}") from None
    except MemoryError:
        raise MeshFileError(f"{shown}: needs more memory than there is; decimate it first") from None


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


def _surface(
    polygons: Polygons,
    data: bytes,
    path: str | os.PathLike[str],
    units: str | None,
    size: str | float | None,
    part: str | None,
) -> Surface:
    shown = printable(os.fspath(path))
    warnings = list(polygons.warnings)
    used = np.zeros(len(polygons.vertices), bool)
    used[polygons.corner] = True
    if not used.all():
        warnings.append(f"{int((~used).sum())} vertices that no face uses were dropped")
    places = polygons.vertices[used]
    scale, notes = mm_per_unit(
        float(extent(places).max()), shown, own=polygons.mm_per_unit, units=units, size=size
    )
    warnings.extend(notes)
    if part is not None:
        polygons = polygons.selected(chosen_faces(polygons, part, shown))
        used[:] = False
        used[polygons.corner] = True
        places = polygons.vertices[used]
        extent(places)
    middle = 0.5 * (places.min(axis=0) + places.max(axis=0))
    points = (places - middle) * scale
    corner = (np.cumsum(used) - 1)[polygons.corner]

    sizes = np.diff(polygons.start)
    check_face_count(int((sizes - 2).sum()), shown)
    triangles, polygon = triangulate(points, corner, polygons.start)
    labels, names = part_labels(polygons)
    uv = _own_uv(polygons, triangles, warnings)
    normal = None if polygons.normals is None else polygons.normals[triangles]
    mended = repair(points, corner[triangles], corner_uv=uv, corner_normal=normal, part=labels[polygon])
    return Surface.from_arrays(
        mended.vertices,
        mended.faces,
        corner_uv=mended.corner_uv,
        corner_normal=mended.corner_normal,
        part=mended.part,
        part_names=names,
        origin_mm=middle * scale,
        name="".join(c if c.isprintable() else "_" for c in Path(path).stem),
        sha256=hashlib.sha256(data).hexdigest(),
        mm_per_unit=scale,
        warnings=tuple(warnings) + mended.warnings,
    )


def _own_uv(
    polygons: Polygons, triangles: NDArray[np.int64], warnings: list[str]
) -> NDArray[np.float64] | None:
    """Take the first UV set that is complete and lies in 0..1, else the first complete one."""
    fallback: tuple[int, NDArray[np.float64]] | None = None
    partial = 0
    for number, values in enumerate(polygons.uv_sets):
        uv = values[triangles]
        sound = np.isfinite(uv).all(axis=(1, 2)) & (np.abs(uv) < 1e6).all(axis=(1, 2))
        if not sound.all():
            partial = partial or int((~sound).sum())
            continue
        side = uv[:, 1:] - uv[:, :1]
        area = np.abs(side[:, 0, 0] * side[:, 1, 1] - side[:, 0, 1] * side[:, 1, 0])
        if not area.sum() > 0:
            warnings.append(f"UV set {number} has no area and is ignored")
            continue
        if uv.min() >= -_UV_ROUNDING and uv.max() <= 1 + _UV_ROUNDING:
            if number:
                warnings.append(f"UV set {number} is used: the sets before it leave 0..1 or are incomplete")
            return np.clip(uv, 0.0, 1.0)
        fallback = fallback or (number, uv)
    if fallback is not None:
        low, high = fallback[1].min(), fallback[1].max()
        warnings.append(f"the file's UVs leave 0..1 (they run from {low:.3g} to {high:.3g})")
        return fallback[1]
    if partial:
        warnings.append(f"{partial} of {len(triangles)} faces have no usable UVs; the file's UVs are ignored")
    return None
