"""Closed regions between particles: triangles that join their centres, paired into quadrilaterals.

Real grain has cells with three and four sides, and those are the faces of the mesh that joins the particles, not
their Voronoi regions. Triangles are known by the lengths of their sides, so plane and surface share everything.

Where many thin triangles meet at one particle they would make a star. Three things together cure that, in this order:
particles that lie too close under others are left out (`kept_apart`); thin triangles are paired first, needles nearly
whatever the angles; and where sharp corners, seven cells or four lone triangles still meet, pairs are broken and tied anew
until no exchange makes it better (`surftex.kernels.star_knots`), past the share if need be.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen

THIN_RAD = np.radians(30.0)
"""Triangles with a smaller angle are paired first."""

NEEDLE_RAD = np.radians(20.0)
"""Triangles with a smaller angle may make cells that are nearly triangles."""

TOO_CLOSE = 0.55
"""Particles nearer than this share of the sum of their radii overlap too much to make a cell between them."""

_LAST_RESORT_RAD, _NEEDLE_RESORT_RAD = np.radians(62.0), np.radians(86.0)


@dataclass(frozen=True, eq=False)
class Triangles:
    """t triangles between particles.

    Attributes
    ----------
    corner : (t, 3) int64
        Particles, counter-clockwise.
    twin : (t, 3) int64
        What lies across the side from corner i to corner i + 1: 3 other + its side; -1 at a border.
    length : (t, 3) float64
        Of those sides, where needed in the metric in which the particles are round.
    """

    corner: NDArray[np.int64]
    twin: NDArray[np.int64]
    length: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.corner)

    @property
    def angle(self) -> NDArray[np.float64]:
        """(t, 3) radians, at the corners."""
        onward, opposite, back = (np.roll(self.length, -k, axis=1) for k in range(3))
        cosine = (onward**2 + back**2 - opposite**2) / np.maximum(2 * onward * back, 1e-300)
        return np.arccos(np.clip(cosine, -1, 1))

    @property
    def area(self) -> NDArray[np.float64]:
        """(t,) in squares of the unit of length."""
        a, b, c = self.length.T
        s = 0.5 * (a + b + c)
        return np.sqrt(np.maximum(s * (s - a) * (s - b) * (s - c), 0))

    def flipped(self) -> "Triangles":
        """Flip sides until no circle around a triangle holds a fourth particle.

        Returns
        -------
        triangles : Triangles
            As many.
        """
        from surftex.kernels.triangulation import flip_to_delaunay

        corner, twin, length = self.corner.copy(), self.twin.copy(), self.length.copy()
        flip_to_delaunay(
            corner,
            twin,
            length,
            np.zeros(3 * len(corner) + 16, np.int64),
            np.zeros(3 * len(corner), np.uint8),
        )
        return Triangles(frozen(corner), frozen(twin), frozen(length))


def twins_of(key: NDArray[np.int64], back: NDArray[np.int64]) -> NDArray[np.int64]:
    """Match the sides of triangles.

    Parameters
    ----------
    key : (t, 3) int64
        Of each side, as walked.
    back : (t, 3) int64
        Key of the same side walked the other way.

    Returns
    -------
    twin : (t, 3) int64
        -1 where there is none.
    """
    flat, wanted = key.ravel(), back.ravel()
    order = np.argsort(flat, kind="stable")
    at = np.minimum(np.searchsorted(flat[order], wanted), max(len(flat) - 1, 0))
    if len(flat) == 0:
        return np.zeros((0, 3), np.int64)
    found = order[at]
    return np.where(flat[found] == wanted, found, -1).reshape(key.shape)


def paired(triangles: Triangles, *, share: float, most_rad: float) -> NDArray[np.int64]:
    """Pair triangles into quadrilaterals, squarest first.

    Parameters
    ----------
    triangles : Triangles
        t triangles.
    share : float
        Of the triangles to use up, 0 to 1; around stars it may be more.
    most_rad : float
        Largest deviation of a quadrilateral's angles from a right angle.

    Returns
    -------
    cells : (c, 4) int64
        Particles, counter-clockwise; the fourth is -1 in triangles.
    """
    from surftex.kernels.star_knots import untie_stars
    from surftex.kernels.triangulation import pair_triangles

    count, angle = len(triangles), triangles.angle
    worst = _deviation(triangles, angle)
    least = angle.min(axis=1)
    across = np.where(triangles.twin >= 0, triangles.twin // 3, 0)
    needle = np.minimum(least[:, None], least[across]) < NEEDLE_RAD
    limit = np.where(needle, _NEEDLE_RESORT_RAD, _LAST_RESORT_RAD)
    side = np.flatnonzero(triangles.twin.ravel() > np.arange(3 * count))
    side = side[np.argsort(worst.ravel()[side], kind="stable")]
    mate = np.full(count, -1, np.int64)
    pair_triangles(
        triangles.twin, side, worst.ravel()[side], limit.ravel()[side], least < THIN_RAD, share * count, most_rad, mate
    )  # fmt: skip
    particles = int(triangles.corner.max(initial=-1)) + 1
    start = np.append(0, np.cumsum(np.bincount(triangles.corner.ravel(), minlength=particles)))
    spoke = np.argsort(triangles.corner.ravel(), kind="stable")
    untie_stars(triangles.corner, triangles.twin, angle, worst, limit, mate, start, spoke)
    alone = np.flatnonzero(mate < 0)
    first = np.flatnonzero(mate >= 0)
    first = first[mate[first] // 3 > first]
    other, theirs = mate[first] // 3, mate[first] % 3
    mine = mate[other] % 3
    quads = np.stack(
        [
            triangles.corner[first, mine], triangles.corner[other, (theirs + 2) % 3],
            triangles.corner[first, (mine + 1) % 3], triangles.corner[first, (mine + 2) % 3],
        ],
        axis=1,
    )  # fmt: skip
    lone = np.concatenate([triangles.corner[alone], np.full((len(alone), 1), -1, np.int64)], axis=1)
    return np.concatenate([quads, lone])


def _deviation(triangles: Triangles, angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """(t, 3) largest deviation from right angles of the quadrilateral across each side; inf where there is none."""
    t, i = np.divmod(np.arange(3 * len(triangles)), 3)
    twin = triangles.twin.ravel()
    u, j = np.divmod(np.maximum(twin, 0), 3)
    around = np.stack(
        [
            angle[t, i] + angle[u, (j + 1) % 3], angle[t, (i + 1) % 3] + angle[u, j], angle[t, (i + 2) % 3],
            angle[u, (j + 2) % 3],
        ]
    )  # fmt: skip
    worst = np.abs(around - np.pi / 2).max(axis=0)
    same = triangles.corner[t, (i + 2) % 3] == triangles.corner[u, (j + 2) % 3]
    worst[(twin < 0) | (t == u) | same] = np.inf
    return worst.reshape(-1, 3)


def kept_apart(
    first: NDArray[np.int64],
    second: NDArray[np.int64],
    distance: NDArray[np.float64],
    radius: NDArray[np.float64],
    top: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Leave out the lower of two particles that lie too close, closest first.

    Parameters
    ----------
    first : (p,) int64
        Of each pair.
    second : (p,) int64
        Of each pair.
    distance : (p,) float64
        Between their feet.
    radius : (n,) float64
        Across, where they are long.
    top : (n,) float64
        Height of the top of each.

    Returns
    -------
    kept : (n,) bool
        Whether each stays.
    """
    kept = np.ones(len(radius), bool)
    closeness = distance / np.maximum(radius[first] + radius[second], 1e-300)
    close = np.flatnonzero((closeness < TOO_CLOSE) & (first < second))
    for row in close[np.argsort(closeness[close], kind="stable")]:
        a, b = first[row], second[row]
        if kept[a] and kept[b]:
            kept[a if top[a] < top[b] else b] = False
    return kept
