"""Runs inside Blender's Python: import a GLB and its height, say what came in, draw it by Cycles. No surftex here."""

import json
import sys

import bpy  # pyright: ignore[reportMissingImports]
import numpy as np


def main(glb: str, height: str, still: str) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=glb)
    thing = next(each for each in bpy.context.scene.objects if each.type == "MESH")
    tree = thing.data.materials[0].node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    told = {"size_m": max(thing.dimensions), "images": {}, "normal": None}
    for socket in ("Base Color", "Roughness", "Normal", "Specular IOR Level"):
        links = shader.inputs[socket].links
        node = links[0].from_node if links else None
        while node is not None and node.type != "TEX_IMAGE":
            if node.type == "NORMAL_MAP":
                told["normal"] = [node.space, node.uv_map, node.inputs["Strength"].default_value]
            links = [link for entry in node.inputs for link in entry.links]
            node = links[0].from_node if links else None
        if node is not None:
            image = node.image
            told["images"][socket] = [image.colorspace_settings.name, *image.size, image.depth]
    told["uv"] = [layer.name for layer in thing.data.uv_layers]
    picture = bpy.data.images.load(height)
    values = np.array(picture.pixels[:]).reshape(picture.size[1], picture.size[0], picture.channels)[..., 0]
    told["height"] = [picture.is_float, float(values.min()), float(values.max())]
    thing.data.calc_tangents(uvmap=thing.data.uv_layers[0].name)
    place = np.array([thing.data.vertices[loop.vertex_index].co for loop in thing.data.loops])
    told["tangents"] = np.concatenate(
        [place, [[*loop.tangent, loop.bitangent_sign] for loop in thing.data.loops]], axis=1
    ).tolist()
    draw(thing, still)
    sys.stdout.write("JSON " + json.dumps(told) + "\n")


def draw(thing, still: str) -> None:
    """Light from the side, a camera in front, raw linear numbers."""
    scene = bpy.context.scene
    size = max(thing.dimensions)
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.data.angle, sun.rotation_euler = 3.0, 0.0, (0.9, 0.5, 0.3)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 0.8 * size
    camera.location, camera.rotation_euler = (0, -1.0, 0), (np.pi / 2, 0, 0)
    for each in (sun, camera):
        scene.collection.objects.link(each)
    scene.camera, scene.world = camera, bpy.data.worlds.new("world")
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 32
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.max_bounces = 0
    scene.render.resolution_x = scene.render.resolution_y = 220
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "PNG", "16"
    scene.render.filepath = still
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
