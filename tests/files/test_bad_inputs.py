"""Promise: a hostile file is a sound surface, or one line that names it, soon and in little memory."""

import os
import resource
import time

import numpy as np
import pytest

from surftex.errors import InputError, MeshFileError
from surftex.files.meshes import load
from tests.files.bad_inputs import ball, cases, obj, write

REJECT = {
    1: "is empty",
    2: "is empty",
    3: "no STL file",
    4: "declares 3616 bytes",
    5: "glTF",
    6: "JSON does not parse",
    7: "vertex 2, line 2",
    8: "vertex 7 of 3",
    10: "before the first vertex",
    11: "index 0",
    12: "no faces",
    13: "line 1",
    16: "UTF-16",
    17: "60000 corners",
    19: "4294967295",
    22: "1000000000",
    23: "2000000000",
    24: "-3",
    25: "only 3 lines",
    26: "OFF",
    27: "no OBJ records",
    28: "known are",
    32: "network",
    33: "folder",
    35: "1000000000",
    36: "5000 of 86",
    37: "cycle",
    38: "scale of 0",
    40: "KHR_draco_mesh_compression",
    41: "LINES",
    44: "no area",
    56: "overflows",
    74: "is a folder",
}
"""Part of the error of each file of the shared collection that is refused."""

ACCEPT = {
    9: (2, 1, 1, ""),
    14: (1, 1, 1, "fewer than 3"),
    15: (1, 1, 1, ""),
    18: (168, 1, 0, ""),
    20: (168, 1, 0, ""),
    21: (168, 1, 0, "37 bytes"),
    29: (168, 1, 0, ""),
    30: (168, 1, 0, "mtllib"),
    31: (168, 1, 0, ""),
    34: (168, 1, 0, ""),
    39: (168, 1, 0, ""),
    42: (1, 1, 1, ""),
    43: (72, 1, 1, "3 degenerate"),
    45: (168, 1, 0, "25 duplicate"),
    46: (3, None, None, "1 edge with more than two faces"),
    47: (2, 2, 2, "1 vertex where sheets touch"),
    48: (168, 1, 0, "were turned"),
    49: (168, 1, 0, "inside out"),
    50: (168, 1, 0, "2 vertices"),
    51: (168, 1, 0, "86 vertices"),
    52: (7200, 200, 0, ""),
    53: (168, 1, 0, ""),
    54: (168, 1, 0, ""),
    55: (168, 1, 0, ""),
    57: (6, 1, 1, ""),
    58: (3, 1, 1, ""),
    59: (2, 1, 1, ""),
    60: (72, 1, 1, "leave 0..1"),
    61: (72, 1, 1, ""),
    62: (72, 1, 1, ""),
    63: (72, 1, 1, "no area"),
    64: (72, 1, 1, "no usable UVs"),
    65: (2, 1, 1, "no usable UVs"),
    66: (160, 1, 1, "one side only"),
    67: (100, 1, 0, ""),
    68: (336, 2, 0, ""),
    69: (4, 1, 1, ""),
    70: (4, 2, 2, "2 vertices where sheets touch"),
    71: (2, 1, 1, ""),
    72: (72, 1, 1, "72 duplicate"),
    73: (500, 1, 1, ""),
}
"""Faces, components, border loops and a part of a warning for each file that is taken."""


def check_sound(surface):
    """What every surface promises, whatever it was made from."""
    for array in (surface.vertices, surface.corner_uv, surface.corner_normal, surface.origin_mm):
        assert array is None or np.isfinite(array).all()
    assert (surface.face_area_mm2 > 0).all()
    assert len(np.unique(surface.faces)) == len(surface.vertices)
    _, corner, angle = surface.fans
    assert len(corner) == 3 * len(surface.faces)
    assert np.isfinite(angle).all()
    assert all(line.isprintable() for line in surface.warnings)
    longest = (surface.vertices.max(0) - surface.vertices.min(0)).max()
    assert longest == pytest.approx(300, rel=1e-6)
    assert np.allclose(surface.vertices.max(0) + surface.vertices.min(0), 0, atol=1e-3)


def check_refused(path, says):
    with pytest.raises(InputError) as caught:
        load(path, size="300 mm")
    message = str(caught.value)
    assert says in message
    assert message.isprintable(), "the message must be one line without control characters"
    return message


