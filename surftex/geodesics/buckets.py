"""`Buckets`: where the texels of a face look for what is near them.

A face smaller than a cell is one bucket. A larger one is covered by square cells, laid along its longest edge, so that
lists stay short on a cube of twelve faces too.
"""

from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen, read_only_view
from surftex.errors import InputError
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

MOST_CELLS = 1 << 24
"""Cells in all; a finer wish is coarsened."""

_whole_faces: WeakKeyDictionary[Surface, tuple[NDArray[Any], ...]] = WeakKeyDictionary()
"""Cells of surfaces whose faces are a bucket each: every kind of feature has the same."""


@dataclass(frozen=True, eq=False)
class Buckets:
    """Cells over the faces of a surface.

    Attributes
    ----------
    surface : Surface
        What they cover.
    first : (m + 1,) int64
        Bucket of each face's first cell; the last entry is the number of buckets.
    cells : (m, 2) int32
        Cells along the longest edge of the face, and across it.
    grid : (m, 6) float64
        Lower left corner x, y of the cells in the frame of the face, unit direction x, y of the longest edge, cells
        per mm along it and across.
    """

    surface: Surface
    first: NDArray[np.int64]
    cells: NDArray[np.int32]
    grid: NDArray[np.float64]

    @staticmethod
    def of(surface: Surface, cell_mm: float = np.inf) -> "Buckets":
        """Cover a surface with cells.

        Parameters
        ----------
        surface : Surface
            m faces.
        cell_mm : float
            Side of a cell; faces that are no larger get one bucket. It grows where there would be more than
            16 million cells.

        Returns
        -------
        buckets : Buckets
            At least m of them.

        Raises
        ------
        InputError
            If the side is not positive.
        """
        if not cell_mm > 0:
            raise InputError(f"cell_mm is {cell_mm}; it takes a positive length")
        count = len(surface.faces)
        row = np.arange(count)
        longest = np.argmax(surface.edge_length, axis=1)
        origin = surface.flat[row, longest]
        length = surface.edge_length[row, longest]
        height = 2 * surface.face_area_mm2 / length
        side = max(cell_mm, float(length.max() / 2**14), float(np.sqrt((length * height).sum() / MOST_CELLS)))
        along = (surface.flat[row, (longest + 1) % 3] - origin) / length[:, None]
        cells = np.ones((count, 2), np.int32)
        if np.isfinite(side):
            cells[:, 0] = np.maximum(np.ceil(length / side), 1)
            cells[:, 1] = np.maximum(np.ceil(height / side), 1)
        grid = np.column_stack([origin, along, cells[:, 0] / length, cells[:, 1] / height])
        first = np.concatenate([[0], np.cumsum(cells.astype(np.int64).prod(axis=1))])
        made = frozen(first), frozen(cells), frozen(grid)
        if len(surface.faces) == first[-1]:  # the same for every wish of that size
            made = _whole_faces.setdefault(surface, made)
        return Buckets(surface, *made)

    def __len__(self) -> int:
        return int(self.first[-1])

    def find(self, points: SurfacePoints) -> NDArray[np.int64]:
        """Look up the buckets of points.

        Parameters
        ----------
        points : SurfacePoints
            n points.

        Returns
        -------
        bucket : (n,) int64
            Below ``len(buckets)``; cells of one face are contiguous.
        """
        from surftex.kernels.buckets import buckets_of

        points.check_on(self.surface)
        bucket = np.zeros(len(points), np.int64)
        buckets_of(
            read_only_view(points.face, np.int32),
            read_only_view(points.barycentric, np.float64),
            self.surface.flat,
            self.first,
            self.cells,
            self.grid,
            bucket,
        )
        return bucket
