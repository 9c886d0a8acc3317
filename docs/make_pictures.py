"""Makes the pictures of hides, and of hides on meshes: `python -m docs.make_pictures [NAME ...]`.

Pictures go to docs/pictures, as JPEG, and stand in docs/gallery.md. Each is one function; its docstring says what
it shows. Some need meshes that are not shipped: they are looked for in the folder that SURFTEX_SHARED names, else
in `../shared`, and skipped with a line where they are missing.
"""

import os
import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image

import surftex as sx
from surftex.files.meshes import load
from surftex.preview.render import render
from surftex.preview.sheet import contact_sheet
from surftex.preview.studio import SoftBox, Studio
from surftex.surface.closest import closest_points
from surftex.surface.shapes import plane
from surftex.surface.surface import Surface

HERE = Path(__file__).resolve().parent
MESHES = HERE.parent / "meshes"
SHARED = Path(os.environ.get("SURFTEX_SHARED", HERE.parent.parent / "shared")) / "meshes"
HIDES = {
    "calf": 16, "cattle-pebbled": 40, "goat": 24, "pig": 20, "ostrich": 50, "crocodile": 120, "lizard": 24,
    "stingray": 18, "car-interior": 20,
}  # fmt: skip
"""Side of the sheet, in mm, that shows each hide."""
WIDEST = 1400
"""Pixels across, of any picture."""
LARGEST = 250_000
"""Bytes of a picture, beyond which it is kept with less quality."""
LARGE_GOAT = {
    "cell_size": "3 mm", "crista_height": "0.4 mm", "sulcus_width": "0.42 mm", "sulcus_depth": "0.15 mm",
    "grain_height": "0.055 mm", "grain_size": "0.75 mm", "pocket_width": "0.6 mm", "pocket_depth": "0.05 mm",
    "pore_density": 0.3, "pore_width": "0.27 mm", "pore_depth": "0.12 mm", "pore_spread": "0.55 mm",
}  # fmt: skip
"""Goat whose cells can be seen on a thing of half a metre: all of it 2.5 times as large, not its cells alone."""


SHOP = Studio(
    (
        SoftBox((-0.75, 0.95, 0.55), (0.55, 0.5), 0.9, (1.0, 0.97, 0.93), 36),
        SoftBox((1.0, 0.3, 0.2), (0.2, 0.9), 0.3, (0.95, 0.97, 1.0), 16),
        SoftBox((0.45, 0.55, -0.9), (0.35, 0.8), 0.85, (1.0, 1.0, 1.0), 25),
    ),
    above=0.24,
    below=0.10,
    exposure=1.05,
)
"""Softer than "studio", with more of a rim from behind."""


class MissingMeshError(Exception):
    """A mesh that is not shipped is not there."""


def save(picture, name, *, exact=False):
    """Write a JPEG, no wider than WIDEST; `exact`: plain fields of colour, which must come out as they are."""
    image = Image.fromarray(np.asarray(picture))
    if image.width > WIDEST:
        image = image.resize((WIDEST, round(image.height * WIDEST / image.width)), Image.Resampling.LANCZOS)
    path = HERE / "pictures" / f"{name}.jpg"
    if exact:
        image.save(path, optimize=True, quality=97, subsampling=0)
        return
    for quality in range(86, 50, -4):
        image.save(path, optimize=True, quality=quality)
        if path.stat().st_size <= LARGEST:
            break


def shared(name):
    """Find a mesh that is not shipped."""
    path = SHARED / name
    if not path.exists():
        raise MissingMeshError(f"{path} is not there; SURFTEX_SHARED names the folder that holds meshes/")
    return path


def sheet_of(material, side_mm, *, size=420, seed=7, light="raking"):
    """Bake a flat sheet, and draw the middle of it, as wide as told."""
    maps = sx.bake(plane(1.25 * side_mm, cells=24), material, resolution=1024, seed=seed)
    return render(maps, size=(size, size), view="front", light=light, zoom=1.5, floor=False)


def towards(surface, place):
    """Azimuth and elevation, in degrees, from which a place is seen from straight in front."""
    point, _ = closest_points(surface, np.array([place], float))
    x, y, z = (surface.vertex_normal[surface.faces[point.face[0]]] * point.barycentric[0][:, None]).sum(
        axis=0
    )
    return float(np.degrees(np.arctan2(x, z))), float(np.clip(np.degrees(np.arcsin(y)), -80, 80))


def seam_at(maps, place):
    """Middle of the edge nearest to a place along which the unwrap is cut though the surface is smooth, in mm."""
    surface = maps.surface
    face, edge = np.nonzero(maps.atlas.seam & (surface.neighbor >= 0))
    normal = surface.frame[:, 2]
    smooth = (normal[face] * normal[surface.neighbor[face, edge]]).sum(axis=1) > 0.95
    face, edge = face[smooth], edge[smooth]
    ends = surface.faces[face, edge], surface.faces[face, (edge + 1) % 3]
    middle = surface.vertices[np.stack(ends)].mean(axis=0)
    return middle[np.argmin(np.linalg.norm(middle - np.asarray(place), axis=1))]


