"""`SurfaceImage`: a picture stored on a surface, read by places on it and not by places on a page.

The page behind it is its own business: bilinear lookup through the picture's own unwrap, with a gutter that
continues the surface, so that a reader sees no seam.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, frozen
from surftex.charts.atlas import Atlas
from surftex.charts.lookup import bilinear, half
from surftex.errors import InputError
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.surface import Surface


@dataclass(frozen=True, eq=False)
class SurfaceImage:
    """A picture on a surface; make one with `SurfaceImage.baked` or from a file's picture with `SurfaceImage.of`.

    Attributes
    ----------
    corner_uv : (m, 3, 2) float64
        Where the picture shows each corner of each face.
    image : (height, width) or (height, width, c) float32
        Row 0 on top.
    texel_mm : float
        Side of a texel on the surface, for lookups that know their footprint; 0 where that is unknown.
    """

    corner_uv: NDArray[np.float64]
    image: NDArray[np.float32]
    texel_mm: float = 0.0

    @staticmethod
    def of(corner_uv: ArrayLike, image: ArrayLike) -> "SurfaceImage":
        """Wrap a picture that is laid out already.

        Parameters
        ----------
        corner_uv : (m, 3, 2) float
            Where it shows each corner; u right, v up.
        image : (height, width) or (height, width, c) array
            Finite numbers.

        Returns
        -------
        picture : SurfaceImage
            With read-only copies.

        Raises
        ------
        InputError
            If shapes do not fit.
        """
        uv = checked(corner_uv, "corner_uv", (None, 3, 2), np.float64)
        picture = np.asarray(image)
        if picture.ndim not in (2, 3) or picture.size == 0:
            raise InputError(
                f"image has shape {picture.shape}; it takes (height, width) or (height, width, c)"
            )
        picture = checked(picture, "image", (None,) * picture.ndim, np.float32)
        return SurfaceImage(frozen(uv.copy()), frozen(picture.copy()))

    @staticmethod
    def baked(
        surface: Surface,
        value: Callable[[Samples], NDArray[Any]],
        *,
        resolution: int = 1024,
        atlas: Atlas | None = None,
        threads: int | None = None,
    ) -> "SurfaceImage":
        """Store what a function says.

        Parameters
        ----------
        surface : Surface
            Where it lies.
        value : callable
            Gets samples, returns (t,) or (t, c) numbers.
        resolution : int
            Side of the page in texels.
        atlas : Atlas, optional
            An unwrap to use; a new one without it.
        threads : int, optional
            None means every core.

        Returns
        -------
        picture : SurfaceImage
            Without holes.
        """
        from surftex.charts.texels import texels
        from surftex.charts.unwrap import unwrap

        atlas = unwrap(surface, resolution=resolution) if atlas is None else atlas
        page = texels(surface, atlas, resolution, threads=threads)
        return SurfaceImage(atlas.corner_uv, frozen(page.image(np.asarray(value(page.samples), np.float32))))

    @cached_property
    def mips(self) -> tuple[NDArray[np.float32], ...]:
        """The picture, and coarser ones of half its side each, as long as sides are even and above 16."""
        levels = [self.image]
        while min(levels[-1].shape[:2]) > 16 and not any(side % 2 for side in levels[-1].shape[:2]):
            levels.append(frozen(half(levels[-1])))
        return tuple(levels)

    def at(
        self, points: SurfacePoints, footprint_mm: NDArray[np.floating] | None = None
    ) -> NDArray[np.float64]:
        """Read the picture.

        Parameters
        ----------
        points : SurfacePoints
            n places on the surface.
        footprint_mm : (n,) float, optional
            Side of the patch that each stands for; wider ones than a texel read coarser pictures, where
            `texel_mm` is known.

        Returns
        -------
        value : (n,) or (n, c) float64
            Bilinear, and mixed between the two nearest mips.
        """
        uv = np.einsum("pk,pkc->pc", points.barycentric, self.corner_uv[points.face])
        if footprint_mm is None or self.texel_mm <= 0:
            return bilinear(self.image, uv)
        level = np.log2(np.maximum(np.asarray(footprint_mm, np.float64) / self.texel_mm, 1.0))
        level = np.minimum(level, len(self.mips) - 1.0)
        lower = np.floor(level).astype(np.int64)
        value = np.zeros((len(uv), *self.image.shape[2:]))
        for number, image in enumerate(self.mips):
            for chosen, share in (
                (lower == number, 1.0 - (level - lower)),
                (lower + 1 == number, level - lower),
            ):
                here = np.flatnonzero(chosen & (share > 0))
                if len(here):
                    part = share[here] if image.ndim == 2 else share[here, None]
                    value[here] += part * bilinear(image, uv[here])
        return value
