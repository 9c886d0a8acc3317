"""Faults from outside: signals, full disks, folders without leave, damaged caches, two runs at once.

Whatever happens, the output is whole or not there, what was there stays, and the command says so in a line.
"""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from surftex import interrupts
from surftex.files.output import file_hashes
from surftex.kernels import jit
from surftex.randomness import stream
from tests.files.bad_inputs import ball, obj

COMMAND = [sys.executable, "-m", "surftex", "bake", "ball.obj", "--size", "300 mm", "--material", "crocodile", "--set",
           "cell_size=40 mm", "--resolution", "128", "--no-cache"]  # fmt: skip
MOMENTS = int(os.environ.get("SURFTEX_MOMENTS", "4"))
"""Signals of each kind."""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "ball.obj").write_bytes(obj(*ball()))
    return tmp_path


def bake(folder, *more, before=None, **environment):
    process = subprocess.run(
        [*COMMAND, *more], cwd=folder, capture_output=True, text=True, timeout=300, preexec_fn=before,
        env={**os.environ, **environment},
    )  # fmt: skip
    assert "Traceback" not in process.stderr
    return process


def started(folder, *more):
    return subprocess.Popen(
        [*COMMAND, *more], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def is_whole(out):
    """Whether every file is there with the bytes that its report tells."""
    report = json.loads((out / "report.json").read_text())
    return file_hashes(out) == {**report["outputs"], "report.json": file_hashes(out)["report.json"]}


def refused(process, code, says):
    assert process.returncode == code, process.stderr
    assert process.stdout == ""
    assert process.stderr.count("\n") == 1
    assert says in process.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    "number", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM], ids=lambda each: each.name
)
def test_a_signal_at_any_moment_leaves_all_or_nothing(folder, number):
    began = time.monotonic()
    assert bake(folder, "--out", "out").returncode == 0
    usual_s = time.monotonic() - began
    whole = bytes_of(folder / "out")
    assert is_whole(folder / "out")
    for k, share in enumerate(stream(number, "moments").uniform(MOMENTS, 1)[:, 0]):
        name = f"out{k}" if k % 2 else "out"  # in every other round an earlier bake is replaced
        process = started(folder, "--out", name, *(() if k % 2 else ("--overwrite",)))
        time.sleep((0.4 + 0.7 * share) * usual_s)
        process.send_signal(number)
        _, said = process.communicate(timeout=60)
        assert "Traceback" not in said
        out = folder / name
        assert is_whole(out) if out.exists() else k % 2
        if number != signal.SIGKILL:  # the last is for a process that is not up yet, or is done already
            assert process.returncode in (0, 130, -number)
            assert process.returncode != 130 or k % 2 == 0 or not out.exists()
            assert not list(folder.glob(".*"))
    again = bake(folder, "--out", "last")
    assert again.returncode == 0, again.stderr
    assert bytes_of(folder / "last") == whole


def bytes_of(out):
    return {name: digest for name, digest in file_hashes(out).items() if name != "report.json"}


def most_bytes():
    import resource

    resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000))


def test_a_full_disk_is_a_line_and_nothing_is_left(folder):
    process = bake(folder, "--out", "out", before=most_bytes)
    refused(process, 3, "cannot write: File too large")
    assert re.match(
        r"surftex: out: ball[._a-z]+: cannot write: File too large; nothing was left there$", process.stderr
    )
    assert [path.name for path in folder.iterdir()] == ["ball.obj"]


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="no folder here that nobody may write in")
def test_a_folder_that_nobody_may_write_in_is_a_line(folder):
    refused(bake(folder, "--out", "/proc/out"), 2, "/proc/out: cannot write in /proc")


def test_a_link_as_output_is_refused_before_any_work(folder):
    (folder / "real").mkdir()
    (folder / "link").symlink_to("real")
    refused(bake(folder, "--out", "link"), 2, "symbolic link")
    assert not list((folder / "real").iterdir())


@pytest.mark.slow
def test_two_runs_at_once_do_not_mix(folder):
    both = [started(folder, "--out", "out") for _ in range(2)]
    said = [process.communicate(timeout=300)[1] for process in both]
    codes = sorted(process.returncode for process in both)
    assert codes in ([0, 0], [0, 2]), said
    assert is_whole(folder / "out")
    assert not list(folder.glob(".*"))


PROBE = """
import numpy as np
from surftex.kernels.jit import kernel

@kernel
def doubled(values):
    for i in range(len(values)):
        values[i] *= 2

values = np.ones(3)
doubled(values)
assert (values == 2).all()
"""


def probe(folder, cache):
    (folder / "probe.py").write_text(PROBE)
    process = subprocess.run(
        [sys.executable, "probe.py"], cwd=folder, capture_output=True, text=True, timeout=120,
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
    )  # fmt: skip
    assert process.returncode == 0, process.stderr


@pytest.mark.slow
def test_damaged_or_forbidden_kernels_are_compiled_again(folder):
    cache = folder / "kernels"
    probe(folder, cache)
    for suffix, damage in ((".nbi", lambda data: data[:20]), (".nbc", lambda data: b"\x80" * len(data))):
        (path,) = cache.rglob(f"*{suffix}")
        data = path.read_bytes()
        path.write_bytes(damage(data))
        probe(folder, cache)
        assert path.read_bytes()[:60] == data[:60]
    if Path("/proc/self").exists():
        probe(folder, "/proc/kernels")


@pytest.mark.slow
def test_kernels_are_compiled_again_when_a_part_of_them_changes(folder):
    package = folder / "surftex" / "kernels"
    package.mkdir(parents=True)
    text = (Path(jit.__file__)).read_text()
    for name, content in {
        "../__init__.py": "",
        "../interrupts.py": Path(interrupts.__file__).read_text(),
        "__init__.py": "",
        "jit.py": text,
        "factor.py": "from surftex.kernels.jit import part\n\n\n@part\ndef factor():\n    return 2\n",
        "product.py": (
            "from surftex.kernels.factor import factor\nfrom surftex.kernels.jit import kernel\n\n\n"
            "@kernel\ndef product(values):\n    values[0] *= factor()\n"
        ),
    }.items():
        (package / name).write_text(content)
    for times in (2, 3):
        changed = (package / "factor.py").read_text().replace("return 2", f"return {times}")
        (package / "factor.py").write_text(changed)
        process = subprocess.run(
            [sys.executable, "-c", "import numpy as np; from surftex.kernels.product import product; "
             "values = np.ones(1); product(values); print(int(values[0]))"],
            cwd=folder, capture_output=True, text=True, timeout=120,
            env={**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": str(folder)},
        )  # fmt: skip
        assert process.stdout.strip() == str(times), process.stderr
