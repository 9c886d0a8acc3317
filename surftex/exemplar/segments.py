"""`segment`: a picture parted into labels by tone, tint and roughness, where nobody has painted a label map."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.errors import InputError
from surftex.exemplar.picture import checked_picture
from surftex.randomness import stream

_SAMPLES, _ROUNDS = 20_000, 40
_ROUGH = 1.0
"""Weight of the roughness of a place beside its colour."""


def segment(image: ArrayLike, labels: int, *, scale: float = 2.0, seed: int = 0) -> NDArray[np.uint8]:
    """Part a picture into labels.

    Parameters
    ----------
    image : (h, w) or (h, w, 3) uint8, uint16 or float
        The picture.
    labels : int
        How many, 2 to 8.
    scale : float
        Pixels over which tone and roughness are taken; parts of less than that vanish.
    seed : int
        Of the samples that the labels start from.

    Returns
    -------
    label : (h, w) uint8
        From the darkest, 0, to the lightest.

    Raises
    ------
    InputError
        If the picture is none, or there are too few or too many labels.

    Examples
    --------
    >>> halves = np.where(np.arange(64) < 20, 30, 220) + np.zeros((64, 1))
    >>> np.bincount(segment(halves.astype(np.uint8), 2).ravel()).tolist()
    [1280, 2816]
    """
    from scipy.ndimage import gaussian_filter

    if not 2 <= labels <= 8:
        raise InputError(f"labels is {labels}; a picture is parted into 2 to 8")
    if not 0.5 <= scale <= 100:
        raise InputError(f"scale is {scale:g}; it takes 0.5 to 100 pixels")
    picture = checked_picture(image)[0].astype(np.float64)
    features = []
    for band in np.moveaxis(picture, 2, 0):
        mean = gaussian_filter(band, scale)
        features += [mean, _ROUGH * np.sqrt(gaussian_filter((band - mean) ** 2, 1.5 * scale))]
    place = np.stack(features, axis=-1).reshape(-1, len(features))
    middle = _middles(place, labels, seed)
    nearest = _nearest(place, middle).reshape(picture.shape[:2])
    votes = np.stack([gaussian_filter((nearest == each).astype(np.float64), scale) for each in range(labels)])
    return votes.argmax(axis=0).astype(np.uint8)


def _middles(place: NDArray[np.float64], labels: int, seed: int) -> NDArray[np.float64]:
    """Middles of the labels, from the darkest on: each is the mean of what lies nearest to it."""
    pick = (stream(seed, "segments").uniform(min(_SAMPLES, len(place)))[:, 0] * len(place)).astype(np.int64)
    some = place[pick]
    middle = some[:1]
    while len(middle) < labels:
        away = ((some[:, None] - middle) ** 2).sum(axis=2).min(axis=1)
        middle = np.concatenate([middle, some[away.argmax()][None]])
    for _ in range(_ROUNDS):
        nearest = _nearest(some, middle)
        middle = np.stack(
            [some[nearest == k].mean(axis=0) if (nearest == k).any() else middle[k] for k in range(labels)]
        )
    return middle[np.argsort(middle[:, ::2].sum(axis=1), kind="stable")]


def _nearest(place: NDArray[np.float64], middle: NDArray[np.float64]) -> NDArray[np.int64]:
    away = np.stack([((place - each) ** 2).sum(axis=1) for each in middle])
    return away.argmin(axis=0)
