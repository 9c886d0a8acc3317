"""Wrinkles on a tile: walks along the sides of its cells that leave it on one side and come in on the other."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.features.cell_walks import sides_of, walks
from surftex.features.growth_plane import Direction
from surftex.materials.cells.model import Cells
from surftex.materials.cells.skeleton import wrinkle_count
from surftex.randomness import stream

ROW = np.dtype(
    [
        ("face", "i4"), ("barycentric", "f8", 3), ("curve", "i4"), ("start_mm", "f8"), ("length_mm", "f8"),
        ("from_mm", "f8", 2), ("to_mm", "f8", 2),
    ]
)  # fmt: skip
"""A straight piece: its wrinkle, the wrinkle's length before it and in all, and both ends; the second may lie outside."""


def tile_wrinkles(
    cells: Cells, side_mm: float, seed: int, place: NDArray[np.float64], regions: NDArray[np.int64],
    stress: Direction | None,
) -> NDArray:  # fmt: skip
    """Walk along the sides of cells that keep to the stress.

    Parameters
    ----------
    cells : Cells
        With number, length and angle of wrinkles.
    side_mm : float
        Of the tile.
    seed : int
        Of the material.
    place : (n, 2) float64
        Of the particles between which the cells lie.
    regions : (c, 4) int64
        The cells.
    stress : callable, optional
        Direction that wrinkles keep to; along x without it.

    Returns
    -------
    table : (p,) structured array
        See `ROW`.
    """
    count = wrinkle_count(cells, side_mm**2, seed)
    end = sides_of(regions) if count else np.zeros((0, 2), np.int64)
    step = place[end[:, 1]] - place[end[:, 0]]
    step -= side_mm * np.round(step / side_mm)
    length, ahead = np.hypot(step[:, 0], step[:, 1]), np.arctan2(step[:, 1], step[:, 0])
    leaving = np.stack([ahead, ahead + np.pi], axis=1)
    if stress is not None:
        leaving -= stress(place)[end]
    found = walks(
        end, leaving, length, stream(seed, "cells", "wrinkles"), count=count, most_length=cells.wrinkle_length,
        most_rad=np.radians(cells.wrinkle_angle),
    )  # fmt: skip
    if not found:
        return np.zeros(0, ROW)
    first = np.concatenate([np.array(path[:-1]) for path in found])
    last = np.concatenate([np.array(path[1:]) for path in found])
    curve = np.repeat(np.arange(len(found)), [len(path) - 1 for path in found])
    step = place[last] - place[first]
    step -= side_mm * np.round(step / side_mm)
    length = np.hypot(step[:, 0], step[:, 1])
    table = np.zeros(len(first), ROW)
    table["barycentric"][:, 0] = 1
    table["curve"], table["from_mm"], table["to_mm"] = curve, place[first], place[first] + step
    before = np.cumsum(length) - length
    table["start_mm"] = before - before[np.searchsorted(curve, curve)]
    table["length_mm"] = np.bincount(curve, length)[curve]
    return table


def nearest_wrinkle(
    table: NDArray, side_mm: float, place: NDArray[np.float64], tree: Any, reach_mm: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Find the nearest wrinkle of places in a tile.

    Parameters
    ----------
    table : (p,) structured array
        From `tile_wrinkles`.
    side_mm : float
        Of the tile.
    place : (n, 2) float64
        In it.
    tree : scipy.spatial.KDTree
        Of the places, with the tile as its box.
    reach_mm : float
        What is farther away does not count.

    Returns
    -------
    distance : (n,) float64
        inf where none is near.
    along : (n,) float64
        Length of the wrinkle before the nearest place on it.
    length : (n,) float64
        Of the wrinkle.
    """
    count = len(place)
    distance, along, length = np.full(count, np.inf), np.zeros(count), np.zeros(count)
    step = table["to_mm"] - table["from_mm"]
    size = np.hypot(step[:, 0], step[:, 1])
    middle = table["from_mm"] + 0.5 * step
    reach = np.minimum(0.5 * size + reach_mm, 0.49 * side_mm)
    rows = tree.query_ball_point(middle % side_mm, reach)
    piece = np.repeat(np.arange(len(table)), [len(row) for row in rows])
    if len(piece) == 0:
        return distance, along, length
    sample = np.concatenate([np.asarray(row, np.int64) for row in rows])
    offset = place[sample] - middle[piece]
    offset -= side_mm * np.round(offset / side_mm)
    square = np.maximum(size[piece] ** 2, 1e-300)
    share = np.clip(0.5 + (offset * step[piece]).sum(axis=1) / square, 0, 1)
    away = offset - (share - 0.5)[:, None] * step[piece]
    apart = np.hypot(away[:, 0], away[:, 1])
    order = np.lexsort((piece, apart, sample))
    order = order[np.diff(sample[order], prepend=-1) > 0]
    found, own = sample[order], piece[order]
    distance[found] = apart[order]
    along[found] = table["start_mm"][own] + share[order] * size[own]
    length[found] = table["length_mm"][own]
    return distance, along, length
