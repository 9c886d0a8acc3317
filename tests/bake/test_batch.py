"""Batches: done once, whole or not there, whoever dies on the way."""

import errno
import json
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest

import surftex
from surftex.bake import batch, jobs
from surftex.bake.batch import run_batch
from surftex.bake.jobs import LOCKS, job_contents, job_key, job_lock
from surftex.errors import InputError, WorkError
from surftex.files import output
from surftex.recipe.batch import load_batch
from surftex.recipe.model import Recipe

JOBS = """
surftex = 1
meshes = ["one.obj", "two.obj"]
materials = ["calf"]
seeds = [1, 2]
resolution = 64
units = "mm"
maps = ["height"]
set = ["cell_size=4 mm", "wrinkle_density=0", "pore_density=0", "pocket_depth=0"]
"""


class Here:
    """Workers that are threads of this process: quick to start."""

    count, threads = 2, 1

    def __init__(self):
        self.pool = ThreadPoolExecutor(2)

    def executor(self):
        return self.pool

    def renew(self, broken):
        raise AssertionError("threads do not die")

    def abandon(self):
        self.pool.shutdown(wait=True, cancel_futures=True)

    def lost(self):
        return None


def ball_text(radius):
    from surftex.surface.shapes import sphere

    ball = sphere(radius, subdivisions=2)
    rows = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in ball.vertices]
    return "\n".join(rows + ["f " + " ".join(str(v + 1) for v in face) for face in ball.faces])


@pytest.fixture
def studio(tmp_path):
    (tmp_path / "one.obj").write_text(ball_text(12.0))
    (tmp_path / "two.obj").write_text(ball_text(15.0))
    (tmp_path / "jobs.toml").write_text(JOBS)
    return tmp_path


def done_in(studio, **options):
    workers = Here()
    try:
        return run_batch(load_batch(studio / "jobs.toml"), workers, **options)
    finally:
        workers.abandon()


def outputs(studio):
    found = {}
    for folder in sorted((studio / "out").iterdir()):
        if folder.is_dir() and not folder.name.startswith("."):
            found[folder.name] = json.loads((folder / "report.json").read_text())["outputs"]
    return found


def test_what_is_done_is_kept_and_what_is_damaged_or_changed_is_done_again(studio):
    first = done_in(studio)
    assert [result.state for result in first.results] == ["done"] * 4
    assert first.exit_code == 0
    whole = outputs(studio)
    assert list(whole) == ["one-calf-1", "one-calf-2", "two-calf-1", "two-calf-2"]
    report = json.loads((studio / "out" / "batch-report.json").read_text())
    assert report["states"]["done"] == 4
    assert [job["folder"] for job in report["jobs"]] == list(whole)

    assert [result.state for result in done_in(studio).results] == ["kept"] * 4
    height = studio / "out" / "one-calf-2" / "one_height.exr"
    height.write_bytes(height.read_bytes()[:-1])
    (studio / "out" / "two-calf-1" / "report.json").unlink()
    assert [result.state for result in done_in(studio).results] == ["kept", "done", "done", "kept"]
    assert outputs(studio) == whole
    (studio / "out" / ".one-calf-1-abcdefgh" / "new").mkdir(parents=True)  # killed when all but this was done
    (studio / "out" / ".one-calf-1-abcdefgh" / "lock").touch()
    assert [result.state for result in done_in(studio).results] == ["kept"] * 4
    assert {path.name for path in (studio / "out").iterdir()} == {*whole, LOCKS, "batch-report.json"}

    (studio / "one.obj").write_text(ball_text(13.0))
    assert [result.state for result in done_in(studio).results] == ["done", "done", "kept", "kept"]
    (studio / "jobs.toml").write_text(JOBS.replace("4 mm", "5 mm"))
    assert [result.state for result in done_in(studio).results] == ["done"] * 4
    assert [result.state for result in done_in(studio, resume=False).results] == ["done"] * 4


