"""What dart throwing works with: darts, the ellipses they claim, and the board of pieces that are still free.

The way of throwing itself is `surftex.features.poisson`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import checked
from surftex.errors import InputError
from surftex.kernels.pool import slices
from surftex.randomness import Stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

if TYPE_CHECKING:
    from surftex.geodesics.directions import DirectionField
    from surftex.geodesics.windows import Buckets, Records

Size = float | Callable[[SurfacePoints], NDArray[np.floating]]
"""A number, or a function that gives one for each of some points."""

SATURATION = 0.697
"""Sites per (major x minor) of a full surface: random sequential packing of discs in the plane."""

GAP = 1e-3
"""How far a point of a full surface may lie outside every region, as a share of the minor semi-axis."""

_SLICE = 16384
_PROBES = 32768

_BEYOND_PROBES = 4.0
"""No size is taken to be larger than so many times the largest that was probed; a rare larger one costs cuts, no gap."""


class Ellipses:
    """The exclusive ellipse at any point of a surface; sizes are numbers or functions of points."""

    def __init__(
        self, surface: Surface, spacing_mm: Size, ratio: Size, direction: "DirectionField | None"
    ) -> None:
        self.surface = surface
        self.spacing_mm, self.ratio, self.direction = spacing_mm, ratio, direction
        constant = not (callable(spacing_mm) or callable(ratio))
        if constant:
            probes = SurfacePoints.trusted(np.zeros(1, np.int32), np.full((1, 3), 1 / 3))
        else:
            from surftex.features.uniform import area_points

            probes = area_points(surface, Stream(0).uniform(_PROBES, 3))
        axis = self.axis(probes)
        self._product = axis.prod(axis=1)
        self.most_minor_mm = _BEYOND_PROBES * float(axis[:, 1].max())
        self.roundness = float(np.mean((axis[:, 1] / axis[:, 0]) ** 2))

    def axis(self, points: SurfacePoints) -> NDArray[np.float64]:
        """(n, 2) major and minor semi-axes at n points, checked."""
        major = _sizes(self.spacing_mm, points, "spacing_mm", 0.0)
        ratio = _sizes(self.ratio, points, "ratio", 1.0)
        return np.stack([major, major / ratio], axis=1)

    def angle(self, points: SurfacePoints) -> NDArray[np.float64]:
        """(n,) direction of the major axis in the frame of each point's face."""
        if self.direction is None:
            return np.zeros(len(points))
        return self.direction.at(points)

    def expected_sites(self) -> float:
        """About how many sites fill the surface; inf where they are beyond all numbers."""
        with np.errstate(divide="ignore", over="ignore"):
            return SATURATION * self.surface.area_mm2 * float(np.mean(1 / self._product))

    def cell_mm(self) -> float:
        """Side of buckets that suits the regions."""
        return float(np.sqrt(np.median(self._product)))


def _sizes(value: Size, points: SurfacePoints, name: str, least: float) -> NDArray[np.float64]:
    """Evaluate a size at points; positive, finite, at least `least`."""
    if not callable(value):
        sizes = np.full(len(points), float(value))
    elif len(points) == 0:
        sizes = np.zeros(0)
    else:
        sizes = checked(value(points), f"{name}(points)", (len(points),), np.float64)
    wrong = np.flatnonzero(~((sizes > 0) & (sizes >= least) & np.isfinite(sizes)))
    if len(wrong):
        limit = f"at least {least:g}" if least else "positive"
        raise InputError(
            f"{name} is {sizes[wrong[0]]} at {len(wrong)} of {len(sizes)} points; it must be {limit}"
        )
    return sizes


