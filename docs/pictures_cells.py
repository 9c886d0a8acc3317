"""Pictures of grown leather: `python -m docs.pictures_cells [NAME ...]`, into docs/pictures, beside docs/make_pictures.py."""

import sys
import time

import numpy as np

import surftex as sx
from docs.make_pictures import HERE, MissingMeshError, save, shared, three_scales
from surftex.bake.growing import Growth
from surftex.bake.tiling import bake_tile
from surftex.charts.atlas import Atlas
from surftex.files.images import png_bytes
from surftex.files.meshes import load
from surftex.maps.mapset import MapSet
from surftex.maps.normal import surface_tangents
from surftex.preview.growth import growth_frames
from surftex.preview.render import render
from surftex.preview.sheet import contact_sheet
from surftex.surface.shapes import plane
from surftex.surface.surface import Surface

SMOOTH = {"blob_density": 0.0}
FLAT = {"view": "front", "light": "raking", "floor": False}


def rings(size=256):
    """Grey picture of three soft rings that repeats: a potential as in Fig. 8 (b)."""
    line = (np.arange(size) + 0.5) / size
    x, y = np.meshgrid(line, line)
    grey = np.zeros((size, size))
    for across, down, radius in ((0.3, 0.32, 0.2), (0.74, 0.62, 0.24), (0.24, 0.8, 0.13)):
        away = [np.abs((each - middle + 0.5) % 1 - 0.5) for each, middle in ((x, across), (y, down))]
        grey = np.maximum(grey, np.exp(-(((np.hypot(*away) - radius) / 0.045) ** 2)))
    return (255 * grey).astype(np.uint8)


def recipe_of(preset, fields=None, resolution=900, **changes):
    """Make the recipe of a tile."""
    layer = {"material": "cells", "preset": preset, **changes}
    return sx.Recipe.model_validate(
        {
            "surftex": 1,
            "seed": 7,
            "bake": {"resolution": resolution},
            "fields": fields or {},
            "layer": [layer],
        }
    )


def flat(maps, size=440, zoom=1.06, times=1, **more):
    """Draw a tile, or as many of it side by side."""
    side = times * maps.report["tile"]["side_mm"]
    sheet = plane(side, cells=4)
    atlas = Atlas.of(sheet, sheet.corner_uv)
    images = {name: np.tile(each, (times, times, 1)[: each.ndim]) for name, each in maps.items()}
    seen = MapSet(images, sheet, atlas, surface_tangents(sheet, atlas))
    return render(seen, size=(size, size), zoom=zoom, **FLAT, **more)


def with_rings(work):
    """Call with the path of the potential, beside the other pictures."""
    path = HERE / "pictures" / "cells-potential.png"
    path.write_bytes(png_bytes(rings()))
    return work({"rings": {"image": str(path)}})


def on_the_sheet(picture):
    """Cut off the background around a flat sheet."""
    sheet = np.abs(picture.astype(int) - picture[0, 0]).max(axis=2) > 12
    rows, columns = (np.flatnonzero(sheet.mean(axis=axis) > 0.5) for axis in (1, 0))
    return picture[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]


def figure_8():
    """Fig. 8 of the report: particles under a constant force, the potential, under it, and both laid over each other."""

    def work(fields):
        pictures = []
        driven = {"potential": "rings", "potential_height": 7, "potential_force": 0.035}
        for changes in ({"drift": "along", "drift_force": 0.01}, driven):
            growth = Growth(frames=1)
            names = {**fields, "along": {"axis": [1, 0.35, 0]}}
            recipe = recipe_of("cells", names, 64, cell_size=1.0, **changes)
            maps = bake_tile(recipe, 25.0, growth=growth)
            size = {"size": (340, 340), "zoom": 1.06, **FLAT}
            pictures += growth_frames(maps, recipe.layer[0].material, growth.states, **size)
        pictures = [on_the_sheet(picture) for picture in pictures]
        rows, columns = (np.linspace(0, 255, side).astype(int) for side in pictures[1].shape[:2])
        potential = np.repeat(rings()[rows][:, columns, None], 3, axis=2)
        both = np.clip(0.62 * pictures[1] + 0.5 * potential, 0, 255).astype(np.uint8)
        labels = ["(a) constant force", "(b) potential", "(c) under it", "(d) (b) and (c)"]
        save(contact_sheet([pictures[0], potential, pictures[1], both], labels, columns=4), "cells-figure-8")

    with_rings(work)