def test_a_failure_stops_the_batch_unless_told_to_keep_going(studio):
    (studio / "one.obj").write_text("v 0 0 nonsense\n")
    stopped = done_in(studio)
    assert stopped.count("failed") >= 1
    assert stopped.count("not started") >= 1
    assert stopped.exit_code == 2
    going = done_in(studio, keep_going=True)
    assert [result.state for result in going.results][:2] == ["failed", "failed"]
    assert {result.state for result in going.results[2:]} <= {"done", "kept"}
    assert "one.obj" in (going.results[0].reason or "")
    assert going.exit_code == 2


def test_a_mesh_that_is_missing_is_one_failure(studio):
    (studio / "two.obj").unlink()
    result = done_in(studio, keep_going=True)
    assert [each.state for each in result.results] == ["done", "done", "failed", "failed"]
    assert "no such mesh file" in (result.results[2].reason or "")


def test_folders_of_others_are_left_alone(studio):
    mine = studio / "out" / "one-calf-1"
    mine.mkdir(parents=True)
    (mine / "notes.txt").write_text("mine")
    result = done_in(studio, keep_going=True)
    assert result.results[0].state == "failed"
    assert "no batch made" in (result.results[0].reason or "")
    assert [path.name for path in mine.iterdir()] == ["notes.txt"]
    assert done_in(studio, overwrite=True).results[0].state == "done"
    assert (mine / "notes.txt").read_text() == "mine"


def test_files_by_bytes_are_the_files_by_path(studio):
    (studio / "toe.png").write_bytes(png())
    recipe = 'surftex = 1\n[fields]\ntoe = { image = "toe.png" }\n[[layer]]\npreset = "calf"\nmask = "1"\ncell_size = "4 mm"\n'
    (studio / "toe.toml").write_text(recipe)
    assert done_in(studio).exit_code == 0
    by_path = outputs(studio)
    (studio / "jobs.toml").write_text(JOBS.replace("surftex = 1", 'surftex = 1\nout = "far"'))
    assert done_in(studio, by_bytes=True).exit_code == 0
    (studio / "out").rename(studio / "near")
    (studio / "far").rename(studio / "out")
    assert outputs(studio) == by_path
    report = json.loads((studio / "out" / "one-calf-1" / "report.json").read_text())
    assert report["recipe"]["mesh"]["path"] == str(studio / "one.obj")


def test_a_job_is_another_when_two_files_of_one_name_change_places(tmp_path):
    (tmp_path / "ball.obj").write_text(ball_text(10))
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "m.png").write_bytes(png() + name.encode())
    keys = []
    for one, two in (("a", "b"), ("b", "a"), ("a", "b")):
        fields = {
            "one": {"image": str(tmp_path / one / "m.png")},
            "two": {"image": str(tmp_path / two / "m.png")},
        }
        layers = [{"preset": "calf", "mask": "one"}]
        recipe = Recipe.model_validate(
            {"mesh": {"path": str(tmp_path / "ball.obj")}, "fields": fields, "layer": layers}
        )
        keys.append(job_key(recipe, job_contents(recipe)))
    assert keys[0] == keys[2] != keys[1]


def test_files_of_layers_travel_too(tmp_path):
    (tmp_path / "ball.obj").write_text(ball_text(10))
    (tmp_path / "models").mkdir()
    model = tmp_path / "models" / "mine.stex"
    model.write_bytes(
        (Path(surftex.__file__).parent / "materials" / "presets" / "composite" / "gravel.stex").read_bytes()
    )
    recipe = Recipe.model_validate(
        {
            "mesh": {"path": str(tmp_path / "ball.obj")},
            "layer": [{"material": "composite", "model": str(model)}],
        }
    )
    moved = jobs._unpacked(recipe, job_contents(recipe), tmp_path / "far")
    assert moved.layer[0].material.model == str(tmp_path / "far" / "models" / "mine.stex")
    assert Path(moved.layer[0].material.model).read_bytes() == model.read_bytes()
    assert moved.mesh.path == str(tmp_path / "far" / "ball.obj")


def png():
    import numpy as np

    from surftex.files.images import png_bytes

    return png_bytes(np.zeros((4, 4, 3), np.uint8))


