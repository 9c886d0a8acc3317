"""The scripts under examples/ do what they say."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


def environment():
    """With the command of this Python first on the path."""
    bin_folder = str(Path(sys.executable).parent)
    return {
        **os.environ,
        "PATH": bin_folder + os.pathsep + os.environ["PATH"],
        "BAKE_OPTIONS": "--units mm --resolution 64 -q",
    }


@pytest.fixture
def studio(tmp_path, meshes):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "torus.obj").write_bytes((meshes / "torus.obj").read_bytes())
    (tmp_path / "in" / "bad.obj").write_text("v 0 0 0\n")
    return tmp_path


def test_the_shell_loop_bakes_what_is_missing_and_goes_on(studio):
    command = ["sh", str(EXAMPLES / "bake_all.sh"), str(studio / "in"), "ostrich", str(studio / "out")]
    first = subprocess.run(command, capture_output=True, text=True, env=environment())
    assert first.returncode == 1
    assert "bad.obj" in first.stderr
    assert (studio / "out" / "torus.obj-ostrich" / "torus.glb").is_file()
    second = subprocess.run(command, capture_output=True, text=True, env=environment())
    assert "torus.obj-ostrich: up to date" in second.stdout


def test_the_driver_tells_every_job(studio):
    (studio / "jobs.toml").write_text(
        'surftex = 1\nmeshes = ["in/*.obj"]\nmaterials = ["ostrich"]\nresolution = 64\nunits = "mm"\n'
    )
    command = [sys.executable, str(EXAMPLES / "drive_a_batch.py"), str(studio / "jobs.toml")]
    done = subprocess.run(command, capture_output=True, text=True, env=environment())
    assert done.returncode == 2
    assert "torus-ostrich" in done.stdout
    assert "seams 0." in done.stdout
    assert "failed" in done.stdout
    assert (studio / "out" / "batch-report.json").is_file()


def test_a_batch_that_is_not_there_is_told_in_a_line():
    command = [sys.executable, str(EXAMPLES / "drive_a_batch.py"), "none.toml"]
    done = subprocess.run(command, capture_output=True, text=True, env=environment())
    assert done.returncode == 2
    assert done.stderr == "the batch 'none.toml' does not exist\n"


@pytest.mark.slow
def test_the_round_trip_through_blender_gives_a_picture(studio):
    python = os.environ.get("BLENDER_PYTHON", sys.executable)
    if subprocess.run([python, "-c", "import bpy"], capture_output=True).returncode:
        pytest.skip("no bpy in this Python; BLENDER_PYTHON names one that has it")
    picture = studio / "torus.png"
    command = [
        sys.executable,
        str(EXAMPLES / "blender_round_trip.py"),
        str(studio / "in" / "torus.obj"),
        "calf",
        str(picture),
    ]
    subprocess.run(command, check=True, env={**environment(), "BLENDER_PYTHON": python})
    assert picture.stat().st_size > 20_000
