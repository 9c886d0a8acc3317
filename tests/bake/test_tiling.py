"""Tiles as maps: borders match, wrinkles and potentials repeat, pictures drive the growth, the command says what is wrong."""

import json

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import KDTree

from surftex.bake.growing import Growth
from surftex.bake.tiling import bake_tile, tile_normals
from surftex.errors import InputError
from surftex.materials.cells.model import Cells
from surftex.materials.cells.tile import sheet_of
from surftex.materials.cells.tile_fields import sheet_points, tile_direction
from surftex.materials.cells.tile_wrinkles import nearest_wrinkle
from surftex.recipe.model import Recipe
from tests.test_cli import surftex

LAYER = {"material": "cells", "cell_size": 1.5, "generations": 70, "blob_density": 0.0}


def recipe(fields=None, bake=None, **changes):
    return Recipe.model_validate(
        {"fields": fields or {}, "bake": {"resolution": 96, **(bake or {})}, "layer": [{**LAYER, **changes}]}
    )


def test_borders_of_every_map_match():
    maps = bake_tile(recipe(wrinkle_count=6, wrinkle_length=30, wrinkle_depth=0.3, stress=None), 18.0)
    for name in ("height", "normal", "base_color", "roughness"):
        image = maps[name].astype(float)
        inside = np.abs(np.diff(image, axis=0)).mean(), np.abs(np.diff(image, axis=1)).mean()
        across = np.abs(image[0] - image[-1]).mean(), np.abs(image[:, 0] - image[:, -1]).mean()
        assert max(across) < 1.5 * max(inside)
    assert maps.report["cells"]["count"] == len(maps.features["cell"])
    assert 0.45 < maps.report["cells"]["triangles"] + 0.15 < 0.8


def test_normals_are_those_of_a_wave_that_repeats():
    side, count = 10.0, 200
    x = (np.arange(count) + 0.5) * side / count
    wave = 2 * np.pi / side
    height = np.tile(0.3 * np.sin(wave * x), (count, 1))
    slope = 0.3 * wave * np.cos(wave * x)
    normal = tile_normals(height, side)
    np.testing.assert_allclose(-normal[5, :, 0] / normal[5, :, 2], slope, atol=1e-4)
    np.testing.assert_allclose(normal[..., 1], 0, atol=1e-7)
    up = tile_normals(np.ascontiguousarray(height.T[::-1]), side)
    np.testing.assert_allclose(-up[::-1, 5, 1] / up[::-1, 5, 2], slope, atol=1e-4)


def test_wrinkles_of_a_tile_are_nearest_as_by_brute_force():
    tile = Cells(cell_size=1.5, generations=70, wrinkle_count=5, wrinkle_length=40.0).tile(20.0, 2)
    table = tile.features["wrinkle"]
    assert len(np.unique(table["curve"])) == 5
    assert table["length_mm"].min() > 10
    place = 20 * np.random.Generator(np.random.PCG64(2)).uniform(size=(300, 2))
    found, along, length = nearest_wrinkle(table, 20.0, place, KDTree(place, boxsize=20.0), 2.0)
    shifts = np.array([[x, y] for x in (-20, 0, 20) for y in (-20, 0, 20)])
    start = (table["from_mm"][:, None] + shifts).reshape(-1, 2)
    step = np.repeat(table["to_mm"] - table["from_mm"], 9, axis=0)
    offset = place[:, None] - start[None]
    share = np.clip((offset * step).sum(axis=2) / (step**2).sum(axis=1), 0, 1)
    apart = np.linalg.norm(offset - share[..., None] * step, axis=2).min(axis=1)
    near = apart < 2.0
    assert near.sum() > 50
    np.testing.assert_allclose(found[near], apart[near], atol=1e-9)
    assert (along[near] <= length[near] + 1e-9).all()
    sunk = tile.at(place[apart < 0.1])["height_mm"].mean()
    assert sunk < tile.at(place[apart > 1.0])["height_mm"].mean() - 0.05


def test_a_direction_of_the_sheet_is_one_of_the_tile():
    sheet = sheet_of(10.0)
    place = np.array([[1.0, 2.0], [9.9, 0.1], [5.0, 5.0]])
    np.testing.assert_allclose(
        sheet_points(sheet, place).positions(sheet)[:, :2] + sheet.origin_mm[:2], place
    )
    from surftex.geodesics.directions import DirectionField

    along = DirectionField.from_axis(sheet, (1.0, 1.0, 0.0))
    np.testing.assert_allclose(np.tan(tile_direction(sheet, along)(place)), 1.0, atol=1e-6)


def test_cells_of_a_tile_are_long_where_they_are_told():
    fields = {"up": {"axis": [0, 1, 0]}}
    told = recipe(fields, cell_ratio=2.0, direction="up")
    corner = bake_tile(told, 24.0).features["cell"]["corner_mm"]
    assert np.ptp(corner[..., 1], axis=1).mean() > 1.3 * np.ptp(corner[..., 0], axis=1).mean()


def test_a_picture_drives_particles_from_where_it_is_bright(tmp_path):
    x = np.arange(64)
    grey = np.tile(127 + 120 * np.cos(2 * np.pi * x / 64), (64, 1)).astype(np.uint8)
    Image.fromarray(grey).save(tmp_path / "waves.png")
    fields = {"waves": {"image": str(tmp_path / "waves.png")}}
    driven = bake_tile(recipe(fields, potential="waves", potential_height=12, potential_force=0.04), 24.0)
    place = driven.features["particle"]["place_mm"][:, 0]
    dark = (place > 8) & (place < 16)
    plain = bake_tile(recipe(), 24.0).features["particle"]["place_mm"][:, 0]
    assert dark.sum() > 1.15 * ((plain > 8) & (plain < 16)).sum()


