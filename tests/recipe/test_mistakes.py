"""Each mistake in a recipe is told in one line, with file, line, key and what may have been meant."""

import pytest

from surftex.errors import RecipeError
from surftex.materials.leather.model import Leather
from surftex.recipe.read import load_recipe, recipe_for, recipe_from_preset, recipe_from_text

GOOD = """surftex = 1
seed = 7
[mesh]
path = "shoe.glb"
units = "m"
[bake]
resolution = 4096
maps = ["base_color", "height"]
[fields]
wear = { curvature = "convex", radius = "4 mm" }
toe = { image = "toe.png" }
both = "wear * toe"
grain = { axis = [0, 0, 1] }
[[layer]]
material = "leather"
preset = "calf"
cell_size = "0.9 mm"
cell_ratio = 1.4
direction = "grain"
mask = "1 - 0.7 * toe"
"""


def refused(text, **options):
    with pytest.raises(RecipeError) as problem:
        recipe_from_text(text, name="shoe.toml", **options)
    message = str(problem.value)
    assert "\n" not in message
    return message


def test_a_right_recipe_is_read():
    recipe = recipe_from_text(GOOD, name="shoe.toml")
    assert recipe.seed == 7
    assert recipe.bake.resolution == 4096
    assert recipe.layer[0].material.cell_size == 0.9
    assert recipe.layer[0].material.sulcus_depth == Leather.preset("calf").sulcus_depth
    assert recipe.layer[0].mask == "1 - 0.7 * toe"
    written = recipe.written_out()
    assert written["layer"][0]["preset"] == "calf"
    assert written["fields"]["wear"] == {"curvature": "convex", "radius": 4.0}


