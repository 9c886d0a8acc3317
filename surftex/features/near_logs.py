"""Log maps between points that lie near each other, whichever way around a bump is the shortest.

`surftex.geodesics.paths.shortest_path` is shortest among the paths near it; around an ear or over a sharp edge another may be
shorter. Its length bounds a flood, which finds them all.
"""

import numpy as np
from numpy.typing import NDArray

from surftex.geodesics.paths import shortest_path
from surftex.geodesics.pieces import CurvePieces
from surftex.geodesics.windows import flood_points, within
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_MORE, _LESS = 1 + 1e-9, 1 - 1e-7


def near_logs(
    surface: Surface,
    source: SurfacePoints,
    target: SurfacePoints,
    first: NDArray[np.int64],
    second: NDArray[np.int64],
    *,
    threads: int | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Log maps of targets at sources.

    Parameters
    ----------
    surface : Surface
        Where all lie.
    source : SurfacePoints
        s points.
    target : SurfacePoints
        t points.
    first : (e,) int64
        Source of each pair.
    second : (e,) int64
        Target of each pair.
    threads : int, optional
        None means every core; cannot change the result.

    Returns
    -------
    vector_mm : (e, 2) float64
        In the frame of the source's face; 0 where there is no way.
    distance_mm : (e,) float64
        Along the shortest of all ways; inf where there is none.
    """
    pieces, distance = shortest_path(surface, source.taken(first), target.taken(second), threads=threads)
    heading = path_angles(pieces, len(first))[0]
    length = np.where(np.isfinite(distance), distance, 0)
    vector = np.stack([length * np.cos(heading), length * np.sin(heading)], axis=1)
    reach = np.zeros(len(source))
    np.maximum.at(reach, first, length * _MORE)
    used = np.flatnonzero(reach > 0)
    if len(used) == 0:
        return vector, distance
    records = flood_points(surface, source.taken(used), reach[used], threads=threads)
    start, found, exact, log = within(records, target, threads=threads)
    count = len(target)
    key = used[found] * count + np.repeat(np.arange(count), np.diff(start))
    order = np.argsort(key)
    wanted = first * count + second
    row = order[np.minimum(np.searchsorted(key[order], wanted), len(order) - 1)]
    better = (key[row] == wanted) & (exact[row] < _LESS * distance)
    vector[better], distance[better] = log[row[better]], exact[row[better]]
    return vector, distance


def path_angles(pieces: CurvePieces, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Directions in which paths leave and arrive, in the frames of the faces there.

    Parameters
    ----------
    pieces : CurvePieces
        Of `count` paths.
    count : int
        Paths, with or without pieces.

    Returns
    -------
    leaving, arriving : (count,) float64
        Radians; 0 for paths of no length.
    """
    leaving, arriving = np.zeros(count), np.zeros(count)
    if len(pieces):
        first = np.flatnonzero(np.diff(pieces.curve, prepend=-1))
        last = np.append(first[1:], len(pieces)) - 1
        step = pieces.end - pieces.start
        heading = np.arctan2(step[:, 1], step[:, 0])
        leaving[pieces.curve[first]], arriving[pieces.curve[last]] = heading[first], heading[last]
    return leaving, arriving