def test_a_job_in_other_hands_is_waited_for_and_then_kept(studio):
    assert done_in(studio).exit_code == 0
    with job_lock(studio / "out", "one-calf-1") as held:
        assert held
        with job_lock(studio / "out", "one-calf-1") as again:
            assert not again
        results = []
        other = threading.Thread(target=lambda: results.append(done_in(studio)))
        other.start()
        time.sleep(1.0)
        assert not results
    other.join(30)
    assert [result.state for result in results[0].results] == ["kept"] * 4


def test_a_job_whose_folder_cannot_be_written_fails_alone(studio, monkeypatch):
    plain = os.mkdir

    def refused(path, *more, **how):
        if Path(path).parent.name == "one-calf-2":
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        plain(path, *more, **how)

    monkeypatch.setattr(os, "mkdir", refused)
    (studio / "out" / "one-calf-2").mkdir(parents=True)
    result = done_in(studio, keep_going=True)
    assert [each.state for each in result.results] == ["done", "failed", "done", "done"]
    assert "one-calf-2: cannot write" in (result.results[1].reason or "")
    assert result.exit_code == 2


def test_an_output_that_cannot_be_made_is_told_before_any_job_is_touched(studio, monkeypatch):
    (studio / "out").write_text("in the way")
    monkeypatch.setattr("surftex.bake.batch.job_contents", lambda recipe: pytest.fail("a job was begun"))
    with pytest.raises(InputError, match="out is a file; name a folder"):
        done_in(studio)
    assert (studio / "out").read_text() == "in the way"


def test_a_disk_that_is_full_fails_a_job_and_the_others_go_on(studio, monkeypatch):
    plain = output._sync

    def full(path):
        if ".two-calf-1-" in str(path):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        plain(path)

    monkeypatch.setattr(output, "_sync", full)
    result = done_in(studio, keep_going=True)
    assert [each.state for each in result.results] == ["done", "done", "failed", "done"]
    assert (result.results[2].reason or "").endswith(
        "two-calf-1: cannot write: No space left on device; nothing was left there"
    )
    assert result.exit_code == 3
    assert not list((studio / "out").glob(".two*"))
    monkeypatch.undo()
    assert [each.state for each in done_in(studio).results] == ["kept", "kept", "done", "kept"]


class Deadly(Here):
    """Workers of which one dies, and takes the pool with it, whenever it is given a certain job."""

    renewed = 0

    def executor(self):
        return self

    def submit(self, work, task):
        if not task.folder.endswith("one-calf-2"):
            return self.pool.submit(work, task)
        dead = Future()
        dead.set_exception(BrokenProcessPool())
        return dead

    def renew(self, broken):
        self.renewed += 1


def test_a_job_that_kills_its_worker_twice_fails_and_the_others_go_on(studio):
    workers = Deadly()
    try:
        result = run_batch(load_batch(studio / "jobs.toml"), workers, keep_going=True)
    finally:
        workers.abandon()
    assert [each.state for each in result.results] == ["done", "failed", "done", "done"]
    assert result.results[1].reason == "its worker was killed; out of memory? Try a lower resolution"
    assert result.exit_code == 3
    assert workers.renewed == 2


def test_a_job_that_a_cluster_gave_up_has_the_line_of_a_killed_worker(studio, monkeypatch):
    distributed = pytest.importorskip("distributed")
    dead = Future()
    dead.set_exception(distributed.KilledWorker("job", None, 3))
    workers = Here()
    monkeypatch.setattr(workers, "executor", lambda: Given(dead))
    result = run_batch(load_batch(studio / "jobs.toml"), workers)
    assert result.results[0].reason == "its worker was killed; out of memory? Try a lower resolution"
    assert result.exit_code == 3


class Given:
    """An executor whose jobs all end in the same way."""

    def __init__(self, future):
        self.future = future

    def submit(self, work, task):
        same = Future()
        same.set_exception(self.future.exception())
        return same


class Deserted(Here):
    """Workers whose scheduler goes while the first jobs are done."""

    def lost(self):
        return "the scheduler at tcp://far:8786 is gone"