def test_a_potential_that_does_not_repeat_is_said(tmp_path):
    ramp = np.tile(np.linspace(0, 255, 64), (64, 1)).astype(np.uint8)
    Image.fromarray(ramp).save(tmp_path / "ramp.png")
    fields = {"ramp": {"image": str(tmp_path / "ramp.png")}}
    (said,) = bake_tile(recipe(fields, potential="ramp", generations=10), 24.0).report["warnings"]
    assert "'ramp' does not repeat: it differs at left and right by 0.9" in said
    waves = "0.5 + 0.5 * sin(0.2617993878 * x)"
    assert bake_tile(recipe(potential=waves, generations=10), 24.0).report["warnings"] == []


def test_wrinkles_that_were_asked_for_and_are_not_there_are_said():
    (said,) = bake_tile(recipe(wrinkle_density=0.01, generations=10), 20.0).report["warnings"]
    assert (
        "no wrinkle was placed: 0.004 were asked for (wrinkle_density is per 1000 mm^2, and there are 400"
        in said
    )
    assert bake_tile(recipe(wrinkle_density=10, generations=20), 20.0).report["warnings"] == []


def test_what_is_no_tile_is_refused_in_a_line():
    two = Recipe.model_validate({"layer": [LAYER, LAYER]})
    with pytest.raises(InputError, match="a tile takes one layer; this recipe has 2"):
        bake_tile(two, 20.0)
    with pytest.raises(InputError, match="leather needs a mesh; tiles are made of cells"):
        bake_tile(Recipe.model_validate({"layer": [{"preset": "calf"}]}), 20.0)
    with pytest.raises(InputError, match="leave the mask out"):
        bake_tile(Recipe.model_validate({"layer": [{**LAYER, "mask": 0.5}]}), 20.0)
    with pytest.raises(InputError, match="a tile has no map 'ambient_occlusion'"):
        bake_tile(recipe(bake={"maps": ["ambient_occlusion"]}), 20.0)
    with pytest.raises(InputError, match=r"layer: cells\.potential: 'none_such': unknown field"):
        bake_tile(recipe(potential="none_such"), 20.0)


def test_threads_change_no_byte_and_a_tile_goes_on(tmp_path):
    one = bake_tile(recipe(), 18.0, threads=1)
    growth = tmp_path / "growth.npz"
    bake_tile(recipe(generations=40), 18.0, growth=Growth(growth))
    two = bake_tile(recipe(), 18.0, threads=2, growth=Growth(growth))
    for name in one:
        np.testing.assert_array_equal(one[name], two[name])
    with pytest.raises(
        InputError, match="grew on another mesh, on other bodies of it, or on a tile of another side"
    ):
        bake_tile(recipe(), 21.0, growth=Growth(growth))


def test_the_command_makes_a_tile(tmp_path):
    (tmp_path / "mine.toml").write_text(
        'surftex = 1\n[fields]\nwaves = { image = "waves.png", size = [32, 32] }\n'
        '[[layer]]\nmaterial = "cells"\ncell_size = "2 mm"\ngenerations = 40\npotential = "waves"\n',
        "utf-8",
    )
    grey = np.zeros((32, 32), np.uint8)
    grey[:, 16:] = 200
    Image.fromarray(grey).save(tmp_path / "waves.png")
    call = "tile", "mine.toml", "--side", "3 cm", "--resolution", "64"
    done = surftex(*call, "--json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["tile"] == {"side_mm": 30.0, "mm_per_texel": 30 / 64}
    assert set(report["outputs"]) == {path.name for path in (tmp_path / "mine-tile").iterdir()} - {
        "report.json"
    }
    again = surftex(*call, folder=tmp_path)
    assert again.returncode == 2
    assert "--overwrite" in again.stderr
    Image.fromarray(grey[:20]).save(tmp_path / "waves.png")
    wrong = surftex(*call, "--overwrite", folder=tmp_path)
    assert wrong.returncode == 2
    assert (
        wrong.stderr
        == "surftex: mine.toml:3: fields.waves: waves.png has 32 x 20 pixels, not size = [32, 32]\n"
    )
    (tmp_path / "waves.png").unlink()
    gone = surftex(*call, "--overwrite", folder=tmp_path)
    assert gone.returncode == 2
    assert gone.stderr.startswith("surftex: mine.toml:3: fields.waves: ")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("even", "--side", "wide"), "--side: 'wide' is not a length"),
        (("even", "--side", "-3 mm"), "a tile of -3 mm has no place"),
        (("evn", "--side", "3 cm"), "there is no preset 'evn'; did you mean even?"),
        (("even", "--side", "3 cm", "--set", "cells.generations=0"), "generations"),
        (("even", "--side", "3 cm", "--set", "cells.cell_size=-1"), "cell_size"),
        (("even", "--side", "3 cm", "--set", "cells.births=0"), "births"),
        (("calf", "--side", "3 cm"), "leather needs a mesh"),
        (("even",), "--side"),
    ],
)
def test_bad_tiles_are_told_in_a_line(arguments, says, tmp_path, capsys):
    from surftex.cli.main import main

    assert main(["tile", *arguments, "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert says in said
    assert not (tmp_path / "out").exists()
