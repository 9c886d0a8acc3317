"""What an unwrap does to each face: orientation, stretch, density; exact, from the two triangles."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.surface.surface import Surface

ANISOTROPY_LIMIT = 4.0
"""Ratio of the longest to the shortest image of a millimetre that a bake accepts."""

DENSITY_LIMIT = 4.0
"""Ratio of a face's texel density to the mean one, or the other way round, that a bake accepts."""


@dataclass(frozen=True, eq=False)
class FaceQuality:
    """Measures per face.

    Attributes
    ----------
    orientation : (m,) int8
        1 where the face lies on the page as seen from outside, -1 mirrored, 0 without area.
    anisotropy : (m,) float64
        At least 1; inf without area.
    density : (m,) float64
        Page units along a millimetre, as the root of the areas' ratio.
    """

    orientation: NDArray[np.int8]
    anisotropy: NDArray[np.float64]
    density: NDArray[np.float64]

    def good(self, mean: NDArray[np.float64] | float) -> NDArray[np.bool_]:
        """Tell which faces a bake accepts.

        Parameters
        ----------
        mean : float or (m,) float64
            Density to compare with.

        Returns
        -------
        good : (m,) bool
            Area on the page, anisotropy and density within the limits. Mirrored faces may be good.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = self.density / mean
        return (
            (self.orientation != 0)
            & (self.anisotropy <= ANISOTROPY_LIMIT)
            & (ratio <= DENSITY_LIMIT)
            & (ratio >= 1 / DENSITY_LIMIT)
        )


def face_quality(surface: Surface, corner_uv: NDArray[np.float64]) -> FaceQuality:
    """Measure an unwrap face by face.

    Parameters
    ----------
    surface : Surface
        m faces.
    corner_uv : (m, 3, 2) float64
        Their corners on any page.

    Returns
    -------
    quality : FaceQuality
        Measures per face.
    """
    first, second = corner_uv[:, 1] - corner_uv[:, 0], corner_uv[:, 2] - corner_uv[:, 0]
    long, across, tall = surface.flat[:, 1, 0], surface.flat[:, 2, 0], surface.flat[:, 2, 1]
    along = first / long[:, None]
    up = (second - along * across[:, None]) / tall[:, None]
    twice = along[:, 0] * up[:, 1] - along[:, 1] * up[:, 0]
    square = (along**2).sum(axis=1) + (up**2).sum(axis=1)
    spread = np.sqrt(np.maximum(square**2 - 4 * twice**2, 0))
    with np.errstate(divide="ignore", invalid="ignore"):
        anisotropy = (square + spread) / (2 * np.abs(twice))
    shortest = np.sqrt(np.maximum(square - spread, 0) / 2)
    flat = ~(np.abs(twice) > 1e-12 * square) | ~np.isfinite(anisotropy) | ~(shortest > 0)
    return FaceQuality(
        orientation=np.where(flat, 0, np.sign(twice)).astype(np.int8),
        anisotropy=np.where(flat, np.inf, np.maximum(anisotropy, 1)),
        density=np.sqrt(np.abs(twice)),
    )
