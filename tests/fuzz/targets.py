"""What is fed with damage: every reader of files and text, and what is done with what they let through.

A target takes a folder to write in and a number; a refusal is an `InputError`, anything else but peace is a find.
"""

import json
import re
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from surftex.randomness import stream
from tests.files.bad_inputs import glb_of
from tests.fuzz.damage import VALUES, altered, changed, damaged

ROOT = Path(__file__).resolve().parent.parent.parent
Target = Callable[[Path, int], None]
MASK = "clamp(1 - 0.7 * toe, 0, 1) * smoothstep(0, 40, z) if x < 3 and not y >= 2 else part('upper') + pi ** 2 / -wear"

RECIPE = """surftex = 1
seed = 7
[mesh]
path = "ball.obj"
units = "m"
size = "30 mm"
[bake]
resolution = 64
maps = ["height", "base_color"]
[fields]
up = { gradient = [1, 0, 0] }
wear = { curvature = "convex", radius = "4 mm" }
toe = { image = "toe.png", channel = "red" }
grain = { strokes = "grain.json" }
away = { noise = 3, wavelength = "3 mm" }
both = "clamp(up + wear, 0, 1)"
[[layer]]
material = "leather"
preset = "calf"
cell_size = "2 mm"
cell_ratio = 1.4
direction = "grain"
pore_density = "0.1 * up"
mask = "1 - 0.7 * both"
[[layer]]
material = "skin"
freckle_count = 5
freckle_radius = [0.8, "0.3 mm"]
"""

BATCH = """surftex = 1
meshes = ["one.obj", "tw*.obj"]
materials = ["calf", "my.toml"]
seeds = [1, 2]
resolution = 64
units = "mm"
out = "out"
maps = ["height"]
set = ["cell_size=4 mm"]
[[job]]
mesh = "one.obj"
material = "ostrich"
seed = 4
maps = ["height"]
[[job]]
recipe = "my.toml"
"""


def mesh(folder: Path, number: int) -> None:
    from surftex.files.meshes import load
    from tests.files.test_fuzz import SEEDS, rich_document

    names = [*SEEDS, "document"]
    name = names[number % len(names)]
    if name == "document":
        doc, binary = rich_document()
        path = folder / "a.glb"
        path.write_bytes(glb_of(json.dumps(changed(doc, number)).encode(), binary))
    else:
        path = folder / name
        path.write_bytes(damaged(SEEDS[name], name, number))
    surface = load(path, size="300 mm")
    assert np.isfinite(surface.vertices).all()
    assert len(surface.fans[1]) == 3 * len(surface.faces)


def scene(folder: Path, number: int) -> None:
    from surftex.files.scene import read_scene
    from tests.files.test_fuzz import rich_document

    doc, binary = rich_document()
    doc["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 1, 1, 1]},
                         "normalTexture": {"index": 0}, "occlusionTexture": {"index": 0},
                         "extensions": {"KHR_materials_specular": {"specularColorFactor": [1, 1, 1]}}}]  # fmt: skip
    doc["textures"], doc["images"] = [{"source": 0}], [{"uri": "a.png"}]
    (folder / "a.png").write_bytes(
        damaged(pictures()["a.png"], "scene", number) if number % 3 else pictures()["a.png"]
    )
    (folder / "a.glb").write_bytes(glb_of(json.dumps(changed(doc, number)).encode(), binary))
    read_scene(folder / "a.glb")


def recipe(folder: Path, number: int) -> None:
    from surftex.recipe.read import load_recipe

    (folder / "r.toml").write_bytes(damaged_text(RECIPE, "recipe", number))
    load_recipe(folder / "r.toml").written_out()


def field(folder: Path, number: int) -> None:
    """Fields of damaged recipes that can be read, at points."""
    from surftex.bake.fields import make_fields
    from surftex.recipe.read import recipe_from_text
    from surftex.surface.points import SurfacePoints
    from surftex.surface.shapes import plane

    (folder / "toe.png").write_bytes(pictures()["a.png"])
    (folder / "grain.json").write_text(strokes_text())
    text = damaged_text(RECIPE, "field", number).decode("utf-8", "replace")
    fields = make_fields(recipe_from_text(text, folder=folder), plane(30.0, cells=6))
    points = SurfacePoints(np.arange(9), np.full((9, 3), 1 / 3))
    for name in ("up", "wear", "toe", "away", "both"):
        values = fields.scalar(name)(points, np.ones(9, np.float32))
        assert np.isfinite(values).all(), name


