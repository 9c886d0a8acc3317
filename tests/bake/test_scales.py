"""What a report says where features fit neither the mesh nor the texels."""

import json
import re
import time

import pytest

import surftex as sx
from surftex.bake.cost import START_S, bake_cost
from surftex.bake.scales import size_warnings
from surftex.cli import main
from surftex.recipe.model import Recipe
from surftex.recipe.read import recipe_for
from surftex.surface.shapes import plane, sphere


def warned(ball, leather, **options):
    return sx.bake(ball, leather, maps="height", uv="unwrap", unwrapper="uvunwrap", **options).report[
        "warnings"
    ]


def test_cells_below_three_texels_are_told_with_what_shows_them_well():
    leather = sx.Leather.preset("calf", cell_size=3.0, wrinkle_density=0, pore_density=0)
    ball = sphere(60.0, subdivisions=2)
    (said,) = warned(ball, leather, resolution=128)
    assert said.startswith("cells of 3 mm are 1.")
    assert said.endswith(
        "at 128, too few to be seen well; a resolution of 512 or udim with texels_per_mm = 1.7 (--udim --texels-per-mm 1.7) "
        "would do"
    )
    (said,) = warned(ball, leather, resolution=240)
    assert 2.5 < float(said.split(" are ")[1].split(" texels")[0]) < 3
    assert warned(ball, leather, resolution=288) == []


@pytest.mark.parametrize(
    ("density", "says"),
    [
        (1.0, "well; udim with texels_per_mm = 6.25 (--udim --texels-per-mm 6.25) would do"),
        (1.41, "a resolution of 8192 or udim with"),
        (3.7, "a resolution of 4096 or udim with"),
        (3.8, None),
    ],
)
def test_the_least_resolution_that_does_is_named(density, says):
    said = size_warnings(sx.Recipe.of(sx.Leather(cell_size=0.8)), 500.0, density, 2048).values()
    assert [says in each for each in said] == [True] if says else not said


def test_the_layer_is_named_where_there_are_several():
    layers = [{"preset": "calf"}, {"material": "leather", "cell_size": "600 mm"}]
    said = size_warnings(sx.Recipe(layer=layers), 500.0, 10.0, 2048).values()
    assert [each.split(" of ")[0] for each in said] == ["layer[2]: cells"]


def test_cells_larger_than_the_mesh_are_a_unit_that_slipped():
    leather = sx.Leather(cell_size="500 mm")
    (said,) = warned(sphere(10.0, subdivisions=2), leather, resolution=64)
    assert said == (
        "cells of 500 mm are larger than the mesh, whose longest side is 20 mm; is a unit wrong? "
        "units and size (--units, --size) scale the mesh"
    )


@pytest.mark.parametrize(("radius", "warns"), [(20.0, True), (50.0, False)])
def test_rows_of_scales_need_cells_enough(radius, warns):
    said = warned(sphere(radius, subdivisions=3), sx.Leather.preset("crocodile"), resolution=64)
    assert [
        each.startswith("layer: cell_shape box lays cells in rows, and the mesh holds only ") for each in said
    ] == [True] * warns


def test_what_a_pattern_says_of_itself_is_in_the_report():
    cells = sx.Cells(cell_size=4.0, generations=30, wrinkle_count=3, wrinkle_length=0.0)
    made = sx.bake(plane(40.0, 40.0), cells, resolution=64, maps="height")
    assert any(each.startswith("layer: ") for each in made.report["warnings"])


def test_inspect_tells_it_before_a_bake(tmp_path, capsys):
    from tests.test_cli import write_obj

    write_obj(tmp_path / "ball.obj", sphere(500.0, subdivisions=2))
    assert main(["inspect", str(tmp_path / "ball.obj"), "--units", "mm"]) == 0
    said = capsys.readouterr().out
    assert "warning: cells of 0.65 mm are 0.59" in said
    assert "texels wide at 2048, too few to be seen well; udim with texels_per_mm = 7.7 (--udim" in said
    assert main(["inspect", str(tmp_path / "ball.obj"), "--size", "1 um", "--json"]) == 0
    (said,) = json.loads(capsys.readouterr().out)["cost"]["warnings"]
    assert "larger than the mesh, whose longest side is 0.001 mm" in said
    assert bake_cost(sphere(50.0, subdivisions=2))["warnings"] == []


