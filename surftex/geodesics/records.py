"""`Records`: what a flood found, row by row, and where each bucket finds its rows, nearest first.

A row is one window (see `surftex.kernels.windows` for its columns and kinds); a bucket lists the rows that come near
enough to matter in it. Distances from rows are exact within the radius of their source, and never too short.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.errors import WorkError
from surftex.geodesics.buckets import Buckets
from surftex.geodesics.pieces import CurvePieces
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface


@dataclass(frozen=True, eq=False)
class Records:
    """What `flood_points` found.

    Attributes
    ----------
    buckets : Buckets
        Of the surface that was flooded.
    sources : SurfacePoints
        The n sources.
    radius_mm : (n,) float64
        How far each was flooded.
    bound_mm : (m,) float64
        What was nearest on a face at this distance or farther was left out; inf where nothing was.
    source_of : (p,) int32
        Source of each primitive; here a primitive is a source.
    limit_mm : (p,) float64
        Radius of each primitive's source.
    row : (r, 10) float64
        Image, interval, sigma, turn and least distance.
    row_id : (r, 3) int32
        Face, primitive, kind.
    start : (b + 1,) int64
        Bucket b has entries start[b] to start[b + 1].
    entry_row : (e,) int32
        Row of each entry.
    entry_least_mm : (e,) float64
        A lower bound of the row's distances in the bucket, ascending within it.
    """

    buckets: Buckets
    sources: SurfacePoints
    radius_mm: NDArray[np.float64]
    bound_mm: NDArray[np.float64]
    source_of: NDArray[np.int32]
    limit_mm: NDArray[np.float64]
    row: NDArray[np.float64]
    row_id: NDArray[np.int32]
    start: NDArray[np.int64]
    entry_row: NDArray[np.int32]
    entry_least_mm: NDArray[np.float64]

    @property
    def surface(self) -> Surface:
        """The surface that was flooded."""
        return self.buckets.surface

    @cached_property
    def reached(self) -> NDArray[np.bool_]:
        """(m,) the faces on which something may be found."""
        return frozen(np.diff(self.start[self.buckets.first]) > 0)

    @property
    def nbytes(self) -> int:
        """Memory of rows and entries."""
        arrays = (self.row, self.row_id, self.start, self.entry_row, self.entry_least_mm)
        return sum(array.nbytes for array in arrays)


@dataclass(frozen=True, eq=False)
class CurveRecords(Records):
    """What `flood_curves` found; `sources` are the starts of the pieces.

    Attributes
    ----------
    pieces : CurvePieces
        The curves.
    piece_of : (p,) int32
        Piece of each primitive: the pieces themselves, then the caps at ends and bends.
    along_mm : (p,) float64
        Length of the curve before the primitive.
    tangent : (p, 2) float64
        Unit direction of the curve at a cap, in the frame of its face; sides of a cap are told by it.
    """

    pieces: CurvePieces
    piece_of: NDArray[np.int32]
    along_mm: NDArray[np.float64]
    tangent: NDArray[np.float64]


def entries_of(
    buckets: Buckets,
    row: NDArray[np.float64],
    row_id: NDArray[np.int32],
    limit: NDArray[np.float64],
    bound: NDArray[np.float64],
) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float64]]:
    """List the rows of each bucket.

    Parameters
    ----------
    buckets : Buckets
        b buckets.
    row : (r, 10) float64
        Read-only.
    row_id : (r, 3) int32
        Read-only.
    limit : (p,) float64
        Radius of each primitive; read-only.
    bound : (m,) float64
        Bound of each face; read-only.

    Returns
    -------
    start : (b + 1,) int64
        Entries of each bucket.
    entry_row : (e,) int32
        Their rows.
    entry_least : (e,) float64
        Their least distances, ascending in each bucket.

    Raises
    ------
    WorkError
        If there are more rows than 32 bits count.
    """
    from surftex.kernels.buckets import distribute, sort_buckets

    if len(row) >= 2**31:
        raise WorkError(
            f"{len(row)} windows are more than can be listed; use a smaller radius or fewer sources"
        )
    where = (buckets.first, buckets.cells, buckets.grid)
    start = np.zeros(len(buckets) + 1, np.int64)
    none, nothing = np.zeros(0, np.int32), np.zeros(0)
    distribute(row, row_id, limit, bound, *where, 0, start, none, nothing)
    start = np.cumsum(start)
    entry_row, entry_least = np.zeros(int(start[-1]), np.int32), np.zeros(int(start[-1]))
    moving = start.copy()
    distribute(row, row_id, limit, bound, *where, 1, moving, entry_row, entry_least)
    sort_buckets(start, entry_row, entry_least)
    return frozen(start), frozen(entry_row), frozen(entry_least)
