"""Leather, stage by stage: `python -m benchmarks.leather [MESH]`. CPU seconds over all threads, warm.

The mesh is subdivided once; cells, wrinkles and pores are sized so that it holds 5,000 and then 50,000 cells, 30
wrinkles and 50,000 pores. Without a mesh it is the shipped head.
"""

import resource
import sys
import time
from pathlib import Path

import numpy as np

import surftex as sx
from surftex.surface.shapes import midpoint_subdivided
from surftex.surface.surface import Surface

MESHES = Path(__file__).resolve().parent.parent / "meshes"


def sized(surface: Surface, cells: int) -> sx.Leather:
    """Calf whose lengths are scaled so that a surface holds a number of cells."""
    spacing = float(np.sqrt(0.697 * surface.area_mm2 / cells))
    scale = spacing / 0.85
    return sx.Leather.preset(
        "calf", cell_size=spacing, cell_ratio=1.0, crista_height=0.05 * scale, sulcus_depth=0.03 * scale,
        sulcus_width=0.17 * scale, wrinkle_density=0.0, wrinkle_count=30, wrinkle_length=14 * scale,
        wrinkle_width=0.32 * scale, wrinkle_depth=0.04 * scale, wrinkle_taper=5 * scale, pocket_depth=0.0,
        pore_density=50_000 / surface.area_mm2, pore_width=0.1 * scale, grain_size=0.25 * scale,
    )  # fmt: skip


def main() -> None:
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else MESHES / "head.ply"
    coarse = sx.load(path)
    points, faces = midpoint_subdivided(np.array(coarse.vertices), np.array(coarse.faces))
    surface = Surface.from_arrays(points, faces, name=path.stem)
    print(f"{path.name}: {len(faces)} faces")
    for resolution, cells in ((2048, 5_000), (2048, 5_000), (4096, 5_000), (2048, 50_000)):
        began = time.process_time()
        maps = sx.bake(
            surface,
            sized(surface, cells),
            resolution=resolution,
            maps=("base_color", "roughness", "normal", "height"),
        )
        total = time.process_time() - began
        stages = "  ".join(f"{stage['name']} {stage['cpu_s']:.2f}" for stage in maps.report["stages"])
        placed = " ".join(f"{kind} {count}" for kind, count in maps.report["features"].items())
        print(
            f"{resolution}^2, {placed}: {total:.2f} CPU-s in all, unwrap in this process included ({stages})"
        )
    print(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} GB")


if __name__ == "__main__":
    main()
