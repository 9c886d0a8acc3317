"""Makes every picture that the README and the docs show: `python -m docs.make_pictures [NAME ...]`.

Pictures go to docs/pictures, as JPEG. Each is one function; its docstring is its caption.
"""

import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image

import surftex as sx
from surftex.files.meshes import load
from surftex.preview.render import render
from surftex.preview.sheet import contact_sheet
from surftex.surface.shapes import plane

HERE = Path(__file__).resolve().parent
MESHES = HERE.parent / "meshes"
HIDES = {
    "calf": 16, "cattle-pebbled": 40, "goat": 24, "pig": 20, "ostrich": 50, "crocodile": 120, "lizard": 24,
    "stingray": 18, "car-interior": 20,
}  # fmt: skip
"""Side of the sheet, in mm, that shows each hide."""


def save(picture, name):
    Image.fromarray(np.asarray(picture)).save(HERE / "pictures" / f"{name}.jpg", quality=88)


def sheet_of(material, side_mm, *, size=420, seed=7, light="raking", fields=None):
    surface = plane(side_mm, cells=24)
    if fields is not None:
        material = sx.Recipe.model_validate({"surftex": 1, "fields": fields, "layer": [material]})
    maps = sx.bake(surface, material, resolution=768, seed=seed)
    return render(maps, size=(size, size), view="front", light=light, zoom=1.06, floor=False)


def hides():
    """The nine hides, each on a flat sheet under raking light; the side of the sheet in mm is in the label."""
    pictures = [sheet_of(sx.Leather.preset(name), side) for name, side in HIDES.items()]
    save(contact_sheet(pictures, [f"{name}, {side} mm" for name, side in HIDES.items()], columns=3), "hides")


def figure_12():
    """Fig. 12 of Sakurai et al.: the twelve settings of Table 1, 500 pixels of 0.02 mm."""
    pictures, labels = [], []
    for letter in "abcdefghijkl":
        layer = {"material": "leather", "preset": f"sakurai-12{letter}", "stress": "up"}
        pictures.append(sheet_of(layer, 10.0, size=320, fields={"up": {"axis": [0.0, 1.0, 0.0]}}))
        labels.append(f"12 ({letter})")
    save(contact_sheet(pictures, labels, columns=4), "figure-12")


def figure_11():
    """Fig. 11 of the same paper: two anisotropies, across on the left and upright on the right."""
    fields = {"across": {"axis": [1.0, 0.0, 0.0]}, "upright": {"axis": [0.0, 1.0, 0.0]}, "left": "x < 10"}
    surface = plane(20.0, cells=24)
    layers = [
        {"material": "leather", "preset": "sakurai-12a", "cell_ratio": 2.2, "direction": "upright"},
        {
            "material": "leather",
            "preset": "sakurai-12a",
            "cell_ratio": 2.2,
            "direction": "across",
            "mask": "left",
        },
    ]
    recipe = sx.Recipe.model_validate({"surftex": 1, "fields": fields, "layer": layers})
    maps = sx.bake(surface, recipe, resolution=1024, seed=7)
    save(render(maps, size=(640, 640), view="front", light="raking", zoom=1.06, floor=False), "figure-11")


def shown(mesh, preset, name, *, views, resolution=2048, seed=7, part=None, **changes):
    surface = load(MESHES / mesh, units=None if mesh.endswith("glb") else "mm", part=part)
    maps = sx.bake(surface, sx.Leather.preset(preset, **changes), resolution=resolution, seed=seed)
    pictures = [render(maps, size=(640, 560), **view) for view in views]
    save(contact_sheet(pictures, ["" for _ in pictures], columns=len(pictures)), name)
    return pictures


def front():
    """Three shipped meshes: calf shoe, ostrich bag, pebbled cushion."""
    pictures = [
        render(
            sx.bake(load(MESHES / mesh, units="mm"), sx.Leather.preset(preset), resolution=2048, seed=7),
            size=(640, 560),
        )
        for mesh, preset in (
            ("shoe.obj", "calf"),
            ("handbag.obj", "ostrich"),
            ("cushion.obj", "cattle-pebbled"),
        )
    ]
    save(contact_sheet(pictures, ["calf", "ostrich", "cattle-pebbled"], columns=3), "front")


def bags():
    """The bag in ostrich and in crocodile, far and near."""
    near = {"zoom": 4.0, "light": "raking"}
    first = shown("handbag.obj", "ostrich", "bag-ostrich", views=[{}, near])
    second = shown("handbag.obj", "crocodile", "bag-crocodile", views=[{}, near])
    save(contact_sheet([*first, *second], ["ostrich", "", "crocodile", ""], columns=2), "bags")


def head():
    """The head in goat: far, at the ear, at the nose; cells keep their size."""
    shown("head.ply", "goat", "head", cell_size="4 mm", crista_height="0.5 mm", sulcus_width="0.9 mm", sulcus_depth="0.2 mm",
          views=[{}, {"zoom": 5.0, "target": (75.0, 0.0, 0.0)}, {"view": "front", "zoom": 4.0, "light": "raking"}])  # fmt: skip


PICTURES = {
    made.__name__.replace("_", "-"): made for made in (hides, figure_12, figure_11, front, bags, head)
}

if __name__ == "__main__":
    (HERE / "pictures").mkdir(exist_ok=True)
    for name in sys.argv[1:] or PICTURES:
        began = time.perf_counter()
        PICTURES[name]()
        print(f"{name}: {time.perf_counter() - began:.0f} s")
