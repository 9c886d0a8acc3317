"""Strokes and picked points: what is written is read back, on the same surface and on a finer one."""

import json

import numpy as np
import pytest

from surftex.errors import RecipeError, WorkError
from surftex.features.uniform import scatter
from surftex.files.strokes import Stroke, read_strokes, write_strokes
from surftex.randomness import stream
from surftex.surface.shapes import sphere
from surftex.surface.surface import Surface


def ball(subdivisions):
    one = sphere(radius_mm=20.0, subdivisions=subdivisions)
    return Surface.from_arrays(one.vertices, one.faces, origin_mm=(5.0, 0.0, 100.0), mm_per_unit=1000.0)


def test_what_is_written_is_read_back(tmp_path):
    surface = ball(3)
    points = scatter(surface, stream(1, "strokes"), count=12)
    write_strokes(
        tmp_path / "a.json",
        surface,
        [Stroke(points, "crow", {"width_mm": 1.5})],
        {"tip": scatter(surface, stream(2, "tip"), count=1)},
    )
    back = read_strokes(tmp_path / "a.json", surface)
    assert back.strokes[0].name == "crow"
    assert back.strokes[0].numbers == {"width_mm": 1.5}
    np.testing.assert_array_equal(back.strokes[0].points.face, points.face)
    np.testing.assert_allclose(back.strokes[0].points.barycentric, points.barycentric, atol=1e-12)
    assert list(back.points) == ["tip"]
    finer = ball(4)
    moved = read_strokes(tmp_path / "a.json", finer).strokes[0].points
    away = np.linalg.norm(moved.positions(finer) - points.positions(surface), axis=1)
    assert away.max() < 0.1
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]


def test_points_may_be_a_list_and_coordinates_are_the_files_own(tmp_path):
    surface = ball(3)
    (tmp_path / "a.json").write_text(json.dumps({"points": [[0.025, 0, 0.1], [0.005, 0, 0.12]]}))
    read = read_strokes(tmp_path / "a.json", surface)
    assert list(read.points) == ["1", "2"]
    np.testing.assert_allclose(read.points["1"].positions(surface), [[20, 0, 0]], atol=0.01)
    np.testing.assert_allclose(read.points["2"].positions(surface), [[0, 0, 20]], atol=0.01)


def test_a_file_that_cannot_be_written_is_named(tmp_path):
    with pytest.raises(WorkError, match="cannot be written"):
        write_strokes(tmp_path / "none" / "a.json", ball(1))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"surftex": 99, "points": [[0.025, 0, 0.1]]}, "a.json: surftex is 99; this program reads"),
        ({"strokes": [{"points": [[0.025, 0, 0.1]], "width_mm": 0}]}, r"a.json: strokes\[0\].width_mm is 0;"),
        ({"strokes": [{"points": [[0.025, 0, 0.1]], "width_mm": 1e9}]}, r"width_mm is 1e\+09; it takes"),
        ({"strokes": [{"points": [[0.025, 0, 0.1]], "depth_mm": -1}]}, r"depth_mm is -1; it takes 0 to 1000"),
    ],
)
def test_strokes_without_sense_are_refused(tmp_path, content, message):
    (tmp_path / "a.json").write_text(json.dumps(content))
    with pytest.raises(RecipeError, match=message):
        read_strokes(tmp_path / "a.json", ball(1))
