"""Numbers between levels: evened out among neighbours, without leaving the level that was drawn."""

import numpy as np
from numpy.typing import NDArray

from surftex.exemplar.lattice import MISSING, Lattice
from surftex.randomness import Stream

NEXT = np.array([(1, 0), (-1, 0), (0, 1), (0, -1)], np.int32)
"""Steps to the four neighbours, right and down."""

_EDGE = 0.1
"""Numbers keep this far from a level's ends, so that rounding to 8 bits cannot move them into the next level."""


def within_levels(
    lattice: Lattice,
    level: NDArray[np.uint8],
    random: Stream,
    group: NDArray[np.uint8] | None = None,
) -> NDArray[np.float32]:
    """Choose a number within each level: anywhere, then half way to the mean of the four neighbours.

    Parameters
    ----------
    lattice : Lattice
        Where the levels are.
    level : (c, places) uint8
        With copies up to date.
    random : Stream
        Of the first numbers.
    group : (places,) uint8, optional
        Labels; only neighbours of one label even each other out.

    Returns
    -------
    number : (c, n) float32
        From `level` to `level` + 1, at the sites.
    """
    site = lattice.site
    part = np.zeros((1, lattice.places), np.float32)
    part[0, site] = random.uniform(len(site))[:, 0]
    lattice.repeat(part)
    reach, column = lattice.reach(NEXT)
    around = reach[site][:, column] if lattice.follow else site[:, None] + reach[:, column]
    alike = np.ones(around.shape, bool) if group is None else group[around] == group[site][:, None]
    numbers = np.zeros((len(level), len(site)), np.float32)
    for band, levels in enumerate(level):
        low = levels[site].astype(np.float32)
        own = low + part[0, site]
        near = np.where(alike & (levels[around] != MISSING), levels[around] + part[0, around], own[:, None])
        mean = np.float32(0.5) * own + np.float32(0.125) * near.sum(axis=1, dtype=np.float32)
        numbers[band] = np.clip(mean, low + np.float32(_EDGE), low + np.float32(1 - _EDGE))
    return numbers
