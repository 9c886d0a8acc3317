"""Run by a Python that has bpy: Blender's own MikkTSpace tangents of the mesh in an npz, into another."""

import sys

import bpy
import numpy as np


def main(source: str, target: str) -> None:
    given = np.load(source)
    vertices, faces = np.unique(given["position"].reshape(-1, 3), axis=0, return_inverse=True)
    faces = faces.ravel()
    mesh = bpy.data.meshes.new("mesh")
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", vertices.astype(np.float32).ravel())
    mesh.loops.add(len(faces))
    mesh.loops.foreach_set("vertex_index", faces.astype(np.int32))
    mesh.polygons.add(len(faces) // 3)
    mesh.polygons.foreach_set("loop_start", np.arange(0, len(faces), 3, dtype=np.int32))
    mesh.update()
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", given["uv"].astype(np.float32).ravel())
    mesh.polygons.foreach_set("use_smooth", np.ones(len(faces) // 3, bool))
    mesh.normals_split_custom_set(given["normal"].reshape(-1, 3).tolist())
    mesh.calc_tangents(uvmap="UVMap")
    tangent, normal = np.zeros(3 * len(faces), np.float32), np.zeros(3 * len(faces), np.float32)
    sign = np.zeros(len(faces), np.float32)
    mesh.loops.foreach_get("tangent", tangent)
    mesh.loops.foreach_get("normal", normal)
    mesh.loops.foreach_get("bitangent_sign", sign)
    shape = given["position"].shape
    np.savez(target, tangent=tangent.reshape(shape), normal=normal.reshape(shape), sign=sign.reshape(-1, 3))


main(*sys.argv[1:])
