"""A growth as it looks on its way: the caps of its particles, seen from above, on a tile or on a surface."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.features.growth_law import GrowthLaw
from surftex.geodesics.buckets import Buckets
from surftex.geodesics.records import Records
from surftex.geodesics.windows import flood_points, within
from surftex.materials.cells.skeleton import particles_of
from surftex.materials.layers import Layers
from surftex.randomness import stream
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.surface import Surface

YOUNG = np.array([0.60, 0.33, 0.17], np.float32)
OLD = np.array([0.26, 0.10, 0.045], np.float32)
GROUND = np.array([0.055, 0.028, 0.018], np.float32)
_OLD_AGE = 60.0


@dataclass(frozen=True, eq=False)
class Caps:
    """Present shapes of n particles.

    Attributes
    ----------
    radius, height, aspect, angle, scale : (n,) float64
        Of the particles.
    color : (n, 3) float32
        Young ones are pale.
    """

    radius: NDArray[np.float64]
    height: NDArray[np.float64]
    aspect: NDArray[np.float64]
    angle: NDArray[np.float64]
    scale: NDArray[np.float64]
    color: NDArray[np.float32]

    @staticmethod
    def of(table: NDArray, law: GrowthLaw) -> "Caps":
        """Read particles.

        Parameters
        ----------
        table : (n,) structured array
            Features of the kind ``particle``.
        law : GrowthLaw
            Of their growth.

        Returns
        -------
        caps : Caps
            Of all.
        """
        particles = particles_of(table)
        age = np.clip((particles.generation - particles.born) / _OLD_AGE, 0, 1)[:, None]
        own = 1 + 0.16 * (2 * stream(0, "cells", "caps").uniform(len(table), 1) - 1)
        color = (YOUNG + (OLD - YOUNG) * age) * own
        return Caps(
            np.maximum(particles.radius(law), 1e-9), particles.height, particles.aspect, particles.angle,
            particles.scale, color.astype(np.float32),
        )  # fmt: skip

    @property
    def reach(self) -> NDArray[np.float64]:
        """(n,) largest semi-axes."""
        return self.radius * np.sqrt(np.maximum(self.aspect, 1 / self.aspect))

    def seen(self, start: NDArray[np.int64], who: NDArray[np.integer], vector: NDArray[np.float64]) -> Layers:
        """Look down at samples.

        Parameters
        ----------
        start : (k + 1,) int64
            Sample i has the candidates start[i] to start[i + 1].
        who : (e,) int
            Particles.
        vector : (e, 2) float64
            From the foot of each to the sample, in the frame in which its angle is told.

        Returns
        -------
        layers : Layers
            ``height_mm``, ``base_color`` and ``roughness``; the ground where no particle is.
        """
        count = len(start) - 1
        sample = np.repeat(np.arange(count), np.diff(start))
        turned = np.cos(self.angle[who]), np.sin(self.angle[who])
        along = vector[:, 0] * turned[0] + vector[:, 1] * turned[1]
        across = vector[:, 1] * turned[0] - vector[:, 0] * turned[1]
        stretch = np.sqrt(self.aspect[who])
        square = ((along / stretch) ** 2 + (across * stretch) ** 2) / self.radius[who] ** 2
        top = np.where(
            square < 1, self.height[who] + self.radius[who] * np.sqrt(np.maximum(1 - square, 0)), -np.inf
        )
        order = np.lexsort((-top, sample))
        first = order[np.diff(sample[order], prepend=-1) > 0]
        first = first[np.isfinite(top[first])]
        height, color = np.zeros(count), np.tile(GROUND, (count, 1))
        found = sample[first]
        height[found] = top[first]
        color[found] = self.color[who[first]]
        share = np.clip(height / (1.6 * self.scale.max(initial=1e-9)), 0, 1)
        color *= (0.45 + 0.55 * share)[:, None]  # what lies deep is dark
        return Layers(
            {
                "height_mm": height.astype(np.float32),
                "base_color": color.astype(np.float32),
                "roughness": np.full(count, 0.5, np.float32),
            }
        )


@dataclass(frozen=True, eq=False)
class GrowthPattern:
    """A growth on a surface, at one moment.

    Attributes
    ----------
    features : mapping of str to structured array
        ``particle``.
    """

    surface: Surface
    features: Mapping[str, NDArray]
    caps: Caps
    records: Records | None

    channels = ("height_mm", "base_color", "roughness")

    @staticmethod
    def of(surface: Surface, table: NDArray, law: GrowthLaw, threads: int | None = None) -> "GrowthPattern":
        """Flood from the feet of particles.

        Parameters
        ----------
        surface : Surface
            Where they grow.
        table : (n,) structured array
            Features of the kind ``particle``.
        law : GrowthLaw
            Of their growth.
        threads : int, optional
            None means every core.

        Returns
        -------
        pattern : GrowthPattern
            Ready to be asked.
        """
        caps = Caps.of(table, law)
        records = None
        if len(table):
            feet = SurfacePoints.trusted(
                np.ascontiguousarray(table["face"]), np.ascontiguousarray(table["barycentric"])
            )
            buckets = Buckets.of(surface, float(np.median(caps.reach)))
            records = flood_points(surface, feet, caps.reach, buckets=buckets, threads=threads)
        return GrowthPattern(surface, {"particle": table}, caps, records)

    def at(self, samples: Samples) -> Layers:
        """Evaluate at samples.

        Parameters
        ----------
        samples : Samples
            n points.

        Returns
        -------
        layers : Layers
            The channels named by `channels`.
        """
        if self.records is None:
            return self.caps.seen(
                np.zeros(len(samples) + 1, np.int64), np.zeros(0, np.int32), np.zeros((0, 2))
            )
        start, who, _, vector = within(self.records, samples.points, threads=1)
        return self.caps.seen(start, who, vector)


def tile_growth(
    table: NDArray, law: GrowthLaw, side_mm: float, resolution: int
) -> dict[str, NDArray[np.float32]]:
    """Look down at a growth on a tile.

    Parameters
    ----------
    table : (n,) structured array
        Features of the kind ``particle``.
    law : GrowthLaw
        Of their growth.
    side_mm : float
        Of the tile.
    resolution : int
        Texels along a side; row 0 is at the top.

    Returns
    -------
    channels : dict of str to (h, w) or (h, w, 3) float32
        As `GrowthPattern.channels`.
    """
    from scipy.spatial import KDTree

    caps = Caps.of(table, law)
    line = (np.arange(resolution) + 0.5) * side_mm / resolution
    place = np.stack(np.meshgrid(line, line[::-1]), axis=2).reshape(-1, 2)
    tree: Any = KDTree(place, boxsize=side_mm)
    foot = table["place_mm"] % side_mm
    rows = tree.query_ball_point(foot, np.minimum(caps.reach, 0.49 * side_mm))
    who = np.repeat(np.arange(len(table)), [len(row) for row in rows])
    sample = np.concatenate([np.zeros(0, np.int64), *[np.asarray(row, np.int64) for row in rows]])
    order = np.lexsort((who, sample))
    sample, who = sample[order], who[order]
    vector = place[sample] - foot[who]
    vector -= side_mm * np.round(vector / side_mm)
    layers = caps.seen(np.searchsorted(sample, np.arange(len(place) + 1)).astype(np.int64), who, vector)
    return {
        name: each.reshape(resolution, resolution, *each.shape[1:]) for name, each in layers.channels.items()
    }
