"""Which triangles or edges may matter to which band of rows."""

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen

BAND_ROWS = 64
"""Rows of a band: the slice of work of one thread, always the same rows of the page."""


def band_lists(
    top: NDArray[np.float64], bottom: NDArray[np.float64], height: int
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """List the items that reach into each band of a page.

    Parameters
    ----------
    top : (k,) float64
        Least row that item i reaches.
    bottom : (k,) float64
        Greatest row that it reaches.
    height : int
        Rows of the page.

    Returns
    -------
    start : (bands + 1,) int64
        Where each band's list begins.
    item : (n,) int32
        Items of the bands, ascending in each. Read-only.
    """
    bands = -(-height // BAND_ROWS)
    low = np.clip(np.floor((top - 1) / BAND_ROWS), 0, bands - 1).astype(np.int64)
    high = np.clip(np.floor((bottom + 1) / BAND_ROWS), 0, bands - 1).astype(np.int64)
    count = high - low + 1
    item = np.repeat(np.arange(len(top), dtype=np.int32), count)
    band = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + np.repeat(low, count)
    order = np.argsort(band, kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(band, minlength=bands))]).astype(np.int64)
    return start, frozen(item[order])
