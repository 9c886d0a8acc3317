"""What a report tells renderers, and of biology that left its range."""

import json

import numpy as np
import pytest

import surftex as sx
from surftex.optics import blender_inputs, gltf_material, lookup

PALE = {"variation": 0.0, "mottle": 0.0, "drift": 0.0, "flush": 0.0, "tan": 0.0, "pore_density": 0.0,
        "relief_depth": 0.0, "relief_swell": 0.0, "relief_secondary": 0.0}  # fmt: skip


@pytest.fixture(scope="module")
def ball():
    return sx.shapes.sphere(20, subdivisions=3)


def skin(**changes):
    return sx.Skin(**(PALE | changes))


def test_what_leaves_its_range_is_counted_once_per_texel(ball):
    usual = sx.bake(ball, skin(), resolution=64)
    assert usual.report["clamped"] == {}
    dark = sx.bake(ball, skin(melanin=0.8, stratum_corneum=0.05), resolution=64)
    texels = dark.report["texels"]
    assert dark.report["clamped"] == {"melanin": texels, "stratum_corneum_mm": texels}
    assert any(
        "melanin left its range" in text and "0.002 to 0.45" in text for text in dark.report["warnings"]
    )
    edge = sx.bake(ball, skin(melanin=0.45, stratum_corneum=0.04), resolution=64)
    assert edge.report["clamped"] == {}
    assert np.array_equal(dark["base_color"], edge["base_color"])


def test_neither_tiles_nor_threads_change_the_count(ball):
    mixed = skin(melanin=0.44, mottle=0.4)
    counts = [
        sx.bake(ball, mixed, resolution=64, tile=tile, threads=threads).report["clamped"]["melanin"]
        for tile, threads in ((None, 2), (7, 1), (64, 1))
    ]
    assert counts[0] == counts[1] == counts[2]
    assert 0 < counts[0] < 64 * 64


def test_what_a_mask_hides_is_not_counted(ball, tmp_path):
    path = tmp_path / "half.toml"
    path.write_text(
        'surftex = 1\n[[layer]]\nmaterial = "skin"\nmelanin = 0.9\nmask = "0"\n'
        '[[layer]]\nmaterial = "skin"\npore_density = 0.0\n',
        "utf-8",
    )
    assert sx.bake(ball, str(path), resolution=32).report["clamped"] == {}


def test_report_and_glb_tell_the_same_subsurface(ball, tmp_path):
    import pygltflib

    maps = sx.bake(ball, skin(melanin=0.03), resolution=64)
    told = maps.report["subsurface"]
    look = lookup({"melanin": 0.03, "pheomelanin": 0.12, "blood": 0.014, "oxygenation": 0.78,
                   "stratum_corneum_cm": 0.0015, "epidermis_cm": 0.008})  # fmt: skip
    assert told["radius_mm"] == pytest.approx(look.subsurface_radius_mm[0], rel=1e-4)
    maps.save(tmp_path / "out")
    assert (tmp_path / "out" / told["map"]).is_file()
    document = pygltflib.GLTF2().load(tmp_path / "out" / f"{maps.stem}.glb")
    assert document.materials[0].extras["surftex_subsurface"] == told
    alone = gltf_material(look)["extras"]["surftex_subsurface"]
    assert {**told, "radius_mm": None} == {**alone, "radius_mm": None, "map": told["map"]}
    assert told["radius_mm"] == pytest.approx(alone["radius_mm"], rel=1e-4)
    sockets = maps.report["blender"]["inputs"]
    whole = blender_inputs(look)[0]
    assert sockets["Subsurface Radius"] == pytest.approx(whole["Subsurface Radius"], rel=1e-3)
    assert set(sockets) <= {*whole, "Normal"}
    images = [socket["image"] for socket in sockets.values() if isinstance(socket, dict)]
    assert len(images) == 5
    assert all((tmp_path / "out" / image).is_file() for image in images)
    json.dumps(maps.report["blender"])


def test_leather_has_no_subsurface(ball):
    report = sx.bake(ball, sx.Leather(cell_size=8), resolution=32).report
    assert report["subsurface"] == {}
    assert "Subsurface Radius" not in report["blender"]["inputs"]
    assert report["clamped"] == {}


def test_skin_reads_its_looks_from_a_table_of_ones_own(ball, tmp_path):
    from surftex.optics.making import Making, make_table

    counts = {
        "pheomelanin": 1,
        "melanin": 3,
        "epidermis_cm": 1,
        "stratum_corneum_cm": 1,
        "blood": 2,
        "oxygenation": 1,
    }
    table = make_table(Making(shader="principled", nodes=counts, paths=300, beam_paths=200, step_nm=50.0))
    (tmp_path / "mine.npz").write_bytes(table.to_bytes())
    path = tmp_path / "skin.toml"
    path.write_text('surftex = 1\n[[layer]]\nmaterial = "skin"\ntable = "mine.npz"\n' + "".join(
        f"{name} = {value}\n" for name, value in PALE.items()), "utf-8")  # fmt: skip
    maps = sx.bake(ball, str(path), resolution=32)
    look = lookup({"melanin": 0.022, "blood": 0.014}, table=sx.optics.load_table(tmp_path / "mine.npz"))
    assert maps["base_color"][16, 16] == pytest.approx(look.base_color[0], abs=1e-5)
    assert np.abs(maps["base_color"] - sx.bake(ball, skin(), resolution=32)["base_color"]).max() > 0.005
    held = {
        "pheomelanin",
        "oxygenation",
        "stratum_corneum_mm",
        "epidermis_mm",
    }  # one node each, and another value
    assert maps.report["clamped"] == dict.fromkeys(held, maps.report["texels"])
    warned = [text for text in maps.report["warnings"] if "left its range" in text]
    assert len(warned) == 4
    assert any(
        text.startswith("epidermis_mm") and text.endswith("it is 0.1 alone in the table") for text in warned
    )


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("gone.npz", "gone.npz"),
        ("../mine.npz", "leaves the recipe's folder"),
        ("wrong.npz", "is no table of skin"),
    ],
)
def test_a_wrong_table_is_refused(ball, tmp_path, name, message):
    from surftex.errors import InputError

    (tmp_path / "wrong.npz").write_bytes(b"wrong")
    path = tmp_path / "skin.toml"
    path.write_text(f'surftex = 1\n[[layer]]\nmaterial = "skin"\ntable = "{name}"\n', "utf-8")
    with pytest.raises(InputError, match=message):
        sx.bake(ball, str(path), resolution=32)
