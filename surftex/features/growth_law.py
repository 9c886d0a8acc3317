"""How particles are born, grow, push and die: the constants of a growth, and the curves they stand for.

After a Japanese report on leather texture from particle simulation and metaballs; mass and stiffness of
particles are 1, lengths are told in diameters of the largest particle, times in generations of three steps of 0.35.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

STEPS = 3
"""Steps in a generation."""

STEP = 0.35
"""Length of a step, in units of sqrt(mass / stiffness)."""

_EULER = 0.5772156649015329


@dataclass(frozen=True)
class GrowthLaw:
    """Constants of a growth.

    Attributes
    ----------
    generations : int
        After which it ends.
    births : float
        First rate, per generation and per square of the diameter.
    births_end : float
        Generation at which the rate has fallen to 1 / e of that.
    ageing : float
        How fast it falls: the exponent of the double exponential, per generation.
    smallest : float
        Final size of the last born, as a share of the first born's.
    variation : float
        Standard deviation of the final size, as a share of it.
    growth : float
        Rate at which a particle reaches its final size, per generation.
    life : int
        Generations after which a particle dies.
    damping : float
        Share of the critical damping of a pair.
    attraction : float
        Share of the pull between particles that do not touch.
    rise : float
        Force upwards, in stiffness times diameter.
    ceiling : float
        Height of the layer, in diameters.
    """

    generations: int = 140
    births: float = 0.048
    births_end: float = 45.0
    ageing: float = 0.12
    smallest: float = 0.5
    variation: float = 0.15
    growth: float = 0.08
    life: int = 200
    damping: float = 0.7
    attraction: float = 0.0
    rise: float = 0.025
    ceiling: float = 1.2

    def rate(self, generation: int) -> float:
        """Births in a generation, as a share of the first rate.

        Parameters
        ----------
        generation : int
            From 0.

        Returns
        -------
        share : float
            1 at first, 1 / e at `births_end`, 0 in the end: a metabolism that ages.
        """
        return float(np.exp(-np.exp(np.clip(self.ageing * (generation - self.births_end), -50, 50))))

    def born(self, generation: int, area: float) -> tuple[int, int]:
        """Numbers of the particles that are born in a generation.

        Parameters
        ----------
        generation : int
            From 0.
        area : float
            Of the ground, in squares of the diameter.

        Returns
        -------
        first : int
            Number of the first.
        last : int
            One past the last; fractions are kept for the next generation.
        """
        rates = np.array([self.rate(each) for each in range(generation + 1)])
        sums = np.floor(self.births * area * np.concatenate([[0.0], np.cumsum(rates)]) + 1e-9).astype(int)
        return int(sums[-2]), int(sums[-1])

    def total_births(self, area: float) -> float:
        """Births of an endless growth, in closed form.

        Parameters
        ----------
        area : float
            Of the ground, in squares of the diameter.

        Returns
        -------
        births : float
            Right where the rate is near 1 at first.
        """
        return self.births * area * (self.births_end - _EULER / self.ageing)

    def mean_life(self) -> float:
        """Tell for how many generations particles move, until the growth ends or they die.

        Returns
        -------
        generations : float
            The mean of all births; 0 of a growth without any.
        """
        generation = np.arange(self.generations)
        rate = np.array([self.rate(int(each)) for each in generation])
        lived = np.minimum(self.generations - generation, self.life)
        return float((rate * lived).sum() / max(rate.sum(), 1e-300))

    def final_share(self, generation: int, normal: NDArray[np.float64]) -> NDArray[np.float64]:
        """Tell the final diameter of particles, as a share of the largest.

        Parameters
        ----------
        generation : int
            In which they are born.
        normal : (n,) float64
            Normal numbers.

        Returns
        -------
        share : (n,) float64
            Smaller for later ones, so that they fill gaps.
        """
        size = self.smallest + (1 - self.smallest) * self.rate(generation)
        return size * np.clip(1 + self.variation * normal, 0.4, 1.8)

    def grown(self, age: NDArray[np.integer]) -> NDArray[np.float64]:
        """Share of its final size that a particle has reached.

        Parameters
        ----------
        age : (n,) int
            Generations since birth.

        Returns
        -------
        share : (n,) float64
            0 to 1.
        """
        return 1 - np.exp(-self.growth * age)
