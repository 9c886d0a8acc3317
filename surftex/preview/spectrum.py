"""What a height map is made of: its statistics, its two-sided power spectrum, and the ring that cells leave in it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import checked
from surftex.errors import InputError


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
        return 10 * np.log10(np.maximum(self.density, 1e-30 * top) / top)


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

    The radius of the strongest ring starts it; then the second moments of the power in an elliptical band around
    it, above the level of the band's edges, give the axes, again and again until they stand still.

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
    shape = np.eye(2) * start**2
    for _ in range(60):
        reach = np.sqrt(np.einsum("ni,ij,nj->n", places, np.linalg.inv(shape), places))
        band = (reach > 0.5) & (reach < 1.6)
        edge = ((reach > 0.4) & (reach <= 0.55)) | ((reach >= 1.5) & (reach < 1.7))
        floor = float(np.median(power[edge])) if edge.any() else 0.0
        weight = np.maximum(power[band] - floor, 0)
        if not weight.sum() > 0:
            break
        # Within a whitened band all directions weigh alike, however the power is spread around the ring.
        inner = places[band] / reach[band, None]
        amount = (weight * reach[band]).sum() / weight.sum()
        moment = np.einsum("n,ni,nj->ij", weight * reach[band] ** 2, inner, inner) / weight.sum() * 2
        scale = np.sqrt(np.linalg.det(shape) / max(np.linalg.det(moment), 1e-300))
        update = moment * scale * amount**2
        if np.abs(update - shape).max() < 1e-9 * np.abs(shape).max():
            break
        shape = update
    value, vector = np.linalg.eigh(shape)
    long, short = np.sqrt(value[1]), np.sqrt(value[0])
    angle = float(np.degrees(np.arctan2(vector[1, 1], vector[0, 1])))
    middle = float(np.sqrt(long * short))
    return Ring(middle, float(long / short), (angle + 90) % 180 - 90, 1 / middle)


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
