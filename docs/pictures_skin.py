"""Makes the pictures of skin: `python -m docs.pictures_skin [NAME ...]`, in docs/pictures. Docstrings are captions.

All use the recipe meshes/head_skin.toml; on heads of others its landmarks are those of docs/landmarks.
"""

import os
import sys
import time
from functools import cache
from pathlib import Path

import numpy as np

import surftex as sx
from docs.make_pictures import HERE, MESHES, save
from surftex.bake.fields import make_fields
from surftex.files.meshes import load
from surftex.preview.render import render
from surftex.preview.sheet import contact_sheet
from surftex.recipe.compose import composed
from surftex.recipe.read import recipe_from_text

REAL = Path(os.environ.get("SURFTEX_SHARED", HERE.parent.parent / "shared")) / "meshes"
RECIPE = MESHES / "head_skin.toml"
HEADS = {
    "head_lee_perry_smith": ("head_lee_perry_smith.ply", {"units": "m"}),
    "bust_demosthenes": ("bust_demosthenes.off", {"size": "600 mm"}),
    "face_ict_neutral": ("face_ict_neutral.obj", {"units": "cm", "part": "M_Face"}),
}


def recipe_on(name, **changes):
    """The recipe with the landmarks of a head."""
    text = RECIPE.read_text("utf-8").replace("head_landmarks.json", str(HERE / "landmarks" / f"{name}.json"))
    lines = [f"{key}={value}" for key, value in changes.items()]
    return recipe_from_text(text, name=RECIPE.name, folder=MESHES, allow_outside=True, changes=lines)


@cache
def baked(name, resolution=4096):
    """Skin on the head of a name; on ours, without other meshes."""
    if not REAL.is_dir():
        return sx.bake(load(MESHES / "head.ply", units="mm"), sx.Recipe.load(RECIPE), resolution=resolution)
    file, scale = HEADS[name]
    recipe = composed(recipe_on(name), REAL / file, scale, resolution=resolution)
    return sx.bake(recipe)


def scan(resolution=4096):
    return baked("head_lee_perry_smith", resolution)


def skin_fields():
    """Fig. 6: likelihood on a scanned head (Lee Perry-Smith, Infinite-Realities, CC BY 3.0): lips, freckles, hair, oil."""
    surface = scan().surface
    fields = make_fields(recipe_on("head_lee_perry_smith"), surface)
    pictures, labels = [], []
    for label, text in {
        "lips": "lips",
        "freckles": "clamp(cheeks + nose, 0, 1) * (1 - lips)",
        "hair": "beard",
        "oil": "0.5 + 0.5 * oily",
    }.items():
        field = fields.scalar(text)
        shade = 0.15 + 0.85 * field(corners(surface)).reshape(-1, 3)
        maps = shaded(surface, shade)
        pictures.append(maps)
        labels.append(label)
    save(contact_sheet(pictures, labels, columns=4), "skin-fields")


def corners(surface):
    from surftex.surface.points import SurfacePoints

    count = len(surface.faces)
    near = np.full((3, 3), 1e-4) + np.eye(3) * (1 - 3e-4)
    return SurfacePoints.trusted(np.repeat(np.arange(count, dtype=np.int32), 3), np.tile(near, (count, 1)))


def shaded(surface, value):
    """A grey picture of a field, seen from the front."""
    from surftex.preview.camera import camera_for
    from surftex.preview.render import _visible

    size = (420, 420)
    vertices = surface.vertices + surface.origin_mm
    camera = camera_for(vertices, size, view="front", zoom=1.9, target=eyes(surface), up="y")
    face, weight = _visible(camera.project(vertices)[surface.faces], size)
    seen = face >= 0
    picture = np.full((*face.shape, 3), 235, np.uint8)
    lit = 0.35 + 0.65 * np.clip(surface.frame[face[seen], 2] @ camera.axes[2], 0, 1)
    level = np.einsum("nk,nk->n", weight[seen], value[face[seen]]) * lit
    picture[seen] = (255 * np.clip(level, 0, 1) ** 0.8).astype(np.uint8)[:, None]
    return picture


def eyes(surface):
    """Middle of the face of the scanned head, or of ours."""
    from surftex.files.strokes import read_strokes

    path = (
        HERE / "landmarks" / "head_lee_perry_smith.json" if REAL.is_dir() else MESHES / "head_landmarks.json"
    )
    points = read_strokes(path, surface).points
    return points["nose_tip"].positions(surface)[0] + surface.origin_mm


def skin_relief():
    """Fig. 7: relief alone, close up, under raking light: furrows, pores, a smile line."""
    maps = scan()
    bare = sx.MapSet(
        {**maps.maps, "base_color": np.full_like(maps["base_color"], 0.45)},
        maps.surface,
        maps.atlas,
        maps.tangents,
    )
    at = eyes(maps.surface)
    save(
        render(
            bare,
            size=(900, 700),
            view=(40.0, 2.0),
            zoom=8.0,
            target=at + np.array([25, -12, -20]),
            light="raking",
        ),
        "skin-relief",
    )


def skin_face():
    """Fig. 8 and 9: the full face."""
    maps = scan()
    at = eyes(maps.surface)
    views = [((0.0, 4.0), 2.0), ((45.0, 4.0), 2.0)]
    pictures = [
        render(
            maps, size=(620, 700), view=view, zoom=zoom, target=at + np.array([0, 0, -40]), light="portrait"
        )
        for view, zoom in views
    ]
    save(np.concatenate(pictures, axis=1), "skin-face")


def skin_chin():
    """Fig. 10: mouth and chin close up: stubble, pores, lips."""
    maps = scan()
    at = eyes(maps.surface)
    save(
        render(
            maps,
            size=(900, 700),
            view=(25.0, 0.0),
            zoom=9.0,
            target=at + np.array([12, -48, -15]),
            light="portrait",
        ),
        "skin-chin",
    )


def skin_heads():
    """The same recipe on two other heads: Demosthenes (ryanfb, CC BY 4.0) and a neutral face (USC ICT, MIT)."""
    pictures = []
    for name, view in (("bust_demosthenes", (10.0, 2.0)), ("face_ict_neutral", (30.0, 4.0))):
        maps = baked(name)
        pictures.append(render(maps, size=(620, 640), view=view, zoom=1.6, light="portrait"))
    save(np.concatenate(pictures, axis=1), "skin-heads")


PICTURES = {
    made.__name__.replace("_", "-"): made
    for made in (skin_fields, skin_relief, skin_face, skin_chin, skin_heads)
}

if __name__ == "__main__":
    for name in sys.argv[1:] or PICTURES:
        if not REAL.is_dir() and name == "skin-heads":
            print(f"{name}: left out; SURFTEX_SHARED names no folder with real meshes")
            continue
        began = time.perf_counter()
        PICTURES[name]()
        print(f"{name}: {time.perf_counter() - began:.0f} s", flush=True)
