"""Damaged files: whatever bytes change, a file is a surface or one line of error, never another exception."""

import warnings

import numpy as np
import pytest

from surftex.errors import InputError
from surftex.files.meshes import load
from surftex.randomness import stream
from tests.files.bad_inputs import ball, glb, gltf, obj, off, ply, sheet, stl, stl_text

V, F = ball(6, 4)
SEEDS = {
    "a.obj": obj(V, F, uv=V[:, :2], before="usemtl m\ng n\n"), "b.obj": obj(*sheet(2), after="f 1 2 3 4 5\n"), "a.stl": stl(V, F),
    "b.stl": stl_text(V, F), "a.ply": ply(V, F), "b.ply": b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
    b"property float y\nproperty float z\nelement face 2\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
    b"3 0 1 2\n4 0 1 2 0\n", "a.off": off(V, F), "a.glb": glb(V, F), "a.gltf": gltf(V, F),
}  # fmt: skip
WORDS = [
    b"nan",
    b"-1",
    b"0",
    b"99999999999",
    b"1e400",
    b"//",
    b"\n",
    b" ",
    b"null",
    b"{}",
    b"[]",
    b"true",
    b"\xff",
    b'""',
    b"1.5",
]


def damaged(data, name, number):
    """The file after a few random edits."""
    bytes_ = bytearray(data)
    draws = stream(7, "fuzz", name, number).uniform(6, 4)
    for kind, place, size, value in draws[: 1 + number % 5]:
        at = int(place * len(bytes_))
        if kind < 0.4:
            bytes_[at : at + 1] = bytes([int(value * 256)])
        elif kind < 0.6:
            bytes_[at : at + 1 + int(size * 4)] = WORDS[int(value * len(WORDS))]
        elif kind < 0.75:
            del bytes_[at : at + 1 + int(size * 30)]
        elif kind < 0.9:
            bytes_[at:at] = bytes_[int(value * len(bytes_)) :][: 1 + int(size * 30)]
        else:
            del bytes_[at:]
        bytes_ = bytes_ or bytearray(b"x")
    return bytes(bytes_)


@pytest.mark.parametrize("name", SEEDS)
def test_damage_is_a_surface_or_a_line(name, tmp_path):
    path = tmp_path / name
    fates = {"surface": 0, "refused": 0}
    for number in range(60):
        path.write_bytes(damaged(SEEDS[name], name, number))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                surface = load(path, size="300 mm")
        except InputError as problem:
            assert str(problem).isprintable(), (number, str(problem))
            fates["refused"] += 1
        else:
            assert np.isfinite(surface.vertices).all(), number
            assert len(surface.fans[1]) == 3 * len(surface.faces), number
            fates["surface"] += 1
    assert fates["refused"] > 5
