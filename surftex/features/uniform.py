"""Points scattered over a surface by area times a field: a fixed number of them, or a Poisson process.

Dart i is a pure function of the stream, of i and of the surface: the face by exact inversion of the areas, then
the place in it. A field thins the darts, and moves none; how the file unwraps the surface cannot matter. Fields
that know their `span` say what no value on a face exceeds, so that nothing above a guessed peak is cut off, and
darts that cannot stay are dropped unseen.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked
from surftex.errors import InputError
from surftex.randomness import Stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface


class PointField(Protocol):
    """A number at each of some points, with bounds on every face."""

    def __call__(self, points: SurfacePoints) -> NDArray[np.floating]:
        """Evaluate at points."""
        ...

    def span(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Give the least and the greatest value possible on each face, (m,) each."""
        ...


Weight = ArrayLike | PointField | Callable[[SurfacePoints], NDArray[np.floating]] | None
"""A number per face, or a function that gives one for each of some points."""

_COUNT_ROW = 2**48
_BATCH = 65536
_STARVED = 1e-4
_FEW = 1 / 64
"""Where fewer darts than this can stay, they are thrown by the spans instead of by area alone."""


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
    density_per_mm2: float | PointField | None = None,
    weight: Weight = None,
    power: float = 1.0,
) -> SurfacePoints:
    """Scatter points independently, by area times a field.

    Parameters
    ----------
    surface : Surface
        Where they shall lie, m faces.
    stream : Stream
        The random numbers of this use, and of no other.
    count : int, optional
        How many; give this or `density_per_mm2`.
    density_per_mm2 : float or PointField, optional
        Of a Poisson process: the count is drawn from a Poisson law with the mean that the density has over the
        area. A field needs a `span`; below 0 it counts as 0.
    weight : (m,) array_like or callable, optional
        With a number as density the share of it that stays, 0 to 1; with `count` any likelihood from 0 on. An
        array has one number per face. A callable takes `SurfacePoints`; one with a `span` may leave 0..1, below
        0 it counts as 0; one without may not.
    power : float
        Of the weight: above 1 it gathers the points where the weight is high, below 1 it spreads them.

    Returns
    -------
    points : SurfacePoints
        In the order of the stream. With a number as density, points of a smaller one (same weight) come first in
        those of a larger one, and those under a callable weight are a subset of those without.

    Raises
    ------
    InputError
        If not exactly one of `count` and `density_per_mm2` is given, if one is negative, if a weight leaves its
        range, if a field has no upper bound, or if it lets hardly any of the `count` points pass.

    Examples
    --------
    >>> from surftex.randomness import stream
    >>> from surftex.surface.shapes import plane
    >>> len(scatter(plane(10.0), stream(7, "pores"), count=25))
    25
    """
    if (count is None) == (density_per_mm2 is None):
        raise InputError("scatter takes either count or density_per_mm2, and not both")
    if not 0 < power < np.inf:
        raise InputError(f"power is {power}; it takes a number above 0")
    if callable(density_per_mm2):
        if weight is not None:
            raise InputError("a density that is a field takes no weight; multiply the two fields")
        thinned = _thinned(surface, density_per_mm2, "density_per_mm2", 1.0, None)
        darts, most = thinned
        return darts.thrown(surface, stream, 0, _poisson_count(most, stream))
    if count is None and not (density_per_mm2 is not None and 0 <= density_per_mm2 < np.inf):
        raise InputError(f"density_per_mm2 is {density_per_mm2}; it takes a number of at least 0")
    if count is not None and count < 0:
        raise InputError(f"count is {count}; it takes a number of at least 0")
    if weight is None:
        darts, area = _Darts(None, None, 1.0, None), surface.area_mm2
    elif callable(weight):
        darts, area = _thinned(surface, weight, "weight", power, 1.0 if count is None else None)
    else:
        share = checked(weight, "weight", (len(surface.faces),), np.float64)
        share = _within_unit(share, "weight") ** power
        darts, area = _Darts(share, None, 1.0, None), float((surface.face_area_mm2 * share).sum())
    if count is None:
        return darts.thrown(surface, stream, 0, _poisson_count(float(density_per_mm2 or 0) * area, stream))
    if count and not area > 0:
        raise InputError(
            "weight is 0 on every face, so no point can be placed; give some face a weight above 0"
        )
    return _until(surface, stream, count, darts)


