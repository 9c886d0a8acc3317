"""Evening out: move each site to the middle of its region, a few times (Lloyd's relaxation on the surface)."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import read_only_view
from surftex.features.poisson import Sites
from surftex.features.uniform import area_points
from surftex.geodesics.buckets import Buckets
from surftex.geodesics.records import Records
from surftex.geodesics.tracing import trace
from surftex.geodesics.windows import flood_points, nearest
from surftex.kernels.pool import Tick, slices
from surftex.randomness import Stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_SLICE = 1 << 14

SAMPLES = 64
"""Samples per site from which the middle of its region is estimated, in the last `_CAREFUL` rounds."""

_CAREFUL = 3
_ROUGH = 16
"""Samples per site of the rounds before: what these miss, later ones mend."""


def samples_per_site(rounds: int) -> int:
    """Count the samples that all rounds take, for each site.

    Parameters
    ----------
    rounds : int
        Of `relaxed`.

    Returns
    -------
    count : int
        What their time is proportional to.
    """
    return sum(_samples(turn, rounds) for turn in range(rounds))


def _samples(turn: int, rounds: int) -> int:
    return SAMPLES if turn >= rounds - _CAREFUL else _ROUGH


Length = Callable[[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]], NDArray[np.float64]]


def relaxed(
    surface: Surface,
    sites: Sites,
    stream: Stream,
    *,
    rounds: int,
    length: Length | None = None,
    reach: float = 1.6,
    threads: int | None = None,
    tick: Tick | None = None,
) -> Sites:
    """Move each site to the middle of the samples that are nearest to it.

    Parameters
    ----------
    surface : Surface
        Where the sites lie.
    sites : Sites
        c sites.
    stream : Stream
        Of the samples.
    rounds : int
        How often; the cells of a plane become hexagons after many.
    length : callable, optional
        ``length(vector (n, 2), site (n,), angle_rad (c,)) -> (n,)``: measures tangent vectors at sites
        instead of their walking distance.
    reach : float
        How far regions may reach, in major semi-axes: between full sites, by any length, no further than the diagonal
        of a square of 1.
    threads : int, optional
        None means every core; cannot change the result.
    tick : callable, optional
        Told the finished share; may raise to cancel.

    Returns
    -------
    sites : Sites
        The same number, in the same order, with their axes carried along.

    References
    ----------
    .. [1] Lloyd. Least squares quantization in PCM. IEEE Trans. Information Theory 28 (1982).
    """
    points, angle = sites.points, sites.angle_rad
    count = len(sites)
    drawn = 0
    for turn in range(rounds if count else 0):
        told = None if tick is None else lambda share, turn=turn: tick((turn + share) / rounds)
        number = _samples(turn, rounds) * count
        samples = area_points(surface, stream.uniform(number, 3, first=drawn))
        drawn += number
        buckets = Buckets.of(surface, float(np.median(sites.axis_mm)))
        records = flood_points(
            surface, points, reach * sites.axis_mm[:, 0], buckets=buckets, threads=threads,
            tick=None if told is None else lambda share, told=told: told(0.5 * share),
        )  # fmt: skip
        site, move = _owners(
            records, samples, length, angle, threads,
            None if told is None else lambda share, told=told: told(0.5 + 0.5 * share),
        )  # fmt: skip
        del records, samples
        owned = site >= 0
        site, move = site[owned], move[owned]
        members = np.maximum(np.bincount(site, minlength=count), 1)
        mean = np.stack([np.bincount(site, move[:, k], minlength=count) / members for k in (0, 1)], axis=1)
        heading = np.arctan2(mean[:, 1], mean[:, 0])
        walked = trace(surface, points, heading, np.hypot(*mean.T), threads=threads)
        points, angle = walked.end, angle + walked.angle_rad - heading
    return Sites(points, sites.axis_mm, angle)


def _owners(
    records: Records,
    samples: SurfacePoints,
    length: Length | None,
    angle: NDArray[np.float64],
    threads: int | None,
    tick: Tick | None,
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Find whose each sample is, -1 for nobody's, and the tangent vector at the site that leads to it.

    Samples are asked face by face, in slices: those of a face find the same rows, and few wait at a time.
    """
    from surftex.kernels.ordering import order_by_face

    count = len(samples)
    owner, move, order = np.full(count, -1, np.int32), np.zeros((count, 2)), np.zeros(count, np.int32)
    place = np.zeros(len(records.surface.faces) + 1, np.int64)
    order_by_face(read_only_view(samples.face, np.int32), place, order)

    def work(first: int, last: int) -> None:
        chosen = order[first:last]
        near, _, vector = nearest(
            records, samples.taken(chosen), 1 if length is None else 6, vectors=True, threads=1
        )
        rows, best = np.arange(len(near)), np.zeros(len(near), np.int64)
        if length is not None:
            measured = length(vector.reshape(-1, 2), np.maximum(near, 0).ravel(), angle).reshape(near.shape)
            best = np.argmin(np.where(near >= 0, measured, np.inf), axis=1)
        owner[chosen], move[chosen] = near[rows, best], vector[rows, best]

    slices(work, count, size=_SLICE, threads=threads, tick=tick)
    return owner, move