def three_scales(
    surface, material, near, seam, name, *, resolution=4096, far=None, zooms=(5.0, 9.0), beside=None
):
    """Bake, and draw from far, near, and at the cut of the unwrap that is nearest to a place."""
    maps = sx.bake(
        surface, material, resolution=resolution, seed=7, maps=("base_color", "roughness", "normal", "height")
    )
    size = (560, 480)
    point, _ = closest_points(surface, np.array([near], float))
    near, cut = point.positions(surface)[0], seam_at(maps, seam)
    pictures = [render(maps, size=size, **(far or {}))]
    for place, zoom in zip((near, cut), zooms, strict=True):
        seen = {
            "view": beside or towards(surface, place),
            "target": place + surface.origin_mm,
            "zoom": zoom,
        }
        pictures.append(render(maps, size=size, floor=False, **seen))
    save(contact_sheet(pictures, ["far", "near", "across a seam of the unwrap"], columns=3), name)


def hides():
    """The nine hides, each on a flat sheet under raking light; the side of the sheet in mm is in the label."""
    pictures = [sheet_of(sx.Leather.preset(name), side) for name, side in HIDES.items()]
    save(contact_sheet(pictures, [f"{name}, {side} mm" for name, side in HIDES.items()], columns=3), "hides")


def helmet():
    """The nine hides on the leather of a flying helmet: as a whole, and its crown near; small for those of fine grain."""
    pictures = []
    for name in HIDES:
        size = "340 mm" if name in ("cattle-pebbled", "ostrich", "crocodile") else "170 mm"
        surface = load(shared("helmet_flight_leather.glb"), part="LeatherPartsMat", size=size)
        low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
        point, _ = closest_points(surface, [0.5 * (low + high) + np.array([0.15, 0.45, 0.2]) * (high - low)])
        crown = point.positions(surface)[0]
        maps = sx.bake(surface, sx.Leather.preset(name), resolution=2048, seed=7)
        far = render(maps, size=(230, 230))
        seen = {"view": towards(surface, crown), "target": crown + surface.origin_mm, "zoom": 4.0}
        pictures.append(np.concatenate([far, render(maps, size=(230, 230), floor=False, **seen)], axis=1))
    save(contact_sheet(pictures, list(HIDES), columns=3), "helmet")


def shoe():
    """A real shoe in pebbled cattle: far, the toe cap, and across a seam of its own unwrap."""
    surface = load(shared("shoe_variants.glb"))
    three_scales(surface, sx.Leather.preset("cattle-pebbled"), (110, -10, 25), (0, 10, 50), "shoe")


def chair():
    """The velvet of a real chair becomes pebbled hide of 4 mm; its other parts are left out."""
    surface = load(shared("chair_sheen.glb"), part="fabric Mystere Mango Velvet")
    material = sx.Leather.preset(
        "cattle-pebbled", cell_size="4 mm", crista_height="0.5 mm", sulcus_width="0.55 mm"
    )
    three_scales(surface, material, (200, 100, 200), (0, 0, 200), "chair", zooms=(6.0, 12.0))


def real_head():
    """A scanned head in goat of 3 mm, so that cells can be seen: far, the ear, and across a seam."""
    surface = load(shared("head_lee_perry_smith.ply"), units="m")
    ear, cheek = (84.0, 36.0, 22.0), (40.0, 10.0, 75.0)
    three_scales(
        surface,
        sx.Leather.preset("goat", **LARGE_GOAT),
        ear,
        cheek,
        "real-head",
        far={"view": "front"},
        zooms=(5.0, 9.0),
    )


def bellows():
    """The nine pleats of an old camera's bellows, in goat of 3 mm, at 1.5 m for the camera with its tripod."""
    whole = load(shared("camera_antique.glb"), size="1500 mm")
    count = np.bincount(whole.component)
    kept = np.isin(count[whole.component], (136, 148))
    surface = Surface.from_arrays(whole.vertices, whole.faces[kept], name="bellows")
    seen = surface.vertices[np.unique(surface.faces)]
    low, high = seen.min(axis=0), seen.max(axis=0)
    side = np.array([high[0], (low[1] + high[1]) / 2, (low[2] + high[2]) / 2])
    hide = sx.Leather.preset("goat", **LARGE_GOAT)
    three_scales(surface, hide, side, side, "bellows", zooms=(3.0, 7.0), beside=(60.0, 20.0))


