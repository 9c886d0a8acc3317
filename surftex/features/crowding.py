"""Features that lie on one another: refused before a flood leaves a record of each in every face around."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface
from surftex.words import by_count

MOST_TOGETHER = 100
"""Cells within a cube as wide as one of them, and points of any kind at one place. Cells that keep apart are five at the
most, on thin and folded meshes too; what is strewn at random has some tens."""

_APART = ("cell", "crown")
"""Kinds that keep apart, so that no two are at one place; pores fall as they fall, and four cells may meet in a pocket. Grown
cells, which name particles at their corners, coincide where three particles meet on both sides of a fold."""

_SAME_MM = 2.0**-23
_MIXED = np.array(
    [0x1E3779B97F4A7C15, 0x3F58476D1CE4E5B9, 0x14D049BB133111EB, 0x2545F4914F6CDD1D, 0x5851F42D4C957F2D],
    np.int64,
)
"""Odd numbers at random, by which five numbers make one: of 5 million cubes no two get the same, but for one in a million."""

_SIZES = ("minor_mm", "scale_mm")
_MEND = "was the file made by hand? Take them out, or place anew without it"


def refuse_crowds(surface: Surface, features: Mapping[str, NDArray[Any]]) -> None:
    """Refuse points that coincide where they must not, and more together than any placing leaves.

    Parameters
    ----------
    surface : Surface
        Where they lie.
    features : mapping of str to structured array
        By kind; their faces and weights are good. Curves are left alone.

    Raises
    ------
    InputError
        Naming the kind, how many rows, and the first.
    """
    for kind, table in features.items():
        names = table.dtype.names or ()
        if "curve" in names or len(table) < 2:
            continue
        points = SurfacePoints.trusted(
            np.ascontiguousarray(table["face"]), np.ascontiguousarray(table["barycentric"])
        )
        place, body = points.positions(surface), surface.component[points.face]
        apart = kind in _APART and "corner" not in names
        _refuse_one_place(kind, apart, _groups(body, place, np.full(len(table), _SAME_MM)))
        size = next((table[name] for name in _SIZES if name in names), None)
        if kind == "cell" and size is not None:
            cube_mm = np.exp2(np.floor(np.log2(size.astype(np.float64))))
            _refuse_crowd(_groups(body, place, cube_mm), cube_mm, size)


def _groups(
    body: NDArray[np.int32], place: NDArray[np.float64], cube_mm: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Sort rows into cubes, of one size and one body each: the cube of each row, and how many rows are in each cube."""
    cube = np.column_stack([body, np.log2(cube_mm), np.floor(place / cube_mm[:, None])]).astype(np.int64)
    _, group, count = np.unique(cube @ _MIXED, return_inverse=True, return_counts=True)
    return group, count


def _refuse_one_place(kind: str, apart: bool, groups: tuple[NDArray[np.int64], NDArray[np.int64]]) -> None:
    group, count = groups
    if not apart:
        worst = int(np.argmax(count))
        if count[worst] > MOST_TOGETHER:
            first = int(np.flatnonzero(group == worst)[0])
            raise InputError(
                f"{kind}: {count[worst]} rows lie at one place, the first is row {first}, and more than {MOST_TOGETHER} are no "
                f"pattern; {_MEND}"
            )
        return
    if count.max() > 1:
        first = int(np.flatnonzero(count[group] > 1)[0])
        second = int(np.flatnonzero(group == group[first])[1])
        such = by_count(len(group) - len(count), "{} such row", "{} such rows")
        raise InputError(
            f"{kind}: rows {first} and {second} lie at one place ({such}), and a {kind} keeps its distance; {_MEND}"
        )


def _refuse_crowd(
    groups: tuple[NDArray[np.int64], NDArray[np.int64]],
    cube_mm: NDArray[np.float64],
    size: NDArray[np.floating],
) -> None:
    group, count = groups
    worst = int(np.argmax(count))
    if count[worst] > MOST_TOGETHER:
        first = int(np.flatnonzero(group == worst)[0])
        raise InputError(
            f"cell: {count[worst]} rows crowd within {cube_mm[first]:g} mm, the first is row {first} of {size[first]:g} mm, "
            f"and there is room for a few; {_MEND}"
        )
