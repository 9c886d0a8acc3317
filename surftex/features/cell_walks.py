"""Walks along the sides of cells that keep to a direction: the skeleton of long wrinkles."""

import numpy as np
from numpy.typing import NDArray

from surftex.randomness import Stream


def walks(
    end: NDArray[np.int64],
    leaving: NDArray[np.float64],
    length: NDArray[np.float64],
    random: Stream,
    *,
    count: int,
    most_length: float,
    most_rad: float,
) -> list[list[int]]:
    """Walk from side to side, each time along the one nearest to the direction.

    Parameters
    ----------
    end : (s, 2) int64
        Particles at the ends of each side of a cell.
    leaving : (s, 2) float64
        Angle between the direction and the side, walked away from each end.
    length : (s,) float64
        Of the sides.
    random : Stream
        Picks the first sides.
    count : int
        Walks.
    most_length : float
        Of each.
    most_rad : float
        A walk ends where every way turns farther away from the direction.

    Returns
    -------
    walks : list of list of int
        Particles in walking order, at least two each.
    """
    if len(end) == 0 or most_length <= 0:
        return []
    turn = np.abs((leaving + np.pi) % (2 * np.pi) - np.pi)
    around: dict[int, list[tuple[int, int]]] = {}
    for side in range(len(end)):
        for which in (0, 1):
            around.setdefault(int(end[side, which]), []).append((side, which))
    found = []
    for draw in random.uniform(count)[:, 0]:
        side = min(int(draw * len(end)), len(end) - 1)
        which = 0 if turn[side, 0] <= turn[side, 1] else 1
        path, seen, left = [int(end[side, which])], {int(end[side, which])}, most_length
        while left > 0:
            there = int(end[side, 1 - which])
            if there in seen:
                break
            path.append(there)
            seen.add(there)
            left -= float(length[side])
            side, which = min(around[there], key=lambda way: turn[way])
            if turn[side, which] > most_rad:
                break
        if len(path) > 1:
            found.append(path)
    return found


def sides_of(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """List the sides of cells, each once.

    Parameters
    ----------
    cells : (c, 4) int64
        From `surftex.features.cell_mesh.paired`.

    Returns
    -------
    end : (s, 2) int64
        Particles at their ends, the lower number first, in ascending order.
    """
    triangle = cells[:, 3] < 0
    rows = [cells[:, [0, 1]], cells[:, [1, 2]]]
    rows += [cells[triangle][:, [2, 0]], cells[~triangle][:, [2, 3]], cells[~triangle][:, [3, 0]]]
    return np.unique(np.sort(np.concatenate(rows), axis=1), axis=0)
