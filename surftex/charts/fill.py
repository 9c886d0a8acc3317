"""Pictures without holes: every texel that stands for no place takes the value of the nearest one that does."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.errors import InputError
from surftex.kernels.pool import slices
from surftex.paged import let_go

_ROWS = 64


def nearest_mapped(mapped: NDArray[np.bool_], *, threads: int | None = None) -> NDArray[np.int64]:
    """Find the nearest mapped texel of every texel of a page.

    Parameters
    ----------
    mapped : (height, width) bool
        Texels that stand for a place on the surface.
    threads : int, optional
        None means every core.

    Returns
    -------
    source : (height, width) int64
        Flat index of the nearest mapped texel by distance between centres; its own where a texel is mapped.

    Raises
    ------
    InputError
        If no texel is mapped.
    """
    from surftex.kernels.gutter import nearest_in_rows

    row = _nearest_rows(mapped)
    height, width = mapped.shape
    source = np.zeros((height, width), np.int64)

    def work(first: int, last: int) -> None:
        nearest_in_rows(row, first, last, np.zeros(width, np.int64), np.zeros(width + 1), source[first:last])

    slices(work, height, size=_ROWS, threads=threads)
    return source


def fill_nearest(
    images: Iterable[NDArray[Any]], mapped: NDArray[np.bool_], *, threads: int | None = None
) -> None:
    """Fill the texels of pictures that are not mapped, in place.

    Parameters
    ----------
    images : iterable of (height, width) or (height, width, c) arrays
        Any type; C-contiguous. They may lie in files, see `surftex.paged`.
    mapped : (height, width) bool
        Texels that hold a value.
    threads : int, optional
        None means every core.

    Raises
    ------
    InputError
        If no texel is mapped.
    """
    from surftex.kernels.gutter import nearest_in_rows
    from surftex.kernels.rows import repeat_rows

    row = _nearest_rows(mapped)
    width = mapped.shape[1]
    pages = [image.reshape(mapped.size, -1) for image in images]

    def work(first: int, last: int) -> None:
        source = np.zeros((last - first, width), np.int64)
        nearest_in_rows(row, first, last, np.zeros(width, np.int64), np.zeros(width + 1), source)
        free = np.flatnonzero(~mapped[first:last])
        place, source = frozen(free + first * width), frozen(source.ravel()[free])
        for page in pages:
            repeat_rows(place, source, page)
            let_go(page)

    slices(work, len(mapped), size=_ROWS, threads=threads)


def _nearest_rows(mapped: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Row of the nearest mapped texel in each texel's column."""
    from surftex.kernels.gutter import nearest_in_columns

    if not mapped.any():
        raise InputError(
            f"no texel of the {mapped.shape[1]} x {mapped.shape[0]} page is mapped; nothing can fill it"
        )
    row = np.zeros(mapped.shape, np.int32)
    nearest_in_columns(np.ascontiguousarray(mapped), row)
    return row
