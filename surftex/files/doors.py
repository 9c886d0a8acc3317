"""Meshes that other libraries hold in memory, as surfaces: trimesh, pyvista, or plain arrays.

None of the libraries is imported here: an object can only be theirs where they are loaded already.
"""

import hashlib
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked
from surftex.errors import SurfaceError
from surftex.files.building import surface_of
from surftex.files.polygons import Polygons, starts_of
from surftex.files.reading import printable
from surftex.surface.surface import Surface
from surftex.words import sort_of


def as_surface(
    mesh: Any,
    *,
    units: str = "mm",
    size: str | float | None = None,
    part: str | None = None,
    name: str = "surface",
    attributes: Mapping[str, ArrayLike] | None = None,
) -> Surface:
    """Turn what a caller has into a surface.

    Parameters
    ----------
    mesh : Surface, trimesh.Trimesh, trimesh.Scene, pyvista.PolyData or (V, F)
        A surface passes through untouched. UVs come along from a trimesh texture visual and from a PolyData's
        texture coordinates, and so do attributes of vertices and faces; a scene's geometries become parts. F may
        hold triangles or quads.
    units : str
        What a unit of the mesh is: "mm", "cm", "m" or "in".
    size : str or float, optional
        Length of the longest side; overrules `units`.
    part : str, optional
        Geometry of a scene to keep.
    name : str
        Stem for file names.
    attributes : mapping of str to (n,), (n, k), (m,) or (m, k) float, optional
        For (V, F): numbers of the n vertices or m faces by name, for fields to read.

    Returns
    -------
    surface : Surface
        In millimetres, mended as a file would be.

    Raises
    ------
    InputError
        If the object is none of these, or holds no surface.
    """
    if isinstance(mesh, Surface):
        return mesh
    polygons = _polygons(mesh)
    for key, value in (attributes or {}).items():
        polygons.attributes[key] = _at_corners(polygons, key, value)
    digest = hashlib.sha256()
    arrays = (polygons.vertices, polygons.start, polygons.corner, *polygons.uv_sets)
    for array in (*arrays, *(polygons.attributes[key] for key in sorted(polygons.attributes))):
        digest.update(np.ascontiguousarray(array).tobytes())
    try:
        return surface_of(
            polygons, name, name=name, sha256=digest.hexdigest(), units=units, size=size, part=part
        )
    except SurfaceError as problem:
        raise SurfaceError(f"{printable(name)}: {problem}") from None


def _polygons(mesh: Any) -> Polygons:
    trimesh, pyvista = sys.modules.get("trimesh"), sys.modules.get("pyvista")
    if trimesh is not None and isinstance(mesh, trimesh.Trimesh):
        return _joined([_from_trimesh(mesh, np.eye(4))], [])
    if trimesh is not None and isinstance(mesh, trimesh.Scene):
        names, pieces = [], []
        for node in sorted(mesh.graph.nodes_geometry):
            matrix, geometry = mesh.graph.get(node)
            body = mesh.geometry[geometry]
            if isinstance(body, trimesh.Trimesh) and len(body.faces):
                names.append(printable(str(geometry), longest=80))
                pieces.append(_from_trimesh(body, np.asarray(matrix, np.float64)))
        if not pieces:
            raise SurfaceError("the trimesh scene holds no triangles; surftex textures surfaces")
        return _joined(pieces, names)
    if pyvista is not None and isinstance(mesh, pyvista.PolyData):
        return _from_polydata(mesh)
    if pyvista is not None and isinstance(mesh, pyvista.DataObject):
        raise SurfaceError(f"a pyvista {type(mesh).__name__} is no surface; hand in its extract_surface()")
    if isinstance(mesh, (tuple, list)) and len(mesh) == 2:
        return _from_arrays(mesh[0], mesh[1])
    raise SurfaceError(
        f"{sort_of(mesh)} is no mesh; surftex takes a Surface, trimesh.Trimesh or Scene, "
        "pyvista.PolyData, or (vertices, faces)"
    )


def _from_arrays(vertices: Any, faces: Any) -> Polygons:
    places = checked(vertices, "vertices", (None, 3), np.float64, error=SurfaceError)
    width = 4 if getattr(np.asarray(faces), "ndim", 0) == 2 and np.shape(faces)[1] == 4 else 3
    corner = checked(faces, "faces", (None, width), np.int64, error=SurfaceError)
    return _checked_polygons(places, np.full(len(corner), width), corner.ravel(), [])


def _at_corners(polygons: Polygons, name: str, value: Any) -> NDArray[np.float64]:
    """Numbers of vertices or faces, by their count, at the corners."""
    array, faces = np.asarray(value), len(polygons.start) - 1
    if array.dtype.kind not in "biuf" or array.ndim not in (1, 2):
        raise SurfaceError(f"attribute {name!r} is no list of numbers; it has shape {array.shape}")
    if len(array) == len(polygons.vertices):
        return array.astype(np.float64)[polygons.corner]
    if len(array) == faces:
        return np.repeat(array.astype(np.float64), np.diff(polygons.start), axis=0)
    raise SurfaceError(
        f"attribute {name!r} has {len(array)} rows; the mesh has {len(polygons.vertices)} vertices and {faces} faces"
    )