def batch(folder: Path, number: int) -> None:
    from surftex.recipe.batch import load_batch

    for name in ("one.obj", "two.obj"):
        (folder / name).touch()
    (folder / "my.toml").write_text("[mesh]\npath = 'one.obj'\n[[layer]]\npreset = 'calf'\n")
    (folder / "j.toml").write_bytes(damaged_text(BATCH, "batch", number))
    load_batch(folder / "j.toml")


def expression(folder: Path, number: int) -> None:
    from surftex.fields.expressions import Expression

    text = damaged_text(MASK, "expression", number).decode("utf-8", "replace")
    known = Expression.parse(text)
    known.evaluate(lambda name: np.array([0.0, 0.5, 1.0]), 3)
    known.span(lambda name: (np.zeros(3), np.ones(3)), 3)


def change(folder: Path, number: int) -> None:
    """Changes of the command line."""
    from surftex.recipe.read import recipe_for

    seeds = ['leather.cell_size="2 mm"', "crista_height=0.1", "bake.resolution=64", "seed=3", "mesh.units=mm"]
    text = damaged_text(seeds[number % len(seeds)], "change", number).decode("utf-8", "replace")
    recipe_for("calf", changes=[text])


def length(folder: Path, number: int) -> None:
    from surftex.units import length_mm

    assert np.isfinite(length_mm(damaged_text("1.5e-2 mm", "length", number).decode("utf-8", "replace")))


def strokes(folder: Path, number: int) -> None:
    from surftex.files.strokes import read_strokes

    path = folder / "s.json"
    if number % 2:
        path.write_bytes(damaged(strokes_text().encode(), "strokes", number))
    else:
        path.write_text(json.dumps(changed(json.loads(strokes_text()), number)))
    for stroke in read_strokes(path, ball()).strokes:
        assert np.isfinite(stroke.points.positions(ball())).all()


def features(folder: Path, number: int) -> None:
    """Files of features, and what is built on those that pass."""
    from surftex.bake.stack import place_stack
    from surftex.fields.fieldset import FieldSet
    from surftex.files.features import load_features
    from surftex.recipe.model import Recipe

    path = folder / "features.npz"
    name = ("leather", "skin", "cells", "composite")[number % 4]
    if number % 3 == 0:
        path.write_bytes(damaged(packed_features(name), "features", number))
    else:
        tables = altered(placed(name).features, number)
        np.savez(path, **tables) if number % 3 == 1 else np.savez_compressed(path, **tables)
    recipe = Recipe.of(material(name), resolution=64)
    stack = place_stack(recipe, ball(), FieldSet(ball()), features=load_features(path), threads=1)
    assert np.isfinite(stack.at(samples(), ("height_mm",))["height_mm"]).all()


def skin_table(folder: Path, number: int) -> None:
    from surftex.optics.table import SkinTable

    SkinTable.from_bytes(damaged(small_table(), "skin table", number)).grid  # noqa: B018


