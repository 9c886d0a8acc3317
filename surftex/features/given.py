"""Features that come from outside, checked against the surface before any kernel reads them."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.features.crowding import refuse_crowds
from surftex.features.curves import curve_pieces
from surftex.surface.surface import Surface

_ROUNDING = 1e-4
_LARGEST = 1e7
"""Beyond any number of a feature: millimetres, radians, shares."""

_LEAST_MM = 1e-6
"""Of sizes that something is divided by."""

_GAP = 1e-2
"""Of the longest edge around: curves that turn past a vertex leave up to a hundredth of that."""

_SIZES = ("major_mm", "minor_mm", "scale_mm", "diameter_mm", "radius_mm")
_OF_CURVES = ("end_barycentric", "start_mm", "length_mm")
_TYPES = {"face": (np.int32, ()), "curve": (np.int32, ()), "barycentric": (np.float64, (3,)),
          "end_barycentric": (np.float64, (3,))}  # fmt: skip


def check_given(surface: Surface, features: Mapping[str, NDArray[Any]]) -> None:
    """Refuse rows that cannot have been placed on a surface.

    Parameters
    ----------
    surface : Surface
        Where they are said to lie.
    features : mapping of str to structured array
        By kind, such as a features file holds.

    Raises
    ------
    InputError
        Naming the kind, the column and the first row that is wrong.
    """
    for kind, table in features.items():
        for name in table.dtype.names or ():
            column = table[name]
            if name in _TYPES and (column.dtype, column.shape[1:]) != _TYPES[name]:
                raise InputError(
                    f"{kind}: {name} is {column.dtype}{list(column.shape[1:])}; was it written by another program?"
                )
            if column.dtype.kind == "f":
                _refuse(~(np.abs(column) <= _LARGEST), kind, name, f"is beyond {_LARGEST:g}, or no number")
        names = table.dtype.names or ()
        for name in ("face", "barycentric", *(_OF_CURVES if "curve" in names else ())):
            if name not in names:
                raise InputError(f"{kind}: has no column {name}; was it written by another program?")
        faces = len(surface.faces)
        _refuse(
            (table["face"] < 0) | (table["face"] >= faces), kind, "face",
            f"is none of the {faces} faces of this mesh; was it placed on another?",
        )  # fmt: skip
        for name in {"barycentric", "end_barycentric"} & set(names):
            weight = table[name]
            beyond = (weight < -_ROUNDING).any(axis=1) | (np.abs(weight.sum(axis=1) - 1) > _ROUNDING)
            _refuse(beyond, kind, name, "are no weights with sum 1")
        for name in set(_SIZES) & set(names):
            _refuse(table[name] < _LEAST_MM, kind, name, f"is less than {_LEAST_MM:g}")
        for name in {"born", "generation"} & set(names):
            _refuse(table[name] < 0, kind, name, "is negative")
        if {"sides", "corner_mm"} <= set(names):
            most = table["corner_mm"].shape[1] if table["corner_mm"].ndim > 1 else 0
            _refuse((table["sides"] < 3) | (table["sides"] > most), kind, "sides", f"is none of 3 to {most}")
        if "curve" in names:
            _refuse((table["curve"] < 0) | (table["curve"] >= len(table)), kind, "curve",
                    f"is none of 0 to {len(table) - 1}")  # fmt: skip
            _check_curves(surface, kind, table)
        if "corner" in names and "particle" in features:
            most = len(features["particle"])
            _refuse((table["corner"] < -1) | (table["corner"] >= most), kind, "corner",
                    f"is none of the {most} particles")  # fmt: skip
    refuse_crowds(surface, features)


def _check_curves(surface: Surface, kind: str, table: NDArray[Any]) -> None:
    """Refuse curves whose pieces do not follow one another, or whose lengths are not what they say."""
    curve = table["curve"]
    _refuse(np.diff(curve, prepend=curve[:1]) < 0, kind, "curve", "is less than that of the row before it")
    pieces = curve_pieces(surface, table)
    length = pieces.curve_length_mm[curve]
    rounding = _ROUNDING * (length + surface.mean_edge_mm)
    other = "; was it placed on another mesh, or in another size?"
    for name, true, what in (
        ("start_mm", pieces.start_mm, "is not the length of its curve before it"),
        ("length_mm", length, "is not the length of its curve"),
    ):
        _refuse(np.abs(table[name] - true) > rounding, kind, name, what + other)
    edge = surface.edge_length[table["face"]].max(axis=1)
    apart = (
        pieces.points(surface, 0.0).positions(surface)[1:]
        - pieces.points(surface, 1.0).positions(surface)[:-1]
    )
    beyond = np.linalg.norm(apart, axis=1) > _GAP * np.maximum(edge[1:], edge[:-1])
    _refuse(np.append(False, beyond & (np.diff(curve) == 0))[-len(curve):], kind, "barycentric",
            f"is not where the piece before it ends{other}")  # fmt: skip


def _refuse(wrong: NDArray[np.bool_], kind: str, name: str, what: str) -> None:
    rows = np.flatnonzero(wrong.any(axis=tuple(range(1, wrong.ndim))))
    if len(rows):
        raise InputError(f"{kind}: {name} of row {int(rows[0])} {what} ({len(rows)} such rows)")
