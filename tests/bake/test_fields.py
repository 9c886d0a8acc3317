"""Fields of a recipe: files are read and laid onto the surface; what does not fit is named."""

import json

import imagecodecs
import numpy as np
import pytest

from surftex.bake.fields import make_fields, stroke_directions
from surftex.errors import RecipeError
from surftex.files.pictures import read_mask, read_picture
from surftex.recipe.model import Recipe
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import plane, sphere
from surftex.surface.surface import Surface
from tests.bake.waves import Waves


def fields_of(surface, **fields):
    return make_fields(Recipe(layer=({"material": Waves()},), fields=fields), surface)


def middle(surface):
    return SurfacePoints(np.arange(len(surface.faces)), np.full((len(surface.faces), 3), 1 / 3))


def test_every_kind_of_number(tmp_path):
    surface = plane(10.0, cells=8)
    ramp = np.tile(np.linspace(0, 255, 64).astype(np.uint8), (64, 1))
    (tmp_path / "ramp.png").write_bytes(imagecodecs.png_encode(ramp))
    fields = fields_of(
        surface,
        toe={"image": str(tmp_path / "ramp.png")},
        all={"part": "surface"},
        half=0.5,
        up={"gradient": [0, 1, 0]},
        wear={"curvature": "convex", "radius": "2 mm"},
        spots={"noise": 2, "wavelength": "3 mm", "low": 1, "high": 2},
        sum="toe * all + half - wear",
    )
    points = middle(surface)
    place = points.positions(surface)
    np.testing.assert_allclose(fields["sum"](points), place[:, 0] / 10 + 0.5, atol=0.02)
    np.testing.assert_allclose(fields["up"](points), place[:, 1] / 10, atol=1e-9)
    assert 1 <= fields["spots"](points).min() < fields["spots"](points).max() <= 2


def test_strokes_turn_the_direction(tmp_path):
    surface = plane(10.0, cells=8)
    path = tmp_path / "grain.json"
    path.write_text(json.dumps({"strokes": [[[1, 1, 0.5], [5, 5, 0.5], [9, 9, 0.5]]]}))
    points, angle = stroke_directions(path, surface)
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    space = np.einsum("pk,pki->pi", direction, surface.frame[points.face, :2])
    np.testing.assert_allclose(space, [[0.5**0.5, 0.5**0.5, 0]] * 2, atol=1e-9)
    np.testing.assert_allclose(points.positions(surface)[:, :2], [[3, 3], [7, 7]], atol=1e-9)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ("{}", "holds no strokes"),
        ("[1", "at line 1 holds no strokes: it is no JSON"),
        ('{"strokes": [[[0, 0]]]}', r"grain.json: strokes\[0\]\[0\] holds no strokes"),
        ('{"strokes": [[[0, 0, true]]]}', r"strokes\[0\]\[0\]: True is no number"),
        ('{"strokes": [[[0, 0, 1e99]]]}', "are its axes and unit those of the mesh file"),
        (
            '{"strokes": [{"points": [[0, 0, 0]], "width_mm": "wide"}]}',
            r"strokes\[0\].width_mm: 'wide' is no number",
        ),
        (
            '{"points": {"a": {"face": 900, "barycentric": [1, 0, 0]}}}',
            r"points.a: face 900 is none of 0 to 511",
        ),
        ('{"points": {"a": {"face": 9, "barycentric": [1, 1, 0]}}}', "no weights with sum 1"),
        (
            '{"faces": 8, "points": [{"face": 9, "barycentric": [1, 0, 0]}]}',
            "drawn on a mesh of 8 faces, and this one has 512",
        ),
        ('{"strokes": [[[0, 0, 0]]]}', "no stroke of two points"),
        ('{"strokes": [[[5, 5, 0], [5, 5, 9]]]}', "has a direction on the surface"),
        ('{"strokes": [[[5, 5, 0], [NaN, 5, 9]]]}', "not finite"),
    ],
)
def test_strokes_that_are_none(tmp_path, content, says):
    (tmp_path / "grain.json").write_text(content)
    with pytest.raises(RecipeError, match=says) as refused:
        fields_of(plane(10.0), grain={"strokes": str(tmp_path / "grain.json")})
    assert str(refused.value).startswith("fields.grain: ")


def test_what_does_not_fit_the_mesh_is_named(tmp_path):
    with pytest.raises(RecipeError, match=r"fields.toe: the picture .* does not exist"):
        fields_of(plane(), toe={"image": str(tmp_path / "none.png")})
    with pytest.raises(RecipeError, match=r"fields.up: a gradient"):
        fields_of(plane(), up={"gradient": [0, 0, 1]})
    with pytest.raises(RecipeError, match=r"fields.lid: the mesh has no part 'lid'"):
        fields_of(plane(), lid={"part": "lid"})
    (tmp_path / "a.png").write_bytes(imagecodecs.png_encode(np.zeros((4, 4), np.uint8)))
    with pytest.raises(RecipeError, match="needs the mesh's own UVs"):
        fields_of(sphere(subdivisions=1), toe={"image": str(tmp_path / "a.png")})


def test_pictures_of_every_kind(tmp_path):
    gray = np.array([[0, 255], [51, 102]], np.uint8)
    color = np.stack([gray, gray // 2, gray // 3], axis=2)
    deep = (gray.astype(np.uint16) * 257)[..., None].repeat(4, axis=2)
    for name, pixels in [("a.png", gray), ("b.png", color), ("c.png", deep)]:
        data = imagecodecs.png_encode(pixels)
        (tmp_path / name).write_bytes(data)
    np.testing.assert_allclose(read_mask(tmp_path / "a.png"), gray / 255)
    np.testing.assert_allclose(read_mask(tmp_path / "b.png", "green"), (gray // 2) / 255)
    np.testing.assert_allclose(read_mask(tmp_path / "b.png"), (color / 255) @ [0.2126, 0.7152, 0.0722])
    np.testing.assert_allclose(read_mask(tmp_path / "c.png", "alpha"), gray / 255)
    assert read_picture(tmp_path / "c.png").shape == (2, 2, 4)
    with pytest.raises(RecipeError, match="has no alpha channel"):
        read_mask(tmp_path / "b.png", "alpha")
    sheet = plane()
    sheet = Surface.from_arrays(sheet.vertices, sheet.faces, corner_uv=np.full((len(sheet.faces), 3, 2), 0.5))
    with pytest.raises(RecipeError, match="has the label 7; it holds 0, 51, 102, 255"):
        fields_of(sheet, toe={"image": str(tmp_path / "a.png"), "label": 7})


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "none of PNG, JPEG, TIFF and EXR"),
        (b"GIF89a", "none of PNG"),
        (b"\x89PNG\r\n\x1a\n" + b"\0" * 30, "damaged"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + b"\x7f\xff\xff\xff" * 2 + b"\x08\0\0\0\0", "more than the"),
        (b"\xff\xd8\xff", "damaged"),
        (b"II*\0" + b"\xff" * 40, "damaged"),
        (b"v/1\x01" + b"\0" * 40, "damaged"),
    ],
)
def test_broken_pictures_are_refused_in_a_line(tmp_path, data, says):
    (tmp_path / "a.png").write_bytes(data)
    with pytest.raises(RecipeError, match=says) as refused:
        read_picture(tmp_path / "a.png")
    assert "\n" not in str(refused.value)
    with pytest.raises(RecipeError, match="is no file"):
        read_picture(tmp_path)
