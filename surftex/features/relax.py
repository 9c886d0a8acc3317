"""Evening out: move each site to the middle of its region, a few times (Lloyd's relaxation on the surface)."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from surftex.features.poisson import Sites
from surftex.features.uniform import area_points
from surftex.geodesics.tracing import trace
from surftex.geodesics.windows import Buckets, flood_points, nearest
from surftex.randomness import Stream
from surftex.surface.surface import Surface

SAMPLES = 64
"""Samples per site from which the middle of its region is estimated."""

Length = Callable[[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]], NDArray[np.float64]]


def relaxed(
    surface: Surface,
    sites: Sites,
    stream: Stream,
    *,
    rounds: int,
    length: Length | None = None,
    reach: float = 2.0,
    threads: int | None = None,
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
        How far regions may reach, in major semi-axes.
    threads : int, optional
        None means every core; cannot change the result.

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
    for turn in range(rounds if count else 0):
        samples = area_points(surface, stream.uniform(SAMPLES * count, 3, first=turn * SAMPLES * count))
        buckets = Buckets.of(surface, float(np.median(sites.axis_mm)))
        records = flood_points(surface, points, reach * sites.axis_mm[:, 0], buckets=buckets, threads=threads)
        near, _, vector = nearest(records, samples, 1 if length is None else 6, vectors=True, threads=threads)
        if length is not None:
            measured = length(vector.reshape(-1, 2), np.maximum(near, 0).ravel(), angle).reshape(near.shape)
            best = np.argmin(np.where(near >= 0, measured, np.inf), axis=1)
            rows = np.arange(len(near))
            near, vector = near[rows, best][:, None], vector[rows, best][:, None]
        owned = near[:, 0] >= 0
        site, move = near[owned, 0], vector[owned, 0]
        members = np.maximum(np.bincount(site, minlength=count), 1)
        mean = np.stack([np.bincount(site, move[:, k], minlength=count) / members for k in (0, 1)], axis=1)
        heading = np.arctan2(mean[:, 1], mean[:, 0])
        walked = trace(surface, points, heading, np.hypot(*mean.T), threads=threads)
        points, angle = walked.end, angle + walked.angle_rad - heading
    return Sites(points, sites.axis_mm, angle)