def test_a_scheduler_that_goes_ends_the_batch_in_a_line_and_it_can_go_on(studio):
    workers = Deserted()
    with pytest.raises(WorkError, match=r"is gone; \d of 4 jobs are done, the same command goes on"):
        run_batch(load_batch(studio / "jobs.toml"), workers)
    report = json.loads((studio / "out" / "batch-report.json").read_text())
    left = [job for job in report["jobs"] if job["state"] == "not started"]
    assert left
    assert {job["reason"] for job in left} == {"the scheduler at tcp://far:8786 is gone"}
    assert done_in(studio).exit_code == 0


@pytest.mark.parametrize("by_bytes", [False, True])
def test_warnings_of_the_bakes_are_told_and_reported(studio, by_bytes, capsys):
    from argparse import Namespace

    from surftex.cli.batch import _Watch

    (studio / "jobs.toml").write_text(JOBS.replace('units = "mm"\n', "").replace("[1, 2]", "[1]"))
    watch = _Watch(Namespace(quiet=False), 2)
    done = done_in(studio, by_bytes=by_bytes, told=watch)
    assert all("taken as" in " ".join(result.warnings) for result in done.results)
    assert "one-calf-1: warning: " + done.results[0].warnings[0] in capsys.readouterr().err
    assert [result.warnings for result in done_in(studio).results] == [each.warnings for each in done.results]
    report = json.loads((studio / "out" / "batch-report.json").read_text())
    assert [job["warnings"] for job in report["jobs"]] == [list(each.warnings) for each in done.results]


def test_a_plan_tells_what_is_kept_and_what_would_fail_and_ends_as_the_batch_would(studio, capsys):
    from argparse import Namespace

    from surftex.cli.batch import run

    plain: dict = {
        "shared_files": False,
        "scheduler": None,
        "allow_outside": False,
        "dry_run": True,
        "json": False,
    }
    options = Namespace(subject=studio / "jobs.toml", resume=True, overwrite=False, **plain)
    (studio / "jobs.toml").write_text(JOBS.replace("[1, 2]", "[1]"))
    done_in(studio)
    (studio / "jobs.toml").write_text(JOBS)
    run(options)
    said = capsys.readouterr().out.splitlines()
    assert [line.endswith("kept, as an earlier run left it") for line in said[:4]] == [
        True,
        False,
        True,
        False,
    ]
    assert said[4].startswith("4 jobs, 2 of them kept, about ")
    options.resume = False
    run(options)
    assert "4 jobs, 0 of them kept" in capsys.readouterr().out
    (studio / "two.obj").unlink()
    with pytest.raises(InputError, match=r"^2 of 4 jobs would fail$"):
        run(options)
    assert capsys.readouterr().out.count("two.obj: no such mesh file") == 2


def test_a_plan_tells_of_folders_that_the_batch_would_refuse(studio, capsys):
    from argparse import Namespace

    from surftex.cli.batch import run

    options = Namespace(
        subject=studio / "jobs.toml", resume=True, overwrite=False, shared_files=False, scheduler=None,
        allow_outside=False, dry_run=True, json=False,
    )  # fmt: skip
    batch = load_batch(studio / "jobs.toml")
    strange = batch.out / batch.jobs[0].name
    strange.mkdir(parents=True)
    (strange / "letter.txt").write_text("dear")
    with pytest.raises(InputError, match=r"^1 of 4 jobs would fail$"):
        run(options)
    assert "holds files that no batch made" in capsys.readouterr().out
    options.overwrite = True
    run(options)
    assert (strange / "letter.txt").read_text() == "dear"
    (strange / "letter.txt").unlink()
    strange.rmdir()
    batch.out.rmdir()
    batch.out.write_text("a file")
    with pytest.raises(InputError, match=r"^4 of 4 jobs would fail$"):
        run(options)
    assert capsys.readouterr().out.count("it is no folder") == 4


REFUSALS = [
    ("materials = ['calf']\nset = ['cell_size=1 um']", "mm^2 would hold about "),
    ("materials = ['skin-tan']\nset = ['mole_count=9000000']", "skin.mole_count: "),
    (
        "materials = ['cells']\nset = ['cell_size=1 um']",
        "most of them particles",
    ),
    ("materials = ['gravel']\nset = ['pixel_size=1 um']", " more than "),
    ("materials = ['calf']\nudim = true\ntexels_per_mm = 900", "tiles of 64 x 64; at most 100 are made"),
]


