"""A surface to grow particles on: they slide from tangent plane to tangent plane, and never reach through thin parts."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.features.growth_plane import shares
from surftex.features.particle_growth import SLICE, Neighbours, Particles, near_lists
from surftex.features.uniform import area_points
from surftex.geodesics.directions import DirectionField
from surftex.geodesics.pieces import barycentric_of
from surftex.kernels.pool import slices
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

Number = float | Callable[[SurfacePoints], NDArray[np.floating]]
"""A number, or one for each of some points."""

Push = Callable[[SurfacePoints], NDArray[np.float64]]
"""Force of a field at points, (n, 3) in space."""


@dataclass(frozen=True, eq=False)
class SurfaceGround:
    """A surface.

    Attributes
    ----------
    surface : Surface
        m faces.
    diameter : float or callable
        Of the largest particles, mm.
    aspect : float or callable
        Length of particles over their width.
    direction : DirectionField, optional
        Which way they are long.
    field : callable, optional
        What pushes them sideways.
    """

    surface: Surface
    diameter: Number
    aspect: Number = 1.0
    direction: DirectionField | None = None
    field: Push | None = None

    @cached_property
    def _face_diameter(self) -> NDArray[np.float64]:
        count = len(self.surface.faces)
        if not callable(self.diameter):
            return frozen(np.full(count, float(self.diameter)))
        middle = SurfacePoints.trusted(np.arange(count, dtype=np.int32), np.full((count, 3), 1 / 3))
        return frozen(np.asarray(self.diameter(middle), np.float64))

    @property
    def area(self) -> float:
        """In squares of the local diameter; inf where that is beyond all numbers."""
        with np.errstate(divide="ignore", over="ignore"):
            return float((self.surface.face_area_mm2 / self._face_diameter**2).sum())

    def births(self, numbers: NDArray[np.float64]) -> tuple[NDArray, NDArray, NDArray, NDArray, NDArray]:
        """Where particles are born: uniform by area over the square of the local diameter.

        Parameters
        ----------
        numbers : (n, 3) float64
            In [0, 1).

        Returns
        -------
        face, place, scale, aspect, direction : arrays
            Of n births.
        """
        points = area_points(self.surface, numbers, self._face_diameter**-2.0)
        direction = np.zeros(len(points)) if self.direction is None else self.direction.at(points)
        scale, aspect = (_of(value, points) for value in (self.diameter, self.aspect))
        return points.face, points.flat(self.surface), scale, aspect, direction

    def points(self, particles: Particles) -> SurfacePoints:
        """Feet of particles.

        Parameters
        ----------
        particles : Particles
            n of them.

        Returns
        -------
        points : SurfacePoints
            n points.
        """
        weights = np.maximum(barycentric_of(self.surface, particles.face, particles.place), 0)
        return SurfacePoints.trusted(particles.face.copy(), weights / weights.sum(axis=1, keepdims=True))

    def push(self, particles: Particles) -> NDArray[np.float64]:
        """Force of the field.

        Parameters
        ----------
        particles : Particles
            n of them.

        Returns
        -------
        push : (n, 3) float64
            In space.
        """
        return np.zeros((len(particles), 3)) if self.field is None else self.field(self.points(particles))

    def settled(
        self, particles: Particles, threads: int | None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Where particles are in space.

        Parameters
        ----------
        particles : Particles
            n of them.
        threads : int or None
            None means every core.

        Returns
        -------
        foot, normal, axis : (n, 3) float64
            Place on the surface, smooth normal, and the direction in which the particle is long.
        """
        count = len(particles)
        placed = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 3))
        self._settle(particles, placed, threads)
        return placed

    def _settle(
        self, particles: Particles, placed: tuple[NDArray, NDArray, NDArray], threads: int | None
    ) -> None:
        from surftex.kernels.particles_surface import settle

        surface = self.surface
        mesh = surface.faces, surface.vertices, surface.vertex_normal, surface.frame, surface.flat
        slices(
            lambda begin, end: settle(
                begin, end, *mesh, particles.face, particles.place, particles.angle, *placed
            ),
            len(particles), size=SLICE, threads=threads,
        )  # fmt: skip

    def neighbours(
        self, particles: Particles, size: NDArray[np.float64], factor: float, skin: float, threads: int | None
    ) -> Neighbours:
        """List neighbours that can be walked to.

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
        from surftex.kernels.particles_surface import keep_walkable

        count = len(particles)
        foot, normal, _ = self.settled(particles, threads)
        near = near_lists(foot, np.arange(count), count, size, factor, skin, threads)
        mesh = surface_walk(self.surface)
        more = self.surface.frame, self.surface.component, self.surface.vertices, self.surface.faces
        slices(
            lambda begin, end: keep_walkable(
                begin, end, *mesh, *more, particles.face, particles.place, foot, normal, near.count, near.index
            ),
            count, size=SLICE, threads=threads,
        )  # fmt: skip
        return near

    def move(
        self, particles: Particles, radius: NDArray[np.float64], push: NDArray[np.float64], near: Neighbours,
        law: NDArray[np.float64], step: float, steps: int, threads: int | None,
    ) -> None:  # fmt: skip
        """Advance by the semi-implicit method of Euler: stages of a better one would need transport between planes.

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
        from surftex.kernels.particles_surface import move_particles, surface_forces

        count = len(particles)
        placed = foot, normal, axis = self.settled(particles, threads)
        onward = np.zeros((count, 3))
        mesh = surface_walk(self.surface)
        state = particles.face, particles.place, particles.height, particles.velocity, particles.angle
        for number in range(steps):
            slices(
                lambda begin, end: surface_forces(
                    begin, end, self.surface.frame, particles.face, foot, normal, axis, particles.height,
                    particles.velocity, radius, particles.aspect, particles.scale, push, near.index, near.count, law, step,
                    onward,
                ),
                count, size=SLICE, threads=threads,
            )  # fmt: skip
            slices(
                lambda begin, end: move_particles(begin, end, *mesh, step, onward, *state),
                count, size=SLICE, threads=threads,
            )  # fmt: skip
            if number + 1 < steps:
                self._settle(particles, placed, threads)

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
            Millimetres, straight through space.
        """
        foot = self.points(particles).positions(self.surface)
        return np.linalg.norm(foot[first] - foot[second], axis=1)

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
        return shares(particles, radius, near, *self.settled(particles, threads), np.inf, threads)


def surface_walk(surface: Surface) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """Collect what a walk over edges reads.

    Parameters
    ----------
    surface : Surface
        Where to walk.

    Returns
    -------
    flat, neighbor, neighbor_edge, transport : arrays
        As `Surface` has them.
    """
    return surface.flat, surface.neighbor, surface.neighbor_edge, surface.transport


def _of(value: Number, points: SurfacePoints) -> NDArray[np.float64]:
    if callable(value):
        return np.asarray(value(points), np.float64)
    return np.full(len(points), float(value))
