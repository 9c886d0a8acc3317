"""Creases that are there before anything grows: leather's own wrinkles, smoothed, from which particles are driven away."""

import numpy as np
from numpy.typing import NDArray

from surftex.features.curves import curve_pieces, curve_table
from surftex.features.growth import spline
from surftex.fields.distances import distance_field
from surftex.fields.fieldset import FieldSet
from surftex.fields.profiles import smoothstep
from surftex.fields.sources import Field
from surftex.geodesics.pieces import CurvePieces
from surftex.materials.cells.model import Cells
from surftex.materials.leather.model import Leather
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

PLATE = 3.0
"""Size of the plates along whose furrows creases run, in cell sizes."""

REACH = 2.0
"""How far from a crease particles are driven, in cell sizes."""


def laid_creases(
    cells: Cells, surface: Surface, seed: int, names: FieldSet, size_mm: float, threads: int | None
) -> NDArray:
    """Lay creases.

    Parameters
    ----------
    cells : Cells
        With number, length, angle and stress of its wrinkles.
    surface : Surface
        Where.
    seed : int
        Of the material.
    names : FieldSet
        With the stress.
    size_mm : float
        Size of the cells.
    threads : int, optional
        None means every core.

    Returns
    -------
    table : (p,) structured array
        Rows of `surftex.features.curves`; none where no crease fits.
    """
    none = curve_table(surface, CurvePieces.joined([]))
    leather = Leather(
        cell_size=PLATE * size_mm, wrinkle_count=cells.wrinkle_count, wrinkle_density=cells.wrinkle_density,
        wrinkle_length=cells.wrinkle_length, wrinkle_angle=min(cells.wrinkle_angle, 40.0), stress=cells.stress,
        pore_density=0.0, pocket_depth=0.0,
    )  # fmt: skip
    rows = leather.place(surface, seed, fields=names, threads=threads).features.get("wrinkle", none)
    if not len(rows):
        return none
    # a control at each plate: the curve between them flows where furrows turn
    stride = np.floor(rows["start_mm"] / (PLATE * size_mm)).astype(np.int64) + (1 << 20) * rows[
        "curve"
    ].astype(np.int64)
    first = np.diff(stride, prepend=-1) != 0
    last = np.append(np.diff(rows["curve"]) != 0, True)
    order = np.argsort(
        np.concatenate([2 * np.flatnonzero(first), 2 * np.flatnonzero(last) + 1]), kind="stable"
    )
    face = np.concatenate([rows["face"][first], rows["face"][last]])[order]
    weight = np.concatenate([rows["barycentric"][first], rows["end_barycentric"][last]])[order]
    curve = np.concatenate([rows["curve"][first], rows["curve"][last]])[order]
    pieces = spline(surface, SurfacePoints(face, weight), curve, threads=threads)
    return curve_table(surface, pieces)


def crease_potential(surface: Surface, table: NDArray, size_mm: float, height: float) -> Field:
    """Make the potential of creases.

    Parameters
    ----------
    surface : Surface
        Where they lie.
    table : (p,) structured array
        From `laid_creases`, at least one row.
    size_mm : float
        Size of the cells.
    height : float
        Of the potential on a crease.

    Returns
    -------
    potential : callable
        `height` on a crease, 0 from `REACH` cells on.
    """
    away = distance_field(surface, curve_pieces(surface, table), limit_mm=REACH * size_mm)

    def potential(points: SurfacePoints, footprint_mm: NDArray | float = 0.0) -> NDArray[np.float64]:
        share = (away(points, footprint_mm) / (REACH * size_mm)).astype(np.float32)
        return height * (1 - smoothstep(0.0, 1.0, share)).astype(np.float64)

    return potential