def figure_13():
    """Fig. 13 of the report: layer, cells, cells with metaballs, mixed sizes, flat cells across, driven by Fig. 8 (b)."""

    def work(fields):
        growth = Growth(frames=1)
        side = 24.0
        plain = recipe_of("cells", **SMOOTH)
        maps = bake_tile(plain, side, growth=growth)
        layer = next(
            growth_frames(maps, plain.layer[0].material, growth.states, size=(440, 440), zoom=1.06, **FLAT)
        )
        across = {"across": {"axis": [1, 0, 0]}}
        driven = {"potential": "rings", "potential_height": 9, "potential_force": 0.045}
        settings = {
            "(c) metaballs": (recipe_of("cells", blob_height=0.11), side),
            "(d) sizes vary": (recipe_of("mixed"), side * 1.25),
            "(e) flat cells across": (recipe_of("oriented", across, direction="across"), side * 1.25),
            "(f) driven by Fig. 8 (b)": (recipe_of("cells", fields, **driven), side * 1.8),
        }
        pictures = [layer, flat(maps), *(flat(bake_tile(*each)) for each in settings.values())]
        labels = ["(a) layer of particles", "(b) cells", *settings]
        save(contact_sheet(pictures, labels, columns=3), "cells-figure-13")

    with_rings(work)


def presets():
    """Every preset as a tile: near, as it is, and two by two of it."""
    pictures, labels = [], []
    for name, side in {
        "even": 24, "mixed": 36, "milled": 48, "oriented": 32, "field-driven": 48, "travel": 50
    }.items():  # fmt: skip
        maps = bake_tile(recipe_of(name, resolution=1024), float(side))
        pictures += [flat(maps, 340, 3.2), flat(maps, 340), flat(maps, 340, times=2)]
        labels += [f"{name}, near", f"{side} mm", f"{2 * side} mm"]
    save(contact_sheet(pictures, labels, columns=6), "cells-presets")


def growth():
    """A tile on its way: eight generations from the first births to the closed layer."""
    remembered = Growth(frames=8)
    recipe = recipe_of("cells", resolution=64)
    maps = bake_tile(recipe, 20.0, growth=remembered)
    states = remembered.states
    pictures = list(growth_frames(maps, recipe.layer[0].material, states, size=(320, 320), zoom=1.06, **FLAT))
    save(contact_sheet(pictures, [f"generation {each}" for each, _ in states], columns=4), "cells-growth")


def shoe():
    """A real shoe in even grain: far, the toe cap, and across a seam of its own unwrap."""
    surface = load(shared("shoe_variants.glb"))
    three_scales(
        surface, sx.Cells.preset("even", cell_size="2.4 mm"), (110, -10, 25), (0, 10, 50), "cells-shoe"
    )


def head():
    """A scanned head in the default grain of 4 mm: far, the ear, and across a seam."""
    surface = load(shared("head_lee_perry_smith.ply"), units="m")
    ear, cheek = (84.0, 36.0, 22.0), (40.0, 10.0, 75.0)
    far = {"view": "front"}
    cells = sx.Cells.preset("cells", cell_size="4 mm")
    three_scales(surface, cells, ear, cheek, "cells-head", far=far, zooms=(5.0, 9.0))


def bellows():
    """The pleats of an old camera's bellows in the grain of a travel bag of 5 mm, at 1.5 m for the camera with its tripod."""
    whole = load(shared("camera_antique.glb"), size="1500 mm")
    count = np.bincount(whole.component)
    kept = np.isin(count[whole.component], (136, 148))
    surface = Surface.from_arrays(whole.vertices, whole.faces[kept], name="bellows")
    seen = surface.vertices[np.unique(surface.faces)]
    low, high = seen.min(axis=0), seen.max(axis=0)
    side = np.array([high[0], (low[1] + high[1]) / 2, (low[2] + high[2]) / 2])
    creases = {
        "wrinkle_density": 0.3,
        "wrinkle_length": "90 mm",
        "wrinkle_width": "4 mm",
        "wrinkle_depth": "0.4 mm",
        "relief": 0.09,
        "color": "#4a2f22",
    }
    cells = sx.Cells.preset("travel", cell_size="5 mm", **creases)
    near = {"zooms": (3.0, 7.0), "beside": (60.0, 20.0)}
    three_scales(surface, cells, side, side, "cells-bellows", resolution=2048, **near)


def creased():
    """Furrows that flow over a scanned head and drive its grain of 4 mm: far, the forehead, and across a seam."""
    surface = load(shared("head_lee_perry_smith.ply"), units="m")
    furrows = {
        "wrinkle_density": 0.4,
        "wrinkle_length": "150 mm",
        "wrinkle_width": "5 mm",
        "wrinkle_depth": "1 mm",
        "wrinkle_taper": "30 mm",
    }
    cells = sx.Cells.preset("creased", cell_size="4 mm", **furrows)
    forehead, cheek = (25.0, 90.0, 90.0), (40.0, 10.0, 75.0)
    three_scales(surface, cells, forehead, cheek, "cells-creased", zooms=(5.0, 8.0))


PICTURES = {
    made.__name__.replace("_", "-"): made
    for made in (figure_8, figure_13, presets, growth, shoe, head, bellows, creased)
}

if __name__ == "__main__":
    for name in sys.argv[1:] or PICTURES:
        began = time.perf_counter()
        try:
            PICTURES[name]()
        except MissingMeshError as problem:
            print(f"{name}: skipped: {problem}")
        else:
            print(f"{name}: {time.perf_counter() - began:.0f} s", flush=True)
