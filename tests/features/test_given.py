"""Features from outside: rows that cannot lie on the surface never reach a kernel."""

import numpy as np
import pytest

import surftex as sx
from surftex.errors import InputError
from surftex.features.given import check_given
from surftex.surface.shapes import sphere

BALL = sphere(10.0, subdivisions=2)
WRONG = {
    "face beyond": ("face", 320, "face of row 2 is none of the 320 faces"),
    "face below": ("face", -1, "face of row 2"),
    "weights": ("barycentric", [0.5, 0.5, 0.5], "barycentric of row 2 are no weights"),
    "negative weight": ("barycentric", [1.5, -0.5, 0.0], "barycentric of row 2"),
    "curve beyond": ("curve", 2**30, "curve of row 2 is none of 0 to 4"),
    "size of nothing": ("scale_mm", 0.0, "scale_mm of row 2 is less than"),
    "no number": ("scale_mm", np.nan, "scale_mm of row 2 is beyond"),
    "huge": ("length_mm", 1e30, "length_mm of row 2 is beyond"),
    "sides": ("sides", 2**31 - 1, "sides of row 2 is none of 3 to 4"),
}


def rows():
    table = np.zeros(5, [("face", "i4"), ("barycentric", "f8", 3), ("end_barycentric", "f8", 3), ("curve", "i4"),
                         ("start_mm", "f8"), ("length_mm", "f8"), ("scale_mm", "f8"), ("sides", "i4"),
                         ("corner_mm", "f8", (4, 2))])  # fmt: skip
    table["barycentric"] = table["end_barycentric"] = 1 / 3
    table["scale_mm"], table["sides"] = 1, 4
    return table


@pytest.mark.parametrize(("column", "value", "says"), WRONG.values(), ids=WRONG)
def test_a_row_that_cannot_be_is_named(column, value, says):
    table = rows()
    check_given(BALL, {"cell": table})
    table[column][2] = value
    with pytest.raises(InputError, match=says):
        check_given(BALL, {"cell": table})


def test_other_types_and_missing_columns_are_refused():
    for away in ("face", "barycentric", "length_mm"):
        table = rows()
        kept = table[[name for name in table.dtype.names if name != away]]
        with pytest.raises(InputError, match=f"has no column {away}"):
            check_given(BALL, {"cell": kept})
    wide = np.zeros(1, [("face", "i8"), ("barycentric", "f8", 3)])
    with pytest.raises(InputError, match="face is int64"):
        check_given(BALL, {"cell": wide})
    check_given(BALL, {"cell": rows()[:0]})


def test_features_of_another_mesh_are_a_line():
    leather = sx.Leather(cell_size=4.0)
    given = leather.place(sphere(10.0, subdivisions=3)).features
    with pytest.raises(InputError, match="none of the 320 faces of this mesh; was it placed on another"):
        sx.bake(BALL, leather, resolution=16, maps="height", features=given)
    with pytest.raises(InputError, match="do not fit skin"):
        sx.bake(BALL, sx.Skin(freckle_count=1), resolution=16, maps="height", features={"freckle": rows()})
