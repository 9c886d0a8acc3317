"""Tangents are MikkTSpace: its definition on small meshes, Blender's own on real ones."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from surftex.maps.tangents import corner_tangents
from surftex.surface.shapes import plane, sphere, torus
from tests.oracles.maps import mikktspace


def spherical_uv(surface):
    """Longitude and latitude about a tilted axis, that no vertex lies on; cut where the longitude wraps."""
    tilted = np.linalg.qr(np.array([[3.0, 1, 2], [1, 4, 1], [2, 1, 5]]))[0]
    corner = surface.vertices[surface.faces] @ tilted
    u = np.arctan2(corner[..., 1], corner[..., 0]) / (2 * np.pi) + 0.5
    u += (u.max(axis=1, keepdims=True) - u > 0.5) * 1.0
    return np.stack([u, np.arccos(corner[..., 2] / np.linalg.norm(corner, axis=2)) / np.pi], axis=2)


def float32(array):
    return np.asarray(array, np.float32).astype(np.float64)


def test_plane_tangents_follow_the_rotated_unwrap():
    flat = plane(10.0, cells=4)
    turn = 0.7
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    uv = flat.corner_uv @ rotation.T * [0.5, 0.2]
    tangent = corner_tangents(flat.vertices[flat.faces], flat.shading_normal, flat.corner_uv @ rotation.T)
    np.testing.assert_allclose(tangent[..., :2] - [np.cos(turn), -np.sin(turn)], 0, atol=1e-12)
    assert (tangent[..., 3] == 1).all()
    assert not np.allclose(corner_tangents(flat.vertices[flat.faces], flat.shading_normal, uv)[..., :2], 0)


def test_mirrored_unwrap_turns_the_bitangent_and_splits_the_groups():
    flat = plane(2.0, cells=2)
    uv = flat.corner_uv.copy()
    uv[..., 0] = np.abs(uv[..., 0] - 0.5)
    tangent = corner_tangents(flat.vertices[flat.faces], flat.shading_normal, uv)
    left = flat.vertices[flat.faces][..., 0].mean(axis=1) < 1
    assert left.any()
    assert not left.all()
    np.testing.assert_allclose(
        tangent[left], np.broadcast_to([-1, 0, 0, -1], tangent[left].shape), atol=1e-12
    )
    np.testing.assert_allclose(
        tangent[~left], np.broadcast_to([1, 0, 0, 1], tangent[~left].shape), atol=1e-12
    )


def test_faces_without_uv_area_take_the_tangent_of_equal_corners():
    flat = plane(2.0, cells=2)
    uv = flat.corner_uv.copy()
    flattened = np.array([0.25, 0.25])
    uv[0] = flattened
    shared = (uv == flattened).all(axis=2)
    uv[shared] = flattened
    tangent = corner_tangents(flat.vertices[flat.faces], flat.shading_normal, uv)
    assert np.isfinite(tangent).all()
    np.testing.assert_allclose(np.linalg.norm(tangent[..., :3], axis=2), 1, atol=1e-12)
    collapsed = flat.corner_uv.copy()
    collapsed[0, 2] = (collapsed[0, 0] + collapsed[0, 1]) / 2
    tangent = corner_tangents(flat.vertices[flat.faces], flat.shading_normal, collapsed)
    np.testing.assert_allclose(tangent[0, :2], [[1, 0, 0, 1]] * 2, atol=1e-12)


@pytest.mark.parametrize("turns", [0, 1, 2])
@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_faces_that_meet_at_a_corner_alone_share_its_tangent(turns, order):
    position = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [-1, 0, 0], [0, -1, 0]]])
    normal = np.broadcast_to([0.6, 0.0, 0.8], position.shape)
    uv = np.array([[[0, 0], [1, 0], [0, 1]], [[0, 0], [0, 0], [0, 0]]])
    turned = (np.roll(part[order], turns, axis=2) for part in (position, normal))
    tangent = np.roll(corner_tangents(*turned, uv[order])[order, :, :3], -turns, axis=2)
    np.testing.assert_allclose(tangent[0], [[0.8, 0, -0.6]] * 3, atol=1e-12)
    np.testing.assert_allclose(tangent[1], [[0.8, 0, -0.6], [0, 1, 0], [0, 1, 0]], atol=1e-12)


@given(st.integers(0, 10_000))
def test_equals_the_definition_on_random_unwraps(seed):
    random = np.random.RandomState(seed)
    ball = sphere(5.0, subdivisions=0)
    uv = float32(random.randint(0, 4, (len(ball.vertices), 2)) + random.rand(len(ball.vertices), 2))[
        ball.faces
    ]
    if seed % 2:
        torn = random.rand(len(uv), 3) < 0.3
        uv[torn] += 0.125
    position, normal = float32(ball.vertices[ball.faces] * [1, 2, 0.6]), float32(ball.shading_normal)
    np.testing.assert_allclose(
        corner_tangents(position, normal, uv), mikktspace(position, normal, uv), atol=1e-5
    )


def blender_python():
    """A Python that can import bpy: this one, or the one that SURFTEX_BLENDER_PYTHON names."""
    candidate = os.environ.get("SURFTEX_BLENDER_PYTHON", sys.executable)
    found = subprocess.run(
        [candidate, "-c", "import importlib.util as u, sys; sys.exit(u.find_spec('bpy') is None)"],
        check=False,
    )
    if found.returncode:
        pytest.skip(
            "no bpy here: pip install bpy==4.5.* somewhere and name that Python in SURFTEX_BLENDER_PYTHON"
        )
    return candidate


def shoe_corners(folder):
    import trimesh

    mesh = trimesh.load(folder / "meshes" / "shoe_variants.glb", force="mesh", process=False)
    return mesh.vertices[mesh.faces], mesh.vertex_normals[mesh.faces], np.asarray(mesh.visual.uv)[mesh.faces]


@pytest.mark.slow
@pytest.mark.parametrize("subject", ["sphere", "torus", "mirrored plane", "shoe"])
def test_agrees_with_blender(subject, request, tmp_path):
    python = blender_python()
    if subject == "shoe":
        position, normal, uv = shoe_corners(request.getfixturevalue("shared"))
    else:
        surface = {"sphere": sphere(subdivisions=4), "torus": torus(), "mirrored plane": plane(cells=8)}[
            subject
        ]
        position, normal = surface.vertices[surface.faces], surface.shading_normal
        uv = spherical_uv(surface) if subject != "mirrored plane" else np.abs(surface.corner_uv - [0.5, 0])
    position, uv = float32(position), float32(uv)
    np.savez(tmp_path / "in.npz", position=position, normal=normal, uv=uv)
    script = Path(__file__).with_name("blender.py")
    subprocess.run(
        [python, script, tmp_path / "in.npz", tmp_path / "out.npz"], check=True, capture_output=True
    )
    theirs = np.load(tmp_path / "out.npz")
    own = corner_tangents(position, theirs["normal"], uv)
    side, far = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    known = side[:, 0] * far[:, 1] != side[:, 1] * far[:, 0]
    cosine = (own[..., :3] * theirs["tangent"]).sum(axis=2)[known]
    angle_deg = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    assert (own[..., 3] == theirs["sign"])[known].all()
    assert np.percentile(angle_deg, 99) < 0.05
    assert angle_deg.max() < 0.2