def _hung(
    polygons: Polygons,
    vertices: Mapping[str, Any],
    faces: Mapping[str, Any],
    kept: NDArray[np.bool_] | None = None,
) -> Polygons:
    """Take along what another library's mesh has at its vertices and faces, where it is numbers."""
    counts = (len(polygons.vertices), len(polygons.start) - 1 if kept is None else len(kept))
    for table, count in ((faces, counts[1]), (vertices, counts[0])):
        for name, value in table.items():
            array = np.asarray(value)
            if array.dtype.kind in "biuf" and array.ndim in (1, 2) and len(array) == count:
                numbers = array.astype(np.float64)
                if table is vertices:
                    numbers = numbers[polygons.corner]
                else:
                    numbers = np.repeat(
                        numbers if kept is None else numbers[kept], np.diff(polygons.start), axis=0
                    )
                polygons.attributes[printable(str(name), longest=80)] = numbers
    return polygons


def _checked_polygons(
    places: NDArray[np.float64],
    sizes: NDArray[np.int64],
    corner: NDArray[np.int64],
    uv_sets: list[NDArray[np.float64]],
) -> Polygons:
    if len(sizes) == 0:
        raise SurfaceError("the mesh has no faces; surftex textures surfaces, not points or lines")
    wrong = np.flatnonzero((corner < 0) | (corner >= len(places)))
    if len(wrong):
        raise SurfaceError(
            f"{len(wrong)} corners point outside the {len(places)} vertices; "
            f"the first is {int(corner[wrong[0]])}"
        )
    return Polygons(places, starts_of(sizes), corner, uv_sets)


def _from_trimesh(mesh: Any, matrix: NDArray[np.float64]) -> Polygons:
    places = checked(mesh.vertices, "vertices", (None, 3), np.float64, error=SurfaceError)
    faces = checked(mesh.faces, "faces", (None, 3), np.int64, error=SurfaceError)
    if np.linalg.det(matrix[:3, :3]) < 0:
        faces = faces[:, [0, 2, 1]]
    uv = getattr(mesh.visual, "uv", None)
    corner = faces.ravel()
    uv_sets = []
    if uv is not None and np.shape(uv) == (len(places), 2):
        uv_sets = [np.asarray(uv, np.float64)[corner]]
    polygons = _checked_polygons(
        places @ matrix[:3, :3].T + matrix[:3, 3], np.full(len(faces), 3), corner, uv_sets
    )
    painted = getattr(mesh.visual, "kind", None) == "vertex"
    colors = {"color": np.asarray(mesh.visual.vertex_colors) / 255} if painted else {}
    return _hung(polygons, {**colors, **mesh.vertex_attributes}, mesh.face_attributes)


def _from_polydata(mesh: Any) -> Polygons:
    if mesh.n_strips:
        mesh = mesh.triangulate()
    places = checked(mesh.points, "points", (None, 3), np.float64, error=SurfaceError)
    flat = np.asarray(mesh.faces, np.int64)
    sizes, corner = _unpacked(flat)
    sound = np.repeat(sizes >= 3, sizes)
    uv = mesh.active_texture_coordinates
    uv_sets = []
    if uv is not None and len(uv) == len(places):
        uv_sets = [np.asarray(uv, np.float64)[corner[sound], :2]]
    polygons = _checked_polygons(places, sizes[sizes >= 3], corner[sound], uv_sets)
    cells = mesh.cell_data if mesh.n_cells == len(sizes) else {}
    return _hung(polygons, dict(mesh.point_data), dict(cells), sizes >= 3)


def _unpacked(flat: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Sizes and corners of VTK's cells: each a length, then that many points."""
    if len(flat) and len(flat) % (flat[0] + 1) == 0:
        table = flat.reshape(-1, flat[0] + 1)
        if (table[:, 0] == flat[0]).all():
            return table[:, 0].copy(), table[:, 1:].ravel()
    heads, at = [], 0
    while at < len(flat):
        heads.append(at)
        at += int(flat[at]) + 1
    first = np.array(heads, np.int64)
    return flat[first], np.delete(flat, first)


def _joined(pieces: list[Polygons], names: list[str]) -> Polygons:
    """Put several meshes side by side; each is a part if there are names."""
    offset = starts_of(np.array([len(p.vertices) for p in pieces]))
    sizes = np.concatenate([np.diff(p.start) for p in pieces])
    corner = np.concatenate([p.corner + int(o) for p, o in zip(pieces, offset[:-1], strict=True)])
    uv_sets = []
    if any(p.uv_sets for p in pieces):
        uv_sets = [
            np.concatenate(
                [p.uv_sets[0] if p.uv_sets else np.full((len(p.corner), 2), np.nan) for p in pieces]
            )
        ]
    labels = {}
    if names:
        unique = {name: k for k, name in enumerate(dict.fromkeys(names))}
        index = np.repeat([unique[name] for name in names], [len(p.start) - 1 for p in pieces])
        labels["node"] = (index.astype(np.int32), tuple(unique))
    attributes = {}
    for name in dict.fromkeys(name for p in pieces for name in p.attributes):
        shapes = {p.attributes[name].shape[1:] for p in pieces if name in p.attributes}
        if len(shapes) == 1:
            blank = (*next(iter(shapes)),)
            attributes[name] = np.concatenate(
                [p.attributes.get(name, np.full((len(p.corner), *blank), np.nan)) for p in pieces]
            )
    return Polygons(
        np.concatenate([p.vertices for p in pieces]), starts_of(sizes), corner, uv_sets, None, labels,
        attributes=attributes,
    )  # fmt: skip
