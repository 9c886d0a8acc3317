"""Erosion: what is worn grows step by step into what is sound, over the four neighbours of a site."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.errors import InputError
from surftex.exemplar.lattice import Lattice, Plane
from surftex.exemplar.smoothing import NEXT

MOST_STEPS = 1000
"""Steps that are ever counted."""


def erosion_series(
    mask: ArrayLike, *, shrink: int = 1, grow: int = 3, wrap: bool = True
) -> list[NDArray[np.bool_]]:
    """Age a mask of what is worn: smaller ones before it, larger ones after it.

    Parameters
    ----------
    mask : (h, w) bool
        What is worn now.
    shrink : int
        Steps back, at least 0.
    grow : int
        Steps on, at least 0.
    wrap : bool
        Whether the mask tiles.

    Returns
    -------
    series : list of (h, w) bool
        ``shrink + grow + 1`` masks, each within the next; the mask itself is ``series[shrink]``.

    Raises
    ------
    InputError
        If the mask is none, or the steps are out of range.

    Examples
    --------
    >>> [int(each.sum()) for each in erosion_series(np.eye(5, k=0) == 1, shrink=0, grow=1, wrap=False)]
    [5, 13]
    """
    worn = np.asarray(mask)
    if worn.ndim != 2 or worn.size == 0:
        raise InputError(f"the mask has shape {worn.shape}; it takes (height, width)")
    check_steps(shrink, grow)
    plane = Plane.of(worn.shape[0], worn.shape[1], 1, wrap=wrap)
    place = np.zeros(plane.places, bool)
    place[plane.site] = worn.ravel() > 0
    age = worn_after(plane, place, back=shrink, on=grow)
    return [(age <= step).reshape(worn.shape) for step in range(-shrink, grow + 1)]


def check_steps(shrink: int, grow: int) -> None:
    """Check the steps of a series.

    Parameters
    ----------
    shrink : int
        Steps back.
    grow : int
        Steps on.

    Raises
    ------
    InputError
        If one of them is below 0 or above `MOST_STEPS`.
    """
    if not (0 <= shrink <= MOST_STEPS and 0 <= grow <= MOST_STEPS):
        raise InputError(f"shrink and grow are {shrink} and {grow}; they take 0 to {MOST_STEPS} steps")


def worn_after(lattice: Lattice, mask: NDArray[np.bool_], *, back: int, on: int) -> NDArray[np.int32]:
    """Tell at which age each site is worn: 0 at the rim of what is worn now, less inside, more outside.

    Parameters
    ----------
    lattice : Lattice
        Knows the four next neighbours.
    mask : (places,) bool
        What is worn at age 0.
    back : int
        Steps that are counted inside.
    on : int
        Steps that are counted outside.

    Returns
    -------
    age : (n,) int32
        From ``-back`` to ``on + 1`` at the sites: a site is worn where its age is at most that of the surface.
    """
    site = lattice.site
    reach, column = lattice.reach(NEXT)
    around = reach[site][:, column] if lattice.follow else site[:, None] + reach[:, column]
    real = np.zeros((1, lattice.places), bool)
    real[0, site] = True
    lattice.repeat(real)
    beside = real[0][around]
    age = np.where(mask[site], 0, on + 1).astype(np.int32)
    for inside, steps in ((False, on), (True, back)):
        now = np.zeros((1, lattice.places), bool)
        now[0, site] = mask[site] != inside
        for step in range(1, steps + 1):
            lattice.repeat(now)
            met = (now[0][around] & beside).any(axis=1) & ~now[0, site]
            if not met.any():
                break
            age[met] = -step + 1 if inside else step
            now[0, site] |= met
        if inside:
            age[~now[0, site]] = -steps
    return age
