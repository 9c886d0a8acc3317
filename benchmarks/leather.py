"""Leather, stage by stage: `python -m benchmarks.leather [MESH]`. CPU seconds over all threads, warm.

The mesh is subdivided once; cells, wrinkles and pores are sized so that it holds 5,000 and then 50,000 cells, 30
wrinkles and 50,000 pores; a flat square of 500 texels is beside it. Without a mesh it is the shipped head. Each row
is a process of its own: a ball is baked, which loads the kernels, then the mesh, which tells the highest memory, then
the mesh again, which tells the time. What is judged is place, bake and seams; the unwrap, and making the mesh, are not.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np

import surftex as sx
from surftex.bake.stages import peak_rss_mb
from surftex.surface.shapes import midpoint_subdivided, sphere
from surftex.surface.surface import Surface

MESHES = Path(__file__).resolve().parent.parent / "meshes"
MAPS = ("base_color", "roughness", "normal", "height")
ROWS = {
    "head 2048^2": (2048, 5_000),
    "head 4096^2": (4096, 5_000),
    "head 2048^2, ten times the cells": (2048, 50_000),
    "square 500^2": (500, 300),
}


def sized(surface: Surface, cells: int, wrinkles: int = 30, pores: int = 50_000) -> sx.Leather:
    """Calf whose lengths are scaled so that a surface holds a number of cells."""
    spacing = float(np.sqrt(0.697 * surface.area_mm2 / cells))
    scale = spacing / 0.85
    return sx.Leather.preset(
        "calf", cell_size=spacing, cell_ratio=1.0, crista_height=0.05 * scale, sulcus_depth=0.03 * scale,
        sulcus_width=0.17 * scale, wrinkle_density=0.0, wrinkle_count=wrinkles, wrinkle_length=14 * scale,
        wrinkle_width=0.32 * scale, wrinkle_depth=0.04 * scale, wrinkle_taper=5 * scale, pocket_depth=0.0,
        pore_density=pores / surface.area_mm2, pore_width=0.1 * scale, grain_size=0.25 * scale,
    )  # fmt: skip


def square(side_mm: float = 10.0) -> Surface:
    """Two triangles."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) * side_mm
    return Surface.from_arrays(corners, np.array([[0, 1, 2], [0, 2, 3]]), name="square")


def memory_mib() -> float:
    """Most memory that this process has held."""
    return peak_rss_mb() * 1e6 / 2**20


def measured(path: str, resolution: int, cells: int) -> dict:
    """Bake in this process: CPU seconds of the stages, what was placed, and memory before and at the most."""
    if resolution == 500:
        surface, leather = square(), sized(square(), cells, wrinkles=5, pores=1000)
    else:
        coarse = sx.load(path)
        points, faces = midpoint_subdivided(np.array(coarse.vertices), np.array(coarse.faces))
        surface = Surface.from_arrays(points, faces, name="head")
        leather = sized(surface, cells)
    ball = sphere(10.0, subdivisions=4)
    sx.bake(ball, sized(ball, 300, wrinkles=3, pores=300), resolution=256, maps=MAPS)
    before = memory_mib()
    sx.bake(surface, leather, resolution=resolution, maps=MAPS)
    peak = memory_mib()
    baked = sx.bake(surface, leather, resolution=resolution, maps=MAPS)
    return {
        "stages": {stage["name"]: stage["cpu_s"] for stage in baked.report["stages"]},
        "placed": baked.report["features"],
        "texels": baked.report["texels"],
        "before_mib": before,
        "peak_mib": peak,
    }


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("mesh", nargs="?", default=str(MESHES / "head.ply"))
    parser.add_argument("--one", nargs=2, type=int, metavar=("RESOLUTION", "CELLS"), help="one row, as JSON")
    options = parser.parse_args()
    if options.one:
        print("JSON " + json.dumps(measured(options.mesh, *options.one)))
        return
    spent, peak = {}, {}
    for name, row in ROWS.items():
        child = [
            sys.executable,
            "-m",
            "benchmarks.leather",
            options.mesh,
            "--one",
            *(str(number) for number in row),
        ]
        done = subprocess.run(child, capture_output=True, text=True, check=True)
        found = json.loads(next(line for line in done.stdout.splitlines() if line.startswith("JSON "))[5:])
        stages = found["stages"]
        spent[name] = sum(seconds for stage, seconds in stages.items() if stage not in ("load", "unwrap"))
        peak[name] = found["peak_mib"]
        placed = ", ".join(f"{count} {kind}" for kind, count in found["placed"].items())
        print(
            f"{name}: {spent[name]:.2f} CPU-s ({', '.join(f'{stage} {seconds:.2f}' for stage, seconds in stages.items())}),"
            f" peak {found['peak_mib']:.0f} MiB ({found['before_mib']:.0f} before), {placed}, {found['texels']} texels"
        )
    base = spent["head 2048^2"]
    ratios = {
        "2048^2: CPU-s": (base, 5.0),
        "2048^2: peak MiB": (peak["head 2048^2"], 1024.0),
        "square of 500^2: CPU-s": (spent["square 500^2"], 0.5),
        "4096^2 over 2048^2": (spent["head 4096^2"] / base, 4.4),
        "ten times the cells over one": (spent["head 2048^2, ten times the cells"] / base, 2.0),
    }
    for name, (value, most) in ratios.items():
        print(f"{name:30s} {value:8.2f}, goal {most:g}: {'met' if value <= most else 'NOT met'}")


if __name__ == "__main__":
    main()
