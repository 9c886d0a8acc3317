"""`Reaching`: the entries of a flood in the order of their sources, for blending all that reaches a point."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen, read_only_view
from surftex.geodesics.records import Records
from surftex.surface.points import SurfacePoints


@dataclass(frozen=True, eq=False)
class Reaching:
    """A flood whose buckets list their rows by source; make it with `Reaching.of`.

    Attributes
    ----------
    records : Records
        From `surftex.geodesics.windows.flood_points` or `surftex.geodesics.curves.flood_curves`, without a bound.
    entry_row : (e,) int32
        Rows of the buckets: by source, then by row.
    """

    records: Records
    entry_row: NDArray[np.int32]

    @staticmethod
    def of(records: Records) -> "Reaching":
        """Put the entries of every bucket in the order of their sources.

        Parameters
        ----------
        records : Records
            Left as they are.

        Returns
        -------
        reaching : Reaching
            Read-only.
        """
        from surftex.kernels.buckets import sort_buckets

        entry_row = records.entry_row.copy()
        source = records.source_of[records.row_id[entry_row, 1]].astype(np.float64)
        sort_buckets(records.start, entry_row, source)
        return Reaching(records, frozen(entry_row))

    def place(self, points: SurfacePoints) -> tuple[Any, ...]:
        """Collect the arguments that kernels of `surftex.kernels.blend` share.

        Parameters
        ----------
        points : SurfacePoints
            n points on the surface that was flooded.

        Returns
        -------
        arguments : tuple of arrays
            From ``face`` to ``row_id``.
        """
        buckets = self.records.buckets
        return (
            read_only_view(points.face, np.int32),
            read_only_view(points.barycentric, np.float64),
            self.records.surface.flat,
            buckets.first,
            buckets.cells,
            buckets.grid,
            self.records.start,
            self.entry_row,
            self.records.row,
            self.records.row_id,
        )
