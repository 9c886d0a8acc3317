"""The picture that a drawn texture is measured against: checked before anything is drawn, as grey as metrics are."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.exemplar.exemplar import Exemplar
from surftex.exemplar.labels import LabelModel
from surftex.exemplar.measure import distance
from surftex.exemplar.model import TextureModel
from surftex.exemplar.picture import SMALLEST, shrunk, spread
from surftex.exemplar.store import Model
from surftex.files.exemplars import read_exemplar, read_label_map
from surftex.files.reading import printable

MOST_PIXELS = 2**20
"""Pixels of a picture, and of what is drawn, beyond which nearest patches take too long to find."""

_OTHER_SCALES = (1, 2, 3, 4, 6, 8)
_NOTABLE, _CLEARLY = 0.03, 0.5
"""Distance of next pixels from the model's from which another scale is sought, and how much nearer that must be."""


def read_reference(
    path: str | Path, model: Model, size: tuple[int, int], shrink: int = 1
) -> tuple[NDArray[Any], list[str]]:
    """Read the picture to compare a drawing with.

    Parameters
    ----------
    path : path
        PNG or JPEG; a label map for a layout.
    model : TextureModel, CompositeModel or LabelModel
        What will be drawn.
    size : (int, int)
        Width and height of the drawing.
    shrink : int
        Pixels of each side of the picture that become one.

    Returns
    -------
    reference : (h, w) or (h, w, 3) uint8
        As `surftex.metrics` takes it.
    warnings : list of str
        What makes the comparison a poor one.

    Raises
    ------
    InputError
        If the picture cannot be read or compared, or the drawing is too small or too large; the message names the file.
    """
    name = printable(str(path))
    if isinstance(model, LabelModel):
        label = read_label_map(path)[::shrink, ::shrink]
        if label.max() >= model.labels:
            raise InputError(f"{name}: has {label.max() + 1} labels; the model draws {model.labels}")
        reference: NDArray[Any] = spread(label, model.labels)
    else:
        whole = read_exemplar(path)
        reference = shrunk(whole // 257 if whole.dtype == np.uint16 else whole, shrink).astype(np.uint8)
    for what, (width, height) in ((name, reference.shape[1::-1]), ("the drawing", size)):
        if min(width, height) < SMALLEST or width * height > MOST_PIXELS:
            raise InputError(
                f"{what}: has {width} x {height} pixels; pictures are compared from {SMALLEST} x {SMALLEST} to "
                f"{MOST_PIXELS} pixels in all"
            )
    if reference.min() == reference.max():
        raise InputError(f"{name}: is flat: all its pixels are alike; there is nothing to compare with")
    warnings = []
    colored = not isinstance(model, LabelModel) and model.bands.colored
    if colored != (reference.ndim == 3):
        kinds = ("grey", "in colour")
        warnings.append(
            f"{name} is {kinds[reference.ndim == 3]}, the drawing {kinds[colored]}; both are compared as grey"
        )
    if isinstance(model, TextureModel):
        better = _better_scale(model, reference)
        if better > 1:
            warnings.append(
                f"the pixels of {name} seem finer than those the model was learnt from; with --shrink {shrink * better} "
                "they are more alike"
            )
    return reference, warnings


def _better_scale(model: TextureModel, reference: NDArray[Any]) -> int:
    """Pixels to join so that next pixels differ as the model says; 1 unless another number is clearly better."""
    lack = {
        by: _lack(model, shrunk(reference, by))
        for by in _OTHER_SCALES
        if min(reference.shape[:2]) >= by * SMALLEST
    }
    best = min(lack, key=lack.__getitem__)
    return best if lack[1] > _NOTABLE and lack[best] < _CLEARLY * lack[1] else 1


def _lack(model: TextureModel, reference: NDArray[Any]) -> float:
    """Mean distance of pairs of next pixels of the first band from those of the model."""
    whole, target = model.bands, model.target
    bands = replace(
        whole, names=whole.names[: whole.shown], low=whole.low[: whole.shown], high=whole.high[: whole.shown],
        curve=whole.curve[:, : whole.shown],
    )  # fmt: skip
    picture = reference.astype(np.float32).reshape(*reference.shape[:2], -1)
    if picture.shape[2] != bands.shown:
        picture = np.repeat(picture.mean(axis=2, keepdims=True), bands.shown, axis=2)
    exemplar = Exemplar.of(bands.levels_of(picture), np.ones(picture.shape[:2], bool), 1)
    kind = target.pair_type
    near = (kind[:, :2] == 0).all(axis=1) & (np.abs(kind[:, 2:]).sum(axis=1) == 1)
    return float(distance(exemplar.pairs(kind[near], target.code), target.pair[0][near]).mean())