@pytest.mark.parametrize(("lines", "says"), REFUSALS, ids=[lines.split("'")[1] for lines, _ in REFUSALS])
def test_a_plan_foresees_what_is_too_many(studio, capsys, lines, says):
    from surftex.bake.bake import run as bake_run
    from surftex.cli import main

    (studio / "jobs.toml").write_text(f"meshes = ['one.obj']\n{lines}\nresolution = 64\nunits = 'mm'\n")
    assert main(["batch", str(studio / "jobs.toml"), "--dry-run"]) == 2
    printed = capsys.readouterr().out
    assert says in printed
    with pytest.raises(InputError) as refused:
        bake_run(load_batch(studio / "jobs.toml").jobs[0].recipe)
    assert printed.splitlines()[0].endswith(str(refused.value))


def test_a_plan_counts_tiles(studio, capsys):
    from surftex.cli import main

    costs = []
    for density in ("", "udim = true\ntexels_per_mm = 9\n"):
        (studio / "jobs.toml").write_text(
            f"meshes = ['one.obj']\nmaterials = ['calf']\nresolution = 64\nunits = 'mm'\n{density}"
        )
        assert main(["batch", str(studio / "jobs.toml"), "--dry-run", "--json"]) == 0
        costs.append(json.loads(capsys.readouterr().out)["jobs"][0])
    assert costs[0]["tiles"] == 1
    assert 30 < costs[1]["tiles"] < 50
    assert costs[1]["memory_mb"] > costs[0]["memory_mb"]


def test_an_interrupted_batch_says_what_is_done_and_reports_it(studio):
    def told(result, ended, total):
        if ended == 2:
            raise KeyboardInterrupt

    with pytest.raises(
        KeyboardInterrupt, match=r"^interrupted; 2 of 4 jobs are done, the same command goes on$"
    ):
        done_in(studio, told=told)
    report = json.loads((studio / "out" / "batch-report.json").read_text())
    assert report["states"] == {"done": 2, "kept": 0, "failed": 0, "not started": 2}
    assert {job["reason"] for job in report["jobs"]} == {None, "interrupted"}
    assert done_in(studio).count("kept") >= 2


@pytest.mark.parametrize("moment", ["report", "abandon"])
def test_an_interrupt_that_comes_twice_ends_a_batch_as_one_does(studio, monkeypatch, moment):
    def told(result, ended, total):
        if ended == 1:
            signal.raise_signal(signal.SIGINT)

    def disturbed(work):
        def again(*arguments):
            signal.raise_signal(signal.SIGINT)
            return work(*arguments)

        return again

    if moment == "report":
        monkeypatch.setattr(batch, "write_report", disturbed(batch.write_report))
    else:
        monkeypatch.setattr(Here, "abandon", disturbed(Here.abandon))
    workers = Here()
    with pytest.raises(
        KeyboardInterrupt, match=r"^interrupted; 1 of 4 jobs are done, the same command goes on$"
    ):
        run_batch(load_batch(studio / "jobs.toml"), workers, told=told)
    assert json.loads((studio / "out" / "batch-report.json").read_text())["states"]["done"] == 1
    workers.pool.shutdown(wait=True)
    assert [path.name for path in (studio / "out").glob(".*")] == [LOCKS]
    monkeypatch.undo()
    assert done_in(studio).exit_code == 0