@dataclass(frozen=True, eq=False)
class Darts:
    """Darts in their order.

    Attributes
    ----------
    order : (n,) int64
        Ascending; earlier darts win.
    face : (n,) int32
        Face that each has hit.
    bucket : (n,) int64
        Bucket that each has hit.
    flat : (n, 2) float64
        Place in the frame of the face.
    axis : (n, 2) float64
        Semi-axes of the ellipse it claims; 0 before `measured`.
    angle : (n,) float64
        Direction of its major axis.
    position : (n, 3) float64
        Place in space; 0 before `measured`.
    """

    order: NDArray[np.int64]
    face: NDArray[np.int32]
    bucket: NDArray[np.int64]
    flat: NDArray[np.float64]
    axis: NDArray[np.float64]
    angle: NDArray[np.float64]
    position: NDArray[np.float64]

    @staticmethod
    def none() -> "Darts":
        """Make an empty set."""
        whole, real = np.zeros(0, np.int64), np.zeros(0)
        return Darts(whole, whole.astype(np.int32), whole, real.reshape(0, 2), real.reshape(0, 2), real,
                     real.reshape(0, 3))  # fmt: skip

    def __len__(self) -> int:
        return len(self.order)

    def _columns(self) -> tuple[NDArray, ...]:
        return self.order, self.face, self.bucket, self.flat, self.axis, self.angle, self.position

    def part(self, chosen: NDArray) -> "Darts":
        """Choose some of them, by mask or index."""
        return Darts(*[column[chosen] for column in self._columns()])

    def joined(self, other: "Darts") -> "Darts":
        """Put others behind these."""
        pairs = zip(self._columns(), other._columns(), strict=True)
        return Darts(*[np.concatenate([mine, theirs]) for mine, theirs in pairs])

    def points(self, surface: Surface) -> SurfacePoints:
        """Tell the places they hit."""
        from surftex.geodesics.pieces import barycentric_of

        return SurfacePoints.trusted(self.face, barycentric_of(surface, self.face, self.flat))

    def measured(self, ellipses: Ellipses) -> "Darts":
        """Fill in axes, angles and positions."""
        points = self.points(ellipses.surface)
        return Darts(self.order, self.face, self.bucket, self.flat, ellipses.axis(points),
                     ellipses.angle(points), points.positions(ellipses.surface))  # fmt: skip

    def outside(self, floods: Sequence["Flood"], threads: int | None) -> "Darts":
        """Keep those that lie in no exclusive region of any flood."""
        from surftex.kernels.sampling import excluded_darts

        if not len(self) or not floods:
            return self
        by_bucket = np.argsort(self.bucket, kind="stable")
        bucket, flat = self.bucket[by_bucket], self.flat[by_bucket]
        hit = np.zeros(len(self), np.uint8)

        def work(begin: int, end: int) -> None:
            for flood in floods:
                excluded_darts(begin, end, bucket, flat, *flood.arrays, hit)

        slices(work, len(self), size=_SLICE, threads=threads)
        free = np.zeros(len(self), bool)
        free[by_bucket] = hit == 0
        return self.part(free)


def undisputed(darts: Darts) -> NDArray[np.bool_]:
    """Which darts no earlier one of them can reach: no walk is shorter than the straight line."""
    from surftex.kernels.sampling import disputed_darts

    disputed = np.zeros(len(darts), np.uint8)
    if len(darts) > 1:
        reach = darts.axis[:, 0] * (1 + 1e-9)
        cell = np.floor((darts.position - darts.position.min(axis=0)) / reach.max()).astype(np.int64)
        size = cell.max(axis=0) + 3
        stride = np.array([size[1] * size[2], size[2], 1])
        key = cell @ stride
        dart = np.argsort(key, kind="stable")
        disputed_darts(darts.position, reach, key[dart], dart, stride, disputed)
    return disputed == 0


@dataclass(frozen=True, eq=False)
class Flood:
    """The exclusive regions of some sites, as arrays for the kernels."""

    arrays: tuple[NDArray, ...]

    @staticmethod
    def of(records: "Records", sites: Darts) -> "Flood":
        """Join what was flooded with the ellipses of the sources."""
        cosine, sine = np.cos(sites.angle), np.sin(sites.angle)
        rows = np.stack([cosine, sine, -sine, cosine], axis=1) / np.repeat(sites.axis, 2, axis=1)
        return Flood((records.start, records.entry_row, records.row, records.row_id, records.source_of,
                      rows, sites.axis))  # fmt: skip