@dataclass(frozen=True, eq=False)
class _Darts:
    """Where darts fall, and how likely each stays.

    face_weight (m,): factor on the area of each face, None for 1; chance: of points, up to `most`, None for
    always; squeeze (m,): what `chance` cannot exceed on each face.
    """

    face_weight: NDArray[np.float64] | None
    chance: Callable[[SurfacePoints], NDArray[np.float64]] | None
    most: float
    squeeze: NDArray[np.float64] | None

    def thrown(self, surface: Surface, stream: Stream, first: int, count: int) -> SurfacePoints:
        """Throw the darts of some rows of the stream; give those that stay."""
        if self.chance is None:
            return area_points(surface, stream.uniform(count, 4, first=first)[:, :3], self.face_weight)
        batches = range(first, first + count, _BATCH)
        return _joined([self._batch(surface, stream, at, min(_BATCH, first + count - at)) for at in batches])

    def _batch(self, surface: Surface, stream: Stream, first: int, count: int) -> SurfacePoints:
        numbers = stream.uniform(count, 4, first=first)
        points = area_points(surface, numbers[:, :3], self.face_weight)
        level = numbers[:, 3] * self.most
        if self.squeeze is not None:
            top = self.squeeze[points.face]
            level = numbers[:, 3] * top if self.face_weight is not None else level
            points, level = _chosen(points, level < top), level[level < top]
        if self.chance is None or len(points) == 0:
            return points
        return _chosen(points, level < self.chance(points))


def _thinned(
    surface: Surface, field: Callable, name: str, power: float, most: float | None
) -> tuple[_Darts, float]:
    """Make darts that a field thins, and measure the area that they fall on times the most that it can be."""
    if not hasattr(field, "span"):
        if name != "weight":
            raise InputError(f"{name} is a function without a span; make the field with surftex.fields")

        def share(points: SurfacePoints) -> NDArray[np.float64]:
            values = checked(field(points), "weight(points)", (len(points),), np.float64)
            return _within_unit(values, "weight(points)") ** power

        return _Darts(None, share, 1.0, None), surface.area_mm2
    high = np.maximum(field.span()[1], 0.0)  # type: ignore[attr-defined]
    endless = np.flatnonzero(~np.isfinite(high))
    if len(endless):
        raise InputError(
            f"{name} has no upper bound on {len(endless)} of {len(high)} faces; does it divide by what may be 0? "
            "Limit it with min(..., 1) or clamp(...)"
        )
    top = (high * (1 + 1e-9)) ** power

    def chance(points: SurfacePoints) -> NDArray[np.float64]:
        values = checked(field(points), name, (len(points),), np.float64)
        beyond = np.flatnonzero(values > high[points.face] * (1 + 1e-9) + 1e-300)
        if len(beyond):
            at = int(beyond[0])
            raise InputError(
                f"{name} is {values[at]} on face {points.face[at]}, above the {high[points.face[at]]} of its span"
            )
        if most is not None:
            _within_unit(np.maximum(values, 0.0), name)
        return np.maximum(values, 0.0) ** power

    peak = float(top.max()) if most is None else most
    bound = float((surface.face_area_mm2 * top).sum())
    if most is None and bound < _FEW * peak * surface.area_mm2:
        return _Darts(top, chance, peak, top), bound
    return _Darts(None, chance, peak, top), peak * surface.area_mm2


def _until(surface: Surface, stream: Stream, count: int, darts: _Darts) -> SurfacePoints:
    """Draw in batches until `count` points have stayed."""
    if darts.chance is None:
        return darts.thrown(surface, stream, 0, count)
    parts: list[SurfacePoints] = []
    found = tried = 0
    while found < count:
        parts.append(darts.thrown(surface, stream, tried, _BATCH))
        found += len(parts[-1])
        tried += _BATCH
        if tried > 4 * _BATCH and found < _STARVED * tried:
            raise InputError(
                f"weight let {found} of {tried} points pass, too few to place {count}; "
                "raise it somewhere, or lower the count"
            )
    points = _joined(parts)
    return SurfacePoints.trusted(points.face[:count], points.barycentric[:count])


def _joined(parts: list[SurfacePoints]) -> SurfacePoints:
    face = np.concatenate([np.zeros(0, np.int32), *[part.face for part in parts]])
    return SurfacePoints.trusted(
        face, np.concatenate([np.zeros((0, 3)), *[part.barycentric for part in parts]])
    )


def _chosen(points: SurfacePoints, passed: NDArray[np.bool_]) -> SurfacePoints:
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
