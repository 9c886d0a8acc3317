"""`SkinPattern`: a skin placed on a surface, ready to answer at any sample."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.fields.fieldset import FieldSet
from surftex.fields.furrows import FurrowNet
from surftex.fields.profiles import valley, visible
from surftex.materials.layers import Layers
from surftex.materials.skin.baseline import Baseline
from surftex.materials.skin.curves import CurveKind
from surftex.materials.skin.kinds import STATE
from surftex.materials.skin.model import Skin
from surftex.materials.skin.placing import likelihood, tension
from surftex.materials.skin.points import PointKind
from surftex.optics import SkinAppearance, load_table, lookup
from surftex.optics.table import SkinTable, shipped_table
from surftex.randomness import stream
from surftex.surface.points import Samples
from surftex.surface.surface import Surface

Float = NDArray[np.float32]

BIOLOGY = STATE[:6]
"""Entries of the state that are biology: each is a channel of its own."""

CHANNELS = (
    "height_mm", "base_color", "roughness", "specular", "subsurface", "subsurface_radius_mm", *BIOLOGY, "hair", "sebum",
)  # fmt: skip

_STRETCH = 1.2
"""Length of the fields of the skin over their width, at full tension."""

_FURROW_ROUGH, _HAIR_ROUGH = 0.08, 0.45


SHAPING = frozenset(
    {"relief_depth", "relief_width", "relief_secondary", "relief_swell", "sebum_polish", "follicle_color"}
)
"""Parameters that `SkinPattern.shape` reads; all others change the biology, or what is measured."""

KEPT = SHAPING | {
    "melanin", "pheomelanin", "blood", "oxygenation", "stratum_corneum", "epidermis", "variation", "variation_size",
    "mottle", "mottle_size", "drift", "drift_size", "flush", "flush_radius", "flush_where", "tan", "up", "lips_where",
    "lips_blood", "lips_pheomelanin", "lips_epidermis", "mole_irregularity", "freckle_irregularity", "follicle_cover",
    "follicle_height", "follicle_blood", "pore_shade", "pore_sebum", "pock_irregularity", "scar_pallor",
    "scar_irregularity", "vessel_oxygenation", "wrinkle_fold", "wrinkle_fade", "wrinkle_profile", "relief_spacing",
    "relief_where", "sebum", "sebum_where", "relief_tension",
}  # fmt: skip
"""Parameters that move no feature."""


def _carved(skin: Skin) -> bool:
    return skin.relief_depth > 0 or skin.relief_swell > 0 or skin.relief_secondary > 0


@dataclass(frozen=True, eq=False)
class Gathered:
    """Skin at n samples, before its microrelief is carved.

    Attributes
    ----------
    column : dict of str to (n,) float32
        Entries of the state, by name.
    biology : dict of str to (n,) float32
        As `surftex.optics.lookup` takes it.
    appearance : SkinAppearance
        What it answers.
    net : tuple of array, or None
        From `FurrowNet.at`.
    wrinkle : tuple of (n,) float32, or None
        Depth of grooves, and rise of the folds beside them.
    """

    column: Mapping[str, Float]
    biology: Mapping[str, NDArray[Any]]
    appearance: SkinAppearance
    net: tuple[Float, Float, Float] | None
    wrinkle: tuple[Float, Float] | None


@dataclass(frozen=True, eq=False)
class SkinPattern:
    """Skin on a surface; make one with `Skin.place`.

    Attributes
    ----------
    skin : Skin
        What it is like.
    surface : Surface
        Where it lies.
    features : mapping of str to structured array
        Everything placed, by kind.
    table : SkinTable
        Looks by biology.
    """

    skin: Skin
    surface: Surface
    features: Mapping[str, NDArray]
    baseline: Baseline
    points: tuple[PointKind, ...]
    wrinkles: CurveKind | None
    vessels: CurveKind | None
    net: FurrowNet | None
    table: SkinTable

    channels = CHANNELS

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Least and greatest value of each channel of biology that the table knows; beyond, the nearest is shown."""
        ends = {}
        for name in BIOLOGY:
            known = self.table.axes[name.replace("_mm", "_cm")] * (10 if name.endswith("_mm") else 1)
            ends[name] = float(known[0]), float(known[-1])
        return ends

    @staticmethod
    def build(
        skin: Skin,
        surface: Surface,
        seed: int,
        features: Mapping[str, NDArray],
        names: FieldSet,
        threads: int | None = None,
    ) -> "SkinPattern":
        """Flood from features that are placed already.

        Parameters
        ----------
        skin : Skin
            What it is like.
        surface : Surface
            Where it lies.
        seed : int
            Of the noise, the outlines and the furrows.
        features : mapping of str to structured array
            As `SkinPattern.features` has them.
        names : FieldSet
            Named numbers and directions.
        threads : int, optional
            None means every core.

        Returns
        -------
        pattern : SkinPattern
            Ready to answer.
        """
        points = tuple(
            PointKind.build(
                skin, surface, kind, features[kind], likelihood(skin, names, kind),
                stream(seed, "skin", kind, "outline"), threads,
            )
            for kind in skin.order
            if len(features.get(kind, ()))
        )  # fmt: skip
        curves = {
            kind: CurveKind.build(surface, features[kind], profile, threads, fold=fold, fade=fade)
            for kind, profile, fold, fade in (
                ("wrinkle", skin.wrinkle_profile, skin.wrinkle_fold, skin.wrinkle_fade),
                ("vessel", "dome", 0.0, 0.0),
            )
            if len(features.get(kind, ()))
        }
        net = None
        if _carved(skin):
            angle = tension(skin, surface, names).angle_rad
            stretch = 1 + (_STRETCH - 1) * skin.relief_tension
            net = FurrowNet.over(surface, angle, skin.relief_spacing, stretch, stream(seed, "skin", "relief"))
        return SkinPattern(
            skin, surface, MappingProxyType(dict(features)), Baseline.build(skin, surface, seed, names), points,
            curves.get("wrinkle"), curves.get("vessel"), net,
            shipped_table() if skin.table is None else load_table(skin.table),
        )  # fmt: skip

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

    def gather(self, samples: Samples) -> Gathered:
        """Evaluate the biology, and measure the way to furrows and wrinkles: what takes time.

        Parameters
        ----------
        samples : Samples
            n points with their footprints.

        Returns
        -------
        gathered : Gathered
            For `shape`.
        """
        position = samples.points.positions(self.surface)
        state = self.baseline.at(samples, position)
        column = {name: state[:, i] for i, name in enumerate(STATE)}
        if self.vessels is not None:
            added = self.vessels.at(samples)[0]
            column["blood"] += added
            share = added / np.maximum(column["blood"], 1e-9)
            column["oxygenation"] += share * (self.skin.vessel_oxygenation - column["oxygenation"])
        for kind in self.points:
            kind.blend(samples, state)
        net = None
        if self.net is not None and visible(self.skin.relief_spacing, samples.footprint_mm).any():
            net = self.net.at(samples.points, position)
        biology = {
            name.replace("_mm", "_cm"): column[name] / (10 if name.endswith("_mm") else 1) for name in BIOLOGY
        }
        return Gathered(
            column, biology, lookup(biology, table=self.table, threads=1), net,
            None if self.wrinkles is None else self.wrinkles.at(samples),
        )  # fmt: skip

    def shape(self, gathered: Gathered, footprint_mm: Float) -> Layers:
        """Carve furrows and wrinkles, and turn biology into what a renderer is told.

        Parameters
        ----------
        gathered : Gathered
            From `gather`.
        footprint_mm : (n,) float32
            Side of each sample's patch.

        Returns
        -------
        layers : Layers
            The channels named by `channels`.
        """
        column = gathered.column
        height = column["height_mm"].copy()
        furrow = np.zeros(len(height), np.float32)
        if gathered.net is not None:
            furrow, relief = self._relief(gathered.net, footprint_mm)
            height += relief * column["relief"]
        if gathered.wrinkle is not None:
            depth, raised = gathered.wrinkle
            height += raised - depth
        return self._seen(gathered, height, furrow * column["relief"])

    def reshaped(self, skin: Skin) -> "SkinPattern | None":
        """Give the same skin another microrelief, gloss of oil, or colour of hair.

        Parameters
        ----------
        skin : Skin
            What it shall be like.

        Returns
        -------
        pattern : SkinPattern or None
            Whose `shape` takes what this one gathered; None where more than that has changed.
        """
        old, new = self.skin.model_dump(), skin.model_dump()
        if any(new[key] != old[key] for key in new.keys() - SHAPING) or _carved(skin) != _carved(self.skin):
            return None
        return replace(self, skin=skin)

    def keeps(self, skin: Skin) -> bool:
        """Tell whether another skin would have the same features at the same places.

        Parameters
        ----------
        skin : Skin
            With the same seed.

        Returns
        -------
        keeps : bool
            Then `features` need not be placed anew.
        """
        return self.skin.placing() == skin.placing()

    def _relief(self, net: tuple[Float, Float, Float], footprint_mm: Float) -> tuple[Float, Float]:
        """Furrows and fields of the microrelief: how deep in a furrow, and the height in mm."""
        skin, footprint = self.skin, footprint_mm
        shown = visible(skin.relief_spacing, footprint)
        border, along, inner = net
        share = 1 - skin.relief_tension * (1 - along)
        groove = np.maximum(
            *(valley(border[:, i], skin.relief_width, footprint, dimension=1) * share[:, i] for i in (0, 1))
        )
        fine = valley(inner, 0.8 * skin.relief_width, footprint, dimension=1) * (1 - groove)
        t = np.minimum(border.min(axis=1) / (0.5 * skin.relief_spacing), 1)
        height = skin.relief_swell * t * (2 - t) - skin.relief_depth * groove - skin.relief_secondary * fine
        return groove * shown, (height * shown).astype(np.float32)

    def _seen(self, gathered: Gathered, height: Float, furrow: Float) -> Layers:
        """Turn biology into what a renderer is told."""
        skin, column, biology, appearance = self.skin, gathered.column, gathered.biology, gathered.appearance
        clamped = {
            name.replace("_cm", "_mm"): self.table.outside(name, biology[name]) for name in appearance.clamped
        }
        hair = np.clip(column["hair"], 0, 1)
        color = appearance.base_color + hair[:, None] * (
            np.asarray(skin.follicle_color, np.float32) - appearance.base_color
        )
        rough = appearance.roughness * (1 - skin.sebum_polish * column["sebum"]) + _FURROW_ROUGH * furrow
        rough = rough + hair * (_HAIR_ROUGH - rough)
        return Layers(
            {
                "height_mm": height,
                "base_color": np.clip(color, 0, 1).astype(np.float32),
                "roughness": np.clip(rough, 0.04, 1).astype(np.float32),
                "specular": appearance.specular,
                "subsurface": appearance.subsurface_weight * (1 - hair),
                "subsurface_radius_mm": appearance.subsurface_radius_mm,
                **{name: column[name].copy() for name in BIOLOGY},
                "hair": hair,
                "sebum": column["sebum"].copy(),
            },
            clamped,
        )
