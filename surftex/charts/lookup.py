"""Looking pictures up: bilinear values and their weights, mips by averages of two by two."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import read_only_view
from surftex.paged import blocks, in_file, let_go, page


def bilinear_stencil(
    uv: NDArray[np.float64], width: int, height: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Find the four texels that a bilinear lookup mixes.

    Parameters
    ----------
    uv : (n, 2) float64
        Places on the page; u right, v up.
    width : int
        Columns of the picture.
    height : int
        Rows, the first on top.

    Returns
    -------
    texel : (n, 4) int64
        Flat indices; beyond the page the texel at its edge.
    weight : (n, 4) float64
        Their shares, with a sum of 1.
    """
    column, row = uv[:, 0] * width - 0.5, (1.0 - uv[:, 1]) * height - 0.5
    left, top = np.floor(column), np.floor(row)
    across, down = column - left, row - top
    columns = np.clip(np.stack([left, left + 1], axis=1), 0, width - 1).astype(np.int64)
    rows = np.clip(np.stack([top, top + 1], axis=1), 0, height - 1).astype(np.int64)
    texel = (rows[:, :, None] * width + columns[:, None, :]).reshape(-1, 4)
    shares = (
        np.stack([1 - down, down], axis=1)[:, :, None] * np.stack([1 - across, across], axis=1)[:, None, :]
    )
    return texel, shares.reshape(-1, 4)


def bilinear(image: NDArray[Any], uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Look a picture up.

    Parameters
    ----------
    image : (height, width) or (height, width, c) array
        Numbers of any type. It may lie in a file, see `surftex.paged`: then it is read from top to bottom.
    uv : (n, 2) float64
        Places on the page.

    Returns
    -------
    value : (n,) or (n, c) float64
        Mixed from four texels each.
    """
    from surftex.kernels.lookup import mix_texels

    height, width = image.shape[:2]
    texels = read_only_view(image, image.dtype).reshape(height * width, -1)
    mixed = np.zeros((len(uv), texels.shape[1]))
    if in_file(image.shape):
        row = np.clip((1.0 - uv[:, 1]) * height - 0.5, 0, height - 1)
        order = np.argsort(row, kind="stable")
        for rows in blocks(image):
            chosen = order[slice(*np.searchsorted(row[order], [rows.start, rows.stop]))]
            value = np.zeros((len(chosen), texels.shape[1]))
            mix_texels(texels, width, height, read_only_view(uv[chosen], np.float64), value)
            mixed[chosen] = value
    else:
        mix_texels(texels, width, height, read_only_view(uv, np.float64), mixed)
    return mixed[:, 0] if image.ndim == 2 else mixed


def bilinear_tiles(
    images: Mapping[int, NDArray[Any]], uv: NDArray[np.float64], tile: NDArray[np.integer]
) -> NDArray[np.float64]:
    """Look up pictures that lie on several pages.

    Parameters
    ----------
    images : mapping of int to (height, width) or (height, width, c) array
        By UDIM number; all alike.
    uv : (n, 2) float64
        Places, each on its own page.
    tile : (n,) int
        Page of each.

    Returns
    -------
    value : (n,) or (n, c) float64
        Mixed from four texels each, of one page.
    """
    first = next(iter(images.values()))
    value = np.zeros((len(uv), *first.shape[2:]))
    for number, image in images.items():
        rows = tile == number
        value[rows] = bilinear(image, uv[rows])
    return value


def half(image: NDArray[Any]) -> NDArray[Any]:
    """Make the next mip: the mean of each two by two texels.

    Parameters
    ----------
    image : (height, width) or (height, width, c) float array
        Even sides.

    Returns
    -------
    image : (height / 2, width / 2) or (height / 2, width / 2, c) array
        Of the same type.
    """
    from surftex.kernels.lookup import halve

    height, width, *channels = image.shape
    result = page((height // 2, width // 2, *channels), image.dtype)
    for rows in blocks(image):
        part = read_only_view(image[rows], image.dtype).reshape((rows.stop - rows.start) * width, -1)
        smaller = result[rows.start // 2 : rows.stop // 2]
        halve(part, width, smaller.reshape(-1, part.shape[1]))
        let_go(result)
    return result
