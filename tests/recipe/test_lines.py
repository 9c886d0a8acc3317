"""The scanner finds the line of each key that `tomllib` reads."""

import tomllib

from hypothesis import given
from hypothesis import strategies as st

from surftex.recipe.lines import key_lines

TEXT = '''# a comment with = and [brackets]
surftex = 1
"quoted key" = 'it # is'

[mesh]   # here
path = "a \\" b # not a comment"
long = """
[not.a.table]
key = 1
"""
[bake]
maps = [ # one a line
  "height",
  "normal", # [[layer]]
]
a.b.c = 2

[fields]
wear = { curvature = "convex", radius = "4 mm" }
[fields.toe]
image = "toe.png"
[[layer]]
material = "leather"
color = [0.1, 0.2,
   0.3]
[[layer]]
material = "skin"
[layer.more]
x = \'\'\'
= ]
\'\'\'
y = 1979-05-27T07:32:00Z
'''


def test_lines_of_a_text_with_every_trap():
    lines = key_lines(TEXT)
    assert lines[("surftex",)] == 2
    assert lines[("quoted key",)] == 3
    assert lines[("mesh",)] == 5
    assert lines[("mesh", "path")] == 6
    assert lines[("bake", "maps")] == 12
    assert lines[("bake", "maps", 1)] == 14
    assert lines[("bake", "a", "b", "c")] == 16
    assert lines[("fields", "wear", "radius")] == 19
    assert lines[("fields", "toe", "image")] == 21
    assert lines[("layer", 0)] == 22
    assert lines[("layer", 0, "color", 2)] == 25
    assert lines[("layer", 1, "material")] == 27
    assert lines[("layer", 1, "more", "y")] == 32


def paths(value, path=()):
    found = {path} if path else set()
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, each in items:
        found |= paths(each, (*path, key))
    return found


def test_every_key_that_is_read_has_a_line():
    assert paths(tomllib.loads(TEXT)) <= {*key_lines(TEXT), ("layer",), ("mesh",), ("fields",)}


values = st.recursive(
    st.sampled_from(["1", "-2.5", "true", '"text"', "'# text'", '"""a\n= b"""', "'''c\n]'''", "2020-01-01"]),
    lambda inner: st.lists(inner, max_size=3).map(lambda each: "[" + ", # end\n ".join(each) + "\n]"),
    max_leaves=5,
)


@given(st.lists(values, min_size=1, max_size=6))
def test_any_values_between_keys_are_skipped(written):
    text, expected = "", {}
    for i, value in enumerate(written):
        text += "\n" * (i % 3)
        expected[(f"key{i}",)] = text.count("\n") + 1
        text += f"key{i} = {value}\n"
    assert tomllib.loads(text)
    lines = key_lines(text)
    assert {path: lines[path] for path in expected} == expected
