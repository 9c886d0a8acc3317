"""Lattices that textures are drawn on: sites, and the sites that offsets lead to.

A plane has a margin around it: filled from the other side where it is a torus, and with missing levels where it
ends. On surfaces whoever knows the mesh walks the offsets and hands in a table (`Table`). Sites fall into
classes; those of one class are drawn together, by any number of threads, from the picture before.
"""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen

MISSING = 255
"""Level of what is no site."""

_MODULI = (5, 7, 8, 11, 13, 16, 17)


class Lattice(Protocol):
    """What the sampler needs to know of a lattice."""

    @property
    def places(self) -> int:
        """Length of a band's array of levels."""
        ...

    @property
    def follow(self) -> int:
        """1 where `reach` has a row for each place, 0 where it has one row of steps."""
        ...

    @property
    def site(self) -> NDArray[np.int32]:
        """(n,) places that hold levels to be counted."""
        ...

    def reach(self, offset: NDArray[np.integer]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Places that offsets lead to, (1 or places, any), and the column (e,) of each offset (e, 2)."""
        ...

    def classes(self, offset: NDArray[np.integer], live: NDArray[np.bool_] | None) -> list[NDArray[np.int32]]:
        """Sites in classes that are drawn one after the other; only those that are `live` (places,)."""
        ...

    def repeat(self, level: NDArray[Any]) -> None:
        """Bring copies of sites up to date, in place."""
        ...


@dataclass(frozen=True, eq=False)
class Plane:
    """A picture's pixels with a margin around them; make one with `Plane.of`.

    Attributes
    ----------
    height : int
        Rows.
    width : int
        Columns.
    margin : int
        Longest step that an offset may take, in either axis.
    wrap : bool
        Whether the picture continues on its other side.
    """

    height: int
    width: int
    margin: int
    wrap: bool
    site: NDArray[np.int32]
    copy: NDArray[np.int32]
    origin: NDArray[np.int32]

    follow = 0

    @staticmethod
    def of(height: int, width: int, margin: int, *, wrap: bool) -> "Plane":
        """Lay out a plane.

        Parameters
        ----------
        height : int
            Rows.
        width : int
            Columns.
        margin : int
            Longest step that an offset may take, in either axis.
        wrap : bool
            Whether the picture continues on its other side.

        Returns
        -------
        plane : Plane
            Ready to hold levels.
        """
        row, column = np.arange(-margin, height + margin), np.arange(-margin, width + margin)
        inside = ((row >= 0) & (row < height))[:, None] & ((column >= 0) & (column < width))
        place = np.arange(len(row) * len(column), dtype=np.int32).reshape(len(row), len(column))
        copy = origin = np.zeros(0, np.int32)
        if wrap:
            copy = place[~inside]
            origin = place[(row % height + margin)[:, None], column % width + margin][~inside]
        return Plane(height, width, margin, wrap, frozen(place[inside]), frozen(copy), frozen(origin))

    @property
    def places(self) -> int:
        """Pixels and margin."""
        return (self.height + 2 * self.margin) * (self.width + 2 * self.margin)

    def hold(self, picture: NDArray[np.uint8], fill: int = MISSING) -> NDArray[np.uint8]:
        """Put levels into the plane.

        Parameters
        ----------
        picture : (c, height, width) uint8
            Levels.
        fill : int
            What stands in the margin of a picture that ends.

        Returns
        -------
        level : (c, places) uint8
            With the margin filled.
        """
        level = np.full((len(picture), self.places), fill, np.uint8)
        level[:, self.site] = picture.reshape(len(picture), -1)
        self.repeat(level)
        return level

    def picture(self, level: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Take the levels out again.

        Parameters
        ----------
        level : (c, places) uint8
            As `hold` made them.

        Returns
        -------
        picture : (c, height, width) uint8
            A copy.
        """
        return level[:, self.site].reshape(len(level), self.height, self.width)

    def reach(self, offset: NDArray[np.integer]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Turn offsets into steps.

        Parameters
        ----------
        offset : (e, 2) int
            Right and down, at most `margin` each.

        Returns
        -------
        reach : (1, e) int32
            Steps along the array of levels.
        column : (e,) int32
            Of each offset in `reach`.
        """
        offset = np.asarray(offset, np.int64).reshape(-1, 2)
        steps = (offset[:, 1] * (self.width + 2 * self.margin) + offset[:, 0])[None]
        return np.ascontiguousarray(steps, np.int32), np.arange(len(offset), dtype=np.int32)

    def classes(
        self, offset: NDArray[np.integer], live: NDArray[np.bool_] | None = None
    ) -> list[NDArray[np.int32]]:
        """Part the sites so that few offsets, and none of the shortest, join two of one class.

        Parameters
        ----------
        offset : (e, 2) int
            Those that matter.
        live : (places,) bool, optional
            Sites to keep; all without it.

        Returns
        -------
        classes : list of (n,) int32
            Places, ascending in each.
        """
        slope, modulus = _least_conflict(np.asarray(offset, np.int64).reshape(-1, 2))
        row, column = np.divmod(np.arange(self.height * self.width), self.width)
        number = (column + slope * row) % modulus
        if live is not None:
            number = np.where(live[self.site], number, -1)
        return [frozen(self.site[number == each]) for each in range(modulus)]

    def repeat(self, level: NDArray[Any]) -> None:
        """Fill the margin of a torus from its other side.

        Parameters
        ----------
        level : (c, places) array
            Changed in place.
        """
        if self.wrap:
            level[:, self.copy] = level[:, self.origin]


@dataclass(frozen=True, eq=False)
class Table:
    """Sites anywhere, with a table of the sites that offsets lead to; the last place is that of no site.

    Attributes
    ----------
    offset : (e, 2) int32
        Right and down; each once.
    table : (n + 1, e) int32
        Site that each offset leads to from each site; n where it leads to none.
    """

    offset: NDArray[np.int32]
    table: NDArray[np.int32]

    follow = 1

    @property
    def places(self) -> int:
        """Sites, and one place for none."""
        return len(self.table)

    @property
    def site(self) -> NDArray[np.int32]:
        """(n,) all sites."""
        return np.arange(self.places - 1, dtype=np.int32)

    def reach(self, offset: NDArray[np.integer]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Look offsets up.

        Parameters
        ----------
        offset : (e, 2) int
            Any of the table's.

        Returns
        -------
        reach : (n + 1, all) int32
            The table itself.
        column : (e,) int32
            Of each offset in it.
        """
        known = {tuple(map(int, each)): at for at, each in enumerate(self.offset)}
        wanted = [tuple(map(int, each)) for each in np.asarray(offset).reshape(-1, 2)]
        return self.table, np.array([known[each] for each in wanted], np.int32)

    def classes(
        self, offset: NDArray[np.integer], live: NDArray[np.bool_] | None = None
    ) -> list[NDArray[np.int32]]:
        """Part the sites by a hash of their number.

        Parameters
        ----------
        offset : (e, 2) int
            Not looked at.
        live : (places,) bool, optional
            Sites to keep; all without it.

        Returns
        -------
        classes : list of (n,) int32
            Sixteen.
        """
        site = self.site
        mixed = site.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
        number = ((mixed ^ (mixed >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9) >> np.uint64(60)).astype(
            np.int64
        )
        if live is not None:
            number = np.where(live[:-1], number, -1)
        return [frozen(site[number == each]) for each in range(16)]

    def repeat(self, level: NDArray[Any]) -> None:
        """Nothing is stored twice.

        Parameters
        ----------
        level : (c, places) array
            Left as it is.
        """


def _least_conflict(offset: NDArray[np.int64]) -> tuple[int, int]:
    """Slope and modulus for which the fewest and longest offsets join two sites of one class."""
    away = offset[np.abs(offset).sum(axis=1) > 0]
    weight = 10.0 / np.abs(away).sum(axis=1)
    best = (np.inf, 2, 5)
    for modulus in _MODULI:
        for slope in range(1, modulus):
            joined = (away[:, 0] + slope * away[:, 1]) % modulus == 0
            best = min(best, (float(weight[joined].sum()) + 0.05 * modulus, slope, modulus))
    return best[1], best[2]
