"""Pictures without holes: every texel that stands for no place takes the value of the nearest one that does."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import read_only_view
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
    source = np.arange(mapped.size)

    def take(place: NDArray[np.int64], nearest: NDArray[np.int64]) -> None:
        source[place] = nearest

    _gaps(mapped, take, threads)
    return source.reshape(mapped.shape)


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
    from surftex.kernels.rows import repeat_rows

    pages = [image.reshape(mapped.size, -1) for image in images]

    def take(place: NDArray[np.int64], source: NDArray[np.int64]) -> None:
        for page in pages:
            repeat_rows(place, source, page)
            let_go(page)

    _gaps(mapped, take, threads)


def _gaps(
    mapped: NDArray[np.bool_],
    take: Callable[[NDArray[np.int64], NDArray[np.int64]], None],
    threads: int | None,
) -> None:
    """Hand out flat indices of the texels that are not mapped, and of the nearest mapped ones, some rows at a time."""
    from surftex.kernels.gutter import nearest_in_columns, nearest_in_rows

    if not mapped.any():
        raise InputError(
            f"no texel of the {mapped.shape[1]} x {mapped.shape[0]} page is mapped; nothing can fill it"
        )
    row, width = np.zeros(mapped.shape, np.int32), mapped.shape[1]
    nearest_in_columns(np.ascontiguousarray(mapped), row)

    def work(first: int, last: int) -> None:
        place, source = np.zeros((2, (last - first) * width), np.int64)
        count = nearest_in_rows(
            row, first, last, np.zeros(width, np.int64), np.zeros(width + 1), place, source
        )
        take(*(read_only_view(part[:count], np.int64) for part in (place, source)))

    slices(work, len(mapped), size=_ROWS, threads=threads)
