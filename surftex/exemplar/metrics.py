"""How alike two textures are, and how much of one was copied from the other.

Every number means little by itself: divide it by what two halves of one picture give (`natural`).

* `near_distance`: differences of next pixels, up to 4 apart. Longer pairs are nearly independent in most
  textures, and shuffled pixels score as well on them as real ones.
* `pattern_distance`: local binary patterns of 8 neighbours [1]_; no part of the model, so the judge of structure.
* `gabor_distance`: strengths of wavelets at 4 scales and 4 angles.
* `copying`: how far nearest patches of 7 x 7 lie side by side, as in verbatim copies.

References
----------
.. [1] Ojala, Pietikäinen, Mäenpää. Multiresolution Gray-Scale and Rotation Invariant Texture Classification with
   Local Binary Patterns. IEEE TPAMI 24 (2002).
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.errors import InputError
from surftex.exemplar.cliques import pair_window
from surftex.exemplar.lattice import Plane
from surftex.exemplar.measure import distance, pair_shares

_LEVELS = 32
_NEAR = 4
_FREQUENCIES, _ANGLES = (0.35, 0.2, 0.1, 0.05), 4
_PATCH, _DIMENSIONS = 7, 12
_NEIGHBORS = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))


def metrics(image: ArrayLike, reference: ArrayLike) -> dict[str, float]:
    """Compare a texture with a picture of it by all metrics.

    Parameters
    ----------
    image : (h, w) or (h, w, 3) uint8
        The texture.
    reference : (h, w) or (h, w, 3) uint8
        What it shall look like.

    Returns
    -------
    metrics : dict of str to float
        ``near``, ``pattern1``, ``pattern2``, ``gabor``, ``coherence``, ``largest_px``.

    Raises
    ------
    InputError
        If one of them is no picture, or smaller than 32 x 32.
    """
    coherence, largest = copying(image, reference)
    return {
        "near": near_distance(image, reference),
        "pattern1": pattern_distance(image, reference, 1),
        "pattern2": pattern_distance(image, reference, 2),
        "gabor": gabor_distance(image, reference),
        "coherence": coherence,
        "largest_px": float(largest),
    }


def near_distance(image: ArrayLike, reference: ArrayLike) -> float:
    """Compare differences of pixels that are at most 4 apart.

    Parameters
    ----------
    image : (h, w) or (h, w, 3) uint8
        The texture.
    reference : (h, w) or (h, w, 3) uint8
        What it shall look like; its range is cut into 32 levels.

    Returns
    -------
    distance : float
        Mean Euclidean distance of the histograms of differences.
    """
    wanted, given = _grey(reference), _grey(image)
    low, high = np.percentile(wanted, [0.5, 99.5])
    shares = [_near_shares(each, low, max(high - low, 1.0)) for each in (given, wanted)]
    return float(distance(*shares).mean())


def pattern_distance(image: ArrayLike, reference: ArrayLike, radius: int = 1) -> float:
    """Compare local binary patterns.

    Parameters
    ----------
    image : (h, w) or (h, w, 3) uint8
        The texture.
    reference : (h, w) or (h, w, 3) uint8
        What it shall look like.
    radius : int
        Steps to the eight neighbours.

    Returns
    -------
    distance : float
        Total variation of the shares of the 256 patterns, 0 to 1.
    """
    shares = [_patterns(_grey(each), radius) for each in (image, reference)]
    return float(0.5 * np.abs(shares[0] - shares[1]).sum())


def gabor_distance(image: ArrayLike, reference: ArrayLike) -> float:
    """Compare the strengths of wavelets.

    Parameters
    ----------
    image : (h, w) or (h, w, 3) uint8
        The texture.
    reference : (h, w) or (h, w, 3) uint8
        What it shall look like.

    Returns
    -------
    distance : float
        Mean difference of the quantiles of their magnitudes, as a share of the mean magnitude.
    """
    given, wanted = (_gabor_quantiles(_grey(each)) for each in (image, reference))
    return float((np.abs(given - wanted) / wanted.mean(axis=1, keepdims=True)).mean())


def copying(image: ArrayLike, exemplar: ArrayLike) -> tuple[float, int]:
    """Tell how much of a texture was copied.

    Parameters
    ----------
    image : (h, w) or (h, w, 3) uint8
        The texture.
    exemplar : (h, w) or (h, w, 3) uint8
        What it was made from.

    Returns
    -------
    coherence : float
        Share of neighbours whose nearest patches in the exemplar are neighbours in the same way, 0 to 1.
    largest : int
        Pixels of the largest connected piece with one displacement.
    """
    from scipy.ndimage import label
    from scipy.spatial import KDTree

    source, source_shape = _patches(_grey(exemplar))
    given, shape = _patches(_grey(image))
    middle = source.mean(axis=0)
    _, axes = np.linalg.eigh((source - middle).T @ (source - middle))
    axes = axes[:, ::-1][:, :_DIMENSIONS]
    _, nearest = KDTree((source - middle) @ axes).query((given - middle) @ axes, workers=-1)
    row, column = np.divmod(nearest.reshape(shape), source_shape[1])
    down, right = row - np.arange(shape[0])[:, None], column - np.arange(shape[1])
    same_across = (down[:, 1:] == down[:, :-1]) & (right[:, 1:] == right[:, :-1])
    same_down = (down[1:] == down[:-1]) & (right[1:] == right[:-1])
    _, kind, count = np.unique(down * (2 * 10**5) + right, return_inverse=True, return_counts=True)
    largest = 0
    for move in np.argsort(-count, kind="stable")[:60]:
        if count[move] <= largest:
            break
        pieces: NDArray[np.int32] = label(kind.reshape(shape) == move)[0]  # type: ignore[index]
        largest = max(largest, int(np.bincount(pieces.ravel())[1:].max()))
    return float(0.5 * (same_across.mean() + same_down.mean())), largest


def _grey(image: ArrayLike) -> NDArray[np.float64]:
    picture = np.asarray(image, np.float64)
    if picture.ndim == 3 and picture.shape[2] in (1, 3):
        picture = picture.mean(axis=2)
    if picture.ndim != 2 or min(picture.shape) < 32:
        raise InputError(f"shape {picture.shape} is no picture of 32 x 32 or more, grey or of three bands")
    return picture


def _near_shares(picture: NDArray[np.float64], low: float, span: float) -> NDArray[np.float32]:
    level = np.clip((picture - low) / span * _LEVELS, 0, _LEVELS - 1).astype(np.uint8)
    plane = Plane.of(level.shape[0], level.shape[1], _NEAR, wrap=False)
    return pair_shares(plane, plane.hold(level[None]), pair_window(1, _NEAR))[0]


def _patterns(picture: NDArray[np.float64], radius: int) -> NDArray[np.float64]:
    rows, columns = picture.shape
    middle = picture[radius : rows - radius, radius : columns - radius]
    code = np.zeros(middle.shape, np.int64)
    for bit, (right, down) in enumerate(_NEIGHBORS):
        top, left = radius * (1 + down), radius * (1 + right)
        code |= (picture[top : top + len(middle), left : left + middle.shape[1]] >= middle).astype(
            np.int64
        ) << bit
    return np.bincount(code.ravel(), minlength=256) / code.size


def _gabor_quantiles(picture: NDArray[np.float64]) -> NDArray[np.float64]:
    values = (picture - picture.mean()) / max(float(picture.std()), 1e-9)
    down, right = np.meshgrid(*(np.fft.fftfreq(length) for length in values.shape), indexing="ij")
    spectrum = np.fft.fft2(values)
    margin = min(24, min(values.shape) // 8)
    rows = []
    for frequency in _FREQUENCIES:
        for turn in range(_ANGLES):
            angle = np.pi * turn / _ANGLES
            along = right * np.cos(angle) + down * np.sin(angle)
            across = down * np.cos(angle) - right * np.sin(angle)
            width = frequency / 3.0
            window = np.exp(-((along - frequency) ** 2 + across**2) / (2 * width**2))
            magnitude = np.abs(np.fft.ifft2(spectrum * window))[margin:-margin, margin:-margin]
            rows.append(np.quantile(magnitude, np.linspace(0.005, 0.995, 100)))
    return np.array(rows)


def _patches(picture: NDArray[np.float64]) -> tuple[NDArray[np.float64], tuple[int, int]]:
    windows = np.lib.stride_tricks.sliding_window_view(picture, (_PATCH, _PATCH))
    return windows.reshape(-1, _PATCH**2), windows.shape[:2]
