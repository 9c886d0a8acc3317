"""`load`: whatever a caller has, as a surface."""

import os
from typing import Any

from surftex.surface.surface import Surface


def load(
    mesh: Any, *, units: str | None = None, size: str | float | None = None, part: str | None = None
) -> Surface:
    """Load a mesh: from a file, or from what another library holds in memory.

    Parameters
    ----------
    mesh : path, Surface, trimesh.Trimesh, trimesh.Scene, pyvista.PolyData or (vertices, faces)
        Files may be OBJ, PLY, STL, OFF, GLB or glTF.
    units : {"mm", "cm", "m", "in"}, optional
        What a unit of the mesh is. Without it metres for glTF, a plausible guess with a warning for other
        files, millimetres for meshes in memory.
    size : str or float, optional
        Length of the longest side, such as ``"300 mm"``; overrules `units`.
    part : str, optional
        Material slot, group, node or geometry to keep.

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
        from surftex.files.meshes import load as load_file

        return load_file(mesh, units=units, size=size, part=part)
    from surftex.files.doors import as_surface

    return as_surface(mesh, units=units or "mm", size=size, part=part)
