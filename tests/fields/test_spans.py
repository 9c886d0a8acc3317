"""Spans of pictures: never narrower than what a field reads, and narrow along the sides of triangles where that is asked."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from surftex.features.uniform import area_points
from surftex.fields.fieldset import FieldSet
from surftex.fields.sources import image_field
from surftex.fields.spans import Pixels
from surftex.randomness import stream
from surftex.surface.surface import Surface


def triangle(uv):
    """A triangle, and another that sees the whole picture."""
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    return Surface.from_arrays(corners, [[0, 1, 2], [2, 1, 3]], corner_uv=[uv, [[0, 0], [3, 0], [0, 3]]])


@given(
    st.integers(0, 9999),
    st.integers(1, 40),
    st.integers(1, 40),
    st.sampled_from([0.3, 1.0, 3.0]),
    st.sampled_from([0.002, 0.1]),
)
def test_nothing_that_is_read_lies_outside(seed, height, width, size, rare):
    random = stream(seed, "picture")
    picture = (random.uniform(height, width) < rare) * random.uniform(height, width, first=height)
    surface = triangle(size * (random.uniform(3, 2, first=9999) - 0.5) + 0.5)
    field = image_field(surface, np.where(picture.any(), picture, 1.0))
    points = area_points(surface, stream(seed, "points").uniform(600, 3))
    values, wide, narrow = field(points), field.span(), field.narrow()
    for face in (0, 1):
        read = values[points.face == face]
        assert wide[0][face] <= narrow[0][face] <= read.min() + 1e-12
        assert wide[1][face] >= narrow[1][face] >= read.max() - 1e-12


def test_the_box_of_a_triangle_does_not_count():
    picture = np.zeros((512, 512))
    picture[20:200, 300:500] = 1  # upper right, in the box of the lower left triangle
    uv = np.array([[[0.02, 0.02], [0.98, 0.02], [0.02, 0.98]]])
    assert [float(end[0]) for end in Pixels(picture).over(uv)] == [0, 1]
    assert [float(end[0]) for end in Pixels(picture).within(uv)] == [0, 0]
    assert [float(end[0]) for end in Pixels(picture).within(uv, most_pieces=0)] == [0, 1]


@pytest.mark.parametrize("side", [64, 200, 1024])
def test_what_is_narrow_reaches_two_pixels_beyond_the_triangle(side):
    """A black diagonal of so many pixels parts white from a triangle."""
    row, column = np.indices((side, side))
    uv = np.array([[[0.02, 0.02], [0.98, 0.02], [0.02, 0.98]]])
    beyond = (column + side - 1 - row - (side - 1)) / np.sqrt(2)  # pixels from the long side
    for gap, covers in ((4.5, False), (0.0, True)):
        assert (Pixels((beyond > gap).astype(float)).within(uv)[1][0] > 0) == covers


def test_expressions_are_as_narrow_as_their_pictures():
    picture = np.zeros((512, 512))
    picture[20:200, 300:500] = 1
    surface = triangle([[0.02, 0.02], [0.98, 0.02], [0.02, 0.98]])
    field = FieldSet(surface, {"image": image_field(surface, picture), "half": "image / 2"}).scalar(
        "max(half, 0)"
    )
    assert field.narrow is not None
    assert (float(field.span()[1][0]), float(field.narrow()[1][0])) == (0.5, 0.0)
