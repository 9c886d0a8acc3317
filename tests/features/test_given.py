"""Features from outside: rows that cannot lie on the surface never reach a kernel."""

import numpy as np
import pytest

import surftex as sx
from surftex.errors import InputError
from surftex.features.curves import curve_table
from surftex.features.given import check_given
from surftex.geodesics.tracing import trace
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import plane, sphere, torus

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


def curves(surface, number=3):
    """A way of ten pieces or more for each number."""
    angle = np.linspace(0.1, 1.5, number)
    start = SurfacePoints(np.arange(number), np.full((number, 3), 1 / 3))
    return curve_table(surface, trace(surface, start, angle, np.full(number, 30.0)).pieces)


def swapped(table):
    table["face"][3] = table["face"][0]


def one(table):
    table["curve"] = 0


def falling(table):
    table["curve"] = table["curve"][::-1]


def put(column, value):
    def change(table):
        table[column][3] = value

    return change


CURVES = {
    "a negative length": (put("length_mm", -1.0), "length_mm of row 3 is not the length of its curve"),
    "no length": (put("length_mm", 0.0), "length_mm of row 3"),
    "a start far beyond": (
        put("start_mm", 1e7),
        "start_mm of row 3 is not the length of its curve before it",
    ),
    "all one curve": (one, "start_mm of row"),
    "numbers that fall": (falling, "curve of row .* is less than that of the row before it"),
    "another face": (swapped, "of row .*; was it placed on another mesh"),
    "the other way": (lambda t: t["barycentric"][:3].__setitem__(slice(None), 1 / 3), "of row"),
}


@pytest.mark.parametrize(("change", "says"), CURVES.values(), ids=CURVES)
def test_a_curve_that_cannot_be_is_named(change, says):
    table = curves(BALL)
    check_given(BALL, {"wrinkle": table})
    change(table)
    with pytest.raises(InputError, match=says):
        check_given(BALL, {"wrinkle": table})


def test_a_piece_moved_aside_with_its_length_kept_is_named():
    sheet = plane(20.0)
    table = curves(sheet)
    alike = np.isclose(sheet.flat, sheet.flat[table["face"][4]]).all(axis=(1, 2))
    table["face"][4] = np.flatnonzero(alike)[-1]
    with pytest.raises(
        InputError, match=r"wrinkle: barycentric of row [45] is not where the piece before it ends"
    ):
        check_given(sheet, {"wrinkle": table})


@pytest.mark.parametrize("surface", [BALL, plane(20.0), torus(10.0, 3.0)], ids=["ball", "plane", "torus"])
def test_what_was_placed_can_be_given(surface):
    leather = sx.Leather(cell_size=3.0, wrinkle_count=9, wrinkle_length=15.0, invasion=0.8)
    skin = sx.Skin(wrinkle_count=9, wrinkle_length=(0.5, 30.0), vessel_count=9, vessel_length=3.0)
    for material in (leather, skin):
        check_given(surface, material.place(surface, seed=5).features)


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
    given = leather.place(BALL).features
    with pytest.raises(InputError, match="hold no cell"):
        sx.bake(BALL, leather, resolution=16, maps="height", features={"cell": given["cell"][:0]})
    with pytest.raises(
        InputError,
        match=r"features are given, more than the 10 that are allowed; raise max_features \(--max-features\)$",
    ):
        sx.bake(BALL, leather, resolution=16, maps="height", features=given, max_features=10)
    with pytest.raises(InputError, match="do not fit skin"):
        sx.bake(BALL, sx.Skin(freckle_count=1), resolution=16, maps="height", features={"freckle": rows()})


def crowd(count, spread, size=1.0):
    """Cells around one place of a face: on it where the spread is 0, else that share of the face apart."""
    away, turn = spread / 5 * np.sqrt((np.arange(count) + 0.5) / count), np.arange(count) * 2.4
    share = 1 / 3 + away[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    table = np.zeros(count, [("face", "i4"), ("barycentric", "f8", 3), ("major_mm", "f8"), ("minor_mm", "f8"),
                             ("angle_rad", "f8")])  # fmt: skip
    table["face"], table["major_mm"], table["minor_mm"] = 7, size, size
    table["barycentric"] = np.column_stack([share, 1 - share.sum(axis=1)])
    return table


def test_cells_at_one_place_are_refused_and_so_are_crowns():
    pair = crowd(3, 0.5)
    pair[2] = pair[0]
    for kind in ("cell", "crown"):
        with pytest.raises(
            InputError, match=rf"^{kind}: rows 0 and 2 lie at one place \(1 such row\).*place anew"
        ):
            check_given(BALL, {kind: pair})
        with pytest.raises(InputError, match=r"rows 0 and 1 lie at one place \(4999 such rows\)"):
            check_given(BALL, {kind: crowd(5000, 0.0)})
    check_given(BALL, {"cell": crowd(3, 0.5)})


def test_pores_may_coincide_but_not_by_the_hundred():
    check_given(BALL, {"pore": crowd(100, 0.0), "pocket": crowd(4, 0.0), "freckle": crowd(100, 0.0)})
    with pytest.raises(InputError, match=r"^pore: 101 rows lie at one place, the first is row 0"):
        check_given(BALL, {"pore": crowd(101, 0.0)})


def test_grown_cells_may_coincide_where_a_mesh_is_folded_but_not_by_the_hundred():
    for count in (2, 101):
        placed = crowd(count, 0.0)
        grown = np.zeros(count, [*placed.dtype.descr, ("corner", "i4", 4)])
        for name in placed.dtype.names:
            grown[name] = placed[name]
        if count == 2:
            check_given(BALL, {"cell": grown})
            continue
        with pytest.raises(InputError, match=r"^cell: 101 rows lie at one place"):
            check_given(BALL, {"cell": grown})


@pytest.mark.parametrize("size", [0.3, 1.0, 500.0])
def test_cells_far_closer_than_their_size_are_refused_at_once(size):
    """Their flood would leave a record of every one of them in every face around."""
    edge = float(BALL.edge_length.mean())
    many = crowd(5000, 1e-3, size)
    with pytest.raises(
        InputError, match=rf"^cell: \d+ rows crowd within .* mm, .* of {size:g} mm, .* place anew"
    ):
        check_given(BALL, {"cell": many})
    check_given(BALL, {"cell": crowd(5000, 1.0, edge / 40)})
    many["major_mm"] = many["minor_mm"] = np.geomspace(size, 30 * size, len(many))
    with pytest.raises(InputError, match=r"^cell: \d+ rows crowd within"):
        check_given(BALL, {"cell": many})


def test_grown_cells_name_particles_that_are_there():
    table = np.zeros(2, [("face", "i4"), ("barycentric", "f8", 3), ("corner", "i4", 4)])
    table["barycentric"], table["face"], table["corner"] = 1 / 3, [1, 2], [0, 1, 2, -1]
    particles = crowd(3, 0.5)
    check_given(BALL, {"cell": table, "particle": particles})
    table["corner"][1, 2] = 3
    with pytest.raises(InputError, match="corner of row 1 is none of the 3 particles"):
        check_given(BALL, {"cell": table, "particle": particles})