def front():
    """The shipped shoe as its recipe has it, calf, rubber and laces; where the foot bends, and the grain nearer still."""
    maps = sx.bake(
        load(MESHES / "shoe.obj", units="mm"), str(MESHES / "shoe_calf.toml"), resolution=4096, seed=7,
        maps=("base_color", "roughness", "specular", "normal", "height"),
    )  # fmt: skip
    whole = render(maps, size=(900, 620), view=(40, 22), light=SHOP, zoom=1.05)
    vamp, cap = np.array([0.0, 73.0, 57.0]), np.array([26.0, 52.0, 92.0])
    near = render(maps, size=(484, 304), view=(18, 52), target=vamp, light=SHOP, zoom=4.2, floor=False)
    grain = render(
        maps,
        size=(484, 304),
        view=towards(maps.surface, cap - maps.surface.origin_mm),
        target=cap,
        light="raking",
        zoom=12,
        floor=False,
    )
    right = np.concatenate([near, np.full((12, 484, 3), 255, np.uint8), grain])
    save(np.concatenate([whole, np.full((620, 12, 3), 255, np.uint8), right], axis=1), "front")


def bags():
    """The bag in ostrich, in crocodile, and in crocodile that passes from belly to flank: far, near, and across a seam."""
    surface = load(MESHES / "handbag.obj", units="mm")
    graded = str(MESHES / "handbag_crocodile.toml")
    for hide, name in (
        ("ostrich", "bag-ostrich"),
        ("crocodile", "bag-crocodile"),
        (graded, "bag-crocodile-graded"),
    ):
        near = (100, -40, 50) if hide == graded else (0, 0, 61)
        three_scales(surface, hide, near, (149, 0, 0), name, resolution=2048, zooms=(3.0, 6.0))


def strap():
    """A watch strap in stingray with the row of large pearls along its middle: far, near, and across a seam."""
    surface = load(MESHES / "watch_strap.obj", units="mm", part="leather")
    recipe = str(MESHES / "watch_strap_stingray.toml")
    place = (35, 0, 0)
    three_scales(surface, recipe, place, place, "strap-stingray", zooms=(3.0, 6.0))


def skin_colours():
    """Skin by its biology: the six types beside what was measured, moods of the blood, melanin against blood."""
    from PIL import ImageDraw, ImageFont

    from surftex.optics import lookup, skin_types
    from surftex.optics.spectra import rgb_weights

    def strip(colors, text, side):
        codes = np.clip(colors, 0, 1)
        codes = np.where(codes < 0.0031308, 12.92 * codes, 1.055 * codes ** (1 / 2.4) - 0.055)
        cells = np.repeat(np.repeat(np.round(255 * codes).astype(np.uint8), side, 0), side, 1)
        image = Image.new("RGB", (cells.shape[1], cells.shape[0] + 24), "#ffffff")
        image.paste(Image.fromarray(cells), (0, 24))
        ImageDraw.Draw(image).text((4, 5), text, fill="#222222", font=ImageFont.load_default(13))
        return np.asarray(image)

    types, surface = skin_types().values(), 0.0415
    measured = np.array([each.reflectance @ rgb_weights(each.nm) for each in types])
    rows = [np.stack([measured, np.array([lookup(each.biology).base_color[0] + surface for each in types])])]
    for change in ({}, {"blood": 3.0}, {"blood": 1 / 3}, {"oxygenation": 0.4}):
        moods = [
            each.biology | {name: each.biology[name] * by for name, by in change.items()} for each in types
        ]
        rows.append(np.array([lookup(mood).base_color[0] + surface for mood in moods])[None])
    titles = "above: measured, dark to very light; below: fitted", "at rest", "blush", "pallor", "cyanosis"
    left = [strip(row, title, 90) for row, title in zip(rows, titles, strict=True)]
    melanin, blood = np.meshgrid(np.geomspace(0.005, 0.43, 12), np.geomspace(0.003, 0.12, 9))
    grid = lookup({"melanin": melanin.ravel(), "blood": blood.ravel()}).base_color.reshape(9, 12, 3) + surface
    right = strip(grid, "across: melanosomes 0.5 to 43 %; down: blood 0.3 to 12 %", 65)
    column = np.concatenate(left)
    high = max(len(column), len(right))
    padded = [
        np.pad(each, ((0, high - len(each)), (0, 16), (0, 0)), constant_values=255)
        for each in (column, right)
    ]
    save(np.concatenate(padded, axis=1), "skin-colours", exact=True)


PICTURES = {
    made.__name__.replace("_", "-"): made
    for made in (
        front,
        hides,
        bags,
        strap,
        helmet,
        shoe,
        chair,
        real_head,
        bellows,
        skin_colours,
    )
}

if __name__ == "__main__":
    (HERE / "pictures").mkdir(exist_ok=True)
    for name in sys.argv[1:] or PICTURES:
        began = time.perf_counter()
        try:
            PICTURES[name]()
        except MissingMeshError as problem:
            print(f"{name}: skipped: {problem}")
        else:
            print(f"{name}: {time.perf_counter() - began:.0f} s", flush=True)