def texture(folder: Path, number: int) -> None:
    """Files of learnt textures, labels and composites, and pictures drawn from what passes."""
    from surftex.exemplar.store import _MAGIC, as_json, load_model, packed

    path = folder / ("a.json" if number % 3 == 1 else "a.stex")
    model = learnt(("texture", "labels", "composite")[number // 3 % 3])
    if number % 3 == 0:
        path.write_bytes(damaged(packed(model), "texture", number))
    elif number % 3 == 1:
        path.write_text(json.dumps(changed(json.loads(as_json(model)), number)))
    else:
        content = zlib.decompress(packed(model)[len(_MAGIC) :])
        size = int.from_bytes(content[:4], "little")
        head, body = json.loads(content[4 : 4 + size]), content[4 + size :]
        text = json.dumps(changed(head, number)).encode() if number % 2 else content[4 : 4 + size]
        body = damaged(body, "texture body", number)
        path.write_bytes(_MAGIC + zlib.compress(len(text).to_bytes(4, "little") + text + body))
    read: Any = load_model(path)
    some = {} if type(read).__name__ == "LabelModel" else {"sweeps": 1}
    drawn = read.synthesize(24, 20, 1, threads=1, **some)
    assert drawn.dtype == np.uint8


def picture(folder: Path, number: int) -> None:
    from surftex.files.exemplars import read_exemplar, read_label_map
    from surftex.files.images import read_exr, read_png
    from surftex.files.pictures import read_codes, read_mask

    name = sorted(pictures())[number // 6 % len(pictures())]
    data = damaged(pictures()[name], name, number)
    (folder / name).write_bytes(with_sums(data) if name.endswith("png") and number % 2 else data)
    readers = (read_mask, read_codes, read_exemplar, read_label_map, read_png, read_exr)
    readers[number % len(readers)](folder / name)


TARGETS: dict[str, Target] = {
    each.__name__: each
    for each in (mesh, scene, recipe, field, batch, expression, change, length, strokes, features, skin_table,
                 texture, picture)
}  # fmt: skip


def damaged_text(text: str, name: str, number: int) -> bytes:
    """Text with bytes damaged, or with one to three of its values otherwise."""
    if number % 2:
        return damaged(text.encode(), name, number)
    for at, which in stream(7, "text", name, number).uniform(3, 2)[: 1 + (number // 7) % 3]:
        found = list(re.finditer(r'"[^"]*"|\b[\d.]+\b|\b\w+\b|[-+*/=\[\]{},<>]', text))
        spot = found[int(at * len(found))]
        new = (
            json.dumps(VALUES[int(which * len(VALUES))])
            if which < 0.8
            else found[int(which * len(found))].group()
        )
        text = text[: spot.start()] + new + text[spot.end() :]
    return text.encode()


def with_sums(data: bytes) -> bytes:
    """A PNG whose chunks say what they hold, so that damage passes the sums."""
    out, at = bytearray(data[:8]), 8
    while at + 12 <= len(data):
        size = int.from_bytes(data[at : at + 4], "big")
        body = data[at + 4 : at + 8 + size]
        out += data[at : at + 4] + body + zlib.crc32(body).to_bytes(4, "big")
        at += 12 + size
    return bytes(out)


@cache
def ball() -> Any:
    from surftex.surface.shapes import sphere

    return sphere(12.0, subdivisions=2)


@cache
def samples() -> Any:
    from surftex.features.uniform import scatter
    from surftex.surface.points import Samples

    points = scatter(ball(), stream(1, "samples"), count=50)
    return Samples(points, np.full(50, 0.2, np.float32))


@cache
def material(name: str) -> Any:
    from surftex.recipe.layer import material_class
    from tests.promises.test_materials import TABLE

    return material_class(name)(**TABLE[name].parameters)


@cache
def placed(name: str) -> Any:
    return material(name).place(ball(), 1, threads=1)


@cache
def packed_features(name: str) -> bytes:
    import tempfile

    from surftex.files.features import save_features

    with tempfile.TemporaryDirectory() as folder:
        save_features(Path(folder) / "f.npz", placed(name).features)
        return (Path(folder) / "f.npz").read_bytes()


@cache
def learnt(kind: str) -> Any:
    from surftex.exemplar.composite import learn_composite
    from surftex.exemplar.labels import learn_labels
    from surftex.exemplar.learn import learn_texture
    from tests.exemplar.pictures import echo, patches, patchwork

    if kind == "texture":
        return learn_texture(echo(64), pairs=2, spacings=(1,), radius=3)
    label = patches(80, 9.0)
    return learn_labels(label) if kind == "labels" else learn_composite(patchwork(label), label, pairs=2)


@cache
def small_table() -> bytes:
    from surftex.optics.table import COLUMNS, SkinTable, shipped_table

    settings = {**shipped_table().settings, "nodes": dict.fromkeys(shipped_table().settings["nodes"], 1)}
    return SkinTable(np.full((1,) * 6 + (len(COLUMNS),), 0.3), settings).to_bytes()


@cache
def strokes_text() -> str:
    lines = [
        [[0, 0, 12], [3, 0, 11.6], [6, 0, 10.4]],
        {"name": "a", "points": [[12, 0, 0], [11, 4, 0]], "width_mm": 1.5},
    ]
    spots = {"tip": [0, 0, 12], "side": {"face": 3, "barycentric": [0.2, 0.3, 0.5], "xyz": [0, 12, 0]}}
    return json.dumps({"surftex": 1, "faces": len(ball().faces), "strokes": lines, "points": spots})


@cache
def pictures() -> dict[str, bytes]:
    import tempfile

    import imagecodecs

    from surftex.files.images import png_bytes, write_exr

    pixels = (np.arange(9 * 7 * 3) % 255).astype(np.uint8).reshape(9, 7, 3)
    with tempfile.TemporaryDirectory() as folder:
        write_exr(Path(folder) / "a.exr", pixels / np.float32(9))
        exr = (Path(folder) / "a.exr").read_bytes()
    return {
        "a.png": png_bytes(pixels), "b.png": png_bytes(pixels.astype(np.uint16)[..., 0] * 200),
        "a.jpg": bytes(imagecodecs.jpeg_encode(pixels)), "a.tif": bytes(imagecodecs.tiff_encode(pixels)),
        "b.tif": bytes(imagecodecs.tiff_encode(pixels, compression="deflate")), "a.exr": exr,
    }  # fmt: skip
