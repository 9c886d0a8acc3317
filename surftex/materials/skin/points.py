"""Point features of one kind on a surface: flooded once, then blended into the state of any samples."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen, read_only_view
from surftex.features.uniform import area_points
from surftex.fields.sources import Field, span_of
from surftex.fields.splines import disc_moments
from surftex.geodesics.reaching import Reaching
from surftex.geodesics.windows import buckets_for, flood_points
from surftex.materials.skin.kinds import KINDS, STATE, Change
from surftex.materials.skin.model import Skin
from surftex.randomness import Stream, stream
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.surface import Surface

_RULES = {"add": 1, "lessen": 2, "cover": 3}
_WAVES = np.array([0.22, 0.22, 0.15, 0.15, 0.08, 0.08])
_WAVE_REACH = float(np.hypot(*_WAVES.reshape(3, 2).T).sum())
_VARIANCE = 1 / 12
_PLACES = 65536
"""Where a likelihood is looked at for its mean."""

_SPACINGS, _RADII = 0.35, 3.0
"""Single features fade from footprints of this share of their mean spacing on, or of this many radii."""


@dataclass(frozen=True, eq=False)
class PointKind:
    """The features of one kind; make it with `PointKind.build`.

    Attributes
    ----------
    name : str
        One of `KINDS`.
    reaching : Reaching
        What reaches which part of the surface.
    size : (f, 4) float32
        Radius, length over width, cosine and sine of the long axis.
    outline : (f, 6) float32
        Waves of the outline.
    amount : (f, c) float32
        What each changes.
    changes : tuple of Change
        c changes.
    table : (c, p) float32
        Their profiles.
    turned : bool
        Whether directions matter.
    spread : float
        Squared radius that a squared footprint adds.
    finest_mm : float
        Footprint from which on single features fade into their mean.
    mean : (c,) float64
        Mean of each change, in mm^2, where there is one feature to the mm^2.
    where : Field or None
        How likely they are.
    per_mm2 : float
        Features per mm^2 where they are likeliest.
    """

    name: str
    reaching: Reaching
    size: NDArray[np.float32]
    outline: NDArray[np.float32]
    amount: NDArray[np.float32]
    changes: tuple[Change, ...]
    table: NDArray[np.float32]
    turned: bool
    spread: float
    finest_mm: float
    mean: NDArray[np.float64]
    where: Field | None
    per_mm2: float

    @staticmethod
    def build(
        skin: Skin,
        surface: Surface,
        name: str,
        features: NDArray,
        where: Field | None,
        random: Stream,
        threads: int | None,
    ) -> "PointKind":
        """Flood from features that are placed.

        Parameters
        ----------
        skin : Skin
            What they are like.
        surface : Surface
            Where they lie.
        name : str
            Their kind.
        features : (f,) structured array
            As `surftex.materials.skin.placing.place` writes them; f > 0.
        where : Field, optional
            How likely they are at points.
        random : Stream
            Of their outlines.
        threads : int, optional
            None means every core.

        Returns
        -------
        kind : PointKind
            Ready to be asked.
        """
        kind, count = KINDS[name], len(features)
        changes = tuple(change for change in kind.changes(skin) if change.amount != 0)
        lean, uneven = max(kind.lean(skin), 1.0), kind.irregularity(skin)
        radius = features["radius_mm"].astype(np.float64)
        angle = features["angle_rad"] if "angle_rad" in (features.dtype.names or ()) else np.zeros(count)
        size = np.stack([radius, np.full(count, lean), np.cos(angle), np.sin(angle)], axis=1)
        amount = np.stack(
            [
                features[change.amount].astype(np.float64)
                if isinstance(change.amount, str)
                else np.full(count, float(change.amount))
                for change in changes
            ],
            axis=1,
        )
        outline = uneven * _WAVES * (2 * random.uniform(count, 6) - 1) if uneven else np.zeros((count, 6))
        moments = [disc_moments(change.table) for change in changes]
        spread = _VARIANCE / max(np.mean([variance for _, variance in moments]), 1e-3)
        power = skin.freckle_gather if name == "freckle" else 1.0
        likely = _mean_likelihood(surface, where, power, stream(random.key, "likelihood"))
        where = None if where is None else _powered(where, power)
        per_mm2 = count / (surface.area_mm2 * likely)
        finest = min(_SPACINGS / np.sqrt(per_mm2), _RADII * float(radius.mean()))
        reach = np.sqrt((radius * np.sqrt(lean) * (1 + _WAVE_REACH * uneven)) ** 2 + spread * finest**2)
        points = SurfacePoints.trusted(
            np.ascontiguousarray(features["face"]), np.ascontiguousarray(features["barycentric"])
        )
        buckets = buckets_for(surface, reach)
        records = flood_points(surface, points, reach, buckets=buckets, threads=threads)
        volume = np.array([each for each, _ in moments])
        return PointKind(
            name, Reaching.of(records), frozen(size.astype(np.float32)), frozen(outline.astype(np.float32)),
            frozen(amount.astype(np.float32)), changes, frozen(np.stack([change.table for change in changes])),
            lean != 1 or uneven > 0, float(spread), float(finest), volume * (amount * radius[:, None] ** 2).mean(axis=0),
            where, per_mm2,
        )  # fmt: skip

    def blend(self, samples: Samples, state: NDArray[np.float32]) -> None:
        """Change the state of samples, in place.

        Parameters
        ----------
        samples : Samples
            n points with their footprints.
        state : (n, s) float32
            Entries in the order of `STATE`.
        """
        from surftex.kernels.blend import blend_points

        channel = np.array([STATE.index(change.channel) for change in self.changes], np.int64)
        rule = np.array([_RULES[change.rule] for change in self.changes], np.int64)
        footprint = read_only_view(samples.footprint_mm, np.float32)
        blend_points(
            0, len(samples), *self.reaching.place(samples.points), self.reaching.records.limit_mm, footprint,
            self.size, self.outline, self.amount, frozen(channel), frozen(rule), frozen(np.arange(len(channel))),
            int(self.turned), self.spread, self.finest_mm, self.table, state,
        )  # fmt: skip
        self._blend_mean(samples, channel, rule, state)

    def _blend_mean(
        self, samples: Samples, channel: NDArray, rule: NDArray, state: NDArray[np.float32]
    ) -> None:
        """Where footprints are too large for single features, change the state by their mean."""
        coarse = np.flatnonzero(samples.footprint_mm > self.finest_mm)
        if not len(coarse):
            return
        fine = np.clip(2 - samples.footprint_mm[coarse] / self.finest_mm, 0, 1)
        density = np.full(len(coarse), self.per_mm2)
        if self.where is not None:
            points = samples.points
            chosen = SurfacePoints.trusted(points.face[coarse], points.barycentric[coarse])
            density *= self.where(chosen, samples.footprint_mm[coarse])
        share = (1 - fine * fine * (3 - 2 * fine)) * density
        for j, k in enumerate(channel):
            amount = share * self.mean[j]
            if rule[j] == _RULES["add"]:
                state[coarse, k] += amount
            elif rule[j] == _RULES["lessen"]:
                state[coarse, k] *= np.exp(-amount)
            else:
                state[coarse, k] = 1 - (1 - state[coarse, k]) * np.exp(-amount)


def _powered(where: Field, power: float) -> Field:
    return lambda points, footprint_mm=0.0: np.maximum(where(points, footprint_mm), 0.0) ** power


def _mean_likelihood(surface: Surface, where: Field | None, power: float, random: Stream) -> float:
    """Mean of the power of a likelihood over the surface, above 0; from places spread by what the spans allow."""
    if where is None:
        return 1.0
    high = span_of(where, surface)[1]
    top = np.maximum(np.where(np.isfinite(high), high, 1.0), 0.0) ** power
    bound = float((surface.face_area_mm2 * top).sum())
    if bound == 0:
        return 1.0
    numbers = random.uniform(_PLACES, 3)
    numbers[:, 0] = (np.arange(_PLACES) + numbers[:, 0]) / _PLACES
    places = area_points(surface, numbers, top)
    share = np.maximum(where(places), 0.0) ** power / top[places.face]
    return bound / surface.area_mm2 * max(float(share.mean()), 1 / _PLACES)
