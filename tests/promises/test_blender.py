"""Blender reads what we write: sockets, colour spaces, tangents, height; and Cycles sees no seam."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from surftex.bake.bake import bake
from surftex.files.images import read_png
from surftex.materials.leather.model import Leather
from surftex.surface.shapes import sphere

SIZE_MM = 24.0


def blender_python():
    """A Python that has bpy: this one, or that which SURFTEX_BPY names."""
    named = os.environ.get("SURFTEX_BPY")
    if named or importlib.util.find_spec("bpy"):
        return named or sys.executable
    pytest.skip("no Blender here: pip install bpy into a Python, and name that in SURFTEX_BPY")
    return None


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """What Blender says of one leather under two unwraps, and its pictures."""
    python, folder = blender_python(), tmp_path_factory.mktemp("blender")
    ball = sphere(SIZE_MM / 2, subdivisions=4)
    leather = Leather.preset("calf", cell_size=2.5, crista_height=0.15, sulcus_depth=0.1, sulcus_width=0.5)
    results = {}
    for name in ("xatlas", "uvunwrap"):
        maps = bake(ball, leather, resolution=1024, unwrapper=name, seed=3)
        maps.save(folder / name)
        files = [
            folder / name / f"{maps.stem}.glb",
            folder / name / f"{maps.stem}_height.exr",
            folder / f"{name}.png",
        ]
        done = subprocess.run(
            [python, Path(__file__).with_name("blender.py"), *files],
            capture_output=True, text=True, check=False, env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr[-2000:]
        line = next(line for line in done.stdout.splitlines() if line.startswith("JSON "))
        results[name] = (maps, json.loads(line[5:]), read_png(files[2])[..., :3] / 65535)
    return results


@pytest.mark.slow
def test_blender_wires_every_map_in_its_colour_space(told):
    maps, seen, _ = told["xatlas"]
    assert seen["size_m"] == pytest.approx(SIZE_MM / 1000, rel=0.01)
    spaces = {socket: image[0] for socket, image in seen["images"].items()}
    assert spaces["Base Color"] == "sRGB"
    assert spaces["Roughness"] == spaces["Normal"] == "Non-Color"
    assert seen["images"]["Normal"][3] >= 48  # 16 bits in each of three channels
    assert seen["normal"][0] == "TANGENT"
    assert seen["normal"][1] in ("", seen["uv"][0])
    assert seen["normal"][2] == 1.0
    is_float, low, high = seen["height"]
    assert is_float
    assert low == pytest.approx(float(maps["height"].min()), abs=1e-6)
    assert high == pytest.approx(float(maps["height"].max()), abs=1e-6)


@pytest.mark.slow
def test_blender_computes_the_tangents_that_the_normals_are_told_in(told):
    maps, seen, _ = told["xatlas"]
    theirs = np.array(seen["tangents"])
    surface = maps.surface
    corner = surface.vertices[surface.faces].reshape(-1, 3) + surface.origin_mm
    ours = maps.tangents.reshape(-1, 4)
    place = theirs[:, :3] * 1000  # metres, z up, back to millimetres, y up
    place, tangent = (
        np.stack([each[:, 0], each[:, 2], -each[:, 1]], axis=1) for each in (place, theirs[:, 3:6])
    )
    from scipy.spatial import cKDTree

    tree, worst = cKDTree(corner), []
    for at, direction, sign in zip(place[::7], tangent[::7], theirs[::7, 6], strict=True):
        near = tree.query_ball_point(at, 1e-3)
        agree = [float(ours[i, :3] @ direction) for i in near if ours[i, 3] == sign]
        worst.append(max(agree, default=-1.0))
    assert np.mean(np.array(worst) > 0.999) > 0.995


@pytest.mark.slow
def test_cycles_shows_no_step_where_the_unwrap_is_cut(told):
    one, two = told["xatlas"][2], told["uvunwrap"][2]
    assert 0.05 < one.mean() < 0.9
    relief = np.abs(np.diff(one.mean(axis=2), axis=0)).max()
    apart = np.abs(one - two).max(axis=2)
    assert np.percentile(apart, 99.5) < 0.06
    assert apart.max() < 0.5 * relief + 0.1
    plain = np.abs(one - np.roll(one, 2, axis=0)).max(axis=2)  # what another grain would look like
    assert np.percentile(plain, 99.5) > 3 * np.percentile(apart, 99.5)
