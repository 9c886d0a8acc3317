"""Size, memory and throughput: `python -m benchmarks.scale [pages] [meshes] [batch]`.

``pages``: the shipped cushion in pebbled cattle by the command at 2048, 8192 and 16384, all maps written. ``meshes``: a bumpy
ball of 1 and 5 million faces: inspected, unwrapped, baked at 2048. ``batch``: twelve small bakes by one worker and by one per
core, and what a batch costs beside them. Each row is a process of its own; memory is the most that it has held.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

MESHES = Path(__file__).resolve().parent.parent / "meshes"


def command(*arguments: str) -> dict:
    """Run a command that prints a report."""
    done = subprocess.run([sys.executable, "-m", "surftex", *arguments], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(arguments)}: {done.stderr.strip().splitlines()[-1]}")
    return json.loads(done.stdout)


def told(label: str, report: dict) -> float:
    """Print a row of a bake, and give its CPU seconds."""
    spent = {stage["name"]: stage["cpu_s"] for stage in report["stages"]}
    whole = sum(seconds for name, seconds in spent.items() if name not in ("load", "unwrap"))
    parts = ", ".join(f"{name} {seconds:.1f}" for name, seconds in spent.items())
    print(
        f"{label}: {whole:.1f} CPU-s without load and unwrap ({parts}); most memory {report['peak_rss_mb']:.0f} MB",
        flush=True,
    )
    return whole


def pages() -> None:
    """Bake larger and larger pages."""
    spent = {}
    for side in (2048, 8192, 16384):
        with tempfile.TemporaryDirectory() as out:
            spent[side] = told(
                f"cushion, {side} x {side}",
                command("bake", str(MESHES / "cushion.obj"), "--units", "mm", "--material", "cattle-pebbled", "--resolution",
                        str(side), "--out", out, "--overwrite", "--no-cache", "--json", "-q"),
            )  # fmt: skip
    print(f"8192 over 2048: {spent[8192] / spent[2048]:.1f} (goal 17)")


def ball(path: Path, levels: int) -> None:
    """Write a bumpy ball of 20 x 4^levels faces or so."""
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
        for levels in (8, 9):
            path = Path(folder) / f"ball{levels}.ply"
            ball(path, levels)
            began = time.perf_counter()
            facts = command("inspect", str(path), "--units", "mm", "--json")
            print(f"{facts['faces']:,} faces: inspected in {time.perf_counter() - began:.1f} s", flush=True)
            told(
                f"{facts['faces']:,} faces, 2048 x 2048",
                command("bake", str(path), "--units", "mm", "--material", "goat", "--set", 'cell_size="4 mm"',
                        "--resolution", "2048", "--out", str(Path(folder) / f"out{levels}"), "--no-cache", "--json", "-q"),
            )  # fmt: skip


def batch(jobs: int = 12) -> None:
    """Compare a batch by one worker with one per core."""
    cores, wall = len(os.sched_getaffinity(0)), {}
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "torus.obj").write_bytes((MESHES / "torus.obj").read_bytes())
        for workers in (1, cores):
            name = Path(folder) / f"jobs{workers}.toml"
            name.write_text(
                f'surftex = 1\nmeshes = ["torus.obj"]\nmaterials = ["ostrich"]\nseeds = {list(range(jobs))}\nresolution = 512\n'
                f'units = "mm"\nout = "out{workers}"\n',
                "utf-8",
            )
            began = time.perf_counter()
            subprocess.run(
                [sys.executable, "-m", "surftex", "batch", str(name), "--workers", str(workers), "-q"],
                check=True, capture_output=True, env=dict(os.environ, SURFTEX_THREADS="1"),
            )  # fmt: skip
            wall[workers] = time.perf_counter() - began
            report = json.loads((Path(folder) / f"out{workers}" / "batch-report.json").read_text("utf-8"))
            own = sum(job["wall_s"] for job in report["jobs"]) / workers
            beyond = (wall[workers] - own) / jobs
            print(
                f"{workers} workers: {jobs} jobs in {wall[workers]:.1f} s; {beyond:.2f} s a job beyond the bakes",
                flush=True,
            )
    print(
        f"{cores} workers over one: {wall[1] / wall[cores]:.2f} times the throughput (goal {0.9 * cores:.1f})"
    )


if __name__ == "__main__":
    for part in sys.argv[1:] or ("pages", "meshes", "batch"):
        {"pages": pages, "meshes": meshes, "batch": batch}[part]()
