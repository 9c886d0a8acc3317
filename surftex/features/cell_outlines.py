"""Outlines of cells: rounded, shrunk by their grooves, and dotted with blobs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.features.cell_planes import CellPlanes
from surftex.kernels.pool import slices
from surftex.randomness import Stream

MOST_BLOBS = 96
"""On one cell."""

_EDGES = 24
_SLICE = 4096


@dataclass(frozen=True, eq=False)
class Outlines:
    """Rounded outlines of c cells, as kernels read them; see `surftex.kernels.cell_outlines`.

    Attributes
    ----------
    edge : (c, 24, 2) float64
        Sides, so that the gauge of a place is the largest product.
    edges : (c,) int64
        How many; 0 where a cell was too narrow for its groove.
    middle : (c, 2) float64
        Centre of gravity.
    area : (c,) float64
        Inside the outline.
    blob_start : (c + 1,) int64
        Blobs of cell i are those from blob_start[i] on.
    blob : (b, 3) float64
        Place from the middle, and radius.
    """

    edge: NDArray[np.float64]
    edges: NDArray[np.int64]
    middle: NDArray[np.float64]
    area: NDArray[np.float64]
    blob_start: NDArray[np.int64]
    blob: NDArray[np.float64]

    @property
    def breadth(self) -> NDArray[np.float64]:
        """(c,) from the middle to the nearest side; 0 where there is no outline."""
        steepest = np.hypot(self.edge[..., 0], self.edge[..., 1]).max(axis=1, initial=0)
        return np.where(self.edges > 0, 1 / np.maximum(steepest, 1e-300), 0)


def outlined(
    planes: CellPlanes,
    *,
    gap: float,
    rounding: float,
    taper: float,
    blob_density: float,
    blob_radius: float,
    blob_variation: float,
    random: Stream,
    threads: int | None = None,
) -> Outlines:
    """Round cells, and scatter blobs on their tops.

    Parameters
    ----------
    planes : CellPlanes
        c cells.
    gap : float
        Width of the groove's floor, in diameters.
    rounding : float
        Share of a side, from each end, that a rounded corner takes.
    taper : float
        Where the top ends: rho = 1 - taper.
    blob_density : float
        Per square of the diameter, on tops.
    blob_radius : float
        In diameters.
    blob_variation : float
        Standard deviation, as a share.
    random : Stream
        Of the blobs.
    threads : int, optional
        None means every core; cannot change the result.

    Returns
    -------
    outlines : Outlines
        Of the c cells.
    """
    from surftex.kernels.cell_outlines import outlines, scatter_blobs

    count = len(planes)
    edge, edges = np.zeros((count, _EDGES, 2)), np.zeros(count, np.int64)
    middle, area = np.zeros((count, 2)), np.zeros(count)
    width = gap * planes.scale

    def outline(begin: int, end: int) -> None:
        scratch = np.zeros((8, 2)), np.zeros(8), np.zeros((16, 2)), np.zeros((16, 2)), np.zeros((32, 2))
        outlines(
            begin,
            end,
            planes.corner,
            planes.bend,
            planes.sides,
            planes.scale,
            width,
            rounding,
            *scratch,
            edge,
            edges,
            middle,
            area,
        )

    slices(outline, count, size=_SLICE, threads=threads)
    extent = planes.radius + np.hypot(middle[:, 0], middle[:, 1])
    top, start = 1 - taper, np.zeros(count + 1, np.int64)
    density, radius = blob_density / planes.scale**2, blob_radius * planes.scale
    blob = np.zeros((0, 3))
    for fill in (0, 1):
        if blob_density > 0:
            slices(
                lambda begin, end, fill=fill, start=start, blob=blob: scatter_blobs(
                    begin, end, fill, edge, edges, extent, area * top**2, density, top, radius, blob_variation,
                    np.uint64(random.key), MOST_BLOBS, start, blob,
                ),
                count, size=_SLICE, threads=threads,
            )  # fmt: skip
        if fill == 0:
            start = np.cumsum(start)
            blob = np.zeros((int(start[-1]), 3))
    return Outlines(frozen(edge), frozen(edges), frozen(middle), frozen(area), frozen(start), frozen(blob))
