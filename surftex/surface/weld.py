"""Vertices that share a place become one, and rows that are equal."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

_ODD = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)


def weld(places: NDArray[np.float64], tolerance: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Merge vertices that lie within a tolerance of one another.

    Parameters
    ----------
    places : (n, 3) float64
        Finite.
    tolerance : float
        Distance, in the unit of `places`; chains of close vertices merge as a whole.

    Returns
    -------
    kept : (k, 3) float64
        The first vertex of each group, in the order of first appearance.
    group : (n,) int64
        Where each vertex went.
    """
    group = _same_place(places)
    first = _first_of(group)
    group, first = _by_appearance(group, first)
    kept = places[first]
    close = _close_pairs(kept, tolerance)
    if len(close):
        graph = coo_array((np.ones(len(close), np.int8), (close[:, 0], close[:, 1])), shape=(len(kept),) * 2)
        cluster = connected_components(graph, directed=False)[1].astype(np.int64)
        cluster, leader = _by_appearance(cluster, _first_of(cluster))
        group, kept = cluster[group], kept[leader]
    return kept, group


def equal_rows(rows: NDArray[Any]) -> NDArray[np.int64]:
    """Give equal rows equal numbers, in the order in which they first appear.

    Parameters
    ----------
    rows : (n, k) array
        Compared bit by bit, except that -0 equals 0.

    Returns
    -------
    number : (n,) int64
        0 to the count of different rows, less 1.
    """
    from surftex.kernels.rows import number_rows

    number = np.zeros(len(rows), np.int64)
    slot = np.full(1 << (2 * len(rows)).bit_length(), -1)
    number_rows(np.ascontiguousarray(rows + np.zeros(1, rows.dtype)).view(np.uint32), slot, number)
    return number


def _same_place(places: NDArray[np.float64]) -> NDArray[np.int64]:
    """Label rows that are equal, by a hash that is checked; a full sort where it collides."""
    bits = np.ascontiguousarray(places + 0.0).view(np.uint64)
    mixed = bits * _ODD
    mixed ^= mixed >> np.uint64(29)
    key = (mixed * np.roll(_ODD, 1)).sum(axis=1, dtype=np.uint64)
    _, group = np.unique(key, return_inverse=True)
    first = _first_of(group)
    if (places[first[group]] != places).any():
        _, group = np.unique(places, axis=0, return_inverse=True)
    return group.astype(np.int64).reshape(-1)


def _first_of(group: NDArray[np.int64]) -> NDArray[np.int64]:
    """First member of each group."""
    first = np.zeros(int(group.max()) + 1, np.int64)
    first[group[::-1]] = np.arange(len(group))[::-1]
    return first


def _by_appearance(
    group: NDArray[np.int64], first: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Renumber groups by their first members."""
    order = np.argsort(first)
    rank = np.zeros(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return rank[group], first[order]


def _close_pairs(places: NDArray[np.float64], tolerance: float) -> NDArray[np.int64]:
    """Pairs of neighbours within the tolerance.

    Cells twice the tolerance wide are laid eight times, each shifted by half a cell along some of the axes:
    two points within the tolerance share a cell in at least one of them. Points alone in theirs are far off.
    """
    if tolerance <= 0 or len(places) < 2:
        return np.zeros((0, 2), np.int64)
    from scipy.spatial import KDTree

    crowded = np.zeros(len(places), bool)
    scaled = (places - places.min(axis=0)) / (2 * tolerance)
    for shift in np.ndindex(2, 2, 2):
        cell = np.floor(scaled + np.array(shift) * 0.5).astype(np.int64).view(np.uint64)
        mixed = cell * _ODD
        mixed ^= mixed >> np.uint64(31)
        key = (mixed * np.roll(_ODD, 1)).sum(axis=1, dtype=np.uint64)
        order = np.argsort(key)
        same = key[order][1:] == key[order][:-1]
        crowded[order[1:][same]] = True
        crowded[order[:-1][same]] = True
    few = np.flatnonzero(crowded)
    if len(few) < 2:
        return np.zeros((0, 2), np.int64)
    tree = KDTree(places[few], balanced_tree=False, compact_nodes=False)
    return few[_sparse_pairs(tree, places[few], tolerance)]


def _sparse_pairs(tree: object, places: NDArray[np.float64], tolerance: float) -> NDArray[np.int64]:
    """Each point with its nearest few, enough to join every cluster without listing all of its pairs."""
    count = min(8, len(places))
    distance, other = tree.query(places, k=count, distance_upper_bound=tolerance * (1 + 1e-9))  # type: ignore[attr-defined]
    near = np.isfinite(distance)
    near &= other != np.arange(len(places))[:, None]
    point, column = np.nonzero(near)
    return np.column_stack([point, other[point, column]])
