"""Makes the pictures of learnt textures: `python -m docs.pictures_composite [NAME ...]`, in docs/pictures.

Gravel, brick and gingham are those of `$SURFTEX_SHARED/exemplars`; breccia, grass and ground are made here. Quilting is
that of benchmarks/quilting.py. Docstrings are captions.
"""

import itertools
import os
import sys
import tempfile
import time
from functools import cache
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

import surftex as sx
from benchmarks.quilting import quilt
from docs.made_exemplars import breccia, grass, ground, noise
from docs.make_pictures import HERE, MESHES, MissingMeshError, save, shared
from surftex.bake.bake import run
from surftex.files.meshes import load
from surftex.preview.render import render
from surftex.preview.sheet import contact_sheet
from surftex.recipe.read import recipe_from_text
from surftex.surface.surface import Surface

EXEMPLARS = Path(os.environ.get("SURFTEX_SHARED", HERE.parent.parent / "shared")) / "exemplars"


def exemplar(name, by, side=256):
    """An exemplar, scaled down."""
    path = EXEMPLARS / name
    if not path.exists():
        raise MissingMeshError(f"{path} is not there; SURFTEX_SHARED names the folder that holds exemplars/")
    picture = Image.open(path).convert("L" if "skimage" in name else "RGB")
    small = picture.resize((picture.width // by, picture.height // by), Image.Resampling.BOX)
    return np.ascontiguousarray(np.asarray(small)[:side, :side])


def four(picture, **options):
    """Exemplar, pairs, fours, quilting."""
    height, width = picture.shape[:2]
    drawn = [
        sx.learn_texture(picture, order=order, **options).synthesize(width, height, 1)
        for order in ("pair", "quad")
    ]
    return [picture, *drawn, quilt(picture, width, height, 1)]


def side_by_side(pictures, name):
    """Rows of exemplar, pairs, fours, quilting."""
    names = ("exemplar", "pairs", "pairs and fours", "quilting, which copies")
    save(contact_sheet(pictures, names * (len(pictures) // 4), columns=4), name)


def plain():
    """Exemplar; drawn from pairs; from pairs and fours; quilted. Gravel and brick."""
    pictures = [*four(exemplar("gravel_skimage.png", 2)), *four(exemplar("brick_skimage.png", 2))]
    side_by_side(pictures, "textures-plain")


def lawn():
    """The same of grass."""
    side_by_side(four(np.ascontiguousarray(grass()[:192, :192])), "textures-grass")


def weave():
    """The same of gingham, with longer pairs and fours."""
    cloth = exemplar("fabric_pattern_07_col.jpg", 4, 192)
    side_by_side(four(cloth, radius=40, spacings=(1, 2, 4, 8)), "textures-weave")


def knitted():
    """Two pictures side by side; knitted; a hole in gravel; filled."""
    stones, lawn = exemplar("gravel_skimage.png", 2), grass()
    stones = np.repeat(stones[..., None], 3, axis=2)
    rock = np.clip(stones * np.array([1.0, 0.95, 0.85]), 0, 255).astype(np.uint8)
    above, below = rock[:128], np.ascontiguousarray(lawn[128:])
    hole = ((np.mgrid[:256, :256] - 128.0) ** 2 / np.array([30.0**2, 55.0**2])[:, None, None]).sum(axis=0) < 1
    holed = exemplar("gravel_skimage.png", 2).copy()
    holed[hole] = 0
    pictures = [
        np.concatenate([above, below]), sx.knit(above, below, side="below", seed=1), holed, sx.fill(holed, hole, seed=1),
    ]  # fmt: skip
    save(
        contact_sheet(pictures, ("laid together", "knitted", "a hole", "filled"), columns=4),
        "textures-knitted",
    )


def landscape():
    """Ground of three labels: the exemplar and its labels; a drawn layout; a painted one; as a single texture."""
    picture, label = ground()
    model = sx.learn_composite(picture, label, pairs=8)
    side = 224
    painted = np.zeros((side, side), np.uint8)
    down, right = np.mgrid[:side, :side]
    painted[np.abs(down - 112 - 42 * np.sin(right / 35)) < 24] = 1
    painted[(down - 50) ** 2 + (right - 160) ** 2 < 32**2] = 2
    drawn, asked = model.maps(side, side, 2), model.maps(side, side, 2, labels=painted)
    single = sx.learn_texture(picture, pairs=8).synthesize(side, side, 2)
    tones = [each[:side, :side].astype(np.uint8) * 120 for each in (label, drawn["labels"], painted)]
    pictures = [picture[:side, :side], drawn["picture"], asked["picture"], single, *tones]
    names = ("exemplar", "drawn layout", "painted layout", "as one texture", "its labels", "", "")
    save(contact_sheet(pictures, names, columns=4), "textures-landscape")


@cache
def breccia_model():
    return sx.learn_composite(*breccia(), over=True, pairs=8)


def eroded():
    """A breccia; as one texture; as a composite; the same, eroded."""
    picture, _ = breccia()
    model, side = breccia_model(), 224
    ages = [model.synthesize(side, side, 3, age=age) for age in (-1, 0, 3)]
    single = sx.learn_texture(picture, pairs=8).synthesize(side, side, 3)
    pictures = [picture[:side, :side], single, *ages]
    names = ("exemplar", "as one texture", "composite, a step back", "as learnt", "three steps on")
    save(contact_sheet(pictures, names, columns=5), "textures-breccia")


def column_mesh(height=480.0, sections=96):
    """A column with base, swelling shaft and capital, in mm."""
    profile = np.array([
        (62, 0), (62, 14), (56, 16), (58, 24), (54, 30), (46, 34), (45, 40), (43, 180), (38, 420), (38, 432), (42, 438),
        (46, 450), (52, 458), (60, 462), (60, 480),
    ], float)  # fmt: skip
    rings = []
    for start, end in itertools.pairwise(profile):
        count = max(1, int(np.hypot(*(end - start)) // 8))
        rings += [start + (end - start) * k / count for k in range(count)]
    rings = np.array([*rings, profile[-1]])
    turn = 2 * np.pi * np.arange(sections) / sections
    across, along = rings[:, :1], np.repeat(rings[:, 1:] * height / 480, sections, axis=1)
    vertices = np.stack([across * np.cos(turn), along, -across * np.sin(turn)], axis=2).reshape(-1, 3)
    vertices = np.concatenate([vertices, [[0, 0, 0], [0, height, 0]]])
    row, here = np.meshgrid(np.arange(len(rings) - 1), np.arange(sections), indexing="ij")
    next_one = (here + 1) % sections
    corner = [
        row * sections + here,
        row * sections + next_one,
        (row + 1) * sections + next_one,
        (row + 1) * sections + here,
    ]
    a, b, c, d = (each.ravel() for each in corner)
    top, ring = (len(rings) - 1) * sections, np.arange(sections)
    faces = np.concatenate([
        np.column_stack([a, b, c]), np.column_stack([a, c, d]),
        np.column_stack([np.roll(ring, -1), ring, np.full(sections, len(vertices) - 2)]),
        np.column_stack([top + ring, top + np.roll(ring, -1), np.full(sections, len(vertices) - 1)]),
    ])  # fmt: skip
    return Surface.from_arrays(vertices, faces, name="column")


def column():
    """The breccia on a column, whose cracks have grown at its foot; and near."""
    folder = tempfile.TemporaryDirectory()
    model = Path(folder.name) / "breccia.stex"
    breccia_model().save(model)
    recipe = recipe_from_text(f"""
    [fields]
    foot = {{ gradient = [0, -1, 0] }}
    ragged = {{ noise = 3, wavelength = "14 mm", low = 0.2, high = 1.8 }}
    up = {{ axis = [0, 1, 0] }}
    [[layer]]
    material = "composite"
    model = "{model}"
    pixel_size = "1.5 mm"
    direction = "up"
    age = "6 * smoothstep(0.5, 1, foot) * ragged - 0.6"
    relief = "0.8 mm"
    """, allow_outside=True)  # fmt: skip
    maps = run(_with(recipe, 1024), column_mesh()).maps
    folder.cleanup()
    pictures = [
        render(maps, size=(420, 640), view=(20, 8), up="y"),
        render(maps, size=(420, 640), view=(20, 8), up="y", zoom=3.2, target=(0, 90, 45)),
        render(maps, size=(420, 640), view=(20, 8), up="y", zoom=3.2, target=(0, 330, 40)),
    ]
    save(contact_sheet(pictures, ("column", "its foot, worn", "its shaft"), columns=3), "textures-column")


def bust():
    """Gravel cast into a bust: far, and near."""
    surface = load(shared("bust_demosthenes.off"), size="500 mm")
    maps = sx.bake(
        surface, sx.Composite.preset("gravel", pixel_size="1.3 mm", relief="3 mm"), resolution=1536, seed=2
    )
    pictures = [
        render(maps, size=(640, 640), view=(30, 12)),
        render(maps, size=(640, 640), view=(30, 12), zoom=4),
    ]
    save(contact_sheet(pictures, columns=2), "textures-bust")


def rounded_box(size, middle, radius, puff=0.0, step=18.0):
    """A box with round edges, its top and bottom puffed out; vertices and faces."""
    half = np.array(size, float) / 2
    grid = [np.linspace(-each, each, max(2, round(2 * each / step))) for each in half]
    vertices, faces, first = [], [], 0
    for axis in range(3):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        for side in (-1.0, 1.0):
            u, v = (each.ravel() for each in np.meshgrid(grid[one], grid[two], indexing="ij"))
            place = np.zeros((len(u), 3))
            place[:, one], place[:, two], place[:, axis] = u, v, side * half[axis]
            number = first + np.arange(len(u)).reshape(len(grid[one]), len(grid[two]))
            a, b, c, d = (
                each.ravel() for each in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
            )
            some = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
            faces.append(some if side > 0 else some[:, ::-1])
            vertices.append(place)
            first += len(u)
    place = np.concatenate(vertices)
    core = np.clip(place, radius - half, half - radius)
    away = place - core
    place = core + radius * away / np.linalg.norm(away, axis=1, keepdims=True)
    bulge = np.prod(1 - (place[:, ::2] / half[::2]) ** 2, axis=1).clip(0)
    place[:, 1] += puff * bulge * np.sign(place[:, 1])
    kept, which = np.unique(np.round(place, 4), axis=0, return_inverse=True)
    return kept + middle, which.ravel()[np.concatenate(faces)]


def sofa_mesh():
    """A sofa of six puffed boxes, 1600 mm wide."""
    boxes = (
        ((1360, 160, 760), (0, 190, 0), 20, 0), ((670, 170, 700), (-338, 350, 30), 50, 26),
        ((670, 170, 700), (338, 350, 30), 50, 26), ((1360, 620, 150), (0, 430, -360), 45, 0),
        ((170, 520, 860), (-765, 370, 0), 60, 12), ((170, 520, 860), (765, 370, 0), 60, 12),
    )  # fmt: skip
    vertices, faces, first = [], [], 0
    for size, middle, radius, puff in boxes:
        some, corner = rounded_box(size, middle, radius, puff)
        vertices.append(some)
        faces.append(corner + first)
        first += len(some)
    return Surface.from_arrays(np.concatenate(vertices), np.concatenate(faces), name="sofa")


def fabric():
    """Gingham on a cushion, on a sofa that we make, and on the cover of a real chair; its rows along an axis."""
    pictures = []
    chair = load(shared("chair_sheen.glb"), part="fabric Mystere Mango Velvet")
    seat = np.add(chair.origin_mm, (0.0, -100.0, 60.0))
    for surface, pixel, target in (
        (load(MESHES / "cushion.obj"), "1.6 mm", None), (sofa_mesh(), "5 mm", None), (chair, "2.6 mm", seat),
    ):  # fmt: skip
        recipe = recipe_from_text(f"""
        seed = 2
        [fields]
        rows = {{ axis = [1, 0, 0] }}
        [[layer]]
        material = "composite"
        preset = "gingham"
        pixel_size = "{pixel}"
        direction = "rows"
        """)
        maps = run(_with(recipe, 1536), surface).maps
        view = {"size": (460, 400), "view": (28, 22), "up": "y"}
        pictures += [
            render(maps, **view, zoom=zoom, target=target if zoom > 1 else None) for zoom in (1, 2.5, 7)
        ]
    save(contact_sheet(pictures, columns=3), "textures-fabric")


def pebbled():
    """Colour, height and roughness of leather, (256, 256) each: real relief, put together from a map of its normals.

    Colour and roughness are ours: furrows darker and rougher than what is rubbed.
    """
    code = np.asarray(Image.fromarray(exemplar("leather_pebble_normal.png", 1, 512)), float) / 127.5 - 1
    slope = np.stack([-code[..., 0], code[..., 1]]) / np.maximum(code[..., 2], 0.2)
    down, right = np.meshgrid(*(2 * np.pi * np.fft.fftfreq(each) for each in slope.shape[1:]), indexing="ij")
    square = right**2 + down**2
    square[0, 0] = 1
    turn = -1j * (right * np.fft.fft2(slope[0]) + down * np.fft.fft2(slope[1])) / square
    rise = np.fft.ifft2(turn).real
    rise = gaussian_filter(rise, 0.7, mode="wrap") - gaussian_filter(rise, 25, mode="wrap")
    rise = rise.reshape(256, 2, 256, 2).mean(axis=(1, 3))
    low, high = np.percentile(rise, [0.5, 99.5])
    share = np.clip((rise - low) / (high - low), 0, 1)
    patina = share + 0.1 * noise(256, 2, "patina")
    color = np.array([58, 30, 18]) + np.clip(patina, 0, 1)[..., None] * [98, 66, 42]
    rough = 0.8 - 0.45 * share**1.5
    return tuple(np.rint(each).astype(np.uint8) for each in (color, 255 * share, 255 * rough))


def leather():
    """A leather's colour, height and roughness; all three drawn together; the whole on a ring."""
    color, rise, rough = pebbled()
    model = sx.learn_texture(color, height=rise, roughness=rough)
    drawn = model.maps(256, 256, 1)
    rows = [color, rise, rough, drawn["picture"], drawn["height"], drawn["roughness"]]
    with tempfile.TemporaryDirectory() as folder:
        model.save(Path(folder) / "leather.stex")
        leather = sx.Composite(model=f"{folder}/leather.stex", pixel_size="0.4 mm", relief="0.3 mm")
        maps = sx.bake(sx.shapes.torus(36.0, 11.0), leather, resolution=1536, seed=2)
    top = (0.0, 36.0, 8.0)
    ring = [
        render(maps, size=(256, 256), zoom=zoom, up="y", view=(20, 15), target=top if zoom > 1 else None)
        for zoom in (1, 2.5, 6)
    ]
    names = (
        "colour",
        "height",
        "roughness",
        "colour, drawn",
        "height, drawn",
        "roughness, drawn",
        "",
        "",
        "",
    )
    save(contact_sheet([*rows, *ring], names, columns=3), "textures-leather")


def _with(recipe, resolution):
    return sx.Recipe.of(recipe, resolution=resolution)


PICTURES = {
    each.__name__: each
    for each in (plain, lawn, weave, knitted, landscape, eroded, column, bust, fabric, leather)
}


def main():
    for name in sys.argv[1:] or PICTURES:
        start = time.perf_counter()
        try:
            PICTURES[name]()
        except MissingMeshError as missing:
            print(f"{name}: skipped; {missing}")
        else:
            print(f"{name}: {time.perf_counter() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main()
