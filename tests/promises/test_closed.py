"""What a bake touches: no network, no program but its own children, and no file but those that it was told to write."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from surftex.files.images import png_bytes
from tests.files.bad_inputs import obj, sheet
from tests.fuzz.targets import RECIPE, pictures

WATCHED = """
import os, sys
seen = []
def watch(event, arguments):
    if event.startswith(("socket.", "os.system", "os.exec", "os.spawn", "ftplib", "urllib", "http.", "smtplib", "webbrowser")):
        seen.append((event, str(arguments)[:200]))
    if event == "subprocess.Popen":
        seen.append((event, str(arguments[1])[:200]))
    if event == "open" and isinstance(arguments[0], (str, bytes)):
        flags = arguments[2] or 0
        if flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            seen.append((event, os.path.abspath(os.fsdecode(arguments[0]))))
    if event in ("os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.symlink", "os.link"):
        inside = event in ("os.remove", "os.rmdir") and arguments[1] >= 0  # told by an open folder
        start = os.readlink(f"/proc/self/fd/{arguments[1]}") if inside else os.getcwd()
        seen.append((event, os.path.abspath(os.path.join(start, os.fsdecode(arguments[0])))))
sys.addaudithook(watch)
from surftex.cli import main
code = main(sys.argv[1:])
for event, what in seen:
    print(event, what)
sys.exit(code)
"""


def test_a_bake_touches_its_output_its_caches_and_nothing_else(tmp_path, monkeypatch):
    place = tmp_path / "place"
    place.mkdir()
    flat, quads = sheet()
    (place / "ball.obj").write_bytes(obj(flat, quads, uv=flat[:, :2]))
    (place / "toe.png").write_bytes(pictures()["a.png"])
    (place / "grain.json").write_text('{"strokes": [[[0, 0, 0], [1, 1, 0]]]}')
    (place / "r.toml").write_text(RECIPE.replace('units = "m"\n', ""))
    for name in ("TMPDIR", "SURFTEX_CACHE_DIR", "MPLCONFIGDIR"):
        (tmp_path / name).mkdir()
        monkeypatch.setenv(name, str(tmp_path / name))
    process = subprocess.run(
        [sys.executable, "-B", "-c", WATCHED, "bake", "r.toml", "--out", "out", "-q"],
        cwd=place, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert process.returncode == 0, process.stderr
    assert (place / "out" / "report.json").exists()
    kernels = Path(os.environ.get("NUMBA_CACHE_DIR", Path.home())).resolve()
    own = (place / "out", tmp_path / "TMPDIR", tmp_path / "SURFTEX_CACHE_DIR", kernels, Path("/dev"))
    assert "os.rename" in process.stdout  # the watch is awake
    for line in process.stdout.splitlines():
        event, _, what = line.partition(" ")
        if event == "subprocess.Popen":
            assert "xatlas" in what or "surftex.kernels.ahead" in what, line
            continue
        assert event in ("open", "os.rename", "os.remove", "os.mkdir", "os.rmdir"), line
        path = Path(what)
        first = path.relative_to(place).parts[0] if path.is_relative_to(place) else ""
        hidden = first.startswith((".out-", ".surftex-"))  # the work, and the trial whether there can be any
        assert hidden or any(path.is_relative_to(each) for each in own), line


def test_a_picture_outside_the_folder_is_not_read(tmp_path):
    inside = tmp_path / "inside"
    inside.mkdir()
    (tmp_path / "toe.png").write_bytes(png_bytes(np.zeros((4, 4, 3), np.uint8)))
    (inside / "toe.png").symlink_to(tmp_path / "toe.png")
    (inside / "ball.obj").write_bytes(obj(*sheet()))
    (inside / "r.toml").write_text(RECIPE.replace('strokes = "grain.json"', 'strokes = "../grain.json"'))
    process = subprocess.run(
        [sys.executable, "-m", "surftex", "bake", "r.toml"],
        cwd=inside,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert process.returncode == 2
    assert "leaves the recipe's folder" in process.stderr
    assert process.stderr.count("\n") == 1