@pytest.mark.parametrize(
    ("material", "made_of", "placed", "finest"),
    [
        ("calf", "cells", {"cell", "pocket", "pore"}, ("pores", 0.13)),
        ("cells", "cells", {"particle", "cell"}, ("cells", 1.6)),
        ("skin", "furrows", {"pore"}, ("pores", 0.26)),
        ("gingham", "pixels", {"pixel"}, ("pixels", 1.6)),
        ("thesis", "cysts", {"cyst", "mole", "freckle", "follicle"}, None),
    ],
)
def test_a_cost_is_of_the_material_that_was_named(material, made_of, placed, finest):
    ball = sphere(10.0, subdivisions=2)
    cost = bake_cost(ball, material)
    assert (cost["material"], cost["made_of"], set(cost["placed"])) == (material, made_of, placed)
    assert cost["features"] == sum(cost["placed"].values())
    assert cost["cells"] == cost["placed"].get("cell", 0) + cost["placed"].get("pixel", 0)
    page = cost["pages"][1]
    if finest:
        assert (cost["finest"]["kind"], cost["finest"]["mm"]) == finest
    wide, side = cost["finest"]["mm"], cost["suggested_resolution"]
    assert (
        page["texels_per_mm"] / 2048 * side * wide >= 4.5 > page["texels_per_mm"] / 2048 * side / 2 * wide
        or side == 256
    )
    assert bake_cost(sphere(10000.0, subdivisions=2), material)["suggested_resolution"] is None


def test_as_many_cells_are_foreseen_as_a_bake_places():
    ball = sphere(10.0, subdivisions=3)
    for changes in ({"cell_ratio": 1.7}, {"cell_size": "1 + 0.03 * z"}):
        leather = sx.Leather(**{"cell_size": 1.0, **changes})
        foreseen = bake_cost(ball, "mine", Recipe.of(leather))["placed"]["cell"]
        assert foreseen == pytest.approx(len(leather.place(ball).features["cell"]), rel=0.15)


def test_inspect_takes_a_recipe_and_says_what_is_wrong_with_it(tmp_path, capsys):
    from tests.test_cli import write_obj

    write_obj(tmp_path / "ball.obj", sphere(10.0, subdivisions=2))
    mesh = [str(tmp_path / "ball.obj"), "--units", "mm"]
    (tmp_path / "mine.toml").write_text(
        'surftex = 1\n[[layer]]\nmaterial = "leather"\ncell_size = 2\npore_density = 0\n'
    )
    assert main(["inspect", *mesh, "--material", str(tmp_path / "mine.toml")]) == 0
    said = capsys.readouterr().out
    assert f"a bake of {tmp_path / 'mine.toml'}: about 2" in said
    assert "finest of the material: cells of 2 mm; --resolution 256 shows them well" in said
    assert main(["inspect", *mesh, "--material", "skin"]) == 0
    said = capsys.readouterr().out
    assert "across a furrow" in said
    assert "  made of furrows of 0.85 mm; --resolution 256 shows them well\n" in said
    assert "  finest of the material: pores of 0.26 mm; --resolution 1024 shows them well\n" in said
    assert " cell" not in said
    assert main(["inspect", *mesh, "--material", "no-such"]) == 2
    assert main(["inspect", *mesh]) == 0
    assert "a bake of calf: about" in capsys.readouterr().out


def test_inspect_says_that_a_bake_would_be_refused_and_what_mends_it(tmp_path, capsys):
    from tests.test_cli import write_obj

    ball = sphere(500.0, subdivisions=2)
    write_obj(tmp_path / "ball.obj", ball)
    mesh = str(tmp_path / "ball.obj"), "--units", "mm"
    assert main(["inspect", *mesh, "--material", "calf"]) == 0
    said = capsys.readouterr().out
    refused = next(row for row in said.splitlines() if "would be refused" in row).split("refused: ")[1]
    assert re.search(
        r"most of them pockets .* raise cell_size to \S+ mm and lower pore_density to \S+, scale a mesh",
        refused,
    )
    assert (
        main(["bake", *mesh, "--material", "calf", "--resolution", "64", "--out", str(tmp_path / "o")]) == 2
    )
    assert (
        capsys.readouterr().err.splitlines()[-1] == f"surftex: {refused}"
    )  # after a note where kernels are compiled
    layers = [{"preset": "calf", "mask": mask} for mask in (1, 1, 0)]
    recipe = Recipe(layer=layers, bake={"max_features": round(1.5 * bake_cost(ball, "calf")["features"])})
    assert re.match(r"layer\[2\]: leather.cell_size: ", bake_cost(ball, "r", recipe)["refused"])
    assert bake_cost(sphere(50.0, subdivisions=2), "calf")["refused"] is None


