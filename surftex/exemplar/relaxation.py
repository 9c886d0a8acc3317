"""`Relaxation`: a picture that is drawn again and again, by potentials that follow what its statistics lack.

Learning and synthesis are this one loop. Potentials are never frozen for free synthesis: they are no
equilibrium, and a picture drawn on by frozen ones drifts away from its statistics.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from surftex.exemplar.lattice import Lattice
from surftex.exemplar.measure import distance, measured
from surftex.exemplar.smoothing import NEXT
from surftex.exemplar.target import Target
from surftex.kernels.pool import Tick, slices
from surftex.randomness import Stream, stream

PAIR_RATE, LABEL_RATE, QUAD_RATE = 6.0, 3.0, 4.0
"""How strongly potentials follow; beyond twice as much they overshoot and swing."""

LABEL_PUSH = 30.0
"""Potential of a label that covers all where it shall cover nothing, at once: large fields of labels would drift else."""

_QUAD_SUM = 100.0
"""Quads times their rate, at most."""

_LEAST_SHARE, _FINEST, _LARGEST = 1e-4, 256.0, 32000.0
_SITES = 4096

_MOST_COUNTED = 2**18
"""Sites of one texture that are counted each time: their shares are then known better than potentials need."""


class Relaxation:
    """A picture on a lattice on its way to a target's statistics.

    Parameters
    ----------
    target : Target
        What statistics it shall have.
    lattice : Lattice
        Where.
    level : (c, places) uint8
        The first picture, kept and changed in place.
    random : Stream
        Of the draws.
    group : (places,) uint8, optional
        Label of each place.
    live : (places,) bool, optional
        Places that are drawn; all sites without it.
    threads : int, optional
        None means every core; cannot change a byte.
    """

    def __init__(
        self,
        target: Target,
        lattice: Lattice,
        level: NDArray[np.uint8],
        random: Stream,
        *,
        group: NDArray[np.uint8] | None = None,
        live: NDArray[np.bool_] | None = None,
        threads: int | None = None,
    ) -> None:
        self.lattice, self.level, self.random, self.threads = lattice, level, random, threads
        self.group = np.zeros(lattice.places, np.uint8) if group is None else group
        self.live = live
        self.turn = 0
        self.scale = _FINEST
        self.fresh = level.copy()
        self.single = -np.log(np.maximum(target.single, _LEAST_SHARE)).astype(np.float64)
        self.push = np.zeros_like(self.single)
        self.pair = np.zeros((target.groups + 1, 0, 64))
        self.quad = np.zeros((target.groups, 0, 256))
        self.aim(target)

    def aim(self, target: Target) -> None:
        """Take another target: that of before with more types at its ends.

        Parameters
        ----------
        target : Target
            Potentials of the types that were there before stay.
        """
        self.target = target
        more = len(target.pair_type) - self.pair.shape[1]
        self.pair = np.pad(self.pair, ((0, 0), (0, more), (0, 0)))
        more = len(target.quad_band) - self.quad.shape[1]
        self.quad = np.pad(self.quad, ((0, 0), (0, more), (0, 0)))
        plan = _Plan.of(target)
        self.reach, column = self.lattice.reach(plan.offset)
        self.classes = self.lattice.classes(plan.offset, self.live)
        pair, column = plan.pair.copy(), column.astype(np.uint64)
        pair[:, 1] = column[pair[:, 1]]
        self.plan = replace(plan, pair=pair, near=column[plan.near])

    def take(self, other: "Relaxation") -> None:
        """Take the potentials of another picture of the same target.

        Parameters
        ----------
        other : Relaxation
            On any lattice.
        """
        self.single, self.pair, self.quad = other.single.copy(), other.pair.copy(), other.quad.copy()

    def sweep(self) -> None:
        """Draw every live site once, band by band."""
        from surftex.kernels.gibbs import sample_sites, settle_sites

        target, plan = self.target, self.plan
        table, single, quad, exponential = self._tables()
        step, shift = target.code
        count = len(self.classes)
        key, turn = np.uint64(self.random.key), self.turn
        start = int(self.random.at(np.array([turn]))[0] * count)
        for number in range(count):
            site = self.classes[(start + number) % count]

            def draw(first: int, last: int, site: NDArray[np.int32] = site) -> None:
                sample_sites(
                    first, last, self.level, self.group, target.groups, site, self.reach,
                    self.lattice.follow, plan.pair_start, plan.pair, 2 * len(target.pair_type), table, step,
                    shift, single, plan.near_start, plan.near, plan.role_start, plan.role, quad,
                    target.quarter, exponential, target.levels, key, turn, self.fresh,
                )  # fmt: skip

            slices(draw, len(site), size=_SITES, threads=self.threads)
            settle_sites(0, len(site), site, self.fresh, self.level)
            self.lattice.repeat(self.level)
        self.turn += 1

    def follow(self, rate: float = 1.0) -> tuple[float, float]:
        """Measure, and let the potentials follow.

        Parameters
        ----------
        rate : float
            Factor of all rates.

        Returns
        -------
        pair, quad : float
            Mean distance of the target's types; 0 where it has none.
        """
        target = self.target
        single, pair, quad = measured(
            target, self.lattice, self.level, self.group, site=self._counted(), threads=self.threads
        )
        pace = rate * (LABEL_RATE if target.joint else PAIR_RATE)
        present = single.sum(axis=-1, keepdims=True) > 0
        excess = np.where(present, single - target.single, 0)
        self.single += pace * excess
        if target.joint:
            self.push = LABEL_PUSH * excess
        there = target.pair_used[..., None] & (pair.sum(axis=-1, keepdims=True) > 0)
        self.pair += pace * np.where(there, pair - target.pair, 0)
        fours = target.quad_used[..., None] & (quad.sum(axis=-1, keepdims=True) > 0)
        most = max(1, int(target.quad_used.sum(axis=1).max(initial=0)))
        self.quad += rate * min(QUAD_RATE, _QUAD_SUM / most) * np.where(fours, quad - target.quad, 0)
        return (
            float(distance(pair, target.pair)[there[..., 0]].mean()) if there.any() else 0.0,
            float(distance(quad, target.quad)[fours[..., 0]].mean()) if fours.any() else 0.0,
        )

    def run(
        self, sweeps: int, *, steady: float = 0.5, rate: float = 1.0, tick: Tick | None = None
    ) -> list[tuple[float, float]]:
        """Draw and follow, at a rate that falls after a while.

        Parameters
        ----------
        sweeps : int
            How many.
        steady : float
            Share of them before the rate starts to fall.
        rate : float
            Factor of all rates; halved whenever the distances grow far beyond their best.
        tick : callable, optional
            Told the finished share; may raise to cancel.

        Returns
        -------
        distances : list of (float, float)
            As `follow` returns them.
        """
        course: list[tuple[float, float]] = []
        for number in range(sweeps):
            self.sweep()
            late = max(0.0, number - steady * sweeps)
            course.append(self.follow(rate / (1 + late / 20)))
            if tick:
                tick((number + 1) / sweeps)
            recent = [sum(each) for each in course[-10:]]
            if number >= 20 and min(recent) > 1.5 * min(sum(each) for each in course):
                rate *= 0.5
        return course

    def _counted(self) -> NDArray[np.int32]:
        """Choose the sites to count: all, or of many one from each of as many runs, another each time."""
        site = self.lattice.site
        if self.target.groups > 1 or len(site) <= _MOST_COUNTED:
            return site
        within = stream(self.random.key, "counted", self.turn).uniform(_MOST_COUNTED)[:, 0]
        run = len(site) / _MOST_COUNTED
        return site[((np.arange(_MOST_COUNTED) + within) * run).astype(np.int64)]

    def _tables(self) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        """Potentials in whole numbers, on one scale, and the exponentials of that scale."""
        target, plan = self.target, self.plan
        groups, kinds = self.pair.shape[:2]
        single = self.single + self.push
        single = single - 0.5 * (single.max(axis=-1) + single.min(axis=-1))[..., None]
        inner = self.pair if target.joint else self.pair[..., :63]
        middle = 0.5 * (inner.max(axis=-1) + inner.min(axis=-1))[..., None]
        pair = np.where(target.pair_used[..., None], self.pair - middle, 0.0)
        if not target.joint:
            pair[..., 63] = 0.0
        rows = np.zeros((groups, kinds, 2, 64))
        rows[:, :, 0] = pair
        if target.joint:
            rows[:, :, 1] = pair.reshape(groups, kinds, 8, 8).swapaxes(2, 3).reshape(groups, kinds, 64)
        else:
            rows[:, :, 1, :63] = pair[..., 62::-1]
        fours = plan.role_tables(self.quad)
        there = np.repeat(target.quad_used, 4, axis=1)[:, plan.role_row, None, None]
        fours = np.where(there, fours - fours.min(axis=-1, keepdims=True), 0.0)
        largest = np.abs(single).max(initial=0.0)
        for band in range(target.bands):
            used = plan.pair[plan.pair_start[band] : plan.pair_start[band + 1], 2]
            role = slice(*plan.role_start[band : band + 2])
            most = np.abs(rows.reshape(groups, -1, 64)[:, used]).max(axis=(0, 2), initial=0.0).sum()
            most += fours[:, role].max(axis=(0, 2, 3), initial=0.0).sum()
            largest = max(largest, np.abs(single).max(initial=0.0) + float(most))
        self.scale = scale = min(_FINEST, _LARGEST / max(largest, 1e-9))
        whole = np.rint(scale * fours).astype(np.uint64)
        packed = np.zeros((*fours.shape[:2], 65), np.uint64)
        packed[..., :64] = (whole << (np.uint64(16) * np.arange(4, dtype=np.uint64))).sum(
            axis=-1, dtype=np.uint64
        )
        levels = np.zeros((*single.shape[:2], 32), np.int16)
        levels[..., : target.levels] = np.rint(scale * single)
        exponential = np.exp(-np.arange(4096) / scale).astype(np.float32)
        return np.rint(scale * rows).astype(np.int16).ravel(), levels, packed, exponential


def asked_offsets(target: Target) -> NDArray[np.int32]:
    """List every offset that drawing, measuring and evening out ask a lattice for.

    Parameters
    ----------
    target : Target
        What is to be drawn.

    Returns
    -------
    offset : (e, 2) int32
        Right and down, each once.
    """
    return np.unique(np.concatenate([_Plan.of(target).offset, NEXT, np.zeros((1, 2), np.int32)]), axis=0)


@dataclass(frozen=True, eq=False)
class _Plan:
    """A target's types as the kernel takes them: what each band looks at, and by which row.

    A role is a corner of a quad, seen by the other three; `role_row` tells which: ``4 quad + corner``.
    """

    offset: NDArray[np.int32]
    pair_start: NDArray[np.int64]
    pair: NDArray[np.uint64]
    near_start: NDArray[np.int64]
    near: NDArray[np.uint64]
    role_start: NDArray[np.int64]
    role: NDArray[np.uint64]
    role_row: NDArray[np.int64]

    @staticmethod
    def of(target: Target) -> "_Plan":
        known: dict[tuple[int, int], int] = {}

        def place(right: int, down: int) -> int:
            return known.setdefault((int(right), int(down)), len(known))

        pairs: list[list[tuple[int, int, int]]] = [[] for _ in range(target.bands)]
        for k, (head, tail, right, down) in enumerate(target.pair_type):
            pairs[tail].append((head, place(-right, -down), 2 * k))
            pairs[head].append((tail, place(right, down), 2 * k + 1))
        nears: list[list[int]] = []
        roles: list[list[tuple[int, int, int, int]]] = []
        for band in range(target.bands):
            seen: dict[int, int] = {}
            mine = []
            for j in np.flatnonzero(target.quad_band == band):
                shape = target.quad_shape[j]
                for corner in range(4):
                    others = [
                        seen.setdefault(place(*(shape[i] - shape[corner])), len(seen))
                        for i in range(4) if i != corner
                    ]  # fmt: skip
                    mine.append((others[0], others[1], others[2], 4 * int(j) + corner))
            nears.append(list(seen))
            roles.append(mine)
        near_start, near = _listed([[(each,) for each in some] for some in nears], 1)
        role_start, role = _listed(roles, 4)
        three = (role[:, :3] << np.array([0, 16, 32], np.uint64)).sum(axis=1, dtype=np.uint64)
        return _Plan(
            np.array(list(known), np.int32).reshape(-1, 2),
            *_listed(pairs, 3), near_start, near.ravel(), role_start, three, role[:, 3].astype(np.int64),
        )  # fmt: skip

    def role_tables(self, quad: NDArray[np.float64]) -> NDArray[np.float64]:
        """(g, r, 64, 4): potential of each class at a corner, by the code of the other three in their order."""
        groups, kinds = quad.shape[:2]
        cube = quad.reshape(groups, kinds, 4, 4, 4, 4)
        by_corner = [np.moveaxis(cube, 2 + corner, -1).reshape(groups, kinds, 64, 4) for corner in range(4)]
        return np.stack(by_corner, axis=2).reshape(groups, 4 * kinds, 64, 4)[:, self.role_row]


def _listed(lists: list, width: int) -> tuple[NDArray[np.int64], NDArray[np.uint64]]:
    """Put lists end to end, and say where each starts."""
    start = np.cumsum([0, *map(len, lists)]).astype(np.int64)
    return start, np.array([each for some in lists for each in some], np.uint64).reshape(-1, width)
