"""Poisson-disk sites: dart throwing until the surface is full, which is proved and not hoped for.

A dart is kept when it lies outside the exclusive region of every site kept before. The region of a site is
an ellipse in its own log map: semi-axes (a, b), the major one along the direction field there. Faces are cut
into pieces; a piece that lies wholly inside one region is struck off, and darts fall only into the others.
When the last piece is gone, no point is farther than the tolerance from some exclusive region.

Darts have a global order, and the outcome is that of throwing them one after the other. They are decided in
rounds all the same: a dart is kept once no earlier undecided one can reach it, which its straight distance
tells, since no walk is shorter. Each kept site floods its surroundings once, with the radius a.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.errors import InputError
from surftex.features.darts import GAP, Board, Darts, Ellipses, Flood, Size, undisputed
from surftex.kernels.pool import Tick
from surftex.randomness import Stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

if TYPE_CHECKING:
    from surftex.geodesics.directions import DirectionField

TOO_COARSE = 0.5
"""Pieces are cut when fewer than this share of the darts thrown at them hit free places."""

__all__ = ["GAP", "Sites", "expected_sites", "poisson_disk"]


@dataclass(frozen=True, eq=False)
class Sites:
    """Places of cells, with the ellipse that each keeps for itself.

    Attributes
    ----------
    points : SurfacePoints
        n sites, in the order of the darts.
    axis_mm : (n, 2) float64
        Major and minor semi-axis.
    angle_rad : (n,) float64
        Direction of the major axis in the frame of the face.
    """

    points: SurfacePoints
    axis_mm: NDArray[np.float64]
    angle_rad: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.points)

    @property
    def features(self) -> NDArray[np.void]:
        """(n,) structured array: face, barycentric, major_mm, minor_mm, angle_rad."""
        table = np.zeros(len(self), [("face", "i4"), ("barycentric", "f8", 3), ("major_mm", "f8"),
                                     ("minor_mm", "f8"), ("angle_rad", "f8")])  # fmt: skip
        table["face"], table["barycentric"] = self.points.face, self.points.barycentric
        table["major_mm"], table["minor_mm"] = self.axis_mm.T
        table["angle_rad"] = self.angle_rad
        return table


def expected_sites(surface: Surface, spacing_mm: Size, ratio: Size = 1.0) -> float:
    """Tell about how many sites `poisson_disk` would place, in no time.

    Parameters
    ----------
    surface : Surface
        Where the sites would lie.
    spacing_mm : float or callable
        As for `poisson_disk`.
    ratio : float or callable
        As for `poisson_disk`.

    Returns
    -------
    count : float
        Within a few percent.

    Raises
    ------
    InputError
        If a size is not positive, or a ratio is below 1.
    """
    return Ellipses(surface, spacing_mm, ratio, None).expected_sites()


def poisson_disk(
    surface: Surface,
    spacing_mm: Size,
    stream: Stream,
    *,
    ratio: Size = 1.0,
    direction: "DirectionField | None" = None,
    max_sites: int = 5_000_000,
    tick: Tick | None = None,
    threads: int | None = None,
) -> Sites:
    """Throw darts until no more fits.

    Parameters
    ----------
    surface : Surface
        Where the sites shall lie.
    spacing_mm : float or callable
        Major semi-axis a of the exclusive regions: a number, or a function of `SurfacePoints`.
    stream : Stream
        The random numbers of this use, and of no other.
    ratio : float or callable
        a / b of the semi-axes, at least 1.
    direction : DirectionField, optional
        Of the major axes; without it they follow the x axis of each face, which shows unless `ratio` is 1.
    max_sites : int
        Refuse work that would place more than about this number.
    tick : callable, optional
        Told the finished share; may raise to cancel.
    threads : int, optional
        None means every core. The sites do not depend on it.

    Returns
    -------
    sites : Sites
        No site lies in the region of an earlier one: with `ratio` 1 and constant spacing no two are nearer
        than `spacing_mm` along the surface. Every point of the surface lies in the region of some site, or
        within `GAP` x b of a point that does.

    Raises
    ------
    InputError
        If a size is not positive, a ratio is below 1, or about more than `max_sites` sites would fit.
    """
    from surftex.geodesics.windows import Buckets, flood_points

    ellipses = Ellipses(surface, spacing_mm, ratio, direction)
    expected = ellipses.expected_sites()
    if expected > max_sites:
        raise InputError(
            f"about {expected:.3g} sites would fit, more than max_sites = {max_sites}; "
            "use a larger spacing, or allow more"
        )
    board = Board(surface, Buckets.of(surface, ellipses.cell_mm()), ellipses, threads)
    pool = Darts.none()
    parts: list[Darts] = []
    floods: list[Flood] = []
    drawn = thrown = 0
    while len(board) or len(pool):
        numbers = stream.uniform(board.wish(), 3, first=drawn)
        fresh = board.darts(numbers, thrown)
        drawn, thrown = drawn + len(numbers), thrown + len(fresh)
        free = fresh.outside(floods, threads)
        pool = pool.joined(free.measured(ellipses))
        first = undisputed(pool)
        chosen, pool = pool.part(first), pool.part(~first)
        if len(chosen):
            records = flood_points(
                surface, chosen.points(surface), chosen.axis[:, 0], buckets=board.buckets, threads=threads
            )
            floods.append(Flood.of(records, chosen))
            parts.append(chosen)
            pool = pool.outside(floods[-1:], threads)
            board.strike(floods[-1])
        if len(free) < TOO_COARSE * len(fresh):
            board.split(floods)
        if tick:
            tick(board.done_share())
    sites = Darts.none()
    for part in parts:
        sites = sites.joined(part)
    sites = sites.part(np.argsort(sites.order, kind="stable"))
    return Sites(sites.points(surface), frozen(sites.axis), frozen(sites.angle))
