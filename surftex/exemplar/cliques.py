"""Kinds of cliques to choose from: pairs within a radius, and four corners in a few shapes and spacings."""

import numpy as np
from numpy.typing import NDArray

SHAPES = {
    "square": ((0, 0), (1, 0), (0, 1), (1, 1)),
    "diamond": ((0, 0), (-1, 1), (1, 1), (0, 2)),
    "across": ((0, 0), (1, 0), (2, 0), (3, 0)),
    "down": ((0, 0), (0, 1), (0, 2), (0, 3)),
    "falling": ((0, 0), (1, 1), (2, 2), (3, 3)),
    "rising": ((0, 0), (-1, 1), (-2, 2), (-3, 3)),
}
"""Corners of each shape of quad at spacing 1, right and down."""


BETWEEN = 8
"""Longest pair between two bands: after their rotation bands have little to tell each other from afar."""


def pair_window(bands: int, radius: int) -> NDArray[np.int32]:
    """List all pairs within a radius: half a disc within a band, a whole but smaller one between two.

    Parameters
    ----------
    bands : int
        Number of bands.
    radius : int
        Longest pair within a band.

    Returns
    -------
    pair_type : (k, 4) int32
        Head's band, tail's band, steps right and down.
    """
    across, down = (axis.ravel() for axis in np.meshgrid(*[np.arange(-radius, radius + 1)] * 2))
    square = across**2 + down**2
    half = (square <= radius**2) & ((down > 0) | ((down == 0) & (across > 0)))
    whole = square <= min(radius, BETWEEN) ** 2
    parts = [
        np.column_stack([np.full_like(across, a), np.full_like(across, b), across, down])[
            half if a == b else whole
        ]
        for a in range(bands)
        for b in range(a, bands)
    ]
    return np.concatenate(parts).astype(np.int32)


def first_pairs(bands: int) -> NDArray[np.int32]:
    """List what is taken before any choice: next neighbours within bands, bands at one place.

    Parameters
    ----------
    bands : int
        Number of bands.

    Returns
    -------
    pair_type : (k, 4) int32
        As from `pair_window`.
    """
    inner = [(a, a, right, down) for a in range(bands) for right, down in ((1, 0), (0, 1))]
    between = [(a, b, 0, 0) for a in range(bands) for b in range(a + 1, bands)]
    return np.array(inner + between, np.int32)


def quad_pool(
    bands: tuple[int, ...], spacings: tuple[int, ...]
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """List quads of all shapes at some spacings.

    Parameters
    ----------
    bands : tuple of int
        Where they lie; those of one band come together.
    spacings : tuple of int
        Steps between corners.

    Returns
    -------
    quad_band : (j,) int32
        Band of each.
    quad_shape : (j, 4, 2) int32
        Corners.
    """
    shape = np.array([np.multiply(each, k) for k in spacings for each in SHAPES.values()], np.int32)
    shape = shape.reshape(-1, 4, 2)
    return np.repeat(np.array(bands, np.int32), len(shape)), np.tile(shape, (len(bands), 1, 1))