class Board:
    """Pieces of faces that are not known to be covered; darts are thrown at them, and at nothing else."""

    def __init__(self, surface: Surface, buckets: "Buckets", ellipses: Ellipses, threads: int | None) -> None:
        from surftex.kernels.sampling import cell_pieces

        self.surface, self.buckets, self.ellipses, self.threads = surface, buckets, ellipses, threads
        polygon, other = np.zeros((8, 2)), np.zeros((8, 2))
        self.bucket, self.face = np.zeros(0, np.int64), np.zeros(0, np.int32)
        self.corner = np.zeros((0, 3, 2))
        for fill in range(2):
            grids = surface.flat, buckets.first, buckets.cells, buckets.grid
            count = cell_pieces(*grids, fill, polygon, other, self.bucket, self.face, self.corner)
            if not fill:
                self.bucket, self.face = np.zeros(count, np.int64), np.zeros(count, np.int32)
                self.corner = np.zeros((count, 3, 2))
        self.state = np.zeros(len(self), np.uint8)
        self.untried = True
        self._measure()

    def __len__(self) -> int:
        return len(self.bucket)

    def done_share(self) -> float:
        """Share of the surface that is covered."""
        return max(0.0, 1.0 - float(self.area.sum()) / self.surface.area_mm2)

    def wish(self) -> int:
        """How many darts to throw next; it tunes the speed, and no property of the outcome."""
        if not len(self):
            return 0
        room = self.ellipses.expected_sites() * (1 - self.done_share())
        if self.untried:
            self.untried = False
            return int(room) + 1
        return int(1.5 * room + 0.1 * self.ellipses.roundness * len(self)) + 1

    def darts(self, numbers: NDArray[np.float64], first: int) -> Darts:
        """Throw darts, uniform by area, and one at the middle of each piece that is too small to cut.

        Such a piece is struck off: its middle will be covered, and no point of it is farther than `GAP`.
        """
        if not len(self):
            return Darts.none()
        reached = np.cumsum(self.area)
        chosen = np.searchsorted(reached, numbers[:, 0] * reached[-1], side="right")
        chosen = np.minimum(chosen, np.searchsorted(reached, reached[-1]))
        root = np.sqrt(numbers[:, 1])
        share = np.stack([1 - root, root * (1 - numbers[:, 2]), root * numbers[:, 2]], axis=1)
        flat = np.einsum("pk,pki->pi", share, self.corner[chosen])
        small = self._small()
        bucket = np.concatenate([self.bucket[chosen], self.bucket[small]])
        face = np.concatenate([self.face[chosen], self.face[small]])
        flat = np.concatenate([flat, self.corner[small].mean(axis=1)])
        self._keep(~small)
        count = len(bucket)
        order = np.arange(first, first + count)
        return Darts(order, face, bucket, flat, np.zeros((count, 2)), np.zeros(count), np.zeros((count, 3)))

    def _small(self) -> NDArray[np.bool_]:
        """Pieces with no corner farther than the tolerance from the middle."""
        from surftex.geodesics.pieces import barycentric_of

        small = self.radius <= GAP * self.ellipses.most_minor_mm
        asked = np.flatnonzero(small)
        middle = self.corner[asked].mean(axis=1)
        points = SurfacePoints.trusted(
            self.face[asked], barycentric_of(self.surface, self.face[asked], middle)
        )
        small[asked] = self.radius[asked] <= GAP * self.ellipses.axis(points)[:, 1]
        return small

    def _keep(self, chosen: NDArray[np.bool_]) -> None:
        self.bucket, self.face = self.bucket[chosen], self.face[chosen]
        self.corner, self.state = self.corner[chosen], self.state[chosen]
        self._measure()

    def _measure(self) -> None:
        from surftex.kernels.sampling import measure_pieces

        self.area, self.radius = np.zeros(len(self)), np.zeros(len(self))
        measure_pieces(self.corner, self.area, self.radius)

    def strike(self, flood: Flood) -> None:
        """Strike off the pieces that lie inside one of the flood's regions."""
        from surftex.kernels.sampling import covered_pieces

        def work(begin: int, end: int) -> None:
            covered_pieces(begin, end, self.bucket, self.corner, *flood.arrays, self.state)

        slices(work, len(self), size=_SLICE, threads=self.threads)
        self._keep(self.state < 2)

    def split(self, floods: Sequence[Flood]) -> None:
        """Cut the pieces that regions may touch, and strike off what lies inside a region of any flood."""
        from surftex.kernels.sampling import covered_pieces, split_pieces

        touched = self.state == 1
        cut = np.flatnonzero(touched)

        def work(begin: int, end: int) -> tuple[NDArray, ...]:
            chosen = cut[begin:end]
            bucket, face = np.repeat(self.bucket[chosen], 4), np.repeat(self.face[chosen], 4)
            corner, state = np.zeros((len(bucket), 3, 2)), np.zeros(len(bucket), np.uint8)
            split_pieces(self.corner[chosen], corner)
            for flood in floods:
                covered_pieces(0, len(bucket), bucket, corner, *flood.arrays, state)
            free = state < 2
            return bucket[free], face[free], corner[free], state[free]

        parts = slices(work, len(cut), size=_SLICE // 4, threads=self.threads)
        if not parts:
            return
        columns = [list(column) for column in zip(*parts, strict=True)]
        whole = ~touched
        bucket = np.concatenate([self.bucket[whole], *columns[0]])
        order = np.argsort(bucket, kind="stable")
        self.bucket = bucket[order]
        self.face = np.concatenate([self.face[whole], *columns[1]])[order]
        self.corner = np.concatenate([self.corner[whole], *columns[2]])[order]
        self.state = np.concatenate([self.state[whole], *columns[3]])[order]
        self._measure()
