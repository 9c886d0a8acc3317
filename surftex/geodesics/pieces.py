"""`CurvePieces`: curves on a surface as straight pieces, each inside one face.

The pieces of one curve are contiguous, in order, and each starts where the one before it ends (across an
edge, in the frame of the next face).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, frozen
from surftex.errors import SurfaceError
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface


@dataclass(frozen=True, eq=False)
class CurvePieces:
    """Straight pieces of curves, p of them.

    Attributes
    ----------
    face : (p,) int32
        Face that a piece lies in.
    start : (p, 2) float64
        Its start, mm in the frame of its face.
    end : (p, 2) float64
        Its end, mm in the frame of its face.
    curve : (p,) int32
        Curve that it belongs to; pieces of one curve are contiguous, and the numbers never fall.
    start_mm : (p,) float64
        Length of the curve before the piece.
    """

    face: NDArray[np.int32]
    start: NDArray[np.float64]
    end: NDArray[np.float64]
    curve: NDArray[np.int32]
    start_mm: NDArray[np.float64]

    @staticmethod
    def of(face: ArrayLike, start: ArrayLike, end: ArrayLike, curve: ArrayLike) -> "CurvePieces":
        """Check the arrays, measure the lengths, freeze all.

        Parameters
        ----------
        face : (p,) int
            Face of each piece.
        start : (p, 2) float
            Starts, mm in the frame of the face.
        end : (p, 2) float
            Ends, mm in the frame of the face.
        curve : (p,) int
            Curve of each piece, never falling.

        Returns
        -------
        pieces : CurvePieces
            With `start_mm` summed along each curve.

        Raises
        ------
        SurfaceError
            If shapes differ or the pieces of a curve are not contiguous.
        """
        faces = checked(face, "face", (None,), np.int32, error=SurfaceError)
        count = len(faces)
        starts = checked(start, "start", (count, 2), np.float64, error=SurfaceError)
        ends = checked(end, "end", (count, 2), np.float64, error=SurfaceError)
        curves = checked(curve, "curve", (count,), np.int32, error=SurfaceError)
        falls = np.flatnonzero(np.diff(curves) < 0)
        if len(falls):
            at = int(falls[0])
            raise SurfaceError(
                f"curve numbers fall at {len(falls)} pieces; the first is piece {at + 1}, of curve "
                f"{curves[at + 1]} after curve {curves[at]}. Sort the pieces by curve"
            )
        length = np.hypot(*(ends - starts).T) if count else np.zeros(0)
        before = np.concatenate([[0.0], np.cumsum(length)])[:-1] if count else np.zeros(0)
        if count:
            first = np.concatenate([[True], np.diff(curves) > 0])
            before = before - before[np.flatnonzero(first)][np.cumsum(first) - 1]
        return CurvePieces(
            frozen(faces.copy()),
            frozen(starts.copy()),
            frozen(ends.copy()),
            frozen(curves.copy()),
            frozen(np.maximum(before, 0.0)),
        )

    @staticmethod
    def joined(parts: Sequence["CurvePieces"]) -> "CurvePieces":
        """Put sets of curves behind one another; the curves of later sets are numbered on.

        Parameters
        ----------
        parts : sequence of CurvePieces
            Any number of sets.

        Returns
        -------
        pieces : CurvePieces
            All of them.
        """
        if not parts:
            return CurvePieces.of(
                np.zeros(0, np.int32), np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0, np.int32)
            )
        offset, curves = 0, []
        for part in parts:
            curves.append(part.curve + np.int32(offset))
            offset += part.curve_count
        return CurvePieces(
            frozen(np.concatenate([part.face for part in parts])),
            frozen(np.concatenate([part.start for part in parts])),
            frozen(np.concatenate([part.end for part in parts])),
            frozen(np.concatenate(curves).astype(np.int32)),
            frozen(np.concatenate([part.start_mm for part in parts])),
        )

    def __len__(self) -> int:
        return len(self.face)

    @property
    def curve_count(self) -> int:
        """One more than the highest curve number."""
        return int(self.curve[-1]) + 1 if len(self) else 0

    @property
    def length_mm(self) -> NDArray[np.float64]:
        """(p,) length of each piece."""
        return np.hypot(self.end[:, 0] - self.start[:, 0], self.end[:, 1] - self.start[:, 1])

    @property
    def curve_length_mm(self) -> NDArray[np.float64]:
        """(curve_count,) length of each curve; 0 for a number without pieces."""
        return np.bincount(self.curve, self.length_mm, minlength=self.curve_count).astype(
            np.float64, copy=False
        )

    def selected(self, curves: ArrayLike) -> "CurvePieces":
        """Keep some curves, renumbered from 0 in the order of their numbers.

        Parameters
        ----------
        curves : (c,) int
            Numbers of the curves to keep.

        Returns
        -------
        pieces : CurvePieces
            Their pieces.
        """
        kept = np.unique(np.asarray(curves, np.int64))
        rows = np.isin(self.curve, kept)
        return CurvePieces(
            frozen(self.face[rows]),
            frozen(self.start[rows]),
            frozen(self.end[rows]),
            frozen(np.searchsorted(kept, self.curve[rows]).astype(np.int32)),
            frozen(self.start_mm[rows]),
        )

    def points(self, surface: Surface, share: ArrayLike = 0.0) -> SurfacePoints:
        """Places on the pieces.

        Parameters
        ----------
        surface : Surface
            Where the curves lie.
        share : float or (p,) float
            How far along each piece, 0 at its start and 1 at its end.

        Returns
        -------
        points : SurfacePoints
            One on each piece.
        """
        along = np.broadcast_to(np.asarray(share, np.float64), (len(self),))[:, None]
        place = self.start + along * (self.end - self.start)
        return SurfacePoints.trusted(self.face, barycentric_of(surface, self.face, place))


def barycentric_of(
    surface: Surface, face: NDArray[np.int32], flat: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Weights of the corners for places given in the frame of a face.

    Parameters
    ----------
    surface : Surface
        Where the places lie.
    face : (n,) int32
        Their faces.
    flat : (n, 2) float64
        Millimetres in the frame of the face.

    Returns
    -------
    barycentric : (n, 3) float64
        At least 0, with sum 1: a place outside by rounding is moved onto the face.
    """
    corner = surface.flat[face]
    third = flat[:, 1] / corner[:, 2, 1]
    second = (flat[:, 0] - third * corner[:, 2, 0]) / corner[:, 1, 0]
    weights = np.clip(np.stack([1 - second - third, second, third], axis=1), 0.0, 1.0)
    return weights / weights.sum(axis=1, keepdims=True)
