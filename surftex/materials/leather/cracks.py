"""Cracks: furrows that run on into the next plate, the farther the better they lie along the stress.

Eq. 1 to 3 of Sakurai et al.: an edge with unit direction v cracks on by ``l |v . b|`` at both ends.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError
from surftex.features.curves import ROW, curve_table
from surftex.features.voronoi_graph import VoronoiGraph
from surftex.geodesics.directions import DirectionField
from surftex.geodesics.tracing import trace
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_MOST_EDGES = 50
"""Longest crack, in mean edges of the plates."""


def cracks(
    surface: Surface,
    graph: VoronoiGraph,
    stress: DirectionField,
    amount: Callable[[SurfacePoints], NDArray],
    *,
    relative: bool = False,
    threads: int | None = None,
) -> NDArray:
    """Prolong the edges of a Voronoi graph.

    Parameters
    ----------
    surface : Surface
        Where they lie.
    graph : VoronoiGraph
        Its edges are the furrows.
    stress : DirectionField
        b; only its line matters, not its sense.
    amount : callable
        l at points: millimetres, or with `relative` a factor of half the edge.
    relative : bool
        The literal reading of Eq. 1, in which the crack is l times half the edge.
    threads : int, optional
        None means every core.

    Returns
    -------
    table : (p,) structured array
        Pieces of the cracks, each from its root to its tip.

    Raises
    ------
    RecipeError
        If one would run across many plates.
    """
    pieces = graph.pieces
    if len(pieces) == 0:
        return np.zeros(0, ROW)
    first = np.flatnonzero(np.diff(pieces.curve, prepend=-1))
    last = np.append(first[1:], len(pieces)) - 1
    root = np.concatenate([first, last])
    out = np.concatenate([pieces.start[first] - pieces.end[first], pieces.end[last] - pieces.start[last]])
    vertex = np.concatenate(
        [graph.edge_vertex[pieces.curve[first], 0], graph.edge_vertex[pieces.curve[last], 1]]
    )
    at_start = np.arange(len(root)) < len(first)
    where = SurfacePoints.trusted(
        pieces.face[root],
        np.where(
            at_start[:, None],
            pieces.points(surface, 0.0).barycentric[root],
            pieces.points(surface, 1.0).barycentric[root],
        ),
    )
    heading = np.arctan2(out[:, 1], out[:, 0])
    along = np.abs(np.cos(heading - stress.at(where)))
    length = np.asarray(amount(where)) * along
    if relative:
        length = length * pieces.curve_length_mm[pieces.curve[root]] / 2
    farthest = _MOST_EDGES * float(pieces.curve_length_mm.mean())
    if not length.max() <= farthest:
        raise RecipeError(
            f"leather.invasion makes cracks of {length.max():.3g} mm, which run across many plates; "
            f"at most {farthest:.3g} mm is for cracks, longer ones are wrinkles (leather.wrinkle_density)"
        )
    cracked = (vertex >= 0) & (length > 1e-3 * surface.mean_edge_mm * 1e-3) & (np.hypot(*out.T) > 0)
    rows = np.flatnonzero(cracked)
    start = SurfacePoints.trusted(where.face[rows], where.barycentric[rows])
    return curve_table(surface, trace(surface, start, heading[rows], length[rows], threads=threads).pieces)
