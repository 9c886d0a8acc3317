"""A tile of the plane to grow particles on; what leaves it on one side comes in on the other, so that it tiles."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.features.particle_growth import SLICE, Neighbours, Particles, near_lists
from surftex.kernels.pool import slices
from surftex.surface.points import SurfacePoints

Push = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Force of a field at places (n, 2) of a tile, (n, 3); only x and y count."""

Direction = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Direction at places (n, 2) of a tile, (n,) radians."""


@dataclass(frozen=True, eq=False)
class PlaneGround:
    """A square tile.

    Attributes
    ----------
    side : float
        Of the tile, mm.
    diameter : float
        Of the largest particles, mm.
    aspect : float
        Length of particles over their width.
    direction : callable, optional
        Which way they are long; along x without it.
    field : callable, optional
        What pushes them sideways.
    """

    side: float
    diameter: float
    aspect: float = 1.0
    direction: Direction | None = None
    field: Push | None = None

    @property
    def area(self) -> float:
        """In squares of the diameter; inf where that is beyond all numbers."""
        across = self.side / self.diameter
        return across * across  # ** would raise

    def births(self, numbers: NDArray[np.float64]) -> tuple[NDArray, NDArray, NDArray, NDArray, NDArray]:
        """Where particles are born.

        Parameters
        ----------
        numbers : (n, 3) float64
            In [0, 1).

        Returns
        -------
        face, place, scale, aspect, direction : arrays
            Of n births.
        """
        count = len(numbers)
        place = self.side * numbers[:, :2]
        direction = np.zeros(count) if self.direction is None else self.direction(place)
        return (
            np.zeros(count, np.int32), place, np.full(count, self.diameter), np.full(count, self.aspect), direction,
        )  # fmt: skip

    def points(self, particles: Particles) -> SurfacePoints:
        """Stand in for the feet of particles, which no surface knows.

        Parameters
        ----------
        particles : Particles
            n of them.

        Returns
        -------
        points : SurfacePoints
            n times the first corner of face 0.
        """
        return SurfacePoints.trusted(particles.face, np.tile([1.0, 0.0, 0.0], (len(particles), 1)))

    def push(self, particles: Particles) -> NDArray[np.float64]:
        """Force of the field.

        Parameters
        ----------
        particles : Particles
            n of them.

        Returns
        -------
        push : (n, 3) float64
            Along x and y.
        """
        return np.zeros((len(particles), 3)) if self.field is None else self.field(particles.place)

    def neighbours(
        self, particles: Particles, size: NDArray[np.float64], factor: float, skin: float, threads: int | None
    ) -> Neighbours:
        """List neighbours across the borders too.

        Parameters
        ----------
        particles : Particles
            n of them.
        size : (n,) float64
            Largest semi-axes.
        factor : float
            Pairs count within factor (size_i + size_j) + skin.
        skin : float
            Millimetres.
        threads : int or None
            None means every core.

        Returns
        -------
        near : Neighbours
            Of the n particles.
        """
        margin = min(2 * factor * float(size.max()) + skin, 0.49 * self.side)
        owner, shift = copies(particles.place, self.side, margin)
        position = np.zeros((len(owner), 3))
        position[:, :2] = particles.place[owner] + shift
        position[:, 2] = particles.height[owner]
        return near_lists(position, owner, len(particles), size[owner], factor, skin, threads)

    def move(
        self, particles: Particles, radius: NDArray[np.float64], push: NDArray[np.float64], near: Neighbours,
        law: NDArray[np.float64], step: float, steps: int, threads: int | None,
    ) -> None:  # fmt: skip
        """Advance by the classical Runge-Kutta method of fourth order.

        Parameters
        ----------
        particles : Particles
            Moved in place.
        radius : (n,) float64
            Present radii.
        push : (n, 3) float64
            Force of the field.
        near : Neighbours
            Of the particles.
        law : (4,) float64
            For the kernel.
        step : float
            Time of a step.
        steps : int
            How many.
        threads : int or None
            None means every core.
        """
        from surftex.kernels.particles import plane_forces

        axis = np.stack([np.cos(particles.angle), np.sin(particles.angle)], axis=1)
        place = np.concatenate([particles.place, particles.height[:, None]], axis=1)
        velocity = particles.velocity.copy()
        force = np.zeros_like(place)

        def accelerate(where: NDArray[np.float64], speed: NDArray[np.float64]) -> NDArray[np.float64]:
            slices(
                lambda begin, end: plane_forces(
                    begin, end, where, speed, radius, particles.aspect, axis, particles.scale, push, near.index,
                    near.count, self.side, law, force,
                ),
                len(where), size=SLICE, threads=threads,
            )  # fmt: skip
            return force.copy()

        for _ in range(steps):
            a = accelerate(place, velocity)
            v2 = velocity + 0.5 * step * a
            b = accelerate(place + 0.5 * step * velocity, v2)
            v3 = velocity + 0.5 * step * b
            c = accelerate(place + 0.5 * step * v2, v3)
            v4 = velocity + step * c
            d = accelerate(place + step * v3, v4)
            place = place + step / 6 * (velocity + 2 * v2 + 2 * v3 + v4)
            velocity = velocity + step / 6 * (a + 2 * b + 2 * c + d)
        particles.place[:] = place[:, :2] % self.side
        particles.height[:] = place[:, 2]
        particles.velocity[:] = velocity

    def apart(self, particles: Particles, first: NDArray, second: NDArray) -> NDArray[np.float64]:
        """Distances between the feet of pairs.

        Parameters
        ----------
        particles : Particles
            n of them.
        first : (p,) int
            Of each pair.
        second : (p,) int
            Of each pair.

        Returns
        -------
        distance : (p,) float64
            Millimetres, the short way around the tile.
        """
        step = particles.place[first] - particles.place[second]
        step -= self.side * np.round(step / self.side)
        return np.hypot(step[:, 0], step[:, 1])

    def visible(
        self, particles: Particles, radius: NDArray[np.float64], near: Neighbours, threads: int | None
    ) -> NDArray[np.float64]:
        """Share of each cap that shows from above.

        Parameters
        ----------
        particles : Particles
            n of them.
        radius : (n,) float64
            Present radii.
        near : Neighbours
            Of the particles.
        threads : int or None
            None means every core.

        Returns
        -------
        share : (n,) float64
            0 to 1.
        """
        count = len(particles)
        foot, normal, axis = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 3))
        foot[:, :2] = particles.place
        normal[:, 2] = 1
        axis[:, 0], axis[:, 1] = np.cos(particles.angle), np.sin(particles.angle)
        return shares(particles, radius, near, foot, normal, axis, self.side, threads)


def copies(
    place: NDArray[np.float64], side: float, margin: float
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Repeat what lies near the borders of a tile beyond the opposite ones.

    Parameters
    ----------
    place : (n, 2) float64
        In the tile.
    side : float
        Of the tile.
    margin : float
        How far beyond the borders, less than half a side.

    Returns
    -------
    owner : (a,) int64
        0 to n - 1, then whose copy each further one is.
    shift : (a, 2) float64
        How far it is moved, multiples of the side.
    """
    owner, shift = np.arange(len(place)), np.zeros((len(place), 2))
    for k in (0, 1):
        here = place[owner, k] + shift[:, k]
        for chosen, way in ((here < margin, side), (here >= side - margin, -side)):
            rows = np.flatnonzero(chosen)
            moved = shift[rows].copy()
            moved[:, k] += way
            owner, shift = np.concatenate([owner, owner[rows]]), np.concatenate([shift, moved])
    return owner, shift


def shares(
    particles: Particles,
    radius: NDArray[np.float64],
    near: Neighbours,
    foot: NDArray[np.float64],
    normal: NDArray[np.float64],
    axis: NDArray[np.float64],
    side: float,
    threads: int | None,
) -> NDArray[np.float64]:
    """Share of each cap that no other covers.

    Parameters
    ----------
    particles : Particles
        n of them.
    radius : (n,) float64
        Present radii.
    near : Neighbours
        Of the particles.
    foot : (n, 3) float64
        Places in space.
    normal : (n, 3) float64
        Unit.
    axis : (n, 3) float64
        Unit, along the particles.
    side : float
        Of a tile; inf for none.
    threads : int or None
        None means every core.

    Returns
    -------
    share : (n,) float64
        0 to 1.
    """
    from surftex.kernels.particles import visible_share

    share = np.zeros(len(particles))
    slices(
        lambda begin, end: visible_share(
            begin, end, foot, normal, axis, particles.height, radius, particles.aspect, side, near.index, near.count,
            share,
        ),
        len(particles), size=SLICE, threads=threads,
    )  # fmt: skip
    return share
