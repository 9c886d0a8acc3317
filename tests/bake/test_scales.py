"""What a report says where features fit neither the mesh nor the texels."""

import json

import pytest

import surftex as sx
from surftex.bake.cost import bake_cost
from surftex.bake.scales import size_warnings
from surftex.cli import main
from surftex.surface.shapes import plane, sphere


def warned(ball, leather, **options):
    return sx.bake(ball, leather, maps="height", uv="unwrap", unwrapper="uvunwrap", **options).report[
        "warnings"
    ]


def test_cells_below_two_texels_are_told_with_what_would_do():
    leather = sx.Leather.preset("calf", cell_size=3.0, wrinkle_density=0, pore_density=0)
    ball = sphere(60.0, subdivisions=2)
    (said,) = warned(ball, leather, resolution=128)
    assert said.startswith("cells of 3 mm are 1.")
    assert said.endswith(
        "at 128, too few to be seen; --resolution 256 or --udim --texels-per-mm 0.7 would do"
    )
    assert warned(ball, leather, resolution=256) == []


@pytest.mark.parametrize(
    ("density", "says"),
    [(1.0, "--resolution 8192 or --udim"), (0.05, "seen; --udim --texels-per-mm 2.5 would do"), (2.6, None)],
)
def test_the_least_resolution_that_does_is_named(density, says):
    said = size_warnings(sx.Recipe.of(sx.Leather(cell_size=0.8)), 500.0, density, 2048)
    assert [says in each for each in said] == [True] if says else said == ()


def test_the_layer_is_named_where_there_are_several():
    layers = [{"preset": "calf"}, {"material": "leather", "cell_size": "600 mm"}]
    said = size_warnings(sx.Recipe(layer=layers), 500.0, 10.0, 2048)
    assert [each.split(" of ")[0] for each in said] == ["layer[2]: cells"]


def test_cells_larger_than_the_mesh_are_a_unit_that_slipped():
    leather = sx.Leather(cell_size="500 mm")
    (said,) = warned(sphere(10.0, subdivisions=2), leather, resolution=64)
    assert said == (
        "cells of 500 mm are larger than the mesh, whose longest side is 20 mm; is a unit wrong? --units and --size scale "
        "the mesh"
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
    assert (
        "warning: cells of 0.65 mm are 0.6 texels wide at 2048, too few to be seen; --resolution 8192 or"
        in (capsys.readouterr().out)
    )
    assert main(["inspect", str(tmp_path / "ball.obj"), "--size", "1 um", "--json"]) == 0
    (said,) = json.loads(capsys.readouterr().out)["cost"]["warnings"]
    assert "larger than the mesh, whose longest side is 0.001 mm" in said
    assert bake_cost(sphere(50.0, subdivisions=2))["warnings"] == []
