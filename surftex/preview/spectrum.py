"""What a height map is made of: its statistics, its two-sided power spectrum, and the ring that cells leave in it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import checked
from surftex.errors import InputError

_SECTORS, _RINGS = 48, 64
_REACH = 2.2
"""The ring is looked for between 1 / 2.2 and 2.2 of its mean radius."""

_ROUNDS = 8
_FAR_OFF = 0.15
"""Share of the radius from which on a direction is trusted less."""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Two-sided power spectral density of a height.

    Attributes
    ----------
    density : (h, w) float64
        mm^4 (mm^2 of height per (cycle/mm)^2); frequency 0 in the middle, rows upward.
    across : (w,) float64
        Cycles per mm along the columns.
    along : (h,) float64
        Cycles per mm upward.
    """

    density: NDArray[np.float64]
    across: NDArray[np.float64]
    along: NDArray[np.float64]

    @property
    def decibels(self) -> NDArray[np.float64]:
        """(h, w) ten times the logarithm of the density over its largest value."""
        top = max(float(self.density.max()), np.finfo(float).tiny)
        return 10 * np.log10(np.maximum(self.density / top, 1e-30))


@dataclass(frozen=True)
class Ring:
    """An ellipse through the ring of a spectrum.

    Attributes
    ----------
    radius : float
        Geometric mean of the semi-axes, cycles per mm; 0 where there is no ring.
    ratio : float
        Long over short semi-axis, at least 1.
    angle_deg : float
        Of the long axis, from the columns upward, -90 to 90.
    spacing_mm : float
        1 / radius: the mean distance of the rows of cells; infinite without a ring.
    """

    radius: float
    ratio: float
    angle_deg: float
    spacing_mm: float


def height_spectrum(height_mm: NDArray[np.floating], mm_per_texel: float = 1.0) -> Spectrum:
    """Estimate the power spectral density of a flat height map.

    Parameters
    ----------
    height_mm : (h, w) float
        Row 0 on top; its mean plane is taken off, and a Hann window laid over it.
    mm_per_texel : float
        Size of a texel.

    Returns
    -------
    spectrum : Spectrum
        Its integral over all frequencies is the variance of the height.

    Raises
    ------
    InputError
        If the map is smaller than 8 x 8, or the size is none.
    """
    height = checked(height_mm, "height", (None, None), np.float64)
    if min(height.shape) < 8:
        raise InputError(
            f"height is {height.shape[1]} x {height.shape[0]} texels; a spectrum takes at least 8 x 8"
        )
    if not 0 < mm_per_texel < np.inf:
        raise InputError(f"mm_per_texel is {mm_per_texel}; it takes a length above 0")
    rows, columns = height.shape
    y, x = np.mgrid[-1 : 1 : rows * 1j, -1 : 1 : columns * 1j]
    flat = height - height.mean()
    flat = flat - x * (flat * x).sum() / (x * x).sum() - y * (flat * y).sum() / (y * y).sum()
    window = np.outer(np.hanning(rows + 2)[1:-1], np.hanning(columns + 2)[1:-1])
    power = np.abs(np.fft.fftshift(np.fft.fft2(flat[::-1] * window))) ** 2
    density = power * mm_per_texel**2 / (window**2).sum()
    return Spectrum(
        density,
        np.fft.fftshift(np.fft.fftfreq(columns, mm_per_texel)).astype(np.float64),
        np.fft.fftshift(np.fft.fftfreq(rows, mm_per_texel)).astype(np.float64),
    )


