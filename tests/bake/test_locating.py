"""Mistakes that only show on a surface are told with file, line and key."""

import pytest

from surftex.bake.bake import bake
from surftex.errors import InputError
from surftex.recipe.read import recipe_from_text
from surftex.surface.shapes import plane

FIELDS = """surftex = 1
[bake]
resolution = 16
maps = ["melanin"]
unwrapper = "uvunwrap"
[fields]
wear = "1 / (x - x)"
[[layer]]
material = "skin"
pore_density = 0
"""


@pytest.mark.parametrize(
    ("lines", "start", "message"),
    [
        ('freckle_count = 3\nfreckle_where = "0 * x"', 12, "layer: skin.freckle_where: weight is 0 on every face"),
        ('freckle_density = 3\nfreckle_where = "1 + x"', 12, "layer: skin.freckle_where: weight leaves 0..1"),
        ('wrinkle_count = 3\nwrinkle_where = "0 * x"', 12, "layer: skin.wrinkle_where: weight is 0 on every"),
        ('melanin = "0.02 / (x - x)"', 11, "layer: skin.melanin: '0.02 / (x - x)' has no finite value at"),
        ('melanin = "sqrt(x - 10)"', 11, "layer: skin.melanin: 'sqrt(x - 10)' has no finite value at"),
        ('melanin = "wear"', 11, "layer: skin.melanin: fields.wear: '1 / (x - x)' has no finite value at"),
        ('mask = "10 ** (400 + x)"', 11, "layer.mask: '10 ** (400 + x)' has no finite value at"),
        ('mask = "part(\'nose\')"', 11, "layer.mask: the mesh has no part 'nose'"),
        ('order = ["pore"]', 11, "layer: skin.order: it lists pore"),
        ("wrinkle_count = 100000000", 11, "layer: skin.wrinkle_count: 16 mm^2 would hold about 100,000,000 wrinkles"),
        ("vessel_density = 1e9", 11, "layer: skin.vessel_density: 16 mm^2 would hold about 82,560,000 vessels"),
    ],
)  # fmt: skip
def test_a_mistake_on_the_surface_names_file_line_and_key(tmp_path, lines, start, message):
    recipe = recipe_from_text(FIELDS + lines, name="shoe.toml")
    with pytest.raises(InputError) as caught:
        bake(plane(4.0, cells=2), recipe)
    assert str(caught.value).startswith(f"shoe.toml:{start}: {message}")


def test_a_part_in_a_field_names_the_field():
    recipe = recipe_from_text(FIELDS.replace("1 / (x - x)", "part('nose')"), name="shoe.toml")
    with pytest.raises(InputError, match=r"^shoe.toml:7: fields.wear: the mesh has no part 'nose'"):
        bake(plane(4.0, cells=2), recipe)


def test_no_lines_of_the_face_are_refused_where_they_are_written():
    text = FIELDS + '[fields.lines]\nface_lines = []\nlandmarks = "a.json"'
    with pytest.raises(InputError, match=r"^shoe.toml:12: fields.lines.face_lines: "):
        recipe_from_text(text, name="shoe.toml")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("up = [0, 0, 0]", r"up: \[0.0, 0.0, 0.0\] is no direction"),
        ("mole_height = [1.0, 0.2]", r"mole_height: \[1, 0.2\] falls"),
        ("freckle_melanin = [0.2, 0.1]", r"freckle_melanin: \[0.2, 0.1\] falls"),
    ],
)
def test_values_without_sense_are_refused_where_they_are_written(line, message):
    with pytest.raises(InputError, match=rf"^shoe.toml:11: layer.{message}"):
        recipe_from_text(FIELDS + line, name="shoe.toml")
