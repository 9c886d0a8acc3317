"""Skin, stage by stage: `python -m benchmarks.skin [MESH] [--landmarks PICKS.json]`. CPU seconds over all threads, warm.

The counts are those of the thesis: 170,000 follicles, 5,000 cysts, 700 moles, 3,000 freckles, lips, 200 wrinkles; then at
4096^2, with ten times the follicles, and the default skin. Each row in a process of its own, after a bake that warms it.
Goals: 5 CPU-s at 2048^2 without the unwrap, 4.4 times that at 4096^2, 3 times for ten times the follicles.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

MESHES = Path(__file__).resolve().parent.parent / "meshes"
ROWS = {
    "thesis, 2048": ("thesis", 2048, {}),
    "thesis, 4096": ("thesis", 4096, {}),
    "ten times the follicles": ("thesis", 2048, {"follicle_count": 1_700_000}),
    "skin, 2048": ("skin", 2048, {}),
}


def row(mesh: str, landmarks: str, preset: str, side: int, changes: dict) -> None:
    """Bake twice, and print the second as JSON."""
    import surftex as sx
    from surftex.recipe.read import recipe_from_text

    text = f"""
    [fields]
    lips = {{ face = "lips", landmarks = "{landmarks}" }}
    [[layer]]
    material = "skin"
    preset = "{preset}"
    lips_where = "lips"
    wrinkle_count = 200
    """
    text += "\n".join(f"{key} = {value}" for key, value in changes.items())
    recipe = recipe_from_text(text, allow_outside=True)
    surface = sx.load(mesh, size="450 mm")
    maps = ("base_color", "roughness", "normal", "height")
    for _ in range(2):
        baked = sx.bake(surface, recipe, resolution=side, maps=maps)
    report = baked.report
    print("JSON " + json.dumps({key: report[key] for key in ("stages", "features", "texels", "peak_rss_mb")}))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("mesh", nargs="?", default=str(MESHES / "head.ply"))
    parser.add_argument("--landmarks", default=str(MESHES / "head_landmarks.json"))
    parser.add_argument("--row", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.row:
        row(options.mesh, str(Path(options.landmarks).resolve()), *ROWS[options.row])
        return
    first = None
    for name in ROWS:
        command = [
            sys.executable,
            "-m",
            "benchmarks.skin",
            options.mesh,
            "--landmarks",
            options.landmarks,
            "--row",
            name,
        ]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        told = json.loads(next(line for line in done.stdout.splitlines() if line.startswith("JSON "))[5:])
        stages = {stage["name"]: stage["cpu_s"] for stage in told["stages"]}
        total = sum(seconds for stage, seconds in stages.items() if stage != "unwrap")
        first = total if first is None else first
        print(
            f"{name:<24} {total:6.2f} CPU-s without unwrap, {total / first:.2f} times the first "
            f"({', '.join(f'{stage} {seconds:.2f}' for stage, seconds in stages.items())}); {told['texels']:,} texels, "
            f"{told['peak_rss_mb']:.0f} MB; {', '.join(f'{count:,} {kind}' for kind, count in told['features'].items())}",
            flush=True,
        )


if __name__ == "__main__":
    main()
