"""Pictures without holes: every texel that stands for no place takes the value of the nearest one that does."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.kernels.pool import slices


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
    from surftex.kernels.gutter import nearest_in_columns, nearest_in_rows

    mapped = np.ascontiguousarray(mapped)
    if not mapped.any():
        raise InputError(
            f"no texel of the {mapped.shape[1]} x {mapped.shape[0]} page is mapped; nothing can fill it"
        )
    height, width = mapped.shape
    row = np.zeros((height, width), np.int32)
    nearest_in_columns(mapped, row)
    source = np.zeros((height, width), np.int64)

    def work(first: int, last: int) -> None:
        nearest_in_rows(row, first, last, np.zeros(width, np.int64), np.zeros(width + 1), source)

    slices(work, height, size=64, threads=threads)
    return source


def fill_nearest(
    image: NDArray[Any], mapped: NDArray[np.bool_], *, threads: int | None = None
) -> NDArray[Any]:
    """Fill the texels of a picture that are not mapped, in place.

    Parameters
    ----------
    image : (height, width) or (height, width, c) array
        Any type; C-contiguous.
    mapped : (height, width) bool
        Texels that hold a value.
    threads : int, optional
        None means every core.

    Returns
    -------
    image : array
        The same array.
    """
    source = nearest_mapped(mapped, threads=threads)
    free = np.flatnonzero(~mapped)
    flat = image.reshape(mapped.size, -1)
    flat[free] = flat[source.ravel()[free]]
    return image
