"""Smooth noise anchored on the surface's place in space: the same at every resolution and under every unwrap.

One octave is gradient noise of one wavelength; several halve the wavelength each time. An octave that the
sample's footprint cannot show has faded out, so 512 and 8192 texels agree where both can see. The lattice is
turned and shifted at random for each octave, so that no axis shows.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen, read_only_view
from surftex.errors import RecipeError
from surftex.randomness import Stream, stream

_CELLS_PER_WAVELENGTH = 1.86
"""Lattice cells in one wavelength, the reciprocal of the mean frequency of plane sections."""

_UNIT_RMS = 1.6
"""Makes the values fill about -1 to 1 (rms 0.31)."""


@dataclass(frozen=True)
class Noise:
    """Noise in space, band-limited by the samples' footprints.

    Attributes
    ----------
    stream : Stream
        What makes it different from other noise.
    wavelength_mm : float
        Mean distance from crest to crest of the coarsest octave.
    octaves : int
        1 to 12; each has half the wavelength of the one before.
    gain : float
        Amplitude of each octave, as a share of the one before.
    """

    stream: Stream
    wavelength_mm: float
    octaves: int = 1
    gain: float = 0.5

    def __post_init__(self) -> None:
        if not 0 < self.wavelength_mm < np.inf:
            raise RecipeError(f"noise wavelength is {self.wavelength_mm} mm; it takes a length above 0")
        if not 1 <= self.octaves <= 12:
            raise RecipeError(f"noise has {self.octaves} octaves; it takes 1 to 12")
        if not 0 < self.gain <= 1:
            raise RecipeError(f"noise gain is {self.gain}; it takes a number above 0, up to 1")

    def at(
        self, positions: NDArray[np.float64], footprint_mm: NDArray[np.floating] | float = 0.0
    ) -> NDArray[np.float32]:
        """Evaluate at places in space.

        Parameters
        ----------
        positions : (n, 3) float64
            Millimetres, within 10^9 wavelengths of the origin.
        footprint_mm : (n,) float or float
            Side of the patch that each value stands for; octaves finer than twice of it are left out.

        Returns
        -------
        values : (n,) float32
            About -1 to 1, with mean 0 and rms 0.31 whatever the number of octaves.
        """
        return several([self], positions, footprint_mm)[0]

    def _octaves(self) -> tuple[NDArray, NDArray, NDArray, NDArray, NDArray]:
        """Key, turned frame, offset, weight and wavelength of each octave."""
        return _octaves(self.stream.key, self.wavelength_mm, self.octaves, self.gain)


def several(
    noises: Sequence[Noise],
    positions: NDArray[np.float64],
    footprint_mm: NDArray[np.floating] | float = 0.0,
) -> NDArray[np.float32]:
    """Evaluate several noises at the same places: quicker than one after the other.

    Parameters
    ----------
    noises : sequence of Noise
        At least one.
    positions : (n, 3) float64
        As for `Noise.at`.
    footprint_mm : (n,) float or float
        As for `Noise.at`.

    Returns
    -------
    values : (c, n) float32
        One row for each noise: what its `Noise.at` gives.
    """
    from surftex.kernels.noise import LANES, NEAR_ROWS, gradient_noise

    places = read_only_view(positions, np.float64)
    footprint = read_only_view(np.broadcast_to(np.asarray(footprint_mm), len(places)), np.float64)
    values, near = np.zeros((len(noises), len(places)), np.float32), np.zeros(NEAR_ROWS * LANES, np.float32)
    for *octaves, block in _blocks(tuple(noises)):
        gradient_noise(places, footprint, *octaves, block.copy(), near, values)
    return values


@lru_cache(maxsize=256)
def _blocks(noises: tuple[Noise, ...]) -> tuple[tuple[NDArray, ...], ...]:
    """Octaves of some noises as the kernel takes them, so many at a time; what is left of a block has no weight."""
    from surftex.kernels.noise import LANES, ROWS

    octaves = [noise._octaves() for noise in noises]
    key, frame, offset, weight, wavelength = (np.concatenate(part) for part in zip(*octaves, strict=True))
    noise = np.repeat(np.arange(len(noises)), [len(own[0]) for own in octaves])
    blocks = []
    for first in range(0, len(key), LANES):
        part = slice(first, first + LANES)
        count = len(key[part])
        table = np.zeros((ROWS, LANES))
        table[:9, :count] = frame[part].reshape(count, 9).T
        table[9:12, :count] = offset[part].T
        keys, weights, wavelengths = np.zeros(LANES, np.uint64), np.zeros(LANES), np.ones(LANES)
        whose = np.full(LANES, noise[part][-1])
        keys[:count], weights[:count], wavelengths[:count] = key[part], weight[part], wavelength[part]
        whose[:count] = noise[part]
        last = np.append(np.diff(whose) != 0, True)
        blocks.append(tuple(map(frozen, (keys, weights, wavelengths, whose, last, table.ravel().copy()))))
    return tuple(blocks)


@lru_cache(maxsize=256)
def _octaves(
    key: int, wavelength_mm: float, octaves: int, gain: float
) -> tuple[NDArray, NDArray, NDArray, NDArray, NDArray]:
    """Draw the octaves of a noise; a bake asks for the same few, slice by slice."""
    keys, frames, offsets = [], [], []
    wavelength = wavelength_mm * 0.5 ** np.arange(octaves)
    for octave in range(octaves):
        own = stream(key, "octave", octave)
        numbers = own.uniform(1, 7)[0]
        keys.append(own.key)
        frames.append(_rotation(numbers[:3]) * (_CELLS_PER_WAVELENGTH / wavelength[octave]))
        offsets.append(numbers[3:6] * 256)
    weight = gain ** np.arange(octaves)
    weight *= _UNIT_RMS / np.sqrt((weight**2).sum())
    drawn = np.array(keys, np.uint64), np.array(frames), np.array(offsets), weight, wavelength
    for array in drawn:
        array.flags.writeable = False
    return drawn


def _rotation(numbers: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turn by a quaternion, uniform over all turns for three uniform numbers (Shoemake 1992)."""
    a, b, c = numbers
    x, y = np.sqrt(1 - a) * np.array([np.sin(2 * np.pi * b), np.cos(2 * np.pi * b)])
    z, w = np.sqrt(a) * np.array([np.sin(2 * np.pi * c), np.cos(2 * np.pi * c)])
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
