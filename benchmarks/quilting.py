"""Image quilting, short: patches of the exemplar are copied, and joined along the cut where they differ least.

After Efros and Freeman, Image Quilting for Texture Synthesis and Transfer, SIGGRAPH (2001). The peer that copies.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from surftex.randomness import stream

TOLERANCE = 0.1


def quilt(exemplar, width, height, seed=0, *, patch=24, overlap=6):
    """Draw (height, width[, 3]) uint8 from patches of an exemplar."""
    source = np.asarray(exemplar, np.float64)
    source = source[..., None] if source.ndim == 2 else source
    random = stream(seed, "quilting")
    step = patch - overlap
    rows, columns = -(-(height - overlap) // step), -(-(width - overlap) // step)
    drawn = np.zeros((rows * step + overlap, columns * step + overlap, source.shape[2]))
    places = source.shape[0] - patch + 1, source.shape[1] - patch + 1
    strips = {
        shape: sliding_window_view(source, shape, axis=(0, 1))[: places[0], : places[1]]
        for shape in ((patch, overlap), (overlap, patch))
    }
    for number in range(rows * columns):
        row, column = divmod(number, columns)
        top, left = row * step, column * step
        here = drawn[top : top + patch, left : left + patch]
        error = np.zeros(places)
        if column:
            error += _differences(strips[patch, overlap], here[:, :overlap])
        if row:
            error += _differences(strips[overlap, patch], here[:overlap])
        good = np.argwhere(error <= (1 + TOLERANCE) * max(error.min(), 1e-9))
        y, x = good[int(random.uniform(1, 1, first=number)[0, 0] * len(good))]
        chosen = source[y : y + patch, x : x + patch]
        mask = np.ones((patch, patch), bool)
        if column:
            mask[:, :overlap] &= _cut(((here - chosen) ** 2).sum(axis=2)[:, :overlap])
        if row:
            mask[:overlap] &= _cut(((here - chosen) ** 2).sum(axis=2)[:overlap].T).T
        here[mask] = chosen[mask]
    picture = np.clip(np.rint(drawn[:height, :width]), 0, 255).astype(np.uint8)
    return picture[..., 0] if picture.shape[2] == 1 else picture


def _differences(windows, wanted):
    """Sums of squares between every window and what is there."""
    return ((windows - np.moveaxis(wanted, -1, 0)) ** 2).sum(axis=(2, 3, 4))


def _cut(cost):
    """Right of the cheapest way from top to bottom."""
    total = cost.copy()
    for row in range(1, len(total)):
        before = np.pad(total[row - 1], 1, constant_values=np.inf)
        total[row] += np.minimum(np.minimum(before[:-2], before[1:-1]), before[2:])
    mask = np.zeros(cost.shape, bool)
    column = int(total[-1].argmin())
    for row in range(len(total) - 1, -1, -1):
        if row < len(total) - 1:
            low = max(0, column - 1)
            column = low + int(total[row, low : column + 2].argmin())
        mask[row, column:] = True
    return mask
