"""`Bands`: how the numbers of a picture become levels, and levels become numbers again.

Red, green and blue go through a rotation to their principal axes, learnt from the picture and kept with the
model: the first band then carries most of the structure, and the others little but tint.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError

_TAIL_PERCENT = 0.5
_LEAST_SPAN = 2.0
"""Narrowest range of a band, in steps of an 8-bit picture."""

_LEAST_TINT = 0.1


@dataclass(frozen=True, eq=False)
class Bands:
    """Ranges of bands.

    Attributes
    ----------
    names : tuple of str
        ``("grey",)`` or ``("red", "green", "blue")``, then any of ``"height"``, ``"roughness"``.
    low, high : (c,) float64
        Range of each band, after the rotation; 0 to 255 for plain ones.
    axes : (3, 3) float64
        Rotation from red, green, blue to the first three bands; unused without colour.
    levels : int
        Of each band.
    """

    names: tuple[str, ...]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    axes: NDArray[np.float64]
    levels: int

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
        picture: NDArray[np.floating], names: tuple[str, ...], mask: NDArray[np.bool_], levels: int
    ) -> "Bands":
        """Find ranges and axes.

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
        middle, half = 0.5 * (low + high), 0.5 * np.maximum(high - low, _LEAST_SPAN)
        return Bands(names, middle - half, middle + half, axes, levels)

    def levels_of(self, picture: NDArray[np.floating]) -> NDArray[np.uint8]:
        """Turn numbers into levels.

        Parameters
        ----------
        picture : (h, w, c) float
            0 to 255.

        Returns
        -------
        level : (c, h, w) uint8
            0 to `levels` - 1.
        """
        values = _rotated(picture.astype(np.float64), self.names, self.axes)
        share = (values - self.low) / (self.high - self.low)
        level = np.clip(share * self.levels, 0, self.levels - 1).astype(np.uint8)
        return np.ascontiguousarray(np.moveaxis(level, -1, 0))

    def numbers_of(self, number: NDArray[np.floating]) -> NDArray[np.float64]:
        """Turn levels into numbers.

        Parameters
        ----------
        number : (c, ...) float
            Levels, and how far into them: 0 to `levels`.

        Returns
        -------
        picture : (..., c) float64
            0 to 255, not yet rounded or clipped.
        """
        share = np.moveaxis(np.asarray(number, np.float64) / self.levels, 0, -1)
        values = share * (self.high - self.low) + self.low
        if self.colored:
            values = np.concatenate([values[..., :3] @ self.axes.T, values[..., 3:]], axis=-1)
        return values

    def maps_of(self, number: NDArray[np.floating]) -> dict[str, NDArray[np.uint8]]:
        """Turn levels into pictures of 8 bits.

        Parameters
        ----------
        number : (c, h, w) float
            As for `numbers_of`.

        Returns
        -------
        maps : dict of str to (h, w) or (h, w, 3) uint8
            ``picture``, and what was learnt beside it.
        """
        values = np.clip(np.rint(self.numbers_of(number)), 0, 255).astype(np.uint8)
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
