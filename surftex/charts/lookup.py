"""Looking pictures up: bilinear values and their weights, mips by averages of two by two."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import read_only_view
from surftex.paged import blocks, in_file, let_go, page

_KEPT = 64
"""So many by so many texels of a mip are kept while places are looked up, as neighbours ask for the same."""


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


def bilinear(image: NDArray[Any], uv: NDArray[np.float64], mip: int = 0) -> NDArray[np.float64]:
    """Look a picture up.

    Parameters
    ----------
    image : (height, width) or (height, width, c) array
        Numbers of any type. It may lie in a file, see `surftex.paged`: then it is read from top to bottom.
    uv : (n, 2) float64
        Places on the page.
    mip : int
        So many times the picture is halved before, as by `half`; its sides must be even as often.

    Returns
    -------
    value : (n,) or (n, c) float64
        Mixed from four texels each.
    """
    from surftex.kernels.lookup import mix_mip, mix_texels

    height, width = image.shape[:2]
    texels = read_only_view(image, image.dtype).reshape(height * width, -1)
    mixed = np.zeros((len(uv), texels.shape[1]))

    def mix(uv: NDArray[np.float64], value: NDArray[np.float64]) -> None:
        uv = read_only_view(uv, np.float64)
        if mip == 0:
            mix_texels(texels, width, height, uv, value)
            return
        known, mean = np.full((_KEPT, _KEPT), -1), np.zeros((_KEPT**2, texels.shape[1]), image.dtype)
        work = np.zeros(4**mip, image.dtype)
        mix_mip(texels, width, height, 2**mip, uv, known, mean, work, value)

    if in_file(image.shape):
        row = np.clip((1.0 - uv[:, 1]) * height - 0.5, 0, height - 1)
        order = np.argsort(row, kind="stable")
        for rows in blocks(image):
            chosen = order[slice(*np.searchsorted(row[order], [rows.start, rows.stop]))]
            value = np.zeros((len(chosen), texels.shape[1]))
            mix(uv[chosen], value)
            mixed[chosen] = value
    else:
        mix(uv, mixed)
    return mixed[:, 0] if image.ndim == 2 else mixed


def bilinear_tiles(
    images: Mapping[int, NDArray[Any]], uv: NDArray[np.float64], tile: NDArray[np.integer], mip: int = 0
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
    mip : int
        As for `bilinear`.

    Returns
    -------
    value : (n,) or (n, c) float64
        Mixed from four texels each, of one page.
    """
    first = next(iter(images.values()))
    if len(images) == 1:
        return bilinear(first, uv, mip)
    value = np.zeros((len(uv), *first.shape[2:]))
    for number, image in images.items():
        rows = tile == number
        value[rows] = bilinear(image, uv[rows], mip)
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
