"""`TextureModel`: the statistics of a texture, a few kilobytes that draw any amount of it."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import checked_whole
from surftex.errors import InputError
from surftex.exemplar.bands import Bands
from surftex.exemplar.lattice import MISSING, Lattice, Plane
from surftex.exemplar.relaxation import Relaxation
from surftex.exemplar.smoothing import within_levels
from surftex.exemplar.target import Target
from surftex.kernels.pool import Tick
from surftex.randomness import Stream, stream

PAIR_SWEEPS, QUAD_SWEEPS = 40, 80
"""How often each pixel is drawn."""

MOST_PIXELS = 2**26
"""Most pixels of a picture that is drawn at once."""


@dataclass(frozen=True, eq=False)
class TextureModel:
    """What `surftex.learn_texture` learns.

    Attributes
    ----------
    bands : Bands
        How levels become numbers.
    target : Target
        The statistics.
    """

    bands: Bands
    target: Target

    @cached_property
    def nbytes(self) -> int:
        """Bytes of the model as a ``.stex`` file."""
        from surftex.exemplar.store import packed

        return len(packed(self))

    @property
    def sweeps(self) -> int:
        """How often each pixel is drawn where the caller does not say."""
        return QUAD_SWEEPS if len(self.target.quad_band) else PAIR_SWEEPS

    def synthesize(
        self,
        width: int,
        height: int,
        seed: int = 0,
        *,
        sweeps: int | None = None,
        threads: int | None = None,
        tick: Tick | None = None,
    ) -> NDArray[np.uint8]:
        """Draw the texture. Its left continues its right, and its top its bottom: it tiles.

        Parameters
        ----------
        width : int
            Columns, at least 16.
        height : int
            Rows.
        seed : int
            Same seed, same bytes, whatever the number of threads.
        sweeps : int, optional
            How often each pixel is drawn; 40 for pairs, 80 for quads.
        threads : int, optional
            None means every core.
        tick : callable, optional
            Told the finished share; may raise to cancel.

        Returns
        -------
        picture : (height, width) or (height, width, 3) uint8
            Grey or colour, as learnt.

        Raises
        ------
        InputError
            If the size is too small or too large.
        """
        return self.maps(width, height, seed, sweeps=sweeps, threads=threads, tick=tick)["picture"]

    def maps(
        self,
        width: int,
        height: int,
        seed: int = 0,
        *,
        sweeps: int | None = None,
        threads: int | None = None,
        tick: Tick | None = None,
    ) -> dict[str, NDArray[np.uint8]]:
        """Draw the texture with the maps that were learnt beside it.

        Parameters
        ----------
        width : int
            As for `synthesize`.
        height : int
            As for `synthesize`.
        seed : int
            As for `synthesize`.
        sweeps : int, optional
            As for `synthesize`.
        threads : int, optional
            As for `synthesize`.
        tick : callable, optional
            As for `synthesize`.

        Returns
        -------
        maps : dict of str to (height, width) or (height, width, 3) uint8
            ``picture``, and any of ``height`` and ``roughness``.

        Raises
        ------
        InputError
            As for `synthesize`.
        """
        plane = checked_plane(width, height, self.target.radius)
        level = self.levels_on(plane, seed, sweeps=sweeps, threads=threads, tick=tick)
        number = within_levels(plane, level, stream(seed, "exemplar", "within"))
        return self.bands.maps_of(number.reshape(-1, height, width))

    def levels_on(
        self,
        lattice: Lattice,
        seed: int,
        *,
        sweeps: int | None = None,
        threads: int | None = None,
        tick: Tick | None = None,
    ) -> NDArray[np.uint8]:
        """Draw the texture on any lattice.

        Parameters
        ----------
        lattice : Lattice
            Knows the offsets of `surftex.exemplar.relaxation.asked_offsets`.
        seed : int
            As for `synthesize`.
        sweeps : int, optional
            As for `synthesize`.
        threads : int, optional
            As for `synthesize`.
        tick : callable, optional
            As for `synthesize`.

        Returns
        -------
        level : (c, places) uint8
            What each place of the lattice shows; `surftex.exemplar.smoothing` finds numbers within levels.
        """
        level = np.full((self.target.bands, lattice.places), MISSING, np.uint8)
        site = lattice.site
        level[:, site] = random_levels(self.target.single[0], len(site), stream(seed, "exemplar", "start"))
        lattice.repeat(level)
        drawn = Relaxation(self.target, lattice, level, stream(seed, "exemplar", "sweeps"), threads=threads)
        drawn.run(self.sweeps if sweeps is None else checked_whole(sweeps, "sweeps", 1, 1000), tick=tick)
        return level

    def save(self, path: str | Path) -> None:
        """Write the model.

        Parameters
        ----------
        path : path
            ``.stex`` for a compact file, ``.json`` for one that can be read.

        Raises
        ------
        InputError
            If the name ends otherwise.
        WorkError
            If the file cannot be written.
        """
        from surftex.exemplar.store import save_model

        save_model(self, path)


def checked_plane(width: int, height: int, radius: int) -> Plane:
    """Lay out the torus for a picture.

    Parameters
    ----------
    width : int
        Columns.
    height : int
        Rows.
    radius : int
        Longest step of an offset.

    Returns
    -------
    plane : Plane
        To draw on.

    Raises
    ------
    InputError
        If the size is too small or too large.
    """
    if min(width, height) < 16 or width * height > MOST_PIXELS:
        raise InputError(f"the size is {width} x {height}; it takes 16 x 16 to {MOST_PIXELS} pixels in all")
    return Plane.of(height, width, max(1, radius), wrap=True)


def random_levels(single: NDArray[np.floating], count: int, random: Stream) -> NDArray[np.uint8]:
    """Draw levels by their shares, one independent of the other.

    Parameters
    ----------
    single : (c, levels) float
        Shares.
    count : int
        Sites.
    random : Stream
        Of the draws.

    Returns
    -------
    level : (c, count) uint8
        The first picture of a synthesis.
    """
    total = np.cumsum(single, axis=1, dtype=np.float64)
    total /= total[:, -1:]
    numbers = random.uniform(count, len(single)).T
    return np.stack(
        [np.searchsorted(each[:-1], n, side="right") for each, n in zip(total, numbers, strict=True)]
    ).astype(np.uint8)
