"""Points on a surface, and samples: points that know how large a piece of it they stand for."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, frozen, read_only_view
from surftex.errors import SurfaceError
from surftex.surface.surface import Surface


@dataclass(frozen=True, eq=False, init=False)
class SurfacePoints:
    """Places on a surface.

    Parameters
    ----------
    face : (n,) int
        Face of each point.
    barycentric : (n, 3) float
        Weights of the face's corners; at least -1e-6, with a sum of 1.

    Raises
    ------
    SurfaceError
        If shapes differ, or a weight is no weight.
    """

    face: NDArray[np.int32]
    barycentric: NDArray[np.float64]

    def __init__(self, face: ArrayLike, barycentric: ArrayLike) -> None:
        faces = checked(face, "face", (None,), np.int32, error=SurfaceError)
        weights = checked(barycentric, "barycentric", (len(faces), 3), np.float64, error=SurfaceError)
        wrong = np.flatnonzero((weights < -1e-6).any(axis=1) | (np.abs(weights.sum(axis=1) - 1) > 1e-6))
        if len(wrong):
            first = int(wrong[0])
            raise SurfaceError(
                f"{len(wrong)} of {len(faces)} barycentric rows are no weights with sum 1; "
                f"the first is row {first} = {weights[first].tolist()}"
            )
        object.__setattr__(self, "face", frozen(faces.copy()))
        object.__setattr__(self, "barycentric", frozen(weights.copy()))

    @staticmethod
    def trusted(face: NDArray[np.int32], barycentric: NDArray[np.float64]) -> "SurfacePoints":
        """Wrap arrays that surftex itself made, without checks or copies.

        Parameters
        ----------
        face : (n,) int32
            Face of each point.
        barycentric : (n, 3) float64
            Weights with sum 1.

        Returns
        -------
        points : SurfacePoints
            Sharing the arrays.
        """
        points = object.__new__(SurfacePoints)
        object.__setattr__(points, "face", face)
        object.__setattr__(points, "barycentric", barycentric)
        return points

    def __len__(self) -> int:
        return len(self.face)

    def taken(self, rows: NDArray[np.integer]) -> "SurfacePoints":
        """Take some of the points.

        Parameters
        ----------
        rows : (k,) int
            Which, in any order.

        Returns
        -------
        taken : SurfacePoints
            k points.
        """
        return SurfacePoints.trusted(
            np.ascontiguousarray(self.face[rows]), np.ascontiguousarray(self.barycentric[rows])
        )

    def check_on(self, surface: Surface) -> None:
        """Refuse faces that the surface does not have.

        Parameters
        ----------
        surface : Surface
            Where the points should lie.

        Raises
        ------
        SurfaceError
            Naming the first face outside.
        """
        wrong = np.flatnonzero((self.face < 0) | (self.face >= len(surface.faces)))
        if len(wrong):
            raise SurfaceError(
                f"{len(wrong)} of {len(self)} points lie on faces outside 0..{len(surface.faces) - 1}; "
                f"the first is point {int(wrong[0])} on face {int(self.face[wrong[0]])}"
            )

    def flat(self, surface: Surface) -> NDArray[np.float64]:
        """Coordinates in the frame of each point's face.

        Parameters
        ----------
        surface : Surface
            Where the points lie.

        Returns
        -------
        flat : (n, 2) float64
            Millimetres.
        """
        return np.einsum("pk,pki->pi", self.barycentric, surface.flat[self.face])

    def positions(self, surface: Surface) -> NDArray[np.float64]:
        """Places in space.

        Parameters
        ----------
        surface : Surface
            Where the points lie.

        Returns
        -------
        positions : (n, 3) float64
            Millimetres, in the frame of `Surface.vertices`.
        """
        from surftex.kernels.barycentric import interpolate

        result = np.zeros((len(self), 3))
        face, weight = read_only_view(self.face, np.int32), read_only_view(self.barycentric, np.float64)
        interpolate(face, weight, surface.faces, surface.vertices, result)
        return result


@dataclass(frozen=True, eq=False)
class Samples:
    """Where a pattern is asked: points, each standing for a patch of the surface.

    Attributes
    ----------
    points : SurfacePoints
        n points.
    footprint_mm : (n,) float32
        Side of the patch: detail that is finer fades.
    """

    points: SurfacePoints
    footprint_mm: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.points)

    def part(self, first: int, last: int) -> "Samples":
        """Take a slice of the samples.

        Parameters
        ----------
        first : int
            First sample.
        last : int
            One past the last.

        Returns
        -------
        samples : Samples
            Views, no copies.
        """
        return Samples(
            SurfacePoints.trusted(self.points.face[first:last], self.points.barycentric[first:last]),
            self.footprint_mm[first:last],
        )

    def taken(self, rows: NDArray[np.integer]) -> "Samples":
        """Pick samples.

        Parameters
        ----------
        rows : (k,) int
            Which ones, in any order.

        Returns
        -------
        samples : Samples
            k samples.
        """
        from surftex.kernels.rows import take_samples

        count = len(rows)
        face, weight = np.zeros(count, np.int32), np.zeros((count, 3))
        footprint = np.zeros(count, np.float32)
        take_samples(
            read_only_view(rows, np.int32),
            read_only_view(self.points.face, np.int32),
            read_only_view(self.points.barycentric, np.float64),
            read_only_view(self.footprint_mm, np.float32),
            face,
            weight,
            footprint,
        )
        return Samples(SurfacePoints.trusted(face, weight), footprint)
