"""Which triangles or edges may matter to which band of rows."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen

BAND_ROWS = 64
"""Rows of a band: the slice of work of one thread, always the same rows of the page."""


@dataclass(frozen=True, eq=False)
class Bands:
    """Items that reach into each band of a page, ascending in each: ``bands[3]`` are those of the fourth."""

    start: NDArray[np.int64]
    item: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.start) - 1

    def __getitem__(self, band: int) -> NDArray[np.int32]:
        return frozen(self.item[self.start[band] : self.start[band + 1]])

    @staticmethod
    def of(top: NDArray[np.float64], bottom: NDArray[np.float64], height: int) -> "Bands":
        """List the items of each band.

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
        bands : Bands
            Of the page.
        """
        bands = -(-height // BAND_ROWS)
        low = np.clip(np.floor((top - 1) / BAND_ROWS), 0, bands - 1).astype(np.int64)
        high = np.clip(np.floor((bottom + 1) / BAND_ROWS), 0, bands - 1).astype(np.int64)
        count = high - low + 1
        item = np.repeat(np.arange(len(top), dtype=np.int32), count)
        band = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + np.repeat(low, count)
        order = np.argsort(band, kind="stable")
        start = np.concatenate([[0], np.cumsum(np.bincount(band, minlength=bands))]).astype(np.int64)
        return Bands(start, frozen(item[order]))

    @staticmethod
    def of_faces(corner_px: NDArray[np.float64], height: int) -> "Bands":
        """List the faces of each band.

        Parameters
        ----------
        corner_px : (m, 3, 2) float64
            Column and row of each corner.
        height : int
            Rows of the page.

        Returns
        -------
        bands : Bands
            Of the page.
        """
        a, b, c = (np.ascontiguousarray(corner_px[:, k, 1]) for k in range(3))
        return Bands.of(np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c), height)