def test_the_estimate_counts_the_rounds_that_even_cells_out(tmp_path):
    ball = sphere(50.0, subdivisions=3)
    seconds = {}
    for rounds in (0, 3, 12):
        (tmp_path / "r.toml").write_text(
            f'[[layer]]\npreset = "calf"\ncell_size = 0.5\nregularity = {rounds}\n'
        )
        cost = bake_cost(ball, str(tmp_path / "r.toml"))
        seconds[rounds] = cost["pages"][0]["seconds"]
    assert seconds[3] - seconds[0] > 0.5 * seconds[0]
    assert seconds[12] - seconds[3] == pytest.approx(9 / 12 * (seconds[3] - seconds[0]), rel=0.05)


LEATHER = {"cell_size": 0.5, "pore_density": 0.0, "pocket_depth": 0.0}


def foreseen_s(leather):
    return bake_cost(sphere(50.0, subdivisions=3), "mine", Recipe.of(leather))["pages"][0]["seconds"]


@pytest.mark.parametrize(
    ("changes", "more"),
    [
        (
            {"cell_size": 0.5 * 2**0.5, "cell_ratio": 2.0},
            3.0,
        ),  # as many cells, in the reach of four times as many
        ({"cell_size": "0.7071", "cell_ratio": "2 + 0 * x"}, 3.0),
        ({"pocket_depth": 0.1}, 1.1),
        ({"invasion": 0.2}, 3.0),
        ({"pore_density": 20.0, "pore_group": 3}, 2.0),
        ({"crown_spacing": 0.5}, 1.8),
    ],
)
def test_an_estimate_counts_what_hangs_on_cells_and_how_far_they_reach(changes, more):
    start = foreseen_s(sx.Leather(cell_size=50.0))
    plain = foreseen_s(sx.Leather(**LEATHER)) - start
    assert foreseen_s(sx.Leather(**{**LEATHER, **changes})) - start > more * plain


GROWN = {"cell_size": 1.0, "potential_force": 0.02}


@pytest.mark.parametrize(
    ("changes", "more"),
    [
        ({"potential": "x / 50"}, 1.3),
        ({"wrinkle_count": 400, "wrinkle_potential": 1.0}, 1.5),
        ({"wrinkle_count": 400}, 1.01),
        ({"cell_ratio": 3.0}, 1.6),
        ({"cell_ratio": "0.25 + 0 * x"}, 1.6),
        ({"attraction": 0.5}, 1.4),
        ({"generations": 190}, 1.3),
    ],
)
def test_an_estimate_counts_what_drives_a_growth(changes, more):
    start = foreseen_s(sx.Cells(cell_size=100.0))
    plain = foreseen_s(sx.Cells(**GROWN)) - start
    assert more * plain < foreseen_s(sx.Cells(**{**GROWN, **changes})) - start < 2.6 * plain


def test_a_potential_without_force_costs_nothing():
    plain = foreseen_s(sx.Cells(cell_size=1.0, potential_force=0.0))
    assert foreseen_s(sx.Cells(cell_size=1.0, potential_force=0.0, potential="x / 50")) == plain


def test_an_estimate_counts_that_shapes_are_evened_out_more_slowly_than_rounds():
    even = {**LEATHER, "regularity": 8}
    round_s, shaped_s = (foreseen_s(sx.Leather(**even, cell_shape=shape)) for shape in ("round", "ellipse"))
    assert shaped_s > 1.4 * round_s


def test_an_estimate_counts_the_texels_of_every_layer():
    ball = sphere(50.0, subdivisions=3)
    one, two, three = (
        bake_cost(
            ball,
            "mine",
            Recipe(layer=[{"preset": "skin", "pore_density": 0, "mask": mask} for mask in masks]),
        )
        for masks in ((1,), (1, 1), (1, 1, 0))
    )
    first, second, third = (
        cost["pages"][3]["seconds"] - cost["pages"][2]["seconds"] for cost in (one, two, three)
    )
    assert second > 1.4 * first
    assert third == second


@pytest.mark.slow
@pytest.mark.parametrize(
    "preset", ["sakurai-12c", "sakurai-12i", "lizard", "cells", "creased", "field-driven"]
)
def test_a_bake_takes_about_as_much_of_the_processor_as_was_foreseen(preset):
    ball = sphere(35.0, subdivisions=4)
    recipe = Recipe.of(recipe_for(preset), resolution=1024)
    sx.bake(sphere(4.0, subdivisions=2), recipe)  # so that kernels are there
    foreseen = bake_cost(ball, preset, recipe)["pages"][0]["cpu_s"] - START_S
    began = time.process_time()
    sx.bake(ball, recipe)
    assert 0.7 < foreseen / (time.process_time() - began) < 1.6
