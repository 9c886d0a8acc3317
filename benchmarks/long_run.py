"""Many bakes in one process, read, placed, unwrapped, baked, saved: memory, handles, threads and children stay as they were.

``python -m benchmarks.long_run [--bakes 200]``; ``--jobs 400`` runs a batch of small jobs through worker processes after it.
"""

import argparse
import gc
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import surftex as sx

KINDS = {
    "leather": {"cell_size": 4.0, "pore_density": 0.05},
    "skin": {"freckle_count": 20, "mole_count": 2},
    "composite": {"model": "gravel", "pixel_size": 2.0, "sweeps": 2},
}
WARM = 12
"""Bakes before the first look: imports, kernels, pools and caches of the libraries are made once."""


@dataclass(frozen=True)
class Held:
    """What a process holds."""

    memory_mb: float
    handles: int
    threads: int
    children: int


def held() -> Held:
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    return Held(
        pages * os.sysconf("SC_PAGE_SIZE") / 1e6,
        len(list(Path("/proc/self/fd").iterdir())),
        threading.active_count(),
        len(children),
    )


def bakes(count: int, folder: Path) -> list[Held]:
    """Bake `count` times after `WARM`; what is held after the warming, half way, and at the end."""
    mesh = folder / "ball.obj"
    mesh.write_text(ball_text())
    looks = []
    for k in range(WARM + count):
        name = list(KINDS)[k % len(KINDS)]
        material = getattr(sx, name.title())(**KINDS[name])
        maps = sx.bake(sx.load(mesh, units="mm"), material, resolution=64, seed=k)
        maps.save(folder / "out")
        shutil.rmtree(folder / "out")
        if k + 1 in (WARM, WARM + count // 2, WARM + count):
            looks.append(held())
    return looks


def ball_text() -> str:
    ball = sx.shapes.sphere(12.0, subdivisions=2)
    rows = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in ball.vertices]
    return "\n".join(rows + ["f " + " ".join(str(v + 1) for v in face) for face in ball.faces])


def batch(jobs: int, folder: Path) -> dict:
    """A batch of small jobs by worker processes; the largest memory of any worker at its start and its end."""
    (folder / "ball.obj").write_text(ball_text())
    seeds = ", ".join(map(str, range(jobs)))
    (folder / "jobs.toml").write_text(
        f'surftex = 1\nmeshes = ["ball.obj"]\nmaterials = ["calf"]\nseeds = [{seeds}]\nresolution = 64\nunits = "mm"\n'
        'maps = ["height"]\nset = ["cell_size=4 mm", "wrinkle_density=0", "pore_density=0", "pocket_depth=0"]\n'
    )
    process = subprocess.Popen(
        [sys.executable, "-m", "surftex", "batch", "jobs.toml", "--workers", "2", "-q"], cwd=folder
    )
    series: dict[int, list[tuple[float, int]]] = {}
    while process.poll() is None:
        for child in children_of(process.pid):
            try:
                pages = int(Path(f"/proc/{child}/statm").read_text().split()[1])
                handles = len(list(Path(f"/proc/{child}/fd").iterdir()))
            except OSError:
                continue
            series.setdefault(child, []).append((pages * os.sysconf("SC_PAGE_SIZE") / 1e6, handles))
        time.sleep(0.2)
    states = json.loads((folder / "out" / "batch-report.json").read_text())["states"]
    workers = [each for each in series.values() if len(each) > 10]
    quarter = [(each[len(each) // 4], each[-2]) for each in workers]
    return {"code": process.returncode, "states": states,
            "workers": [{"mb": [a[0], b[0]], "handles": [a[1], b[1]]} for a, b in quarter]}  # fmt: skip


def children_of(pid: int) -> list[int]:
    try:
        return [int(word) for word in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bakes", type=int, default=200)
    parser.add_argument("--jobs", type=int, default=0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        began = time.process_time()
        for when, look in zip(("warm", "half", "end"), bakes(options.bakes, Path(scratch)), strict=True):
            print(f"{when:5} {look.memory_mb:7.1f} MB {look.handles:4} handles {look.threads:3} threads "
                  f"{look.children} children")  # fmt: skip
        print(f"{options.bakes + WARM} bakes, {time.process_time() - began:.0f} CPU-s")
    if options.jobs:
        with tempfile.TemporaryDirectory() as scratch:
            print(json.dumps(batch(options.jobs, Path(scratch)), indent=1))