def fitted_ring(spectrum: Spectrum) -> Ring:
    """Fit an ellipse to the ring of a spectrum.

    In each direction the ring is where the power, smoothed, is largest; the ellipse goes through these places by least squares,
    weighted by the power there, and again without those that lie far off.

    Parameters
    ----------
    spectrum : Spectrum
        Of a height.

    Returns
    -------
    ring : Ring
        With radius 0 where the spectrum is empty.
    """
    fx, fy = np.meshgrid(spectrum.across, spectrum.along)
    places = np.stack([fx.ravel(), fy.ravel()], axis=1)
    power = spectrum.density.ravel()
    radius = np.hypot(*places.T)
    step = max(spectrum.across[1] - spectrum.across[0], spectrum.along[1] - spectrum.along[0])
    limit = min(spectrum.across[-1], spectrum.along[-1])
    bins = np.minimum((radius / step).astype(int), int(limit / step) + 1)
    count = np.maximum(np.bincount(bins), 1)
    ring_power = np.bincount(bins, power) / count * (np.arange(len(count)) + 0.5)
    smooth = np.convolve(ring_power, [0.25, 0.5, 0.25], "same")[:-1]
    smooth[:2] = 0
    if len(smooth) < 4 or not smooth.max() > 0:
        return Ring(0.0, 1.0, 0.0, float("inf"))
    start = (int(np.argmax(smooth)) + 0.5) * step
    turn, crest, weight = _crests(places, power, start)
    basis = np.stack([np.cos(turn) ** 2, 2 * np.cos(turn) * np.sin(turn), np.sin(turn) ** 2], axis=1)
    target = crest**-2.0
    form = np.array([1.0, 0.0, 1.0]) / start**2
    for _ in range(_ROUNDS):
        fitted = basis @ form
        off = np.abs(np.log(np.maximum(fitted, 1e-30) / target)) / 2
        trust = weight / (1 + (off / _FAR_OFF) ** 4) / target
        form = np.linalg.lstsq(basis * trust[:, None], target * trust, rcond=None)[0]
    value, vector = np.linalg.eigh(np.array([[form[0], form[1]], [form[1], form[2]]]))
    if not value[0] > 0:
        return Ring(start, 1.0, 0.0, 1 / start)
    long, short = value[0] ** -0.5, value[1] ** -0.5
    angle = float(np.degrees(np.arctan2(vector[1, 0], vector[0, 0])))
    middle = float(np.sqrt(long * short))
    return Ring(middle, float(long / short), (angle + 90) % 180 - 90, 1 / middle)


def _crests(
    places: NDArray[np.float64], power: NDArray[np.float64], start: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Directions, where the power is largest in each, and how large: the mean radius of its upper part."""
    radius = np.hypot(*places.T)
    band = (radius > start / _REACH) & (radius < start * _REACH)
    sector = ((np.arctan2(places[band, 1], places[band, 0]) % np.pi) / np.pi * _SECTORS).astype(
        int
    ) % _SECTORS
    ring = (
        (np.log(radius[band] * _REACH / start) / (2 * np.log(_REACH)) * _RINGS)
        .astype(int)
        .clip(0, _RINGS - 1)
    )
    cell = sector * _RINGS + ring
    count = np.bincount(cell, minlength=_SECTORS * _RINGS)
    total = np.bincount(cell, power[band], _SECTORS * _RINGS)
    mean = (total / np.maximum(count, 1)).reshape(_SECTORS, _RINGS)
    known = (count > 0).reshape(mean.shape).astype(float)
    kernel = np.exp(-0.5 * (np.arange(-4, 5) / 1.5) ** 2)
    for axis, wrapped in ((0, True), (1, False)):
        pad = [(4, 4) if axis == k else (0, 0) for k in (0, 1)]
        mode = {"mode": "wrap"} if wrapped else {"mode": "constant"}
        parts = [np.pad(each, pad, **mode) for each in (mean * known, known)]  # type: ignore[call-overload]
        blurred = [
            np.apply_along_axis(lambda line: np.convolve(line, kernel, "valid"), axis, each) for each in parts
        ]
        mean, known = blurred[0] / np.maximum(blurred[1], 1e-30), (blurred[1] > 1e-6).astype(float)
    top = mean.max(axis=1, keepdims=True)
    high = np.maximum(mean - 0.7 * top, 0) * known
    rings = start / _REACH * _REACH ** (2 * (np.arange(_RINGS) + 0.5) / _RINGS)
    crest = np.exp((high * np.log(rings)).sum(axis=1) / np.maximum(high.sum(axis=1), 1e-300))
    turn = (np.arange(_SECTORS) + 0.5) * np.pi / _SECTORS
    return turn, crest, top[:, 0] / max(float(top.max()), 1e-300)


def statistics(height_mm: NDArray[np.floating]) -> dict[str, float]:
    """Count how high a height is.

    Parameters
    ----------
    height_mm : (...) float
        Millimetres.

    Returns
    -------
    statistics : dict of str to float
        ``mean``, ``rms`` (about the mean), ``skew``, ``least``, ``p01``, ``p05``, ``p25``, ``median``, ``p75``,
        ``p95``, ``p99``, ``most``: millimetres, but for the skew.
    """
    height = np.asarray(height_mm, np.float64).ravel()
    away = height - height.mean()
    rms = float(np.sqrt((away**2).mean()))
    names = ("least", "p01", "p05", "p25", "median", "p75", "p95", "p99", "most")
    values = np.percentile(height, (0, 1, 5, 25, 50, 75, 95, 99, 100))
    # A rounding error above nothing has no shape.
    skew = float((away**3).mean() / rms**3) if rms > 1e-12 * max(1.0, float(np.abs(height).max())) else 0.0
    return {"mean": float(height.mean()), "rms": rms, "skew": skew} | dict(
        zip(names, map(float, values), strict=True)
    )
