"""Maps for the eye: a contact sheet, and meshes that carry their textures, for notebooks."""

import base64
import html
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.files.images import normal_codes, png_bytes, srgb_codes, unit_codes
from surftex.surface.weld import equal_rows

if TYPE_CHECKING:
    from surftex.maps.mapset import MapSet

_THUMBNAIL = 192


class TexturedMesh(NamedTuple):
    """A baked surface for other libraries; millimetres, origin added.

    Attributes
    ----------
    polydata : pyvista.PolyData
        With texture coordinates, and point normals.
    texture : pyvista.Texture or None
        Base colour.
    trimesh : trimesh.Trimesh
        With a PBR material.
    """

    polydata: Any
    texture: Any
    trimesh: Any


def textured_mesh(maps: "MapSet") -> TexturedMesh:
    """Make meshes with their textures.

    Parameters
    ----------
    maps : MapSet
        What a bake gave.

    Returns
    -------
    meshes : TexturedMesh
        For pyvista and trimesh.
    """
    import pyvista
    import trimesh
    from PIL import Image
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    surface = maps.surface
    corner = np.concatenate(
        [(surface.vertices + surface.origin_mm)[surface.faces], surface.shading_normal, maps.atlas.corner_uv],
        axis=2,
    ).reshape(-1, 8)
    number = equal_rows(corner)
    first = np.unique(number, return_index=True)[1]
    vertex, faces = corner[first], number.reshape(-1, 3)
    polydata = pyvista.PolyData.from_regular_faces(vertex[:, :3], faces)
    polydata.point_data["Normals"] = vertex[:, 3:6]
    polydata.point_data.active_normals_name = "Normals"
    polydata.active_texture_coordinates = vertex[:, 6:]
    if any("." in name for name in maps):
        raise InputError(f"{maps.stem} lies on several tiles; save it, and load its GLB")
    pictures = {name: picture_codes(name, maps[name]) for name in maps if name in ("base_color", "normal")}
    if "roughness" in maps:
        rough = unit_codes(maps["roughness"])
        metal = unit_codes(maps["metallic"]) if "metallic" in maps else np.zeros_like(rough)
        pictures["rough"] = np.stack([np.full_like(rough, 255), rough, metal], axis=2)
    opened = {name: Image.fromarray(codes) for name, codes in pictures.items()}
    material = PBRMaterial(
        name=maps.stem,
        baseColorTexture=opened.get("base_color"),
        normalTexture=opened.get("normal"),
        metallicRoughnessTexture=opened.get("rough"),
        metallicFactor=1.0 if "metallic" in maps else 0.0,
        roughnessFactor=1.0 if "rough" in opened else 0.6,
    )
    mesh = trimesh.Trimesh(vertex[:, :3], faces, vertex_normals=vertex[:, 3:6], process=False)
    mesh.visual = TextureVisuals(uv=vertex[:, 6:], material=material)
    texture = pyvista.Texture(pictures["base_color"]) if "base_color" in pictures else None
    return TexturedMesh(polydata, texture, mesh)


def picture_codes(name: str, image: NDArray[Any]) -> NDArray[np.uint8]:
    """Make a map visible on a screen.

    Parameters
    ----------
    name : str
        Of the map.
    image : (h, w) or (h, w, 3) array
        Its values.

    Returns
    -------
    codes : (h, w) or (h, w, 3) uint8
        Numbers without a known range are stretched from black to white; regions get colours of their own.
    """
    if name == "base_color":
        return srgb_codes(image)
    if name == "normal":
        return (normal_codes(image) >> 8).astype(np.uint8)
    if name == "region":
        mixed = (image[..., None].astype(np.uint32) + 1) * np.array(
            [2654435761, 2246822519, 3266489917], np.uint32
        )
        return np.where(image[..., None] < 0, 0, 64 + (mixed >> 25)).astype(np.uint8)
    if name in ("roughness", "specular", "metallic", "ambient_occlusion"):
        return unit_codes(image)
    low, high = float(image.min()), float(image.max())
    return unit_codes((image - low) / (high - low if high > low else 1.0))


def contact_sheet(maps: "MapSet") -> str:
    """Show small pictures of all maps.

    Parameters
    ----------
    maps : MapSet
        What a bake gave.

    Returns
    -------
    page : str
        HTML that needs nothing else.
    """
    cells = []
    for name, image in maps.items():
        step = max(1, -(-max(image.shape[:2]) // _THUMBNAIL))
        data = base64.b64encode(
            png_bytes(picture_codes(name.partition(".")[0], image[::step, ::step]))
        ).decode()
        label = f"{name} {image.min():.3g} to {image.max():.3g}"
        cells.append(
            f'<figure style="display:inline-block;margin:4px;text-align:center;font-size:12px">'
            f'<img width="{_THUMBNAIL}" alt="{name}" src="data:image/png;base64,{data}">'
            f"<figcaption>{html.escape(label)}</figcaption></figure>"
        )
    return f"<div><b>{html.escape(maps.stem)}</b><br>{''.join(cells)}</div>"
