"""The same relief by Blender: `python -m benchmarks.blender --blender-python PYTHON [MESH] [--resolution 2048] [--threads N]`.

PYTHON is one that has `bpy` (Blender as a module, from PyPI). Cycles bakes a solid's Voronoi distance to the edge as
emission, and its bump as a normal map, onto the same mesh with the same unwrap, one sample a texel, margins by
adjacent faces as Blender makes them by itself; ours bakes calf of as many cells, with furrows, 30 wrinkles and 50,000 pores:
colour, roughness, normal, height. CPU seconds over all threads, unwrap excluded, the least of `RUNS` of each: whatever else
a machine does only adds. Ours is warm, Blender's scene stands before its clock starts. `--threads` holds for both sides;
without it each takes every core. On one thread Blender's own takes as much again for what is not rendering, so the
ratio of each count is a figure of its own.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

MARGIN_PX = 16
CELLS = 5_000
RUNS = 3


def blender(mesh: str, resolution: int, cell_mm: float, threads: int) -> None:
    """Run inside Blender: bake, and print what it took as JSON."""
    import bpy  # pyright: ignore[reportMissingImports]

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.obj_import(filepath=mesh)
    thing = bpy.context.selected_objects[0]
    bpy.context.view_layer.objects.active = thing
    bpy.ops.object.shade_smooth()
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 1
    if threads:
        scene.render.threads_mode, scene.render.threads = "FIXED", threads
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.render.bake.margin, scene.render.bake.margin_type = MARGIN_PX, "ADJACENT_FACES"
    material = bpy.data.materials.new("leather")
    material.use_nodes = True
    thing.data.materials.clear()
    thing.data.materials.append(material)
    nodes, link = material.node_tree.nodes, material.node_tree.links.new
    nodes.clear()
    out, place = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeTexCoord")
    cells, target = nodes.new("ShaderNodeTexVoronoi"), nodes.new("ShaderNodeTexImage")
    cells.feature, cells.inputs["Scale"].default_value = "DISTANCE_TO_EDGE", 1 / cell_mm
    link(place.outputs["Object"], cells.inputs["Vector"])
    nodes.active = target
    took = {"version": bpy.app.version_string}

    def bake(name: str, kind: str, shader: str, value: str) -> None:
        surface = nodes.new(shader)
        if kind == "EMIT":
            link(cells.outputs["Distance"], surface.inputs[value])
        else:
            bump = nodes.new("ShaderNodeBump")
            link(cells.outputs["Distance"], bump.inputs["Height"])
            link(bump.outputs[0], surface.inputs[value])
        link(surface.outputs[0], out.inputs["Surface"])
        target.image = bpy.data.images.new(name, resolution, resolution, float_buffer=True)
        spent = []
        for _ in range(RUNS):
            began = time.process_time()
            bpy.ops.object.bake(type=kind)
            spent.append(time.process_time() - began)
        took[name] = min(spent)

    bake("emission", "EMIT", "ShaderNodeEmission", "Color")
    bake("normal", "NORMAL", "ShaderNodeBsdfPrincipled", "Normal")
    print("JSON " + json.dumps(took))


def write_obj(path: Path, surface, corner_uv) -> None:
    """Write the mesh with the unwrap that ours is baked with."""
    rows = [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in surface.vertices]
    rows += [f"vt {u:.7g} {v:.7g}" for u, v in corner_uv.reshape(-1, 2)]
    rows += [
        "f " + " ".join(f"{vertex + 1}/{3 * i + k + 1}" for k, vertex in enumerate(face))
        for i, face in enumerate(surface.faces)
    ]
    path.write_text("\n".join(rows) + "\n")


def _without_unwrap(stages: dict[str, float]) -> float:
    return sum(seconds for name, seconds in stages.items() if name != "unwrap")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("mesh", nargs="?")
    parser.add_argument("--blender-python", required=True)
    parser.add_argument("--resolution", type=int, default=2048)
    parser.add_argument("--threads", type=int)
    options = parser.parse_args()
    import numpy as np

    import surftex as sx
    from benchmarks.leather import MESHES, sized
    from surftex.surface.shapes import midpoint_subdivided
    from surftex.surface.surface import Surface

    coarse = sx.load(options.mesh or MESHES / "head.ply")
    points, faces = midpoint_subdivided(np.array(coarse.vertices), np.array(coarse.faces))
    surface = Surface.from_arrays(points, faces, name="head")
    leather = sized(surface, CELLS)
    maps = ("base_color", "roughness", "normal", "height")
    runs = []
    for _ in range(1 + RUNS):
        baked = sx.bake(
            surface,
            leather,
            resolution=options.resolution,
            maps=maps,
            gutter=MARGIN_PX,
            threads=options.threads,
        )
        runs.append({stage["name"]: stage["cpu_s"] for stage in baked.report["stages"]})
    stages = min(runs[1:], key=_without_unwrap)
    ours = _without_unwrap(stages)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mesh.obj"
        write_obj(path, surface, baked.atlas.corner_uv)
        wanted = options.resolution, leather.cell_size, options.threads or 0
        child = [options.blender_python, __file__, str(path), *map(str, wanted)]
        done = subprocess.run(child, capture_output=True, text=True, check=True)
    theirs = json.loads(next(line for line in done.stdout.splitlines() if line.startswith("JSON "))[5:])
    total = theirs["emission"] + theirs["normal"]
    print(
        f"{len(faces)} faces, {options.resolution}^2, {len(baked.features['cell'])} cells, {baked.report['texels']} texels"
    )
    print(
        f"surftex       {ours:6.2f} CPU-s ({', '.join(f'{name} {seconds:.2f}' for name, seconds in stages.items())})"
    )
    print(
        f"Blender {theirs['version']} {total:6.2f} CPU-s (emission {theirs['emission']:.2f}, normal {theirs['normal']:.2f})"
    )
    print(f"ratio {total / ours:.2f}")


if __name__ == "__main__":
    if len(sys.argv) == 5 and sys.argv[1].endswith(".obj") and sys.argv[2].isdecimal():
        blender(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4]))
    else:
        main()