MISTAKES = [
    ("cell_size =", "cell_sise =", "shoe.toml:17: layer.cell_sise: unknown key; did you mean cell_size?"),
    ("4096", '"4096"', "shoe.toml:7: bake.resolution: '4096': should be a valid integer"),
    ("4096", "8", "shoe.toml:7: bake.resolution: 8: should be greater than or equal to 16"),
    ("0.9 mm", "0.9 mmm", "shoe.toml:17: layer.cell_size: '0.9 mmm': unknown unit 'mmm'; known are um"),
    (
        '0.7 * toe"\n',
        '0.7 * tow"\n',
        "shoe.toml:20: layer.mask: '1 - 0.7 * tow': unknown field 'tow'; did you mean toe?",
    ),
    (
        '0.7 * toe"\n',
        '0.7 * grain"\n',
        "shoe.toml:20: layer.mask: '1 - 0.7 * grain': field 'grain' is a direction, not a number",
    ),
    (
        "wear * toe",
        "wear * both",
        "shoe.toml:9: fields: fields refer to each other in a circle: both -> both",
    ),
    ('"calf"', '"claf"', "shoe.toml:16: layer.preset: there is no leather preset 'claf'; did you mean calf?"),
    (
        '"leather"',
        '"lether"',
        "shoe.toml:15: layer.material: unknown material 'lether'; did you mean leather?",
    ),
    ("resolution", "resolutoin", "shoe.toml:7: bake.resolutoin: unknown key; did you mean resolution?"),
    ("[bake]", "[bakke]", "shoe.toml:6: bakke: unknown key; did you mean bake?"),
    (
        '"grain"',
        '"grian"',
        "shoe.toml:19: layer.direction: field 'grian' does not exist; did you mean grain?",
    ),
    ('"grain"', '"toe"', "shoe.toml:19: layer.direction: field 'toe' is a number, not a direction"),
    (
        "{ axis = [0, 0, 1] }",
        '{ curves = "lines.json" }',
        "shoe.toml:19: layer.direction: field 'grain' is curves, not a direction",
    ),
    (
        "cell_ratio = 1.4",
        'wrinkle_curves = "grain"',
        "shoe.toml:18: layer.wrinkle_curves: field 'grain' is a direction, not curves",
    ),
    (
        "cell_ratio = 1.4",
        'wrinkle_curves = "toe"',
        "shoe.toml:18: layer.wrinkle_curves: field 'toe' is a number, not curves",
    ),
    ("convex", "konvex", "shoe.toml:10: fields.wear.curvature: 'konvex': should be 'convex' or 'concave'"),
    ("{ image", "{ imagge", "shoe.toml:11: fields.toe.imagge: unknown key; did you mean image?"),
    ("toe =", "max =", "shoe.toml:11: fields.max: 'max' cannot name a field"),
    ("radius", "radios", "shoe.toml:10: fields.wear.radios: unknown key; did you mean radius?"),
    ('"4 mm"', '"-4 mm"', "shoe.toml:10: fields.wear.radius: '-4 mm': should be greater than 0"),
    ("[0, 0, 1]", "[0, 1]", "shoe.toml:13: fields.grain.axis[3]: this key is needed and missing"),
    (
        "surftex = 1",
        "surftex = 2",
        "shoe.toml:1: surftex: 2: this surftex reads version 1 of the format; write surftex = 1",
    ),
    ('"height"', '"hieght"', "shoe.toml:8: bake.maps: unknown map 'hieght'; did you mean height?"),
    ("seed = 7", "seed = 7.5", "shoe.toml:2: seed: 7.5: should be a valid integer"),
    ("seed = 7", "seed = ", "shoe.toml:2: invalid value: seed ="),
    ("seed = 7", "seed = 7\nseed = 8", "shoe.toml:3: cannot overwrite a value: seed = 8"),
    (
        '"0.9 mm"',
        "0.9 mm",
        "shoe.toml:17: expected newline or end of document after a statement: cell_size = 0.9 mm; write a length in",
    ),
    ("1.4", "0.2", "shoe.toml:18: layer.cell_ratio: 0.2: should be greater than or equal to 1"),
    ("1.4", "'0.2'", "shoe.toml:18: layer.cell_ratio: 0.2: should be greater than or equal to 1"),
    (
        "cell_ratio = 1.4",
        "invasion = -1",
        "shoe.toml:18: layer.invasion: -1: should be greater than or equal to 0",
    ),
    ("1.4", "true", "shoe.toml:18: layer.cell_ratio: true is neither a number nor text"),
    (
        "cell_ratio = 1.4",
        "pore_group = 99",
        "shoe.toml:18: layer.pore_group: 99: should be less than or equal to 7",
    ),
    ("cell_ratio = 1.4", "color = 'red'", "shoe.toml:18: layer.color: 'red' is no colour; write '#8a5a34'"),
    ("[[layer]]", "[layer]", "shoe.toml:14: layer: write [[layer]] with two brackets"),
    (
        "shoe.glb",
        "../shoe.glb",
        "shoe.toml:4: mesh.path: '../shoe.glb' leaves the recipe's folder; allow it with allow_outside (--allow-outside)",
    ),
    ("toe.png", "/etc/toe.png", "shoe.toml:11: fields.toe.image: '/etc/toe.png' leaves the recipe's folder"),
    ('units = "m"', 'units = "km"', "shoe.toml:5: mesh.units: 'km': should be 'mm', 'cm', 'm' or 'in'"),
]


@pytest.mark.parametrize(
    ("right", "wrong", "message"), MISTAKES, ids=[wrong.strip() for _, wrong, _ in MISTAKES]
)
def test_a_mistake_is_located(right, wrong, message):
    assert right in GOOD
    said = refused(GOOD.replace(right, wrong))
    assert said.startswith(message.split(" leaves")[0])
    assert message.removeprefix("shoe.toml") in said
    assert "; also " not in said


