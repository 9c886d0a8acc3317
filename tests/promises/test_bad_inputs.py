"""Promise: whatever file is handed in, ``inspect`` and ``bake`` answer with a line or with sound maps, soon."""

import json

import numpy as np
import pytest

import surftex as sx
from benchmarks.bad_inputs import rows
from surftex.cli import main
from surftex.files.images import read_exr
from tests.files.bad_inputs import Case, ball, cases, obj, write
from tests.files.test_bad_inputs import ACCEPT, REJECT

SCALE = ["--size", "300 mm"]
BAKE = [
    "--material",
    "crocodile",
    "--set",
    "cell_size=45 mm",
    "--resolution",
    "64",
    "--no-cache",
    "--unwrapper",
    "uvunwrap",
]
ODD = [case for case in cases() if case.faces is None]
ALIKE = ("huge.obj", "tiny.obj", "far.obj", "inside out.obj", "winding.obj", "mirror.glb", "whole.ply")
"""The ball in other sizes, places and formats: scales of the same size and depth."""
SOUND = [case for case in cases() if case.faces is not None]
TO_BAKE = [
    case
    for case in SOUND
    if case.faces not in (1, 2, 168) or case.name in (*ALIKE, "single.obj", "bow tie.obj", "bent quad.obj")
]
"""Other files that hold the same ball, or one triangle, are read only."""


def told(arguments, capsys):
    code = main([*map(str, arguments), *SCALE])
    out, said = capsys.readouterr()
    assert all(line.isprintable() for line in (out + said).splitlines())
    return code, out, said


def check_refused(path, says, folder, capsys):
    for command in (["inspect", path], ["bake", path, *BAKE, "--out", folder / "out"]):
        code, out, said = told(command, capsys)
        assert (code, out) == (2, "")
        assert said.startswith("surftex: ")
        assert said.count("\n") == 1
        assert says in said
        assert not (folder / "out").exists()


def check_baked(path, faces, says, folder, capsys):
    code, out, said = told(["bake", path, *BAKE, "--out", folder / "out", "--json"], capsys)
    assert code == 0, said
    assert says in said
    report = json.loads(out)
    assert report["mesh"]["faces"] == faces
    assert report["coverage"] > 0
    for name in report["outputs"]:
        if name.endswith(".exr"):
            height = read_exr(folder / "out" / name)["Y"]
            assert np.isfinite(height).all()
            assert np.abs(height).max() < 5  # crocodile's furrows and crests, in millimetres
            assert np.ptp(height) > 0.1
    check_written_mesh(folder / "out", faces)
    return height, report["features"]["cell"]


def check_written_mesh(folder, faces):
    """What was written is a finite mesh of the same faces, wound one way; a closed one faces outward."""
    (path,) = folder.glob("*.glb")
    surface = sx.load(path)
    assert len(surface.faces) == faces
    assert not any("turned" in line or "inside out" in line for line in surface.warnings), surface.warnings
    if surface.border_loops == 0:
        assert np.linalg.det(surface.vertices[surface.faces]).sum() > 0


@pytest.mark.parametrize("case", ODD, ids=lambda case: ascii(case.name))
def test_a_file_that_holds_no_surface_is_one_line(case, tmp_path, capsys):
    check_refused(write(case, tmp_path), case.says, tmp_path, capsys)


@pytest.mark.parametrize("case", SOUND, ids=lambda case: ascii(case.name))
def test_an_odd_surface_is_described(case, tmp_path, capsys):
    code, out, said = told(["inspect", write(case, tmp_path)], capsys)
    assert (code, said) == (0, "")
    assert case.says in out
    assert f"{case.faces:,} face" in out


@pytest.mark.parametrize("case", TO_BAKE, ids=lambda case: ascii(case.name))
def test_an_odd_surface_is_baked_to_sound_maps(case, tmp_path, capsys):
    height, cells = check_baked(write(case, tmp_path), case.faces, case.says, tmp_path, capsys)
    if case.name in ALIKE:
        assert cells == pytest.approx(126, abs=8)  # measured 123 to 130
        assert height.std() == pytest.approx(0.207, abs=0.03)


def test_a_link_to_itself_and_a_name_with_an_escape(tmp_path, capsys):
    loop = tmp_path / "loop.obj"
    loop.symlink_to(loop)
    check_refused(loop, "cannot be opened", tmp_path, capsys)
    check_baked(write(Case("e\x1b[31m.obj", obj(*ball())), tmp_path), 168, "", tmp_path, capsys)


@pytest.mark.slow
def test_the_files_that_lie_about_their_size_take_little_time_and_memory(shared):
    """A process each, as users start them; ``python -m benchmarks.bad_inputs`` does so with the whole collection."""
    if not (shared / "bad-inputs").is_dir():
        pytest.skip(f"no collection of bad inputs in {shared}")
    for _ in rows(shared / "bad-inputs", numbers=(52,)):
        pass  # kernels that no test before has compiled are compiled now, not while it is measured
    for row in rows(shared / "bad-inputs", numbers=(19, 22, 35, 52)):
        assert row.code == (2 if row.number in REJECT else 0), row
        assert (REJECT.get(row.number) or ACCEPT[row.number][3]) in row.said
        assert row.processor_s < 5, row
        assert row.peak_mb < 500, row
