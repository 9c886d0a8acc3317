"""What a material answers: named channels, one number or colour per sample."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from surftex.surface.points import Samples

CHANNELS = {
    "height_mm": 1,
    "base_color": 3,
    "roughness": 1,
    "specular": 1,
    "metallic": 1,
    "region": 1,
    "subsurface": 1,
    "subsurface_radius_mm": 3,
    "pheomelanin": 1,
    "blood": 1,
    "melanin": 1,
    "oxygenation": 1,
    "stratum_corneum_mm": 1,
    "epidermis_mm": 1,
    "hair": 1,
    "sebum": 1,
}
"""Channels that maps know, and how many numbers each has. Colour is linear sRGB; `region` is int32, -1 for none."""

RAW = (
    "region", "pheomelanin", "blood", "melanin", "oxygenation", "stratum_corneum_mm", "epidermis_mm", "hair", "sebum",
)  # fmt: skip
"""Channels that are baked only when they are asked for: what a look is made of, not what a renderer is told."""


@dataclass(frozen=True, eq=False)
class Layers:
    """Channels at n samples.

    Attributes
    ----------
    channels : mapping of str to (n,) or (n, 3) float32
        `height_mm` above the surface, `base_color` linear, the rest 0 to 1; `region` is int32.
    clamped : mapping of str to (n,) bool
        Where a channel left the range that looks are known for, and the end of the range is shown; only such channels.
    """

    channels: Mapping[str, NDArray]
    clamped: Mapping[str, NDArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("channels", "clamped"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    def __getitem__(self, name: str) -> NDArray:
        return self.channels[name]

    def __contains__(self, name: object) -> bool:
        return name in self.channels


class Pattern(Protocol):
    """Features placed on a surface; pure per sample, so tiles, sizes and unwraps cannot matter."""

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that `at` answers with."""
        ...

    @property
    def features(self) -> "Mapping[str, np.ndarray]":
        """Structured arrays of everything placed, by kind: `face`, `barycentric`, then parameters."""
        ...

    def at(self, samples: Samples) -> Layers:
        """Evaluate at samples."""
        ...


@runtime_checkable
class Reshaping(Protocol):
    """A pattern that answers in two steps, so that a change of depth or colour need not measure anything anew."""

    def gather(self, samples: Samples) -> Any:
        """Measure what takes time."""
        ...

    def shape(self, gathered: Any, footprint_mm: NDArray[np.float32], /) -> Layers:
        """Turn what was gathered into channels; `at` is both steps."""
        ...

    def reshaped(self, material: Any, /) -> "Reshaping | None":
        """Take over another material of the same kind, or None where `gather` would answer otherwise."""
        ...

    def keeps(self, material: Any, /) -> bool:
        """Tell whether another material of the same kind would place the same features."""
        ...
