"""Lines that a material is grooved along: what samples find of the nearest of them, and how deep the groove is there."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.features.curves import closed, drawn
from surftex.fields.profiles import valley
from surftex.geodesics.curves import nearest_curves
from surftex.geodesics.records import CurveRecords
from surftex.surface.points import SurfacePoints

Float = NDArray[np.float32]

NEAREST = 3
"""Lines whose grooves meet at one place; as many borders meet at a corner of cells."""


@dataclass(frozen=True, eq=False)
class Line:
    """The samples near a line, and what they find of it: each sample meets `NEAREST` such, the nearest first.

    Attributes
    ----------
    at : (m,) int64
        Their numbers, ascending.
    distance_mm : (m,) float32
        To the line.
    share : (m,) float32
        How much of the line is left there, 0 to 1.
    end_mm : (m,) float32
        Along the line to the nearer of its ends.
    left : (m,) bool
        Whether they lie to the left of the line.
    width_mm, depth_mm : (m,) float32
        Those the line was drawn with; 0 where it takes the material's.
    """

    at: NDArray[np.int64]
    distance_mm: Float
    share: Float
    end_mm: Float
    left: NDArray[np.bool_]
    width_mm: Float
    depth_mm: Float


def lines_at(
    records: CurveRecords,
    points: SurfacePoints,
    table: NDArray[Any],
    share: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.floating]],
) -> tuple[Line, ...]:
    """Find the lines near samples.

    Parameters
    ----------
    records : CurveRecords
        Of the lines.
    points : SurfacePoints
        n samples.
    table : (p,) structured array
        The rows that `records` are of, as `surftex.features.curves.curve_table` writes them.
    share : callable
        ``share(along_mm, length_mm)``: how much of a line is left at a place along it. A closed line has no ends.

    Returns
    -------
    lines : tuple of Line
        As many as `NEAREST`, or fewer where fewer meet.
    """
    near = np.flatnonzero(records.reached[points.face])
    if not len(near):
        return ()
    piece, distance, along, side = nearest_curves(records, points.taken(near), NEAREST, threads=1)
    found, endless = [], closed(table)
    for rank in range(NEAREST):
        at = np.flatnonzero(piece[:, rank] >= 0)
        if not len(at):
            break
        own = piece[at, rank]
        length = table["length_mm"][own]
        passed = np.where(endless[own], length / 2, along[at, rank])  # everywhere as in its middle
        found.append(
            Line(
                near[at],
                distance[at, rank].astype(np.float32),
                share(passed, length).astype(np.float32),
                np.minimum(passed, length - passed).astype(np.float32),
                side[at, rank] > 0,
                drawn(table, "width_mm")[own].astype(np.float32),
                drawn(table, "depth_mm")[own].astype(np.float32),
            )
        )
    return tuple(found)


def grooves(
    lines: tuple[Line, ...], width_mm: float, depth_mm: float, footprint_mm: Float
) -> tuple[Float, Float]:
    """Carve lines: where several meet the deepest counts, so that no groove ends in a step at another's.

    Parameters
    ----------
    lines : tuple of Line
        From `lines_at`.
    width_mm, depth_mm : float
        Of lines that were not drawn with their own.
    footprint_mm : (n,) float32
        Side of each sample's patch.

    Returns
    -------
    share : (n,) float32
        1 in the middle of a line, 0 away from all.
    depth_mm : (n,) float32
        Of the groove.
    """
    share, depth = np.zeros(len(footprint_mm), np.float32), np.zeros(len(footprint_mm), np.float32)
    for line in lines:
        width, deep = own_or(line, width_mm, depth_mm)
        part = line.share * valley(line.distance_mm, width, footprint_mm[line.at], dimension=1)
        share[line.at] = np.maximum(share[line.at], part)
        depth[line.at] = np.maximum(depth[line.at], deep * part)
    return share, depth


def own_or(line: Line, width_mm: float, depth_mm: float) -> tuple[Float, Float]:
    """Width and depth at the samples near a line: those it was drawn with, or the material's.

    Parameters
    ----------
    line : Line
        m samples.
    width_mm, depth_mm : float
        The material's.

    Returns
    -------
    width_mm, depth_mm : (m,) float32
        Of the line.
    """
    own = line.width_mm > 0
    width = np.where(own, line.width_mm, np.float32(width_mm))
    return width, np.where(own, line.depth_mm, np.float32(depth_mm))
