"""`Bands`: how the numbers of a picture become levels, and levels become numbers again.

Red, green and blue go through a rotation to their principal axes, learnt from the picture and kept with the
model: the first band then carries most of the structure, and the others little but tint. A tint follows the light in
its own way in each material, so the levels of all bands but the first count from their mean at that light, label by
label, where most of them follows from it: what a tint owes to its light cannot be lost when pixels are drawn.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError

_TAIL_PERCENT = 0.5
_LEAST_SPAN = 2.0
"""Narrowest range of a band, in steps of an 8-bit picture."""

_LEAST_TINT = 0.1

_LEAN = 0.1
"""What a level of light weighs in the mean tint of the next one."""

_MOST_LOOSE = 0.5
"""Share of a tint's variance that its light may leave open; beyond it the tint goes its own way, as of red stones
among grey ones."""


@dataclass(frozen=True, eq=False)
class Bands:
    """Ranges of bands.

    Attributes
    ----------
    names : tuple of str
        ``("grey",)`` or ``("red", "green", "blue")``, then any of ``"height"``, ``"roughness"``.
    low, high : (c,) float64
        Range of each band, after the rotation and above its curve; 0 to 255 for plain ones.
    axes : (3, 3) float64
        Rotation from red, green, blue to the first three bands; unused without colour.
    levels : int
        Of each band.
    curve : (labels, c, levels) float64
        Mean of each band at the middle of each level of the first, for each label; 0 for the first band.
    """

    names: tuple[str, ...]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    axes: NDArray[np.float64]
    levels: int
    curve: NDArray[np.float64]

    @property
    def colored(self) -> bool:
        """Whether the first three bands are a colour."""
        return self.names[0] == "red"

    @property
    def shown(self) -> int:
        """Bands that make the picture; the others are maps beside it."""
        return 3 if self.colored else 1

    @property
    def telling(self) -> tuple[int, ...]:
        """Bands whose structure can be seen: all but tints that span less than a tenth of the widest band."""
        span = self.high - self.low
        return tuple(
            band
            for band in range(len(self.names))
            if band >= self.shown or span[band] >= _LEAST_TINT * span[: self.shown].max()
        )

    @staticmethod
    def learnt(
        picture: NDArray[np.floating],
        names: tuple[str, ...],
        mask: NDArray[np.bool_],
        levels: int,
        label: NDArray[np.uint8] | None = None,
    ) -> "Bands":
        """Find ranges, axes and curves.

        Parameters
        ----------
        picture : (h, w, c) float
            0 to 255.
        names : tuple of str
            Of its bands.
        mask : (h, w) bool
            Pixels that count.
        levels : int
            Of each band.
        label : (h, w) uint8, optional
            Each label gets curves of its own.

        Returns
        -------
        bands : Bands
            From the 0.5th to the 99.5th percentile.

        Raises
        ------
        InputError
            If the picture shows nothing.
        """
        axes = np.eye(3)
        if names[0] == "red":
            axes = _principal(picture[mask][:, :3].astype(np.float64))
        values = _rotated(picture[mask].astype(np.float64), names, axes)
        low, high = np.percentile(values, [_TAIL_PERCENT, 100 - _TAIL_PERCENT], axis=0)
        if (high - low < _LEAST_SPAN).all():
            raise InputError(
                "the picture is flat: all its pixels are nearly alike; there is no texture to learn"
            )
        group = np.zeros(len(values), np.uint8) if label is None else label[mask]
        light = (values[:, 0] - low[0]) / max(high[0] - low[0], _LEAST_SPAN) * levels
        curve = _curves(values, np.clip(light, 0, levels - 1).astype(np.uint8), group, levels)
        values -= _at(curve, light, group)
        low, high = np.percentile(values, [_TAIL_PERCENT, 100 - _TAIL_PERCENT], axis=0)
        middle, half = 0.5 * (low + high), 0.5 * np.maximum(high - low, _LEAST_SPAN)
        return Bands(names, middle - half, middle + half, axes, levels, curve)

    def levels_of(
        self, picture: NDArray[np.floating], label: NDArray[np.uint8] | None = None
    ) -> NDArray[np.uint8]:
        """Turn numbers into levels.

        Parameters
        ----------
        picture : (h, w, c) float
            0 to 255.
        label : (h, w) uint8, optional
            Of each pixel; the first without it.

        Returns
        -------
        level : (c, h, w) uint8
            0 to `levels` - 1.
        """
        values = _rotated(picture.astype(np.float64), self.names, self.axes)
        light = (values[..., 0] - self.low[0]) / (self.high[0] - self.low[0]) * self.levels
        values = values - _at(self.curve, light, label)
        share = (values - self.low) / (self.high - self.low)
        level = np.clip(share * self.levels, 0, self.levels - 1).astype(np.uint8)
        return np.ascontiguousarray(np.moveaxis(level, -1, 0))

    def numbers_of(
        self, number: NDArray[np.floating], label: NDArray[np.uint8] | None = None
    ) -> NDArray[np.float64]:
        """Turn levels into numbers.

        Parameters
        ----------
        number : (c, ...) float
            Levels, and how far into them: 0 to `levels`.
        label : (...) uint8, optional
            Of each place; the first without it.

        Returns
        -------
        picture : (..., c) float64
            0 to 255, not yet rounded or clipped.
        """
        share = np.moveaxis(np.asarray(number, np.float64) / self.levels, 0, -1)
        values = share * (self.high - self.low) + self.low + _at(self.curve, number[0], label)
        if self.colored:
            values = np.concatenate([values[..., :3] @ self.axes.T, values[..., 3:]], axis=-1)
        return values

    def maps_of(
        self, number: NDArray[np.floating], label: NDArray[np.uint8] | None = None
    ) -> dict[str, NDArray[np.uint8]]:
        """Turn levels into pictures of 8 bits.

        Parameters
        ----------
        number : (c, h, w) float
            As for `numbers_of`.
        label : (h, w) uint8, optional
            As for `numbers_of`.

        Returns
        -------
        maps : dict of str to (h, w) or (h, w, 3) uint8
            ``picture``, and what was learnt beside it.
        """
        values = np.clip(np.rint(self.numbers_of(number, label)), 0, 255).astype(np.uint8)
        first = values[..., : self.shown]
        maps = {"picture": first if self.colored else first[..., 0]}
        for name, at in zip(self.names[self.shown :], range(self.shown, len(self.names)), strict=True):
            maps[name] = values[..., at]
        return maps


def _rotated(
    values: NDArray[np.float64], names: tuple[str, ...], axes: NDArray[np.float64]
) -> NDArray[np.float64]:
    if names[0] != "red":
        return values
    return np.concatenate([values[..., :3] @ axes, values[..., 3:]], axis=-1)


def _principal(color: NDArray[np.float64]) -> NDArray[np.float64]:
    """Axes of a cloud of colours, the longest first, each pointing to more light."""
    _, axes = np.linalg.eigh(np.cov(color.T))
    axes = axes[:, ::-1]
    sign = np.sign(axes[np.abs(axes).argmax(axis=0), np.arange(3)])
    return np.asarray(np.round(axes * np.where(sign == 0, 1, sign), 6), np.float64)


def _curves(
    values: NDArray[np.float64], light: NDArray[np.uint8], label: NDArray[np.uint8], levels: int
) -> NDArray[np.float64]:
    """Mean of each band at each level of light, in steps that 8 bits hold; rare levels lean on those next to them."""
    labels, bands = int(label.max()) + 1, values.shape[1]
    at = label.astype(np.int64) * levels + light
    count = np.bincount(at, minlength=labels * levels).reshape(labels, levels)
    away = np.abs(np.subtract.outer(np.arange(levels), np.arange(levels)))
    kernel = _LEAN ** away.astype(np.float64)
    curve = np.zeros((labels, bands, levels))
    for band in range(1, bands):
        total = np.bincount(at, values[:, band], labels * levels).reshape(labels, levels)
        found = (total @ kernel) / np.maximum(count @ kernel, 1e-300)
        level = (total.sum(axis=1) / np.maximum(count.sum(axis=1), 1))[:, None]
        spread = np.bincount(label, (values[:, band] - level[label, 0]) ** 2, labels)
        loose = np.bincount(label, (values[:, band] - found[label, light]) ** 2, labels)
        curve[:, band] = np.where((loose <= _MOST_LOOSE * spread)[:, None], found, level)
    step = np.abs(curve).max() / 127
    return np.round(curve / step) * step if step > 0 else curve


def _at(
    curve: NDArray[np.float64], light: NDArray[np.floating], label: NDArray[np.uint8] | None
) -> NDArray[np.float64]:
    """(..., c): curves at a light in levels, linear between the middles of levels."""
    labels, bands, levels = curve.shape
    place = np.clip(np.asarray(light, np.float64) - 0.5, 0, levels - 1)
    below = np.minimum(place.astype(np.int64), levels - 2)
    part = place - below
    first = below if label is None or labels == 1 else below + levels * label.astype(np.int64)
    result = np.zeros((*place.shape, bands))
    for band in range(1, bands):
        table = curve[:, band].ravel()
        result[..., band] = (1 - part) * table[first] + part * table[first + 1]
    return result
