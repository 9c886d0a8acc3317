"""Landmarks: what is drawn around the places of one body is carried to another by the same places picked there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, frozen
from surftex.errors import SurfaceError

LEAST = 4
"""Landmarks that a warp takes, not all on one line."""

_FIRM = 1e-9


@dataclass(frozen=True, eq=False)
class Warp:
    """A map of space: a similarity, bent so that landmarks meet; far from them the similarity alone remains.

    Attributes
    ----------
    scale : float
        Of the similarity.
    turn : (3, 3) float64
        Its rotation.
    shift : (3,) float64
        Its translation.
    centre : (k, 3) float64
        Landmarks that are carried, in the space they come from.
    weight : (k, 3) float64
        Of their bends.
    reach : float
        Distance over which a bend falls to 1 / e, in that space.
    """

    scale: float
    turn: NDArray[np.float64]
    shift: NDArray[np.float64]
    centre: NDArray[np.float64]
    weight: NDArray[np.float64]
    reach: float

    @staticmethod
    def between(source: ArrayLike, target: ArrayLike) -> "Warp":
        """Find the warp that carries landmarks to landmarks.

        Parameters
        ----------
        source : (k, 3) float
            Landmarks, k >= 4.
        target : (k, 3) float
            The same ones elsewhere.

        Returns
        -------
        warp : Warp
            The similarity of least squares [1]_, and exponential bends for what is left.

        Raises
        ------
        SurfaceError
            If they are too few, lie on one line, or coincide.

        References
        ----------
        .. [1] Umeyama. Least-squares estimation of transformation parameters between two point patterns. IEEE PAMI 13
           (1991).
        """
        here = checked(source, "source", (None, 3), np.float64)
        there = checked(target, "target", (len(here), 3), np.float64)
        if len(here) < LEAST:
            raise SurfaceError(f"{len(here)} landmarks are too few; pick at least {LEAST}")
        middle, goal = here.mean(axis=0), there.mean(axis=0)
        spread = np.linalg.svd(here - middle, compute_uv=False), np.linalg.svd(there - goal, compute_uv=False)
        if min(each[1] / max(each[0], 1e-300) for each in spread) < 1e-3:
            raise SurfaceError("the landmarks lie on one line; pick some beside it")
        left, size, right = np.linalg.svd((there - goal).T @ (here - middle))
        sign = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
        turn = left * sign @ right
        scale = float((size * sign).sum() / ((here - middle) ** 2).sum())
        shift = goal - scale * turn @ middle
        gaps = np.linalg.norm(here[:, None] - here[None], axis=2)
        if gaps[np.triu_indices(len(here), 1)].min() < 1e-6 * gaps.max():
            raise SurfaceError("two landmarks lie on one place; pick each where it belongs")
        reach = 0.5 * float(gaps.max())
        rest = there - (scale * here @ turn.T + shift)
        bend = np.exp(-gaps / reach)
        bend[np.diag_indices(len(here))] += _FIRM
        return Warp(
            scale,
            frozen(turn),
            frozen(shift),
            frozen(here.copy()),
            frozen(np.linalg.solve(bend, rest)),
            reach,
        )

    def __call__(self, places: ArrayLike) -> NDArray[np.float64]:
        """Carry places.

        Parameters
        ----------
        places : (n, 3) float
            In the space of the sources.

        Returns
        -------
        places : (n, 3) float64
            In that of the targets.
        """
        points = np.asarray(places, np.float64)
        carried = self.scale * points @ self.turn.T + self.shift
        for centre, weight in zip(self.centre, self.weight, strict=True):
            away = np.sqrt(((points - centre) ** 2).sum(axis=1))
            carried += np.exp(-away / self.reach)[:, None] * weight
        return carried

    def steepness(self, places: ArrayLike, around: ArrayLike) -> NDArray[np.float64]:
        """Bound how much longer short ways become near places.

        Parameters
        ----------
        places : (n, 3) float
            In the space of the sources.
        around : (n,) float
            How far around each.

        Returns
        -------
        most : (n,) float64
            Times the length of any way within that distance.
        """
        points, room = np.asarray(places, np.float64), np.asarray(around, np.float64)
        most = np.full(len(points), self.scale)
        for centre, weight in zip(self.centre, self.weight, strict=True):
            away = np.maximum(np.sqrt(((points - centre) ** 2).sum(axis=1)) - room, 0)
            most += np.exp(-away / self.reach) * (np.linalg.norm(weight) / self.reach)
        return most
