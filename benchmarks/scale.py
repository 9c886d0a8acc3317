"""Size, memory and throughput: `python -m benchmarks.scale [pages] [meshes] [batch]`.

``pages``: the shipped cushion in pebbled cattle by the command at 2048, 8192 and 16384, all maps written; it takes 10 GB of
room for temporary files. ``meshes``: a bumpy ball of 0.3, 1.3 and 5.2 million faces: inspected, unwrapped, baked at 2048.
``batch``: the same bakes in a plain loop and by a batch with one worker, both on one core, and by a batch with a worker per
core; kernels are compiled, caches of results empty. Each row is a process of its own; CPU seconds are of all its threads and
children, memory is the most that it has held, saving included. Figures of wall time mean something on a quiet machine alone:
the load is printed first.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

MESHES = Path(__file__).resolve().parent.parent / "meshes"

JOBS, ROUNDS = 40, 2
"""Bakes of a batch, and how often each way of doing them is timed; the best counts."""

MATERIALS: dict[str, tuple[Any, ...]] = {"goat": (8, "--set", 'cell_size="4 mm"'), "skin": (9,)}
"""Materials of the balls: up to which subdivision, and options."""

LOOP = """
import sys
from pathlib import Path
from surftex.bake.bake import run
from surftex.bake.saving import save
from surftex.recipe.batch import load_batch

batch = load_batch(Path(sys.argv[1]))
for job in batch.jobs:
    save(run(job.recipe, threads=1, remember=True), batch.out / job.name, threads=1)
