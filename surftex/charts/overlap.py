"""Texels that several faces claim: found by laying every face on the page."""

import numpy as np
from numpy.typing import NDArray

from surftex.charts.bands import BAND_ROWS, Bands
from surftex.kernels.pool import slices

MARGIN_PX = 1e-3
"""How far inside a face a texel's centre must lie to count, so that shared edges do not."""


def overlapping_faces(
    corner_px: NDArray[np.float64], resolution: int, *, threads: int | None = None
) -> tuple[int, NDArray[np.int32]]:
    """Count overlapping texels of a page, and name faces that cause them.

    Parameters
    ----------
    corner_px : (m, 3, 2) float64
        Corners as `Atlas.corner_px` gives them; read-only.
    resolution : int
        Side of the page.
    threads : int, optional
        None means every core.

    Returns
    -------
    texels : int
        Texels whose centre lies in more than one face.
    faces : (k, 2) int32
        Different pairs of the two lowest faces on such texels, in order.
    """
    from surftex.kernels.raster import overlap_band

    bands = Bands.of_faces(corner_px, resolution)

    def work(band: int, _: int) -> tuple[int, NDArray[np.int32]]:
        top = band * BAND_ROWS
        shape = (min(resolution, top + BAND_ROWS) - top, resolution)
        count, first, second = (
            np.zeros(shape, np.int32),
            np.full(shape, -1, np.int32),
            np.full(shape, -1, np.int32),
        )
        overlap_band(corner_px, bands[band], top, MARGIN_PX, count, first, second)
        hit = count > 1
        return int(hit.sum()), np.unique(np.stack([first[hit], second[hit]], axis=1), axis=0)

    found = slices(work, len(bands), size=1, threads=threads)
    pairs = np.concatenate([pairs for _, pairs in found])
    return sum(count for count, _ in found), np.unique(pairs, axis=0)


def core_faces(
    corner_px: NDArray[np.float64], resolution: int, *, threads: int | None = None
) -> NDArray[np.int32]:
    """Find the face of every texel of a page.

    Parameters
    ----------
    corner_px : (m, 3, 2) float64
        Corners as `Atlas.corner_px` gives them; read-only.
    resolution : int
        Side of the page.
    threads : int, optional
        None means every core.

    Returns
    -------
    face : (resolution, resolution) int32
        The lowest face that holds the texel's centre, -1 where there is none.
    """
    from surftex.kernels.raster import raster_band

    bands = Bands.of_faces(corner_px, resolution)
    face = np.full((resolution, resolution), -1, np.int32)

    def work(band: int, _: int) -> None:
        top = band * BAND_ROWS
        rows = face[top : top + BAND_ROWS]
        raster_band(corner_px, bands[band], top, rows, np.zeros((*rows.shape, 3)))

    slices(work, len(bands), size=1, threads=threads)
    return face