@pytest.mark.parametrize("case", cases(), ids=lambda case: ascii(case.name))
def test_own_case(case, tmp_path):
    path = write(case, tmp_path)
    began = time.process_time()
    if case.faces is None:
        message = check_refused(path, case.says)
        assert "Error" not in message
    else:
        surface = load(path, size="300 mm")
        check_sound(surface)
        assert len(surface.faces) == case.faces
        assert case.components is None or surface.component.max() + 1 == case.components
        assert case.loops is None or surface.border_loops == case.loops
        assert not case.says or any(case.says in line for line in surface.warnings), surface.warnings
        assert case.says or not surface.warnings, surface.warnings
        assert case.check is None or case.check(surface)
    assert time.process_time() - began < 5


@pytest.mark.parametrize("number", range(1, 75))
def test_shared_case(shared, number):
    if not (shared / "bad-inputs").is_dir():
        pytest.skip(f"no collection of bad inputs in {shared}")
    path = next((shared / "bad-inputs").glob(f"{number:02d}[_ ]*"))
    if number == 29:
        path = next(path.iterdir())
    began, memory = time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    if number in REJECT:
        check_refused(path, REJECT[number])
    else:
        faces, components, loops, says = ACCEPT[number]
        surface = load(path, size="300 mm")
        check_sound(surface)
        assert len(surface.faces) == faces
        assert components is None or surface.component.max() + 1 == components
        assert loops is None or surface.border_loops == loops
        assert not says or any(says in line for line in surface.warnings), surface.warnings
        assert says or not surface.warnings or number in (15,), surface.warnings
    assert time.process_time() - began < 5
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory < 500 * 1024


def test_every_shared_case_is_accounted_for():
    assert sorted([*REJECT, *ACCEPT]) == list(range(1, 75))


def test_links_that_lead_nowhere(tmp_path):
    loop = tmp_path / "loop.obj"
    loop.symlink_to(loop)
    check_refused(loop, "cannot be opened")
    dangling = tmp_path / "dangling.obj"
    dangling.symlink_to(tmp_path / "absent.obj")
    check_refused(dangling, "no such mesh file")


def test_things_that_are_no_files(tmp_path):
    folder = tmp_path / "folder.obj"
    folder.mkdir()
    check_refused(folder, "is a folder")
    check_refused(tmp_path / "absent.obj", "no such mesh file")
    check_refused("", "is empty")
    check_refused("a\0b.obj", "a\\x00b.obj")
    check_refused(tmp_path / "no such folder" / "x.obj", "no such")


def test_pipes_and_devices_do_not_hang(tmp_path):
    pipe = tmp_path / "pipe.obj"
    os.mkfifo(pipe)
    check_refused(pipe, "pipe or device")
    device = tmp_path / "zero.stl"
    device.symlink_to("/dev/zero")
    check_refused(device, "pipe or device")


def test_a_file_that_may_not_be_read(tmp_path):
    path = tmp_path / "secret.obj"
    path.write_bytes(obj(*ball()))
    path.chmod(0)
    if os.access(path, os.R_OK):
        pytest.skip("this user may read everything")
    check_refused(path, "may not be read")


def test_a_buffer_reached_by_a_link_out_of_the_folder(tmp_path):
    from tests.files.bad_inputs import gltf

    (tmp_path / "inside").mkdir()
    (tmp_path / "secret.bin").write_bytes(b"x" * 10000)
    (tmp_path / "inside" / "mesh.bin").symlink_to(tmp_path / "secret.bin")
    path = tmp_path / "inside" / "mesh.gltf"
    path.write_bytes(gltf(*ball(), "mesh.bin"))
    check_refused(path, "leaves the file's folder")


def test_no_other_file_is_opened(tmp_path, monkeypatch):
    path = tmp_path / "a.obj"
    path.write_bytes(obj(*ball(), before="mtllib a.mtl\nusemtl m\n"))
    (tmp_path / "a.mtl").write_text("newmtl m\nmap_Kd ../../etc/passwd\n")
    opened = []
    real = os.open
    monkeypatch.setattr(
        os, "open", lambda name, *rest, **more: opened.append(str(name)) or real(name, *rest, **more)
    )
    load(path, size=300)
    assert opened == [str(path)]


def test_errors_are_mesh_file_errors_with_exit_code_2(tmp_path):
    path = tmp_path / "x.obj"
    path.write_bytes(b"v 0 0 0\n")
    with pytest.raises(MeshFileError) as caught:
        load(path)
    assert caught.value.exit_code == 2
