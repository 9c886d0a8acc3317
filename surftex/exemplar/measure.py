"""Statistics of what is on a lattice: shares of differences, of fours, of levels; distances between them."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.exemplar.lattice import Lattice
from surftex.exemplar.target import Target
from surftex.kernels.pool import slices

_SITES, _TYPES = 1 << 15, 48


def pair_shares(
    lattice: Lattice,
    level: NDArray[np.uint8],
    pair_type: NDArray[np.integer],
    *,
    code: tuple[int, int] = (-1, 31),
    group: NDArray[np.uint8] | None = None,
    groups: int = 1,
    site: NDArray[np.int32] | None = None,
    threads: int | None = None,
) -> NDArray[np.float32]:
    """Measure pairs.

    Parameters
    ----------
    lattice : Lattice
        Where the levels are.
    level : (c, places) uint8
        With copies up to date.
    pair_type : (k, 4) int
        As in `Target`.
    code : (int, int)
        As `Target.code`.
    group : (places,) uint8, optional
        Label of each place.
    groups : int
        How many there are.
    site : (n,) int32, optional
        Heads to count; all sites without it.
    threads : int, optional
        None means every core; cannot change the result.

    Returns
    -------
    share : (groups + 1, k, 64) float32
        Sums of 1, or of 0 where there is no such pair.
    """
    from surftex.kernels.cliques import count_pairs

    site = lattice.site if site is None else site
    group = np.zeros(lattice.places, np.uint8) if group is None else group
    parts = [np.zeros((groups + 1, 0, 64), np.int64)]
    for first in range(0, len(pair_type), _TYPES):
        some = np.asarray(pair_type[first : first + _TYPES], np.int32)
        reach, column = lattice.reach(some[:, 2:])
        kind = np.ascontiguousarray(np.column_stack([some[:, :2], column]), np.int32)

        def counted(begin: int, end: int, kind: Any = kind, reach: Any = reach) -> NDArray[np.int64]:
            count = np.zeros((groups + 1, len(kind), 64), np.int64)
            count_pairs(begin, end, level, group, groups, site, reach, lattice.follow, kind, *code, count)
            return count

        parts.append(_summed(counted, len(site), threads))
    return _shares(np.concatenate(parts, axis=1))


def quad_shares(
    lattice: Lattice,
    level: NDArray[np.uint8],
    band: NDArray[np.int32],
    shape: NDArray[np.int32],
    quarter: NDArray[np.uint8],
    *,
    group: NDArray[np.uint8] | None = None,
    site: NDArray[np.int32] | None = None,
    threads: int | None = None,
) -> NDArray[np.float32]:
    """Measure quads.

    Parameters
    ----------
    lattice : Lattice
        Where the levels are.
    level : (c, places) uint8
        With copies up to date.
    band : (j,) int32
        Of each quad.
    shape : (j, 4, 2) int32
        Its corners.
    quarter : (groups, c, 256) uint8
        Classes of levels.
    group : (places,) uint8, optional
        Label of each place.
    site : (n,) int32, optional
        First corners to count; all sites without it.
    threads : int, optional
        None means every core; cannot change the result.

    Returns
    -------
    share : (groups, j, 256) float32
        Sums of 1, or of 0 where there is no such quad.
    """
    from surftex.kernels.cliques import count_quads

    groups = len(quarter)
    if len(band) == 0:
        return np.zeros((groups, 0, 256), np.float32)
    site = lattice.site if site is None else site
    group = np.zeros(lattice.places, np.uint8) if group is None else group
    offset, corner = np.unique(shape.reshape(-1, 2), axis=0, return_inverse=True)
    reach, column = lattice.reach(offset)
    corner = np.ascontiguousarray(column[corner.reshape(-1, 4)], np.int32)

    def counted(begin: int, end: int) -> NDArray[np.int64]:
        count = np.zeros((groups, len(band), 256), np.int64)
        count_quads(
            begin, end, level, group, groups, site, reach, lattice.follow, band, corner, quarter, count
        )
        return count

    return _shares(_summed(counted, len(site), threads))


def level_shares(
    lattice: Lattice,
    level: NDArray[np.uint8],
    levels: int,
    *,
    group: NDArray[np.uint8] | None = None,
    groups: int = 1,
    site: NDArray[np.int32] | None = None,
) -> NDArray[np.float32]:
    """Measure levels.

    Parameters
    ----------
    lattice : Lattice
        Where they are.
    level : (c, places) uint8
        Levels below `levels`.
    levels : int
        How many there can be.
    group : (places,) uint8, optional
        Label of each place.
    groups : int
        How many there are.
    site : (n,) int32, optional
        Sites to count; all without it.

    Returns
    -------
    share : (groups, c, levels) float32
        Sums of 1, or of 0 where a group has no site.
    """
    from surftex.kernels.cliques import count_levels

    site = lattice.site if site is None else site
    group = np.zeros(lattice.places, np.uint8) if group is None else group
    count = np.zeros((groups, len(level), 256), np.int64)
    count_levels(0, len(site), level, group, site, count)
    return _shares(count[:, :, :levels])


def measured(
    target: Target,
    lattice: Lattice,
    level: NDArray[np.uint8],
    group: NDArray[np.uint8] | None = None,
    *,
    site: NDArray[np.int32] | None = None,
    threads: int | None = None,
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Measure all that a target speaks of.

    Parameters
    ----------
    target : Target
        What to measure.
    lattice : Lattice
        Where the levels are.
    level : (c, places) uint8
        With copies up to date.
    group : (places,) uint8, optional
        Label of each place.
    site : (n,) int32, optional
        Sites to count; all without it.
    threads : int, optional
        None means every core; cannot change the result.

    Returns
    -------
    single, pair, quad : float32 arrays
        Of the shapes that the target's own have.
    """
    groups = target.groups
    single = level_shares(lattice, level, target.levels, group=group, groups=groups, site=site)
    pair = pair_shares(
        lattice, level, target.pair_type, code=target.code, group=group, groups=groups, site=site, threads=threads
    )  # fmt: skip
    quad = quad_shares(
        lattice, level, target.quad_band, target.quad_shape, target.quarter, group=group, site=site, threads=threads
    )  # fmt: skip
    return single, pair, quad


def distance(share: NDArray[np.floating], other: NDArray[np.floating]) -> NDArray[np.float64]:
    """Tell how far apart histograms are.

    Parameters
    ----------
    share : (..., bins) float
        Histograms.
    other : (..., bins) float
        Others.

    Returns
    -------
    distance : (...) float64
        Euclidean.
    """
    return np.sqrt(((share.astype(np.float64) - other) ** 2).sum(axis=-1))


def _summed(
    counted: Callable[[int, int], NDArray[np.int64]], count: int, threads: int | None
) -> NDArray[np.int64]:
    parts = slices(counted, count, size=_SITES, threads=threads)
    return np.sum(parts, axis=0) if parts else counted(0, 0)


def _shares(count: NDArray[np.int64]) -> NDArray[np.float32]:
    return (count / np.maximum(count.sum(axis=-1, keepdims=True), 1)).astype(np.float32)
