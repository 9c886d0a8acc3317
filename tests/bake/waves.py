"""A small material for tests: waves through space, and spots that are placed at random."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict

from surftex.errors import RecipeError
from surftex.features.uniform import scatter
from surftex.fields.noise import Noise
from surftex.materials.layers import Layers
from surftex.randomness import stream


@dataclass(frozen=True, eq=False)
class WavesPattern:
    waves: "Waves"
    surface: Any
    seed: int
    features: dict
    strength: Any

    channels = ("height_mm", "base_color", "roughness", "region")

    def at(self, samples):
        position = samples.points.positions(self.surface)
        noise = Noise(stream(self.seed, "waves"), self.waves.wavelength, 2).at(position, samples.footprint_mm)
        noise = noise * self.strength(samples.points).astype(np.float32)
        tone = (0.5 + 0.4 * noise).clip(0, 1)
        return Layers(
            {
                "height_mm": np.float32(self.waves.height) * noise,
                "base_color": np.stack([tone, tone * tone, 1 - tone], axis=1).astype(np.float32),
                "roughness": tone.astype(np.float32),
                "region": (position[:, 0] > 0).astype(np.int32),
            }
        )


class Waves(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: Literal["waves"] = "waves"
    wavelength: float = 5.0
    height: float = 0.2
    spots: int = 20
    strength: float | str = 1.0

    def place(
        self, surface, seed=0, *, fields=None, features=None, max_features=5_000_000, threads=None, tick=None
    ):
        if self.spots > max_features:
            raise RecipeError(f"{self.spots} spots are more than max_features = {max_features}")
        if features is None:
            points = scatter(surface, stream(seed, "waves", "spots"), count=self.spots)
            table = np.zeros(len(points), [("face", np.int32), ("barycentric", np.float64, 3)])
            table["face"], table["barycentric"] = points.face, points.barycentric
            features = {"spot": table}
        if tick:
            tick(1.0)
        return WavesPattern(self, surface, seed, dict(features), fields.scalar(self.strength))
