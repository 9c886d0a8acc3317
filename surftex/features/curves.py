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


def drawn(table: NDArray, name: str) -> NDArray[np.float64]:
    """Width or depth that curves were drawn with.

    Parameters
    ----------
    table : (p,) structured array
        As `curve_table` writes it.
    name : str
        ``width_mm`` or ``depth_mm``.

    Returns
    -------
    drawn : (p,) float64
        Of each piece; 0 where it was not drawn with one.
    """
    return table[name] if name in (table.dtype.names or ()) else np.zeros(len(table))


def closed(table: NDArray) -> NDArray[np.bool_]:
    """Find pieces of curves that end where they begin: these have no ends to run out at.

    Parameters
    ----------
    table : (p,) structured array
        As `curve_table` writes it.

    Returns
    -------
    closed : (p,) bool
        Of the curve of each piece.
    """
    first = np.flatnonzero(np.diff(table["curve"], prepend=-1))
    size = np.diff(np.append(first, len(table)))
    last = first + size - 1
    apart = np.abs(table["barycentric"][first] - table["end_barycentric"][last]).max(axis=1, initial=0)
    met = (table["face"][first] == table["face"][last]) & (apart < 1e-6) & (size > 1)
    return np.repeat(met, size)


def with_drawn(table: NDArray, added: NDArray) -> NDArray:
    """Put drawn curves behind others that take their width and depth from a material.

    Parameters
    ----------
    table : (p,) structured array
        As `curve_table` writes it, with or without ``width_mm`` and ``depth_mm``.
    added : (q,) structured array
        With both.

    Returns
    -------
    table : (p + q,) structured array
        With both, which are 0 where a curve was not drawn; the added curves are numbered after the others.
    """
    both = np.zeros(len(table) + len(added), np.dtype([*ROW.descr, ("width_mm", "f8"), ("depth_mm", "f8")]))
    for name in both.dtype.names or ():
        both[name][: len(table)] = table[name] if name in (table.dtype.names or ()) else 0.0
        both[name][len(table) :] = added[name]
    both["curve"][len(table) :] += int(table["curve"].max(initial=-1)) + 1
    return both


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
