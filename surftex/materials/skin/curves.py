"""Curves of one kind on a surface: flooded once, then every curve that reaches a sample creases it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen, read_only_view
from surftex.features.curves import closed, curve_pieces
from surftex.fields.splines import Profile, profile_table
from surftex.geodesics.curves import flood_curves
from surftex.geodesics.reaching import Reaching
from surftex.geodesics.records import CurveRecords
from surftex.surface.points import Samples
from surftex.surface.surface import Surface

_VARIANCE = 1 / 12
_FOLD = 3.0
"""Width of a fold, in widths of its groove."""


@dataclass(frozen=True, eq=False)
class CurveKind:
    """The curves of one kind; make it with `CurveKind.build`.

    Attributes
    ----------
    records : CurveRecords
        What was flooded.
    reaching : Reaching
        What reaches which part of the surface.
    curve : (c, 6) float64
        Length, half width, depth, height of the fold, its side, and whether it is closed, of each curve.
    table : (2, p) float32
        Profiles of groove and fold.
    fade : float
        Power of the taper by which the depth shrinks with the width.
    spread : float
        Squared width that a squared footprint adds.
    """

    records: CurveRecords
    reaching: Reaching
    curve: NDArray[np.float64]
    table: NDArray[np.float32]
    fade: float
    spread: float

    @staticmethod
    def build(
        surface: Surface,
        features: NDArray,
        profile: Profile,
        threads: int | None,
        *,
        fold: float = 0.0,
        fade: float = 0.0,
    ) -> "CurveKind":
        """Flood from curves that are placed.

        Parameters
        ----------
        surface : Surface
            Where they lie.
        features : (p,) structured array
            See `surftex.materials.skin.lines.LINE`; p > 0.
        profile : Profile
            Of the groove, from its floor to its rim.
        threads : int, optional
            None means every core.
        fold : float
            Height of the fold, as a share of the depth.
        fade : float
            Power of the taper by which the depth shrinks with the width.

        Returns
        -------
        kind : CurveKind
            Ready to be asked.
        """
        features = features[np.argsort(features["curve"], kind="stable")]
        count = int(features["curve"].max()) + 1
        curve = np.zeros((count, 6))
        who = features["curve"]
        for i, column in enumerate(("length_mm", "width_mm", "depth_mm")):
            curve[who, i] = np.maximum(features[column], 1e-9)
        curve[:, 3] = fold * curve[:, 2]
        curve[who, 4], curve[who, 5] = features["side"], closed(features)
        table = np.stack([profile_table(profile), profile_table("fold")])
        x = np.linspace(0, 1, table.shape[1])
        spread = _VARIANCE / max(float((x * x * table[0]).sum() / table[0].sum()), 1e-3)
        width = np.maximum(curve[:, 1], 1e-9)
        reach = np.sqrt(((_FOLD if fold > 0 else 1.0) * width) ** 2 + spread * width**2)
        records = flood_curves(surface, curve_pieces(surface, features), reach, threads=threads)
        return CurveKind(records, Reaching.of(records), frozen(curve), frozen(table), fade, spread)

    def at(self, samples: Samples) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Measure what the curves do to samples.

        Parameters
        ----------
        samples : Samples
            n points with their footprints.

        Returns
        -------
        depth : (n,) float32
            Of the grooves, in the unit of `depth_mm`; where curves cross, a smooth greatest.
        raised : (n,) float32
            Of the folds beside them.
        """
        from surftex.kernels.blend import blend_curves

        records = self.records
        depth, raised = np.zeros(len(samples), np.float32), np.zeros(len(samples), np.float32)
        blend_curves(
            0, len(samples), *self.reaching.place(samples.points), records.source_of, records.limit_mm,
            records.along_mm, records.tangent, read_only_view(samples.footprint_mm, np.float32), self.curve,
            self.table, 0, 1, self.fade, self.spread, depth, raised,
        )  # fmt: skip
        return depth, raised
