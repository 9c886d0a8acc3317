"""A features file says what placed it; a bake that says otherwise is refused, and one that says nothing takes its seed."""

import json
import re
import shutil
import zipfile

import pytest

import surftex as sx
from surftex.bake.placed import placed_by, start_from
from surftex.cli import main
from surftex.recipe.read import recipe_from_text
from surftex.surface.shapes import sphere

BALL = sphere(15.0, subdivisions=2)
CHANGES = {"cell_size": 3.0, "wrinkle_density": 0, "pore_density": 0.5}


def leather(**changes):
    return sx.Leather.preset("calf", **CHANGES | changes)


def bake(material, ball=BALL, **options):
    return sx.bake(ball, material, resolution=32, maps="height", uv="unwrap", unwrapper="uvunwrap", **options)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("placed")
    bake(leather(), seed=7).save(folder / "out")
    return folder / "out" / "features.npz"


def test_a_bake_that_says_no_seed_takes_that_of_the_file(made):
    first, again = bake(leather(), seed=7), bake(leather(), features=made)
    assert again.report["seed"] == 7
    assert again.report["recipe"]["seed"] == 7
    assert again["height"].tobytes() == first["height"].tobytes()


def test_colours_and_depths_may_differ(made):
    deeper = bake(leather(crista_height=0.5, color="#ff0000", roughness=0.9), features=made)
    assert deeper["height"].mean() > 5 * bake(leather(), seed=7)["height"].mean()
    assert not [text for text in deeper.report["warnings"] if "placed" in text]


@pytest.mark.parametrize(
    ("material", "options", "says"),
    [
        (leather(), {"seed": 3}, "seed 7, and this bake says 3"),
        (leather(cell_size=1.0), {}, "cell_size 3, and this bake says 1"),
        (leather(pore_density=2.0), {}, "pore_density 0.5, and this bake says 2"),
        (sx.Skin(), {}, "material leather, and this bake says skin"),
        (leather(), {"ball": sphere(30.0, subdivisions=2)}, "size 30 mm, and this bake says 60 mm"),
    ],
)
def test_what_concerns_placing_may_not(made, material, options, says):
    with pytest.raises(sx.InputError, match=rf"features\.npz: was placed with {says}; make them alike"):
        bake(material, features=made, **options)


def test_the_command_refuses_in_one_line(made, tmp_path, capsys, monkeypatch):
    from tests.test_cli import write_obj

    write_obj(tmp_path / "ball.obj", BALL)
    monkeypatch.chdir(tmp_path)
    arguments = ["bake", "ball.obj", "--material", "calf", "--units", "mm", "--features", str(made), "-q"]
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "was placed with cell_size 3, and this bake says 0.65" in said


def test_a_file_that_does_not_say_is_a_warning(made, tmp_path):
    old = shutil.copy(made, tmp_path / "old.npz")
    with zipfile.ZipFile(old, "a") as archive:
        archive.comment = b""
    assert any(
        "does not say what placed it" in text for text in bake(leather(), features=old).report["warnings"]
    )


@pytest.mark.parametrize(
    "comment", [b"{", b"[" * 60_000, b"7", b'{"layer": 3}', b'{"layer": [{}], "size_mm": "a"}']
)
def test_what_a_file_says_is_not_trusted(made, tmp_path, comment):
    odd = shutil.copy(made, tmp_path / "odd.npz")
    with zipfile.ZipFile(odd, "a") as archive:
        archive.comment = comment
    said = ""
    try:
        said = "\n".join(bake(leather(), features=odd).report["warnings"])
    except sx.InputError as problem:
        said = str(problem)
    assert re.search(r"odd.npz: (does not say what placed it|was placed with )", said)


def test_a_kind_that_is_missing_is_told():
    made = bake(leather(), seed=7)
    cells = {kind: table for kind, table in (made.features or {}).items() if kind != "pore"}
    with pytest.raises(sx.RecipeError, match=r"pore_density is 0.5, and the features hold no pore"):
        bake(leather(), seed=7, features=cells)


def test_fields_count_where_placing_uses_them(tmp_path):
    def recipe(**fields):
        rows = "\n".join(f"{name} = {json.dumps(value)}" for name, value in fields.items())
        return recipe_from_text(
            f"[fields]\n{rows}\n[[layer]]\npreset = 'calf'\ncell_size = '2 + far'\nmask = 'cover'\n"
        )

    from surftex.files.features import save_features

    first = recipe(near="x", far="0.1 * near", cover="x")
    told = json.loads(json.dumps(placed_by(first, BALL)))
    assert told["fields"] == {"near": "x", "far": "0.1 * near"}
    save_features(tmp_path / "features.npz", {}, told)
    start_from(tmp_path / "features.npz", recipe(near="x", far="0.1 * near", cover="y"), BALL)
    with pytest.raises(sx.InputError, match=r"fields\.near x, and this bake says y"):
        start_from(tmp_path / "features.npz", recipe(near="y", far="0.1 * near", cover="x"), BALL)
