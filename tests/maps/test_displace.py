"""A displaced mesh is fine, whole, and where the relief says."""

import numpy as np
import pytest
import trimesh

from surftex.errors import InputError
from surftex.files.meshout import write_mesh
from surftex.maps.displace import displaced
from surftex.surface.shapes import cylinder, plane, sphere, torus
from surftex.surface.surface import Surface


def flat_at(height):
    return lambda samples: np.full(len(samples), height)


def edge_lengths(vertices, faces):
    corner = vertices[faces]
    return np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)


def slivered():
    """A ball pulled long, so that its faces have edges of very different length."""
    ball = sphere(10.0, subdivisions=1)
    return Surface.from_arrays(ball.vertices * [6, 1, 1], ball.faces)


@pytest.mark.parametrize("make", [sphere, torus, slivered, lambda: sphere(subdivisions=0)])
def test_closed_surfaces_stay_closed(make):
    surface = make()
    edge_mm = 0.4 * surface.mean_edge_mm
    waves = lambda samples: np.sin(samples.points.positions(surface)[:, 0])  # noqa: E731
    mesh = displaced(surface, waves, edge_mm=edge_mm)
    assert edge_lengths(displaced(surface, flat_at(0), edge_mm=edge_mm).vertices, mesh.faces).max() <= edge_mm
    again = Surface.from_arrays(mesh.vertices, mesh.faces)
    assert again.border_loops == 0
    assert (again.neighbor >= 0).all()
    assert trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).is_watertight


def test_borders_keep_their_loops():
    mesh = displaced(cylinder(columns=12, rows=4), flat_at(0.5), edge_mm=2.0)
    assert Surface.from_arrays(mesh.vertices, mesh.faces).border_loops == 2


def test_lifted_ball_is_a_larger_ball():
    ball = sphere(20.0, subdivisions=4)
    mesh = displaced(ball, flat_at(2.0), edge_mm=0.8)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    assert radius.max() < 22.01
    assert radius.min() > 21.9
    volume = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).volume
    assert volume == pytest.approx(4 / 3 * np.pi * 22**3, rel=0.01)


def test_heights_are_asked_at_the_vertices():
    """Each vertex rests on its own place, once, whatever faces meet there."""
    flat = plane(10.0, cells=3)
    seen = []

    def height_at(samples):
        seen.append(samples)
        return samples.points.positions(flat)[:, 0] * 0.3

    mesh = displaced(flat, height_at, edge_mm=0.7, corner_uv=flat.corner_uv)
    np.testing.assert_allclose(mesh.vertices[:, 2], 0.3 * mesh.vertices[:, 0], atol=1e-6)
    assert len(seen) == 1
    assert (seen[0].footprint_mm == np.float32(0.7)).all()
    np.testing.assert_allclose(mesh.uv * 10, mesh.vertices[mesh.faces][..., :2], atol=1e-9)
    assert len(np.unique(np.round(mesh.vertices, 6), axis=0)) == len(mesh.vertices)
    np.testing.assert_allclose(
        trimesh.Trimesh(mesh.vertices * [1, 1, 0], mesh.faces, process=False).area, 100, rtol=1e-9
    )


def test_refuses_what_would_never_end():
    with pytest.raises(InputError, match=r"take about .* faces; the limit is 1000"):
        displaced(sphere(), flat_at(0), edge_mm=0.01, max_faces=1000)
    for edge_mm in (0.0, -1.0, np.nan):
        with pytest.raises(InputError, match="edge_mm"):
            displaced(sphere(), flat_at(0), edge_mm=edge_mm)
    with pytest.raises(InputError, match="the height"):
        displaced(plane(), flat_at(np.nan), edge_mm=1.0)


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl", ".glb"])
@pytest.mark.parametrize("with_uv", [False, True])
def test_files_come_back(suffix, with_uv, tmp_path):
    ball = sphere(20.0, subdivisions=1)
    uv = np.tile([[0.1, 0.1], [0.4, 0.1], [0.1, 0.4]], (len(ball.faces), 1, 1)) if with_uv else None
    mesh = displaced(ball, flat_at(1.0), edge_mm=5.0, corner_uv=uv)
    write_mesh(tmp_path / f"a{suffix}", mesh.vertices, mesh.faces, mesh.uv)
    write_mesh(tmp_path / f"b{suffix}", mesh.vertices, mesh.faces, mesh.uv)
    first, second = ((tmp_path / f"{stem}{suffix}").read_bytes() for stem in "ab")
    assert first.replace(b'"a"', b'"b"') == second
    read = trimesh.load(tmp_path / f"a{suffix}", force="mesh", process=False)
    scale = 1000 if suffix == ".glb" else 1
    assert len(read.faces) == len(mesh.faces)
    np.testing.assert_allclose(read.vertices[read.faces] * scale, mesh.vertices[mesh.faces], atol=1e-4)
    if with_uv and suffix in (".obj", ".glb"):
        np.testing.assert_allclose(np.asarray(read.visual.uv)[read.faces], mesh.uv, atol=1e-6)
    else:
        read.merge_vertices(merge_norm=True, merge_tex=True)
        assert read.is_watertight


def test_unknown_formats_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"a\.fbx"):
        write_mesh(tmp_path / "a.fbx", np.zeros((3, 3)), np.zeros((1, 3), np.int32))
