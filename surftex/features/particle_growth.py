"""Growing cells: particles are born on a ground, grow, push each other and rise, until they lie packed under a ceiling.

A ground is a tile of the plane that repeats (`surftex.features.growth_plane`) or a surface (`surftex.features.growth_surface`).
All forces of a step read the state before it, and random numbers belong to the number of a birth: the
same particles, to the byte, for any count of threads, and for a growth that was saved and went on later.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError
from surftex.features.growth_law import GrowthLaw
from surftex.kernels.pool import slices
from surftex.randomness import Stream
from surftex.surface.points import SurfacePoints

SLICE = 4096
"""Particles that one call of a kernel looks after."""

ATTRACTED = 1.5
"""How far those that attract each other reach, in sums of their radii."""

_ROOM = 48
_COLUMNS = 8
_SPREAD_RAD = 0.15

Watcher = Callable[["Particles"], None]
"""Told the particles after each generation; may raise to cancel."""


@dataclass(frozen=True, eq=False)
class Particles:
    """n particles after some generation.

    Attributes
    ----------
    generation : int
        How many have passed.
    face : (n,) int32
        Of a surface; 0 in the plane.
    place : (n, 2) float64
        Millimetres: in the frame of the face, or in the tile.
    height : (n,) float64
        Over the ground.
    velocity : (n, 3) float64
        In the frame of the face or of the tile, and upwards.
    angle : (n,) float64
        Of the long axis, in that frame.
    diameter : (n,) float64
        When fully grown.
    scale : (n,) float64
        Diameter of the largest particles thereabouts.
    aspect : (n,) float64
        Length over width.
    born : (n,) int64
        Generation of birth.
    """

    generation: int
    face: NDArray[np.int32]
    place: NDArray[np.float64]
    height: NDArray[np.float64]
    velocity: NDArray[np.float64]
    angle: NDArray[np.float64]
    diameter: NDArray[np.float64]
    scale: NDArray[np.float64]
    aspect: NDArray[np.float64]
    born: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.face)

    @staticmethod
    def none() -> "Particles":
        """Make the beginning of a growth.

        Returns
        -------
        particles : Particles
            No particles, generation 0.
        """
        return Particles(
            0, np.zeros(0, np.int32), np.zeros((0, 2)), np.zeros(0), np.zeros((0, 3)), np.zeros(0), np.zeros(0),
            np.zeros(0), np.zeros(0), np.zeros(0, np.int64),
        )  # fmt: skip

    def radius(self, law: GrowthLaw) -> NDArray[np.float64]:
        """Present radii.

        Parameters
        ----------
        law : GrowthLaw
            Of the growth.

        Returns
        -------
        radius : (n,) float64
            Millimetres.
        """
        return 0.5 * self.diameter * law.grown(np.maximum(self.generation - self.born, 0))

    def chosen(self, rows: NDArray[Any]) -> "Particles":
        """Pick some particles.

        Parameters
        ----------
        rows : (k,) int or (n,) bool
            Which.

        Returns
        -------
        particles : Particles
            Copies.
        """
        return replace(self, **{name: np.ascontiguousarray(getattr(self, name)[rows]) for name in COLUMNS})

    def joined(self, more: "Particles") -> "Particles":
        """Append particles.

        Parameters
        ----------
        more : Particles
            Of the same generation.

        Returns
        -------
        particles : Particles
            All.
        """
        return replace(
            self, **{name: np.concatenate([getattr(self, name), getattr(more, name)]) for name in COLUMNS}
        )


COLUMNS = ("face", "place", "height", "velocity", "angle", "diameter", "scale", "aspect", "born")
"""Arrays of `Particles`."""


class Ground(Protocol):
    """What particles grow on."""

    @property
    def area(self) -> float:
        """In squares of the local diameter."""
        ...

    def points(self, particles: Particles) -> SurfacePoints:
        """Feet of particles; in the plane they all lie on face 0."""
        ...

    def births(self, numbers: NDArray[np.float64]) -> tuple[NDArray, NDArray, NDArray, NDArray, NDArray]:
        """Face, place, scale, aspect and direction of births, from (n, 3) numbers in [0, 1)."""
        ...

    def push(self, particles: Particles) -> NDArray[np.float64]:
        """Force of the field on each particle, (n, 3)."""
        ...

    def neighbours(
        self, particles: Particles, size: NDArray[np.float64], factor: float, skin: float, threads: int | None
    ) -> "Neighbours":
        """Who is within factor (size_i + size_j) + skin of whom."""
        ...

    def move(
        self, particles: Particles, radius: NDArray[np.float64], push: NDArray[np.float64], near: "Neighbours",
        law: NDArray[np.float64], step: float, steps: int, threads: int | None,
    ) -> None:  # fmt: skip
        """Advance the particles in place."""
        ...

    def apart(self, particles: Particles, first: NDArray, second: NDArray) -> NDArray[np.float64]:
        """Distances between the feet of pairs, (p,)."""
        ...

    def visible(
        self, particles: Particles, radius: NDArray[np.float64], near: "Neighbours", threads: int | None
    ) -> NDArray[np.float64]:
        """Share of each particle's cap that shows from above, (n,)."""
        ...


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Lists of neighbours.

    Attributes
    ----------
    count : (n,) int64
        How many each particle has.
    index : (n, room) int32
        Who they are, the first `count` of each row.
    """

    count: NDArray[np.int64]
    index: NDArray[np.int32]


def grow(
    ground: Ground,
    law: GrowthLaw,
    random: Stream,
    *,
    start: Particles | None = None,
    until: int | None = None,
    most: int = 5_000_000,
    threads: int | None = None,
    watch: Watcher | None = None,
) -> Particles:
    """Let particles grow.

    Parameters
    ----------
    ground : Ground
        What they grow on.
    law : GrowthLaw
        How.
    random : Stream
        Of the births.
    start : Particles, optional
        Go on from these; from nothing without them.
    until : int, optional
        Stop after so many generations; the law's own number without it.
    most : int
        Refuse to give birth to more.
    threads : int, optional
        None means every core; cannot change the result.
    watch : callable, optional
        Told the particles after each generation; may raise to cancel.

    Returns
    -------
    particles : Particles
        After the last generation.

    Raises
    ------
    InputError
        If there would be more than `most` births.
    """
    from surftex.features.growth_law import STEP, STEPS

    if (expected := law.total_births(ground.area)) > most:
        raise InputError(
            f"{expected:.0f} particles would be born, more than the {most} allowed; make cells larger, "
            "or raise max_features (--max-features)"
        )
    constants = np.array([2 * law.damping, law.attraction, law.rise, law.ceiling])
    particles = Particles.none() if start is None else start
    end = law.generations if until is None else min(until, law.generations)
    while particles.generation < end:
        particles = _next_generation(ground, law, random, particles)
        particles = particles.chosen(np.arange(len(particles)))  # who was told of the last ones may hold them
        if len(particles):
            radius = particles.radius(law)
            size = radius * np.sqrt(np.maximum(particles.aspect, 1 / particles.aspect))
            factor = ATTRACTED if law.attraction > 0 else 1.0
            near = ground.neighbours(particles, size, factor, 0.1 * float(particles.scale.max()), threads)
            ground.move(particles, radius, ground.push(particles), near, constants, STEP, STEPS, threads)
        if watch is not None:
            watch(particles)
    return particles


def _next_generation(ground: Ground, law: GrowthLaw, random: Stream, particles: Particles) -> Particles:
    """Add the births of the next generation, and take the dead away."""
    generation = particles.generation
    first, last = law.born(generation, ground.area)
    if last > first:
        numbers = random.uniform(last - first, _COLUMNS, first=first)
        face, place, scale, aspect, direction = ground.births(numbers[:, :3])
        normal = np.sqrt(-2 * np.log(1 - numbers[:, 3])) * np.cos(2 * np.pi * numbers[:, 4])
        turn = np.sqrt(-2 * np.log(1 - numbers[:, 5])) * np.cos(2 * np.pi * numbers[:, 6])
        count = last - first
        particles = particles.joined(
            Particles(
                generation, face, place, np.zeros(count), np.zeros((count, 3)), direction + _SPREAD_RAD * turn,
                scale * law.final_share(generation, normal), scale, aspect, np.full(count, generation, np.int64),
            )
        )  # fmt: skip
    particles = replace(particles, generation=generation + 1)
    alive = particles.generation - particles.born <= law.life
    return particles if alive.all() else particles.chosen(alive)


def on_top(
    ground: Ground, law: GrowthLaw, particles: Particles, *, least: float = 0.35, threads: int | None = None
) -> NDArray[np.int64]:
    """Find the particles that make the surface of the layer.

    Parameters
    ----------
    ground : Ground
        What they grow on.
    law : GrowthLaw
        How they grew.
    particles : Particles
        n of them.
    least : float
        Share of a particle's cap that must show.
    threads : int, optional
        None means every core.

    Returns
    -------
    rows : (k,) int64
        Ascending.
    """
    if len(particles) == 0:
        return np.zeros(0, np.int64)
    radius = particles.radius(law)
    size = radius * np.sqrt(np.maximum(particles.aspect, 1 / particles.aspect))
    above = float(np.ptp(particles.height))  # covers need not touch
    near = ground.neighbours(particles, size, 1.0, above, threads)
    return np.flatnonzero(ground.visible(particles, radius, near, threads) >= least)


def near_lists(
    position: NDArray[np.float64],
    owner: NDArray[np.int64],
    count: int,
    size: NDArray[np.float64],
    factor: float,
    skin: float,
    threads: int | None,
) -> Neighbours:
    """List neighbours by a grid in space.

    Parameters
    ----------
    position : (a, 3) float64
        The particles, then copies of some.
    owner : (a,) int64
        Whose copy each is.
    count : int
        Particles, without copies.
    size : (a,) float64
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
        Of the particles.
    """
    from surftex.kernels.particles import near_particles

    side = max(2 * factor * float(size.max()) + skin, 1e-300)
    low = position.min(axis=0)
    cells = np.floor((position - low) / side).astype(np.int64) + 1
    wide = cells.max(axis=0) + 2
    stride = np.array([wide[1] * wide[2], wide[2]])
    cell = cells @ np.array([stride[0], stride[1], 1])
    order = np.argsort(cell, kind="stable")
    key = cell[order]
    numbers, room = np.zeros(count, np.int64), _ROOM
    while True:
        index = np.zeros((count, room), np.int32)

        def work(begin: int, end: int, index: NDArray[np.int32] = index) -> None:
            near_particles(
                begin, end, position, size, factor, skin, cell, key, order, owner, stride, numbers, index
            )

        slices(work, count, size=SLICE, threads=threads)
        if numbers.max() <= room:
            return Neighbours(numbers, index)
        room = int(1.25 * numbers.max()) + 1