HUGE = [
    (
        "[0, 0, 1]",
        "[0, 0, 1e308]",
        "shoe.toml:13: fields.grain.axis[3]: 1e+308 is beyond 1e+100, or no number",
    ),
    ("[0, 0, 1]", f"[0, 1{'0' * 400}, 1]", "shoe.toml:13: fields.grain.axis[2]: 1000"),
    (
        "{ axis = [0, 0, 1] }",
        "{ distance_to = [1e300, 0, 0] }",
        "shoe.toml:13: fields.grain.distance_to: 1e+300",
    ),
    ("7", f"1{'0' * 5000}", "shoe.toml: a number has too many digits to be read"),
    ('"0.9 mm"', f"1{'0' * 400}", "shoe.toml:17: layer.cell_size: 1000"),
]


@pytest.mark.parametrize(("right", "wrong", "message"), HUGE, ids=range(len(HUGE)))
def test_a_number_beyond_all_is_a_line(right, wrong, message):
    said = refused(GOOD.replace(right, wrong))
    assert said.startswith(message)
    assert len(said) < 150


def test_each_of_several_mistakes_is_told_and_located():
    said = refused(GOOD.replace("4096", '"a"').replace("seed = 7", "seed = 1.5"))
    assert said.startswith("shoe.toml:2: seed")
    assert "; also shoe.toml:7: bake.resolution: 'a': should be a valid integer" in said


def test_a_recipe_without_layers_is_refused():
    assert "needs at least one [[layer]]" in refused("surftex = 1\n")
    assert "needs at least one [[layer]]" in refused("layer = []\n")


def test_layers_are_counted():
    assert "65 layers; a recipe holds at most 64" in refused("[[layer]]\npreset = 'calf'\n" * 65)
    assert "layer: a layer needs a material (leather, cells, skin, composite) or a preset" in refused(
        "[[layer]]\nmask = 0.5\n"
    ).replace(".material", "")


def test_layers_are_counted_from_one():
    text = "[[layer]]\npreset = 'calf'\n[[layer]]\npreset = 'goat'\nmask = 'x +'\n"
    assert refused(text).startswith("shoe.toml:5: layer[2].mask: 'x +' at column")


def test_links_that_leave_the_folder_are_seen_through(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "mesh.obj").write_text("")
    (tmp_path / "in" / "link.obj").symlink_to(tmp_path / "mesh.obj")
    recipe = tmp_path / "in" / "a.toml"
    recipe.write_text("[mesh]\npath = 'link.obj'\n[[layer]]\npreset = 'calf'\n")
    with pytest.raises(RecipeError, match="leaves the recipe's folder"):
        load_recipe(recipe)
    assert load_recipe(recipe, allow_outside=True).mesh.path == str(tmp_path / "mesh.obj")


def test_files_that_are_no_recipe(tmp_path):
    for name, data, says in [
        ("a.toml", b"\xff\xfe", "not UTF-8"),
        ("b.toml", b"[" * 5000, "b.toml"),
        ("c.toml", b"\x00", "c.toml:1"),
    ]:
        (tmp_path / name).write_bytes(data)
        with pytest.raises(RecipeError, match=says):
            load_recipe(tmp_path / name)
    with pytest.raises(RecipeError, match="does not exist"):
        recipe_for(tmp_path / "none.toml")
    with pytest.raises(RecipeError, match="is no file"):
        load_recipe(tmp_path)
    with pytest.raises(RecipeError, match="no preset 'claf'; did you mean calf"):
        recipe_for("claf")
    assert recipe_from_preset("calf").layer[0].kind == "leather"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('mesh = "ok.obj"\n[[layer]]\npreset = "calf"\n', 'mesh: write [mesh] on a line by itself, and its keys on the '
         'lines below, such as path = "bag.obj"'),
        ("surftex = 99\n[[layer]]\npreset = 'calf'\n", "surftex: 99: this surftex reads version 1 of the format"),
    ],
)  # fmt: skip
def test_what_is_no_table_and_what_is_no_version_is_told_in_words_of_toml(text, said):
    with pytest.raises(RecipeError) as caught:
        recipe_from_text(text)
    assert said in str(caught.value)
