"""What a bake says before it works: each warning once, as soon as it is known, and the time where that is long."""

import json

import pytest

import surftex as sx
from surftex.bake import advising
from surftex.bake.bake import run
from surftex.cli import main
from surftex.files.meshout import write_mesh
from surftex.recipe.model import Recipe
from surftex.surface.shapes import plane, sphere
from tests.bake.waves import Waves

CALF = sx.Leather.preset("calf", cell_size=3.0, wrinkle_density=0, pore_density=0)


class Listener:
    """Keeps what is said and which stages begin, in their order."""

    def __init__(self):
        self.heard = []

    def say(self, line):
        self.heard.append(line)

    def __call__(self, stage, share):
        if stage not in self.heard:
            self.heard.append(stage)


@pytest.fixture
def sheet(tmp_path):
    """A file that names no unit, with UVs of its own."""
    flat = plane(60.0, cells=6)
    path = tmp_path / "sheet.obj"
    write_mesh(path, flat.vertices, flat.faces, flat.corner_uv)
    path.write_text("\n".join(row for row in path.read_text().splitlines() if row[0] != "#") + "\n")
    return path


def heard(recipe, subject, **options):
    listener = Listener()
    warnings = run(recipe, subject, progress=listener, **options).maps.report["warnings"]
    assert [each for each in listener.heard if listener.heard.count(each) > 1] == []
    return listener.heard, warnings


def test_warnings_of_loading_are_told_before_anything_is_done(sheet):
    said, warnings = heard(Recipe.of(Waves(), resolution=64), sheet)
    (first,) = warnings
    assert first.startswith("the file names no unit")
    assert said[:2] == ["load", f"warning: {first}"]
    assert [each for each in said if ": " in each] == [f"warning: {first}"]


@pytest.mark.parametrize("uv", ["keep", "unwrap"])
def test_too_few_texels_are_told_before_placing_and_once(uv, sheet):
    said, warnings = heard(Recipe.of(CALF, resolution=64, uv=uv), sheet)
    (told,) = [each for each in said if " texels wide at 64" in each]
    (kept,) = [each for each in warnings if " texels wide at 64" in each]
    assert said.index(told) < said.index("place")
    assert "about" not in kept
    assert (told == f"warning: {kept}") == (uv == "keep")  # the density is known, or foreseen
    assert sum("warning: " in each for each in said) == len(warnings)


def test_a_page_that_turns_out_too_coarse_is_told_when_that_is_known(monkeypatch):
    monkeypatch.setattr(advising, "foreseen_density", lambda surface, side: 10.0)
    said, warnings = heard(Recipe.of(CALF, resolution=64), sphere(60.0, subdivisions=2))
    (kept,) = [each for each in warnings if " texels wide at 64" in each]
    assert said.index("place") < said.index(f"warning: {kept}") < said.index("bake")


def test_own_uvs_that_will_not_do_are_told_before_placing(sheet):
    lines = sheet.read_text().splitlines()
    texel = [f"vt {0.5 * float(row.split()[1])} 0.5" if row[:2] == "vt" else row for row in lines]
    texel[next(i for i, row in enumerate(texel) if row[:2] == "vt")] = "vt 0.9 0.9"
    sheet.write_text("\n".join(texel) + "\n")
    said, warnings = heard(Recipe.of(Waves(), resolution=64), sheet)
    (kept,) = [each for each in warnings if each.startswith("unwrapped anew")]
    assert said.index(f"warning: {kept}") < said.index("place")


def test_long_bakes_tell_their_time_before_placing_and_short_ones_do_not(sheet, monkeypatch):
    recipe = Recipe.of(CALF, resolution=64)
    assert not any(each.startswith("note: ") for each in heard(recipe, sheet)[0])
    monkeypatch.setattr(advising, "bake_seconds", lambda *args, **options: 61.0)
    said, warnings = heard(recipe, sheet)
    told = [each for each in said if each.startswith("note: ")]
    assert told == ["note: this will take about 60 seconds"]
    assert not any("will take" in each for each in warnings)
    assert said.index(told[0]) == said.index("place") + 1


def test_features_are_foreseen_once(monkeypatch):
    from surftex.bake import limits

    asked, foresee = [], limits.foresee
    monkeypatch.setattr(limits, "foresee", lambda *args: asked.append(args) or foresee(*args))
    heard(Recipe.of(CALF, resolution=64), sphere(20.0, subdivisions=2))
    assert len(asked) == 1


def test_the_time_is_the_one_that_inspect_tells():
    from surftex.bake.cost import bake_cost, bake_seconds
    from surftex.bake.fields import make_fields
    from surftex.bake.limits import foresee

    ball = sphere(60.0, subdivisions=2)
    for side in (1024, 4096):
        recipe = Recipe.of(CALF, resolution=side)
        page = next(each for each in bake_cost(ball, "", recipe)["pages"] if each["resolution"] == side)
        foreseen = foresee(recipe, ball, make_fields(recipe, ball))
        assert bake_seconds(recipe, ball, foreseen) == pytest.approx(page["seconds"], abs=0.06)
        assert bake_seconds(recipe, ball, foreseen, tiles=3) > 1.5 * page["seconds"] or side == 1024


@pytest.mark.parametrize(
    ("seconds", "says"), [(61, "60 seconds"), (150, "2 minutes"), (3700, "62 minutes"), (9000, "2 hours")]
)
def test_times_are_in_the_unit_that_a_reader_would_take(seconds, says):
    assert advising._lasting(seconds) == says


def test_the_command_prints_each_warning_once_and_none_when_quiet(sheet, capsys):
    command = [
        "bake",
        str(sheet),
        "--material",
        "calf",
        "--set",
        "cell_size=3 mm",
        "--set",
        "wrinkle_density=0",
    ]
    command += [
        "--set",
        "pore_density=0",
        "--resolution",
        "64",
        "--no-cache",
        "--out",
        str(sheet.parent / "out"),
    ]
    assert main(command) == 0
    said = capsys.readouterr().err.splitlines()
    report = json.loads((sheet.parent / "out" / "report.json").read_text())
    assert len(report["warnings"]) >= 2
    for warning in report["warnings"]:
        assert said.count(f"surftex: warning: {warning}") == 1
    assert sum("warning: " in line for line in said) == len(report["warnings"])
    assert main([*command, "-q", "--overwrite"]) == 0
    assert capsys.readouterr().err == ""
