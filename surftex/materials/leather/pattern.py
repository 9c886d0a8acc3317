"""`LeatherPattern`: a leather placed on a surface, ready to answer at any sample."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError
from surftex.features.curves import curve_pieces, drawn
from surftex.fields.noise import Noise, several
from surftex.fields.profiles import smoothstep
from surftex.geodesics.buckets import Buckets
from surftex.geodesics.curves import flood_curves
from surftex.geodesics.records import Records
from surftex.geodesics.windows import flood_points, nearest
from surftex.materials.grooves import Line, lines_at
from surftex.materials.layers import Layers
from surftex.materials.leather.cells import Cells
from surftex.materials.leather.model import Leather
from surftex.materials.leather.relief import Skeleton, layers
from surftex.randomness import stream
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.surface import Surface

CHANNELS = ("height_mm", "base_color", "roughness", "specular", "region")

SHAPING = frozenset({
    "crista_height", "crista_exponent", "variation", "sulcus_depth", "sulcus_width", "sulcus_variation", "wrinkle_depth",
    "wrinkle_width", "wrinkle_fold", "pocket_depth", "pocket_width", "pore_depth", "pore_width", "crown_height",
    "crown_width", "crown_pit_depth", "crown_pit_width", "scale_overlap", "grain_height", "color", "furrow_color",
    "crest_color", "dye", "pore_dye", "wear", "mottle", "cell_tone", "roughness", "furrow_roughness", "crest_roughness",
    "specular",
})  # fmt: skip
"""Parameters that `LeatherPattern.shape` reads; all others move elements, or what is measured of them."""

_SWITCHES = frozenset({"sulcus_variation", "wrinkle_fold", "pocket_depth", "scale_overlap", "grain_height"})
"""Those of which zero and more than zero are two things to gather."""

PLACING = (
    "cell_size", "size_variation", "cell_ratio", "direction", "cell_shape", "regularity", "invasion", "invasion_mode",
    "stress", "wrinkle_count", "wrinkle_density", "wrinkle_length", "wrinkle_angle", "wrinkle_curves", "pore_density",
    "pore_group", "pore_spread", "crown_spacing",
)  # fmt: skip
"""Parameters that decide where elements are; so do `pocket_depth` and `scale_overlap`, by being zero or not."""

_WIDTHS = frozenset({"sulcus_width", "wrinkle_width", "pocket_width", "pore_width", "crown_width"})

LEAST_IN_ROWS = 80
"""Cells on a body, for rows to be seen: on a ball with 54 there are none, with 105 there are some."""

_BODY = 0.01
"""Share of the area from which on a body is looked at."""

_FLOODED = 1.5
"""How far elements are flooded, in widths."""

_CROWN_SPREAD = 0.25
"""How much crowns differ in size, either way."""

_NOISES: tuple[str, ...] = ("wave a", "wave b", "grain", "mottle")

_WAVE = 2.7
"""Noise has an rms of 0.31; a waviness of 0.1 shall move borders by about a tenth of a cell at most places."""


@dataclass(frozen=True, eq=False)
class LeatherPattern:
    """Leather on a surface; make one with `Leather.place`.

    Attributes
    ----------
    leather : Leather
        What it is like.
    surface : Surface
        Where it lies.
    features : mapping of str to structured array
        Everything placed, by kind: ``cell``, ``crack``, ``wrinkle``, ``pocket``, ``pore``, ``crown``.
    """

    leather: Leather
    surface: Surface
    features: Mapping[str, NDArray]
    cells: Cells
    curves: Mapping[str, Any]
    points: Mapping[str, Any]
    seed: int

    channels = CHANNELS

    @staticmethod
    def build(
        leather: Leather,
        surface: Surface,
        seed: int,
        features: Mapping[str, NDArray],
        records: Records | None = None,
        threads: int | None = None,
    ) -> "LeatherPattern":
        """Flood from features that are placed already.

        Parameters
        ----------
        leather : Leather
            What it is like.
        surface : Surface
            Where it lies.
        seed : int
            Of the noise and of what differs from cell to cell.
        features : mapping of str to structured array
            As `LeatherPattern.features` has them.
        records : Records, optional
            From `surftex.materials.leather.cells.flood_cells`, if that is done already.
        threads : int, optional
            None means every core.

        Returns
        -------
        pattern : LeatherPattern
            Ready to answer.

        Raises
        ------
        RecipeError
            If there is no cell.
        """
        if len(features["cell"]) == 0:
            raise RecipeError(
                "the features hold no cell, and leather is made of cells; were they placed by another recipe?"
            )
        curves, points = {}, {}
        for kind, width in (
            ("crack", leather.sulcus_width),
            ("wrinkle", leather.wrinkle_width),
        ):
            if kind in features and len(features[kind]):
                table = features[kind]
                if kind == "wrinkle":
                    width = max(width, float(drawn(table, "width_mm").max()))
                    width *= 3 if leather.wrinkle_fold else 1
                buckets = Buckets.of(surface, width)
                curves[kind] = flood_curves(
                    surface, curve_pieces(surface, table), _FLOODED * width, buckets=buckets, threads=threads
                )
        for kind, width in (
            ("pocket", leather.pocket_width),
            ("pore", leather.pore_width),
            ("crown", leather.crown_width * (1 + _CROWN_SPREAD)),
        ):
            if kind in features and len(features[kind]):
                table = features[kind]
                where = SurfacePoints.trusted(
                    np.ascontiguousarray(table["face"]), np.ascontiguousarray(table["barycentric"])
                )
                points[kind] = flood_points(surface, where, _FLOODED * width, threads=threads)
        return LeatherPattern(
            leather, surface, MappingProxyType(dict(features)),
            Cells.build(leather, surface, features["cell"], stream(seed, "leather", "borders"), records, threads),
            MappingProxyType(curves), MappingProxyType(points), seed,
        )  # fmt: skip

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the reader of a report should know."""
        if self.leather.cell_shape != "box":
            return ()
        surface, count = self.surface, int(self.surface.component.max()) + 1
        share = np.bincount(surface.component, surface.face_area_mm2, count) / surface.area_mm2
        cells = np.bincount(surface.component[self.features["cell"]["face"]], minlength=count)
        small = (share >= _BODY) & (cells < LEAST_IN_ROWS)
        if not small.any():
            return ()
        held = f"the mesh holds only {cells[0]}"
        if count > 1:
            held = f"{small.sum()} of {count} bodies hold no more than {cells[small].max()}"
        return (
            f"cell_shape box lays cells in rows, and {held} of them, too few for rows; it takes {LEAST_IN_ROWS} or more: "
            "lower cell_size",
        )

    def at(self, samples: Samples) -> Layers:
        """Evaluate at samples.

        Parameters
        ----------
        samples : Samples
            n points with their footprints.

        Returns
        -------
        layers : Layers
            The channels named by `channels`.
        """
        return self.shape(self.gather(samples), samples.footprint_mm)

    def gather(self, samples: Samples) -> Skeleton:
        """Measure the way to the nearest element of each kind: what takes time, and no depth or colour changes.

        Parameters
        ----------
        samples : Samples
            n points with their footprints.

        Returns
        -------
        skeleton : Skeleton
            For `shape`.
        """
        leather, points, footprint = self.leather, samples.points, samples.footprint_mm
        position = points.positions(self.surface)
        noise, wave = self._noises(position, footprint), _WAVE * leather.waviness
        plates = self.cells.at(leather, points, (wave * noise["wave a"], wave * noise["wave b"]))
        cell = np.maximum(plates.own, 0)
        numbers = self._cell_numbers
        crown_mm, crown_scale = self._nearest_crown(points)
        return Skeleton(
            plates=plates,
            cell_mm=self.cells.size_mm[cell].astype(np.float32),
            level=numbers[cell, 0],
            tone=numbers[cell, 1],
            cracks=self._lines("crack", points),
            wrinkles=self._lines("wrinkle", points),
            pocket_mm=self._nearest_point("pocket", points),
            pore_mm=self._nearest_point("pore", points),
            crown_mm=crown_mm,
            crown_scale=crown_scale,
            grain=noise["grain"],
            mottle=noise["mottle"],
        )

    def shape(self, skeleton: Skeleton, footprint_mm: NDArray[np.float32]) -> Layers:
        """Turn distances into channels.

        Parameters
        ----------
        skeleton : Skeleton
            From `gather`.
        footprint_mm : (n,) float32
            Side of each sample's patch.

        Returns
        -------
        layers : Layers
            The channels named by `channels`.
        """
        return layers(self.leather, skeleton, footprint_mm)

    def reshaped(self, leather: Leather) -> "LeatherPattern | None":
        """Give the same elements other depths, widths and colours.

        Parameters
        ----------
        leather : Leather
            What they shall be like.

        Returns
        -------
        pattern : LeatherPattern or None
            Whose `shape` takes what this one gathered; None where more than that has changed, or where elements
            have become wider than they were flooded.
        """
        old, new = self.leather.model_dump(), leather.model_dump()
        changed = {key for key in new if new[key] != old[key]}
        if not changed <= SHAPING:
            return None
        if any(bool(old[key]) != bool(new[key]) for key in changed & _SWITCHES):
            return None
        if bool(leather.mottle + leather.wear) != bool(self.leather.mottle + self.leather.wear):
            return None
        wider = any(new[key] > _FLOODED * old[key] for key in changed & _WIDTHS)
        return None if wider else replace(self, leather=leather)

    def keeps(self, leather: Leather) -> bool:
        """Tell whether another leather would have the same elements at the same places.

        Parameters
        ----------
        leather : Leather
            With the same seed.

        Returns
        -------
        keeps : bool
            Then `features` need not be placed anew.
        """
        return self.leather.placing() == leather.placing()

    @cached_property
    def _cell_numbers(self) -> NDArray[np.float32]:
        """Two random numbers of each cell."""
        return (
            stream(self.seed, "leather", "cell").uniform(len(self.features["cell"]) + 1, 2).astype(np.float32)
        )

    @cached_property
    def _crown_scale(self) -> NDArray[np.float32]:
        """Size of each crown, 1 on average."""
        numbers = stream(self.seed, "leather", "crown size").uniform(len(self.features["crown"]))[:, 0]
        return (1 + _CROWN_SPREAD * (2 * numbers - 1)).astype(np.float32)

    @cached_property
    def _shown_noises(self) -> dict[str, Noise]:
        """Noise of each use that a leather has."""
        leather = self.leather
        size = 1.3 * self.cells.median_mm
        uses = {
            "wave a": (size, leather.waviness),
            "wave b": (size, leather.waviness),
            "grain": (leather.grain_size, leather.grain_height),
            "mottle": (leather.mottle_size, leather.mottle + leather.wear),
        }
        return {
            name: Noise(stream(self.seed, "leather", name), size_mm, 2)
            for name, (size_mm, amount) in uses.items()
            if amount > 0
        }

    def _noises(
        self, position: NDArray[np.float64], footprint_mm: NDArray[np.float32]
    ) -> dict[str, NDArray[np.float32]]:
        """Noise of each use, 0 where there is none of it."""
        values: dict[str, NDArray[np.float32]] = dict.fromkeys(_NOISES, np.zeros(len(position), np.float32))
        if shown := self._shown_noises:
            values |= zip(shown, several(tuple(shown.values()), position, footprint_mm), strict=True)
        return values

    def _lines(self, kind: str, points: SurfacePoints) -> tuple[Line, ...]:
        """Find the nearest lines of a kind; none where there are none."""
        if kind not in self.curves:
            return ()
        taper = self.leather.crack_taper if kind == "crack" else self.leather.wrinkle_taper

        def share(along: NDArray[np.float64], length: NDArray[np.float64]) -> NDArray[np.float32]:
            if kind == "crack":
                left = 2 * (1 - along / length) if taper else np.ones(len(along))
            elif taper > 0:
                left = np.minimum(along, length - along) / np.minimum(taper, length / 2)
            else:
                left = np.ones(len(along))
            return smoothstep(0.0, 1.0, left.astype(np.float32))

        return lines_at(self.curves[kind], points, self.features[kind], share)

    def _nearest_point(self, kind: str, points: SurfacePoints) -> NDArray[np.float32] | None:
        if kind not in self.points:
            return None
        return nearest(self.points[kind], points, 1, threads=1)[1][:, 0].astype(np.float32)

    def _nearest_crown(self, points: SurfacePoints) -> tuple[Any, Any]:
        if "crown" not in self.points:
            return None, None
        crown, distance = nearest(self.points["crown"], points, 1, threads=1)
        return distance[:, 0].astype(np.float32), self._crown_scale[np.maximum(crown[:, 0], 0)]
