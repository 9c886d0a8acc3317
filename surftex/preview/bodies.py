"""What can be drawn, as bodies: files, surfaces, bakes and plain arrays; and materials as a shader reads them."""

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.files.scene import Body, read_scene
from surftex.maps.mapset import MapSet
from surftex.preview.texture import Pyramid, linear_light
from surftex.surface.surface import Surface
from surftex.words import sort_of

PLAIN = {
    "base_color": np.array([0.42, 0.41, 0.40]),
    "roughness": 0.55,
    "metallic": 0.0,
    "specular": np.ones(3),
}
"""Clay: how a mesh without material looks."""

CHANNELS = 13
"""Base colour 3, occlusion, roughness, metallic, F0 3, normal 3 and its length in each texel of a material."""


def bodies_of(subject: Any) -> list[Body]:
    """Turn a subject into bodies.

    Parameters
    ----------
    subject : path, MapSet, Surface, (vertices, faces) or list of Body
        GLB and glTF files come with their materials; other meshes look like clay; bodies are handed back.

    Returns
    -------
    bodies : list of Body
        In millimetres.

    Raises
    ------
    InputError
        If it is none of these.
    """
    if isinstance(subject, (str, os.PathLike)):
        if str(subject).lower().endswith((".glb", ".gltf")):
            return read_scene(subject)
        from surftex.files.meshes import load

        return [_clay(load(subject))]
    if isinstance(subject, list) and subject and all(isinstance(each, Body) for each in subject):
        return subject
    if isinstance(subject, MapSet):
        return [_baked(subject)]
    if isinstance(subject, Surface):
        return [_clay(subject)]
    if isinstance(subject, (tuple, list)) and len(subject) == 2:
        return [_clay(Surface.from_arrays(*subject))]
    raise InputError(f"cannot draw {sort_of(subject)}; give a path, a MapSet, a Surface or (vertices, faces)")


def _clay(surface: Surface) -> Body:
    corner = surface.vertices[surface.faces].reshape(-1, 3) + surface.origin_mm
    faces = np.arange(len(corner), dtype=np.int32).reshape(-1, 3)
    normals = surface.shading_normal.reshape(-1, 3)
    return Body(corner, faces, normals, None, None, "clay", dict(PLAIN), {})


def _baked(maps: MapSet) -> Body:
    """Use the maps as they are: more exact than the files, for they are not yet codes."""
    if any("." in name for name in maps):
        raise InputError(f"{maps.stem} lies on several tiles; save it, and draw its GLB")
    plain = _clay(maps.surface)
    size = next(iter(maps.values())).shape[:2]
    image = np.zeros((*size, CHANNELS), np.float32)
    image[..., :3] = maps["base_color"] if "base_color" in maps else PLAIN["base_color"]
    image[..., 3] = maps.get("ambient_occlusion", 1.0)
    image[..., 4] = maps["roughness"] if "roughness" in maps else PLAIN["roughness"]
    image[..., 5] = maps.get("metallic", 0.0)
    image[..., 6:9] = (
        0.08 * (maps["specular"] if "specular" in maps else np.full(size, 0.5, np.float32))[..., None]
    )
    image[..., 9:12] = maps["normal"] if "normal" in maps else np.array([0, 0, 1.0])
    image[..., 12] = 1.0
    uv = maps.atlas.corner_uv.reshape(-1, 2) * [1.0, -1.0] + [0.0, 1.0]
    return Body(
        plain.vertices,
        plain.faces,
        plain.normals,
        maps.tangents.reshape(-1, 4),
        uv,
        maps.stem,
        {**PLAIN, "pyramid": Pyramid(image)},
        {},
    )


def pyramid_of(body: Body) -> Pyramid | None:
    """Lay the pictures of a material into one, in linear numbers.

    Parameters
    ----------
    body : Body
        With pictures, or without.

    Returns
    -------
    pyramid : Pyramid or None
        Of `CHANNELS`; None if the body has no pictures or no unwrap.
    """
    if "pyramid" in body.factors:
        return body.factors["pyramid"]
    if not body.pictures or body.uv is None:
        return None
    sizes = [image.shape[:2] for image in body.pictures.values()]
    size = max(sizes, key=lambda s: s[0] * s[1])
    image = np.zeros((*size, CHANNELS), np.float32)
    image[...] = factors_of(body)

    def fitted(role: str) -> NDArray[Any] | None:
        picture = body.pictures.get(role)
        if picture is None or picture.shape[:2] == size:
            return picture
        rows = np.arange(size[0]) * picture.shape[0] // size[0]
        columns = np.arange(size[1]) * picture.shape[1] // size[1]
        return picture[rows][:, columns]

    if (base := fitted("base_color")) is not None:
        image[..., :3] *= linear_light(base)
    if (orm := fitted("orm")) is not None:
        share = orm.astype(np.float32) / np.iinfo(orm.dtype).max
        if body.factors.get("occluded"):
            image[..., 3] = share[..., 0]
        image[..., 4] *= share[..., 1]
        image[..., 5] *= share[..., 2]
    if (shine := fitted("specular")) is not None:
        image[..., 6:9] *= linear_light(shine)
    if (normal := fitted("normal")) is not None:
        vector = normal.astype(np.float32) * (2 / np.iinfo(normal.dtype).max) - 1
        image[..., 9:12] = vector / np.maximum(np.linalg.norm(vector, axis=2, keepdims=True), 1e-6)
    pyramid = Pyramid(image)
    body.factors["pyramid"] = pyramid
    return pyramid


def factors_of(body: Body) -> NDArray[np.float32]:
    """Give the material without its pictures.

    Parameters
    ----------
    body : Body
        With factors.

    Returns
    -------
    values : (CHANNELS,) float32
        As in a texel.
    """
    factors = body.factors
    shine = 0.04 * np.asarray(factors["specular"], float)
    parts = [factors["base_color"], [1.0, factors["roughness"], factors["metallic"]], shine, [0, 0, 1.0, 1.0]]
    return np.concatenate([np.asarray(part, np.float32) for part in parts]).astype(np.float32)
