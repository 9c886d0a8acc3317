"""Meshes of other libraries come in whole: faces, units, UVs, parts."""

import subprocess
import sys

import numpy as np
import pytest

from surftex.errors import SurfaceError
from surftex.files.doors import as_surface
from surftex.surface.shapes import plane, sphere

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)


def test_a_surface_passes_through():
    ball = sphere()
    assert as_surface(ball) is ball


def test_arrays_of_triangles_and_quads_in_any_unit():
    assert as_surface((SQUARE, [[0, 1, 2], [0, 2, 3]])).area_mm2 == pytest.approx(1)
    surface = as_surface((SQUARE.tolist(), [[0, 1, 2, 3]]), units="cm", name="patch")
    assert surface.area_mm2 == pytest.approx(100)
    assert surface.name == "patch"
    assert surface.sha256
    assert as_surface((SQUARE, [[0, 1, 2, 3]]), size="2 m").area_mm2 == pytest.approx(4e6)


def test_trimesh_with_and_without_uv():
    trimesh = pytest.importorskip("trimesh")
    flat = plane(10, cells=3)
    mesh = trimesh.Trimesh(flat.vertices, flat.faces, process=False)
    assert as_surface(mesh).corner_uv is None
    mesh.visual = trimesh.visual.TextureVisuals(uv=flat.vertices[:, :2] / 10)
    surface = as_surface(mesh)
    assert surface.corner_uv == pytest.approx(surface.vertices[surface.faces][..., :2] / 10 + 0.5)


def test_a_trimesh_scene_has_parts_and_mirrored_nodes():
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene()
    ball = trimesh.creation.icosphere(subdivisions=1)
    scene.add_geometry(ball, geom_name="one", node_name="one")
    mirror = np.diag([-2.0, 2.0, 2.0, 1.0])
    mirror[0, 3] = 9
    scene.add_geometry(ball, geom_name="two", node_name="two", transform=mirror)
    surface = as_surface(scene, units="m")
    assert surface.part_names == ("one", "two")
    assert surface.warnings == ()
    assert as_surface(scene, part="two", units="m").area_mm2 == pytest.approx(4e6 * ball.area)


def test_polydata_of_mixed_polygons_and_texture_coordinates():
    pyvista = pytest.importorskip("pyvista")
    grid = pyvista.Plane(i_size=4, j_size=4, i_resolution=3, j_resolution=3)
    surface = as_surface(grid, units="cm")
    assert len(surface.faces) == 18
    assert surface.area_mm2 == pytest.approx(1600)
    assert surface.corner_uv is not None
    assert as_surface(pyvista.Sphere()).border_loops == 0
    mixed = pyvista.PolyData(np.vstack([SQUARE, [[2, 0.5, 0]]]), [4, 0, 1, 2, 3, 3, 1, 4, 2])
    assert len(as_surface(mixed).faces) == 3


def test_what_is_no_mesh_is_named():
    pyvista = pytest.importorskip("pyvista")
    with pytest.raises(SurfaceError, match=r"^an int is no mesh"):
        as_surface(3)
    with pytest.raises(SurfaceError, match=r"^an array is no mesh"):
        as_surface(SQUARE)
    with pytest.raises(SurfaceError, match="extract_surface"):
        as_surface(pyvista.UnstructuredGrid())
    with pytest.raises(SurfaceError, match="no faces"):
        as_surface(pyvista.PolyData(np.eye(3)))
    with pytest.raises(SurfaceError, match="outside the 4 vertices"):
        as_surface((SQUARE, [[0, 1, 9]]))
    with pytest.raises(SurfaceError, match="vertices"):
        as_surface((np.zeros(3), [[0, 1, 2]]))


def test_the_door_loads_no_library():
    code = (
        "import sys, numpy as np; from surftex.files.doors import as_surface; import surftex.files.meshes; "
        "as_surface((np.eye(3), [[0, 1, 2]])); "
        "print([m for m in ('trimesh', 'pyvista', 'vtk', 'numba', 'igl') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
