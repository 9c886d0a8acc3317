"""From a mesh to a picture by Cycles, without a window: `python examples/blender_round_trip.py MESH MATERIAL PICTURE.png`.

surftex bakes; a Python that has `bpy` (Blender as a module, from PyPI) takes the GLB, adds the height map as displacement
in true millimetres, and renders. `BLENDER_PYTHON` names that Python where it is another than this one.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path


def baked(mesh: str, material: str, folder: Path) -> Path:
    """Bake by the command; the GLB."""
    command = ["surftex", "bake", mesh, "--material", material, "--out", str(folder), "--resolution", "1024"]
    subprocess.run([*command, *os.environ.get("BAKE_OPTIONS", "").split()], check=True)
    return next(folder.glob("*.glb"))


def rendered(glb: Path, picture: Path) -> None:
    """Run inside Blender: load, displace, light, look, render."""
    import bpy  # pyright: ignore[reportMissingImports]
    from mathutils import Vector  # pyright: ignore[reportMissingImports]

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(glb))
    scene = bpy.context.scene
    thing = next(part for part in scene.objects if part.type == "MESH")
    height = json.loads((glb.parent / "report.json").read_text("utf-8"))["outputs"]
    file = next(name for name in height if name.endswith("_height.exr"))
    for slot in thing.material_slots:
        nodes, link = slot.material.node_tree.nodes, slot.material.node_tree.links.new
        texture, displace = nodes.new("ShaderNodeTexImage"), nodes.new("ShaderNodeDisplacement")
        texture.image = bpy.data.images.load(str(glb.parent / file))
        texture.image.colorspace_settings.name = "Non-Color"
        displace.inputs["Midlevel"].default_value = 0.0
        displace.inputs["Scale"].default_value = 0.001  # the map is in millimetres, the scene in metres
        link(texture.outputs["Color"], displace.inputs["Height"])
        link(displace.outputs[0], nodes["Material Output"].inputs["Displacement"])
    corners = [thing.matrix_world @ Vector(corner) for corner in thing.bound_box]
    middle = sum(corners, Vector()) / 8
    size = max((corner - middle).length for corner in corners)
    for place, power in (((-2, -2, 2), 1.0), ((2, -1, 0.5), 0.25)):
        lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "AREA"))
        lamp.data.energy, lamp.data.size = 120 * power * size**2, size
        lamp.location = middle + size * Vector(place)
        lamp.rotation_euler = (middle - lamp.location).to_track_quat("-Z", "Y").to_euler()
        scene.collection.objects.link(lamp)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = middle + size * Vector((-1.2, -3.0, 1.0))
    camera.rotation_euler = (middle - camera.location).to_track_quat("-Z", "Y").to_euler()
    camera.data.clip_start, camera.data.clip_end = size / 1000, size * 100
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 16
    scene.render.resolution_x, scene.render.resolution_y = 640, 480
    scene.render.filepath = str(picture.resolve())
    bpy.ops.render.render(write_still=True)


def main() -> None:
    """Bake here, render there."""
    if sys.argv[1] == "--render":
        rendered(Path(sys.argv[2]), Path(sys.argv[3]))
        return
    mesh, material, picture = sys.argv[1:4]
    with tempfile.TemporaryDirectory() as folder:
        glb = baked(mesh, material, Path(folder) / "out")
        python = os.environ.get("BLENDER_PYTHON", sys.executable)
        subprocess.run([python, __file__, "--render", str(glb), picture], check=True)
    print(picture)


if __name__ == "__main__":
    main()
