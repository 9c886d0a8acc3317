"""Bare skin: pigments and blood of every point before any feature, uneven on purpose."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.fields.curvature import curvature_field
from surftex.fields.fieldset import FieldSet
from surftex.fields.noise import Noise
from surftex.fields.sources import Field
from surftex.materials.skin.kinds import STATE
from surftex.materials.skin.model import Skin
from surftex.materials.skin.placing import read
from surftex.randomness import stream
from surftex.surface.points import Samples
from surftex.surface.surface import Surface

PLAUSIBLE = {
    "pheomelanin": (0.0, 0.5),
    "blood": (0.002, 0.05),
    "melanin": (0.005, 0.3),
    "oxygenation": (0.3, 1.0),
    "stratum_corneum_mm": (0.01, 0.04),
    "epidermis_mm": (0.06, 0.2),
}
"""Ranges that occur in healthy skin (A. Krishnaswamy and G. V. G. Baranoski, "A Biophysically-Based Spectral Model of Light
Interaction with Human Skin", 2004; thickness: J. Sandby-Møller et al., Acta Derm. Venereol. 83, 2003): the measure of
`variation`. Looks are known for more, see `surftex.optics.tissue.PARAMETERS`."""

_FILL = 2.2
"""Noise has an rms of 0.31: times this, a share of 0.2 moves most places by up to a fifth."""


@dataclass(frozen=True, eq=False)
class Baseline:
    """Bare skin on a surface; make it with `Baseline.build`."""

    skin: Skin
    surface: Surface
    seed: int
    fields: dict[str, Field]
    convex: Field | None
    facing_up: NDArray[np.float64]

    @staticmethod
    def build(skin: Skin, surface: Surface, seed: int, names: FieldSet) -> "Baseline":
        """Read the expressions, and measure what stands out and what faces up.

        Parameters
        ----------
        skin : Skin
            The parameters.
        surface : Surface
            Where it lies.
        seed : int
            Of the noise.
        names : FieldSet
            Named numbers.

        Returns
        -------
        baseline : Baseline
            Ready to be asked.
        """
        keys = (
            "melanin", "pheomelanin", "blood", "oxygenation", "flush_where", "lips_where", "relief_where", "sebum_where",
        )  # fmt: skip
        fields = {
            key: read(names, getattr(skin, key), key) for key in keys if isinstance(getattr(skin, key), str)
        }
        up = np.asarray(skin.up, np.float64)
        length = np.linalg.norm(up)
        facing = surface.vertex_normal @ (up / length)
        convex = curvature_field(surface, "convex", skin.flush_radius) if skin.flush > 0 else None
        return Baseline(skin, surface, seed, fields, convex, np.clip(facing + 0.3, 0, 1)[:, None])

    def number(self, key: str, samples: Samples) -> NDArray[np.float64] | float:
        """Read a parameter that may be an expression.

        Parameters
        ----------
        key : str
            Its name.
        samples : Samples
            n points.

        Returns
        -------
        value : float or (n,) float64
            One number where it is one.
        """
        field = self.fields.get(key)
        return getattr(self.skin, key) if field is None else field(samples.points, samples.footprint_mm)

    def at(self, samples: Samples, position: NDArray[np.float64]) -> NDArray[np.float32]:
        """Evaluate bare skin.

        Parameters
        ----------
        samples : Samples
            n points with their footprints.
        position : (n, 3) float64
            Their places in space.

        Returns
        -------
        state : (n, s) float32
            Entries in the order of `STATE`.
        """
        skin, count = self.skin, len(samples)
        state = np.zeros((count, len(STATE)), np.float32)
        column = {name: state[:, i] for i, name in enumerate(STATE)}
        for name in ("melanin", "pheomelanin", "blood", "oxygenation"):
            column[name][:] = self.number(name, samples)
        column["stratum_corneum_mm"][:] = skin.stratum_corneum
        column["epidermis_mm"][:] = skin.epidermis
        for name in ("blood", "melanin"):
            column[name] *= np.exp(self._uneven(name, position, samples))
        if self.convex is not None:
            stands_out = self.convex(samples.points, samples.footprint_mm) * self.number(
                "flush_where", samples
            )
            column["blood"] *= 1 + skin.flush * stands_out.astype(np.float32)
        if skin.tan > 0:
            column["melanin"] *= 1 + skin.tan * self._facing_up(samples)
        if skin.variation > 0:
            for name, (low, high) in PLAUSIBLE.items():
                noise = self._noise(f"variation {name}", skin.variation_size, 1, position, samples)
                column[name] += skin.variation * (high - low) * np.maximum(0.5 + 0.8 * noise, 0)
        lips = self.number("lips_where", samples)
        if np.any(lips):
            share = np.clip(np.asarray(lips, np.float32), 0, 1)
            for name, value in (
                ("blood", skin.lips_blood),
                ("pheomelanin", skin.lips_pheomelanin),
                ("epidermis_mm", skin.lips_epidermis),
            ):
                column[name] += (np.float32(value) - column[name]) * share
        oil = skin.sebum * np.asarray(self.number("sebum_where", samples), np.float32)
        column["sebum"][:] = np.clip(oil, 0, 1)
        column["relief"][:] = np.clip(self.number("relief_where", samples), 0, 1)
        return state

    def _uneven(self, name: str, position: NDArray, samples: Samples) -> NDArray[np.float32]:
        skin = self.skin
        total = np.zeros(len(samples), np.float32)
        for what, amount, size, octaves in (
            ("drift", skin.drift, skin.drift_size, 2),
            ("mottle", skin.mottle, skin.mottle_size, 3),
        ):
            if amount > 0:
                total += _FILL * amount * self._noise(f"{what} {name}", size, octaves, position, samples)
        return total

    def _noise(
        self, name: str, size_mm: float, octaves: int, position: NDArray, samples: Samples
    ) -> NDArray[np.float32]:
        return Noise(stream(self.seed, "skin", name), size_mm, octaves).at(position, samples.footprint_mm)

    def _facing_up(self, samples: Samples) -> NDArray[np.float32]:
        points = samples.points
        corner = self.facing_up[self.surface.faces[points.face], 0]
        return np.einsum("pk,pk->p", points.barycentric, corner).astype(np.float32)