"""


@dataclass(frozen=True)
class Ran:
    """What a process printed and took: wall and CPU seconds, MB of 10^6 bytes."""

    printed: str
    wall_s: float
    cpu_s: float
    peak_mb: float


def ran(*arguments: str, cores: int | None = None, **environment: str) -> Ran:
    """Run Python, on so many cores, and measure it."""
    own = sorted(os.sched_getaffinity(0))
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as complaints:
        began = time.perf_counter()
        process = subprocess.Popen(
            [sys.executable, *arguments], stdout=out, stderr=complaints, env={**os.environ, **environment},
            preexec_fn=lambda: os.sched_setaffinity(0, own[:cores]),
        )  # fmt: skip
        status, usage = os.wait4(process.pid, 0)[1:]
        process.returncode = os.waitstatus_to_exitcode(status)
        wall_s = time.perf_counter() - began
        for file in (out, complaints):
            file.seek(0)
        if process.returncode:
            raise SystemExit(f"{arguments[1]!r}: {(complaints.read().strip() or 'killed').splitlines()[-1]}")
        return Ran(out.read(), wall_s, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024 / 1e6)


def command(*arguments: str) -> tuple[dict[str, Any], Ran]:
    """Run a command that prints a report."""
    done = ran("-m", "surftex", *arguments)
    return json.loads(done.printed), done


def baked(label: str, *arguments: str) -> float:
    """Bake, print a row, and give the CPU seconds without those of loading and unwrapping."""
    report, done = command("bake", *arguments, "--units", "mm", "--overwrite", "--no-cache", "--json", "-q")
    spent = {stage["name"]: stage["cpu_s"] for stage in report["stages"]}
    parts = ", ".join(f"{name} {seconds:.1f}" for name, seconds in spent.items())
    rest = done.cpu_s - spent["load"] - spent["unwrap"]
    print(
        f"{label}: {done.cpu_s:.1f} CPU-s ({parts}, start and saving {done.cpu_s - sum(spent.values()):.1f}), "
        f"{rest:.1f} without load and unwrap, {done.wall_s:.0f} s; most memory {done.peak_mb:.0f} MB",
        flush=True,
    )
    return rest


def pages() -> None:
    """Bake larger and larger pages."""
    spent = {}
    for side in (2048, 8192, 16384):
        with tempfile.TemporaryDirectory() as out:
            spent[side] = baked(
                f"cushion, {side} x {side}",
                str(MESHES / "cushion.obj"), "--material", "cattle-pebbled", "--resolution", str(side), "--out", out,
            )  # fmt: skip
    print(f"8192 over 2048: {spent[8192] / spent[2048]:.1f} (goal 17)")


def ball(path: Path, levels: int) -> None:
    """Write a bumpy ball of 20 x 4^levels faces."""
    from surftex.surface.shapes import sphere

    shape = sphere(150.0, subdivisions=levels)
    x, y, z = shape.vertices.T / 150
    swell = 1 + 0.08 * np.sin(5 * x + 1) * np.cos(4 * y - z) + 0.05 * np.sin(9 * z)
    points = (shape.vertices * swell[:, None]).astype("<f4")
    faces = np.empty(len(shape.faces), [("n", "u1"), ("v", "<i4", 3)])
    faces["n"], faces["v"] = 3, shape.faces
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    path.write_bytes(head.encode() + points.tobytes() + faces.tobytes())


def meshes() -> None:
    """Inspect and bake larger and larger meshes."""
    with tempfile.TemporaryDirectory() as folder:
        for levels in (7, 8, 9):
            path = str(Path(folder) / f"ball{levels}.ply")
            ran("-c", f"from benchmarks.scale import ball, Path; ball(Path({path!r}), {levels})")
            facts, done = command("inspect", path, "--units", "mm", "--json")
            label = f"{facts['faces']:,} faces"
            print(
                f"{label}: inspected in {done.cpu_s:.1f} CPU-s, most memory {done.peak_mb:.0f} MB", flush=True
            )
            for material, sizes in MATERIALS.items():
                if levels <= sizes[0]:
                    out = str(Path(folder) / "out")
                    options = (*sizes[1:], "--resolution", "2048", "--out", out)
                    baked(f"{label}, {material}", path, "--material", material, *options)


def batch() -> None:
    """Compare a plain loop, a batch by one worker, and a batch by one per core."""
    cores = len(os.sched_getaffinity(0))
    ran("-m", "surftex", "cache", "--warm")
    ways: dict[str, list[Ran]] = {"plain loop": [], "1 worker": [], f"{cores} workers": []}
    for turn in range(ROUNDS):
        for way, taken in ways.items():
            with tempfile.TemporaryDirectory() as folder:
                shutil.copy(MESHES / "torus.obj", folder)
                jobs = Path(folder) / "jobs.toml"
                jobs.write_text(
                    f'surftex = 1\nmeshes = ["torus.obj"]\nmaterials = ["ostrich"]\n'
                    f'seeds = {list(range(JOBS))}\nresolution = 1024\nunits = "mm"\nout = "out"\n',
                    "utf-8",
                )
                kept = {"SURFTEX_CACHE_DIR": str(Path(folder) / "cache")}
                if way == "plain loop":
                    done = ran("-c", LOOP, str(jobs), cores=1, **kept)
                else:
                    count = way.split()[0]
                    done = ran(
                        "-m",
                        "surftex",
                        "batch",
                        str(jobs),
                        "--workers",
                        count,
                        "-q",
                        cores=int(count),
                        **kept,
                    )
                assert len(list((Path(folder) / "out").glob("*/report.json"))) == JOBS
                taken.append(done)
                print(
                    f"round {turn + 1}, {way}: {JOBS} jobs in {done.wall_s:.1f} s, {done.cpu_s:.1f} CPU-s",
                    flush=True,
                )
    loop, one, many = (min(each.wall_s for each in taken) for taken in ways.values())
    least = [min(each.cpu_s for each in taken) for taken in ways.values()]
    print(
        f"a batch beyond a plain loop: {(one - loop) / JOBS:.2f} s a job (goal 0.3), {(least[1] - least[0]) / JOBS:.2f} CPU-s"
    )
    print(f"{cores} workers over one: {one / many:.2f} times the throughput (goal {0.9 * cores:.1f})")


if __name__ == "__main__":
    print(f"load before: {os.getloadavg()[0]:.1f} on {len(os.sched_getaffinity(0))} cores", flush=True)
    for part in sys.argv[1:] or ("pages", "meshes", "batch"):
        {"pages": pages, "meshes": meshes, "batch": batch}[part]()
