"""Rows of features for curves: straight pieces inside faces, in order along each curve."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.geodesics.pieces import CurvePieces, barycentric_of
from surftex.surface.surface import Surface

ROW = np.dtype(
    [
        ("face", "i4"),
        ("barycentric", "f8", 3),
        ("end_barycentric", "f8", 3),
        ("curve", "i4"),
        ("start_mm", "f8"),
        ("length_mm", "f8"),
    ]
)
"""A piece: its face, both ends, its curve, the curve's length before it and in all."""


def curve_table(surface: Surface, pieces: CurvePieces, **per_curve: ArrayLike) -> NDArray:
    """Write curves as rows of features.

    Parameters
    ----------
    surface : Surface
        Where the curves lie.
    pieces : CurvePieces
        p pieces.
    **per_curve : float or (c,) float
        Further columns, such as ``width_mm`` and ``depth_mm``: a number for all, or one for each number of a curve.

    Returns
    -------
    table : (p,) structured array
        See `ROW`; the further columns follow, as float64.
    """
    table = np.zeros(len(pieces), np.dtype([*ROW.descr, *((name, "f8") for name in per_curve)]))
    for name, value in per_curve.items():
        numbers = np.asarray(value, np.float64)
        table[name] = numbers if numbers.ndim == 0 else numbers[pieces.curve]
    table["face"], table["curve"], table["start_mm"] = pieces.face, pieces.curve, pieces.start_mm
    table["barycentric"] = barycentric_of(surface, pieces.face, pieces.start)
    table["end_barycentric"] = barycentric_of(surface, pieces.face, pieces.end)
    table["length_mm"] = pieces.curve_length_mm[pieces.curve]
    return table


def curve_pieces(surface: Surface, table: NDArray) -> CurvePieces:
    """Read curves from rows of features.

    Parameters
    ----------
    surface : Surface
        Where the curves lie.
    table : (p,) structured array
        As `curve_table` writes it.

    Returns
    -------
    pieces : CurvePieces
        p pieces.
    """
    face = np.ascontiguousarray(table["face"])
    corner = surface.flat[face]
    return CurvePieces.of(
        face,
        np.einsum("pk,pki->pi", table["barycentric"], corner),
        np.einsum("pk,pki->pi", table["end_barycentric"], corner),
        np.ascontiguousarray(table["curve"]),
    )
