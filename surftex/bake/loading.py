"""`load`: whatever a caller has, as a surface."""

import os
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from numpy.typing import ArrayLike

from surftex.surface.creases import crease_notes, creased
from surftex.surface.surface import Surface


def load(
    mesh: Any,
    *,
    units: str | None = None,
    size: str | float | None = None,
    part: str | None = None,
    crease: float | None = None,
    attributes: Mapping[str, ArrayLike] | None = None,
) -> Surface:
    """Load a mesh: from a file, or from what another library holds in memory.

    Parameters
    ----------
    mesh : path, Surface, trimesh.Trimesh, trimesh.Scene, pyvista.PolyData or (vertices, faces)
        Files may be OBJ, PLY, STL, OFF, GLB or glTF.
    units : {"mm", "cm", "m", "in"}, optional
        What a unit of the mesh is. Without it metres for glTF; for other files what their comments name,
        or a plausible guess, with a warning; millimetres for meshes in memory.
    size : str or float, optional
        Length of the longest side of the whole mesh, such as ``"300 mm"``; overrules `units`.
    part : str, optional
        Material slot, group, node or geometry to keep.
    crease : float, optional
        Degrees: edges that bend by more are hard, and the others are shaded smoothly, whatever normals the mesh has; 0 is
        flat. Without it the mesh's own normals, or smooth ones.
    attributes : mapping of str to (n,), (n, k), (m,) or (m, k) float, optional
        For a mesh in memory: numbers of its n vertices or m faces by name, for fields to read. Files bring their
        own; `Surface.with_attributes` hangs more on any surface.

    Returns
    -------
    surface : Surface
        In millimetres, mended until it can be walked on; its ``warnings`` say what was done.

    Raises
    ------
    InputError
        If there is no surface in it; what, where and how to mend it, in one line.
    """
    if isinstance(mesh, (str, os.PathLike)):
        from surftex.errors import InputError
        from surftex.files.meshes import load as load_file

        if attributes:
            raise InputError(
                "attributes go with a mesh in memory; for a file, take load(path).with_attributes(...)"
            )

        surface = load_file(mesh, units=units, size=size, part=part)
    else:
        from surftex.files.doors import as_surface

        surface = as_surface(
            mesh, units="mm" if units is None else units, size=size, part=part, attributes=attributes
        )
    if crease is not None:
        return creased(surface, crease)
    return replace(surface, warnings=surface.warnings + crease_notes(surface))
