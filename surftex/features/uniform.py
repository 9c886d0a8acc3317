"""Points scattered over a surface, uniform by area: a fixed number of them, or a Poisson process.

Point i is a pure function of the stream, of i and of the surface; a mask thins the points, and moves none.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked
from surftex.errors import InputError
from surftex.randomness import Stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

Weight = ArrayLike | Callable[[SurfacePoints], NDArray[np.floating]] | None
"""A number in 0..1 per face, or a function that gives one for each of some points."""

_COUNT_ROW = 2**48
_BATCH = 65536
_STARVED = 1e-4


def area_points(
    surface: Surface, numbers: NDArray[np.float64], face_weight: NDArray[np.float64] | None = None
) -> SurfacePoints:
    """Turn rows of three numbers into points that are uniform by area.

    Parameters
    ----------
    surface : Surface
        Where the points shall lie.
    numbers : (n, 3) float64
        In [0, 1): the first picks the face, the others the place in it.
    face_weight : (m,) float64, optional
        Factor on the area of each face.

    Returns
    -------
    points : SurfacePoints
        n points.
    """
    area = surface.face_area_mm2 if face_weight is None else surface.face_area_mm2 * face_weight
    reached = np.cumsum(area)
    face = np.searchsorted(reached, numbers[:, 0] * reached[-1], side="right")
    face = np.minimum(face, np.searchsorted(reached, reached[-1]))
    root = np.sqrt(numbers[:, 1])
    barycentric = np.stack([1 - root, root * (1 - numbers[:, 2]), root * numbers[:, 2]], axis=1)
    return SurfacePoints.trusted(face.astype(np.int32), barycentric)


def scatter(
    surface: Surface,
    stream: Stream,
    *,
    count: int | None = None,
    density_per_mm2: float | None = None,
    weight: Weight = None,
) -> SurfacePoints:
    """Scatter points independently, uniform by area.

    Parameters
    ----------
    surface : Surface
        Where they shall lie.
    stream : Stream
        The random numbers of this use, and of no other.
    count : int, optional
        How many; give this or `density_per_mm2`.
    density_per_mm2 : float, optional
        Of a Poisson process: the count is drawn from a Poisson law with mean density x area.
    weight : (m,) array_like or callable, optional
        0 to 1, per face or of `SurfacePoints`: the local density as a share of the full one.

    Returns
    -------
    points : SurfacePoints
        In the order of the stream. With a density, points of a smaller one (same weight) come first in those
        of a larger one; with a callable weight, the points are a subset of those without.

    Raises
    ------
    InputError
        If not exactly one of `count` and `density_per_mm2` is given, if one is negative, if a weight leaves
        0..1, or if the weight lets hardly any of the `count` points pass.

    Examples
    --------
    >>> from surftex.randomness import stream
    >>> from surftex.surface.shapes import plane
    >>> len(scatter(plane(10.0), stream(7, "pores"), count=25))
    25
    """
    if (count is None) == (density_per_mm2 is None):
        raise InputError("scatter takes either count or density_per_mm2, and not both")
    face_weight = None
    if weight is not None and not callable(weight):
        face_weight = _within_unit(checked(weight, "weight", (len(surface.faces),), np.float64), "weight")
    area = surface.area_mm2 if face_weight is None else float((surface.face_area_mm2 * face_weight).sum())
    if count is None:
        if density_per_mm2 is None or not 0 <= density_per_mm2 < np.inf:
            raise InputError(f"density_per_mm2 is {density_per_mm2}; it takes a number of at least 0")
        tried = _poisson_count(density_per_mm2 * area, stream)
        points, passed = _drawn(surface, stream, 0, tried, face_weight, weight)
        return _chosen(points, passed)
    if count < 0:
        raise InputError(f"count is {count}; it takes a number of at least 0")
    if count and not area > 0:
        raise InputError(
            "weight is 0 on every face, so no point can be placed; give some face a weight above 0"
        )
    if not callable(weight):
        return _drawn(surface, stream, 0, count, face_weight, None)[0]
    return _until(surface, stream, count, weight)


def _until(surface: Surface, stream: Stream, count: int, weight: Callable) -> SurfacePoints:
    """Draw in batches until `count` points have passed the weight."""
    parts: list[SurfacePoints] = []
    found = tried = 0
    while found < count:
        points, passed = _drawn(surface, stream, tried, _BATCH, None, weight)
        parts.append(_chosen(points, passed))
        found += len(parts[-1])
        tried += _BATCH
        if tried > 4 * _BATCH and found < _STARVED * tried:
            raise InputError(
                f"weight let {found} of {tried} points pass, too few to place {count}; "
                "raise it somewhere, or lower the count"
            )
    face = np.concatenate([np.zeros(0, np.int32), *[part.face for part in parts]])
    barycentric = np.concatenate([np.zeros((0, 3)), *[part.barycentric for part in parts]])
    return SurfacePoints.trusted(face[:count], barycentric[:count])


def _drawn(
    surface: Surface, stream: Stream, first: int, count: int, face_weight: NDArray | None, weight: Weight
) -> tuple[SurfacePoints, NDArray[np.bool_] | None]:
    """Points of the stream's rows from `first` on, and which of them pass a callable weight (None: all)."""
    numbers = stream.uniform(count, 4, first=first)
    points = area_points(surface, numbers[:, :3], face_weight)
    if not callable(weight):
        return points, None
    share = _within_unit(checked(weight(points), "weight(points)", (count,), np.float64), "weight(points)")
    return points, numbers[:, 3] < share


def _chosen(points: SurfacePoints, passed: NDArray[np.bool_] | None) -> SurfacePoints:
    if passed is None:
        return points
    return SurfacePoints.trusted(points.face[passed], points.barycentric[passed])


def _within_unit(values: NDArray[np.float64], name: str) -> NDArray[np.float64]:
    wrong = np.flatnonzero((values < 0) | (values > 1))
    if len(wrong):
        raise InputError(
            f"{name} leaves 0..1 at {len(wrong)} of {len(values)} entries; the first is entry "
            f"{int(wrong[0])} = {values[wrong[0]]}"
        )
    return values


def _poisson_count(mean: float, stream: Stream) -> int:
    """Draw a number from a Poisson law by inversion; it never falls when the mean grows."""
    from scipy.special import pdtrik

    if mean <= 0:
        return 0
    share = float(stream.uniform(1, 4, first=_COUNT_ROW)[0, 0])
    if share <= np.exp(-mean):
        return 0
    return max(0, int(np.ceil(pdtrik(share, mean) - 1e-9)))
