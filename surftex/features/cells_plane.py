"""Triangles between particles of a tile that repeats."""

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.errors import InputError
from surftex.features.cell_mesh import Triangles, twins_of
from surftex.features.growth_plane import copies

LEAST_SIDE = 6.0
"""Side of a tile, in diameters: a cell must not meet its own copy."""


def plane_triangles(
    place: NDArray[np.float64], side: float, aspect: NDArray[np.float64], angle: NDArray[np.float64]
) -> Triangles:
    """Join particles so that no circle around three holds a fourth, across the borders of the tile too.

    Parameters
    ----------
    place : (n, 2) float64
        In the tile.
    side : float
        Of the tile.
    aspect : (n,) float64
        Length over width; where not 1, circles are ellipses.
    angle : (n,) float64
        Of the long axes.

    Returns
    -------
    triangles : Triangles
        2 n of them.

    Raises
    ------
    InputError
        If the particles are too few to go around the tile.
    """
    from scipy.spatial import Delaunay

    count = len(place)
    if count < 12:
        raise InputError(
            f"{count} cells are too few for a tile of {side:g} mm; make cells smaller, or the tile larger"
        )
    owner, shift = copies(
        place, side, 0.45 * side if count < 400 else min(9 * side / np.sqrt(count), 0.45 * side)
    )
    where = place[owner] + shift
    corner = Delaunay(where).simplices
    middle = where[corner].mean(axis=1)
    corner = corner[((middle >= 0) & (middle < side)).all(axis=1)]
    points = where[corner]
    ahead, beyond = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    wrong = ahead[:, 0] * beyond[:, 1] - ahead[:, 1] * beyond[:, 0] < 0
    corner[wrong] = corner[wrong][:, ::-1]
    points, own = where[corner], owner[corner].astype(np.int64)
    step = np.roll(points, -1, axis=1) - points
    tile = np.rint(shift[corner] / side).astype(np.int64)
    over = np.roll(tile, -1, axis=1) - tile
    onward = np.roll(own, -1, axis=1)
    key, back = _key(own, onward, over, count), _key(onward, own, -over, count)
    twin = twins_of(key, back)
    if len(corner) != 2 * count or (twin < 0).any():
        raise InputError(
            f"the {count} cells do not go around the tile of {side:g} mm; make cells smaller, or the tile larger"
        )
    square = (step**2).sum(axis=2)
    if (aspect != 1).any():
        heading = np.arctan2(step[..., 1], step[..., 0])
        square = square * 0.5 * sum(stretch(aspect[who], heading - angle[who]) for who in (own, onward))
    triangles = Triangles(frozen(own), frozen(twin), frozen(np.sqrt(square)))
    return triangles.flipped() if (aspect != 1).any() else triangles


def stretch(aspect: NDArray[np.float64], turn: NDArray[np.float64]) -> NDArray[np.float64]:
    """Squared length of unit vectors in the metric in which a particle is round.

    Parameters
    ----------
    aspect : array of float64
        Length over width.
    turn : array of float64
        Angle between the vector and the long axis.

    Returns
    -------
    square : array of float64
        1 / aspect along the axis, aspect across it.
    """
    return np.cos(turn) ** 2 / aspect + np.sin(turn) ** 2 * aspect


def _key(first: NDArray, second: NDArray, over: NDArray, count: int) -> NDArray[np.int64]:
    """Make a number of a walk from one particle to another and of the tiles it crosses."""
    return ((first * count + second) * 5 + over[..., 0] + 2) * 5 + over[..., 1] + 2