def started(studio, *more):
    return subprocess.Popen(
        [sys.executable, "-m", "surftex", "batch", "jobs.toml", "--workers", "2", *more],
        cwd=studio, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip


def children(pid):
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((folder / "stat").read_text().rsplit(")", 1)[1].split()[1])
            command = (folder / "cmdline").read_text()
        except OSError:
            continue
        if parent == pid and "spawn_main" in command:
            found.append(int(folder.name))
    return found


def until(condition, seconds=90.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.01)


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_killed_at_any_moment_the_next_run_gives_the_same_bytes(studio):
    (studio / "jobs.toml").write_text(JOBS.replace("64", "512"))
    assert done_in(studio).exit_code == 0
    whole = outputs(studio)
    began = time.monotonic()
    (studio / "out").rename(studio / "undisturbed")
    undisturbed = started(studio)
    undisturbed.communicate()
    assert undisturbed.returncode == 0
    usual_s = time.monotonic() - began
    for share in (0.3, 0.5, 0.57, 0.63, 0.75):
        (studio / "out").rename(studio / f"before {share}")
        process = started(studio)
        time.sleep(share * usual_s)
        workers = children(process.pid)
        process.kill()
        process.communicate()
        until(lambda workers=workers: not any(Path(f"/proc/{pid}/fd/0").exists() for pid in workers), 20)
        (studio / "out").mkdir(exist_ok=True)
        result = done_in(studio)
        assert result.exit_code == 0
        assert outputs(studio) == whole
        assert {path.name for path in (studio / "out").iterdir()} == {*whole, LOCKS, "batch-report.json"}


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_a_killed_worker_is_replaced_and_its_job_runs_again(studio):
    process = started(studio)
    until(lambda: len(children(process.pid)) == 2)
    os.kill(children(process.pid)[0], signal.SIGKILL)
    stdout, stderr = process.communicate(timeout=300)
    assert process.returncode == 0, stderr
    assert "4 done" in stdout
    assert len(outputs(studio)) == 4


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_an_interrupted_batch_ends_cleanly(studio):
    (studio / "jobs.toml").write_text(JOBS.replace("64", "1024").replace('maps = ["height"]', ""))
    process = started(studio)
    until(lambda: any((studio / "out").glob(".*-*/new")))
    workers = children(process.pid)
    assert workers
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130, stderr
    assert stderr.splitlines()[-1] == ("surftex: interrupted; 0 of 4 jobs are done, the same command goes on")
    assert "Traceback" not in stderr
    until(lambda: not any(pid in children(1) or Path(f"/proc/{pid}/fd/0").exists() for pid in workers), 20)
    names = {path.name for path in (studio / "out").iterdir()}
    assert all(not name.startswith(".") or name == LOCKS for name in names)


@pytest.mark.slow
def test_two_batches_into_one_folder_do_not_harm_each_other(studio):
    one, two = started(studio), started(studio)
    for process in (one, two):
        _, stderr = process.communicate(timeout=300)
        assert process.returncode == 0, stderr
    assert len(outputs(studio)) == 4
    assert [result.state for result in done_in(studio).results] == ["kept"] * 4


@pytest.mark.slow
def test_a_cluster_gives_the_same_bytes_and_outlives_a_worker(studio):
    pytest.importorskip("distributed")
    assert done_in(studio).exit_code == 0
    whole = outputs(studio)
    (studio / "out").rename(studio / "local")
    scheduler = subprocess.Popen(
        [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0",
         "--no-dashboard", "--scheduler-file", str(studio / "scheduler.json")],
        stderr=subprocess.DEVNULL,
    )  # fmt: skip
    workers = []
    try:
        until(lambda: (studio / "scheduler.json").exists() and (studio / "scheduler.json").stat().st_size > 0)
        address = json.loads((studio / "scheduler.json").read_text())["address"]
        command = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard",
                   "--no-nanny", "--host", "127.0.0.1", "--local-directory", str(studio / "scratch")]  # fmt: skip
        workers += [subprocess.Popen(command, stderr=subprocess.DEVNULL) for _ in range(2)]
        process = subprocess.Popen(
            [sys.executable, "-m", "surftex", "batch", "jobs.toml", "--scheduler", address, "--workers", "2"],
            cwd=studio, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        until(lambda: (studio / "out" / LOCKS).exists())
        time.sleep(1.0)
        workers[0].kill()
        stdout, stderr = process.communicate(timeout=300)
        assert process.returncode == 0, stderr
        assert "4 done" in stdout
        assert outputs(studio) == whole
        scheduler.kill()
        gone = started(studio, "--scheduler", address, "--no-resume")
        _, stderr = gone.communicate(timeout=120)
        assert gone.returncode == 3
        assert "no scheduler answers" in stderr
        assert stderr.count("\n") == 1
    finally:
        for process in (*workers, scheduler):
            process.kill()
            process.wait()
