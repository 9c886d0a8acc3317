"""`Crossing`: a straight line across a plate, cut where another region begins."""

import numpy as np
from numpy.typing import NDArray

from surftex.geodesics.pieces import CurvePieces

STEPS = 48
"""Places along a line at which the region is asked; the crossing is then narrowed twice by the same number."""

_SHARES = np.linspace(0.0, 1.0, STEPS)

Piece = tuple[int, NDArray[np.float64], NDArray[np.float64]]
"""A face, and a start and an end in its frame."""


class Crossing:
    """A line across a plate: whoever holds it asks for the owners of `asked`, and tells them to `narrow`.

    Parameters
    ----------
    lines : CurvePieces
        Traced lines.
    first : int
        First piece of the line.
    last : int
        One past its last; a line may have none.

    Attributes
    ----------
    regions : (int, int) or None
        Regions on both sides of the cut, ascending; None while the line has met no other region.
    done : bool
        Whether asking more would tell nothing.
    """

    def __init__(self, lines: CurvePieces, first: int, last: int) -> None:
        self.face = lines.face[first:last]
        self.start, self.end = lines.start[first:last], lines.end[first:last]
        self.regions: tuple[int, int] | None = None
        self.done = first == last
        if self.done:
            return
        self.length_mm = np.hypot(*(self.end - self.start).T)
        start = lines.start_mm[first:last]
        self.length = np.append(start, start[-1] + self.length_mm[-1])
        self.low, self.high = 1e-3 * self.length[-1], self.length[-1]

    def asked(self) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        """Choose places along what is left, where the region is to be told.

        Returns
        -------
        face : (STEPS,) int32
            Their faces.
        place : (STEPS, 2) float64
            In the frames of the faces.
        """
        self.far = self.low + _SHARES * (self.high - self.low)
        row = np.searchsorted(self.length[1:-1], self.far, side="right")
        share = np.minimum((self.far - self.length[row]) / np.maximum(self.length_mm[row], 1e-300), 1.0)
        start = self.start[row]
        return self.face[row], start + share[:, None] * (self.end[row] - start)

    def narrow(self, owner: NDArray[np.integer]) -> None:
        """Keep what lies between the last place of the first region and the next.

        Parameters
        ----------
        owner : (STEPS,) int
            Region of each place that was asked for.
        """
        changed = np.flatnonzero(owner[1:] != owner[:-1])
        if len(changed) == 0:
            self.done = True
            return
        at = int(changed[0])
        self.low, self.high = self.far[at], self.far[at + 1]
        low, high = sorted((int(owner[at]), int(owner[at + 1])))
        self.regions = low, high

    def pieces(self) -> list[Piece]:
        """List the line up to the other region, or all of it where there is none.

        Returns
        -------
        pieces : list of Piece
            In walking order.
        """
        if len(self.face) == 0:
            return []
        used = self.high if self.regions is not None else self.length[-1]
        pieces = []
        for i in range(len(self.face)):
            if self.length[i] >= used:
                break
            share = min(1.0, (used - self.length[i]) / max(self.length[i + 1] - self.length[i], 1e-300))
            start = self.start[i]
            pieces.append((int(self.face[i]), start, start + share * (self.end[i] - start)))
        return pieces
