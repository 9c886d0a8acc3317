"""Pictures as a renderer reads them: linear numbers, halved level by level, blended between texels and levels."""

import numpy as np
from numpy.typing import NDArray


def linear_light(codes: NDArray[np.integer]) -> NDArray[np.float32]:
    """Decode sRGB codes.

    Parameters
    ----------
    codes : (...) uint8 or uint16
        As files have them.

    Returns
    -------
    light : (...) float32
        0 to 1, linear.
    """
    top = np.iinfo(codes.dtype).max
    share = np.arange(top + 1) / top
    table = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4).astype(np.float32)
    return table[codes]


class Pyramid:
    """A picture and its halvings.

    Parameters
    ----------
    image : (h, w, c) float
        Row 0 on top.
    """

    def __init__(self, image: NDArray[np.floating]) -> None:
        level = np.asarray(image, np.float32)
        self.levels = [level.astype(np.float16)]
        while min(level.shape[:2]) > 1:
            rows, columns = (n // 2 * 2 for n in level.shape[:2])
            even = level[:rows, :columns]
            level = 0.25 * (even[::2, ::2] + even[1::2, ::2] + even[::2, 1::2] + even[1::2, 1::2])
            self.levels.append(level.astype(np.float16))

    def at(self, uv: NDArray[np.floating], level: NDArray[np.floating]) -> NDArray[np.float32]:
        """Read the picture at places, each at its own level.

        Parameters
        ----------
        uv : (n, 2) float
            v runs down; beyond 0 to 1 the picture repeats.
        level : (n,) float
            0 is the picture itself, 1 its half; clipped to what there is.

        Returns
        -------
        values : (n, c) float32
            Blended between four texels and two levels.
        """
        level = np.clip(level, 0, len(self.levels) - 1)
        low = np.floor(level).astype(int)
        share = (level - low).astype(np.float32)[:, None]
        result = np.zeros((len(uv), self.levels[0].shape[2]), np.float32)
        for k in range(len(self.levels)):
            mine = np.flatnonzero((low == k) | ((low == k - 1) & (share[:, 0] > 0)))
            if len(mine):
                weight = np.where((low[mine] == k)[:, None], 1 - share[mine], share[mine])
                result[mine] += weight * self._blended(uv[mine], k)
        return result

    def _blended(self, uv: NDArray[np.floating], k: int) -> NDArray[np.float32]:
        image = self.levels[k]
        height, width = image.shape[:2]
        column, row = uv[:, 0] * width - 0.5, uv[:, 1] * height - 0.5
        c, r = np.floor(column).astype(np.int64), np.floor(row).astype(np.int64)
        x, y = (column - c).astype(np.float32)[:, None], (row - r).astype(np.float32)[:, None]
        left, right, top, bottom = c % width, (c + 1) % width, r % height, (r + 1) % height
        flat = image.reshape(height * width, -1)
        upper = flat[top * width + left] * (1 - x) + flat[top * width + right] * x
        lower = flat[bottom * width + left] * (1 - x) + flat[bottom * width + right] * x
        return (upper * (1 - y) + lower * y).astype(np.float32)
