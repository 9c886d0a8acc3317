"""`SurfaceLattice`: the texels of a fine page of one's own, as sites that patterns are drawn on.

The charts are turned along a direction field (`surftex.charts.oriented`). From every site, offsets are walked on the
surface itself, over all seams, in the frame of the field; they end on the texel that they meet. A step of less than
half a texel, at random but the same for all offsets of a site, is added before: else, where the page runs at 45
degrees to the field, every other texel would never be met.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import frozen
from surftex.charts.atlas import Atlas
from surftex.charts.fill import nearest_mapped
from surftex.charts.lookup import bilinear
from surftex.charts.surface_image import SurfaceImage
from surftex.errors import InputError
from surftex.geodesics.directions import DirectionField
from surftex.kernels.pool import Tick, slices
from surftex.randomness import Stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

GUTTER_PX = 8
"""Free texels around each chart: its mips are clean while a texel of them is no wider than half of that."""

_SLICE = 4096


def lattice_atlas(surface: Surface) -> Atlas:
    """Unwrap a surface for lattices of any pitch.

    Parameters
    ----------
    surface : Surface
        Where they shall lie.

    Returns
    -------
    atlas : Atlas
        Its charts are laid out anew by each lattice.
    """
    from surftex.charts.unwrap import unwrap

    return unwrap(surface, method="uvunwrap", resolution=2048)


@dataclass(frozen=True, eq=False)
class SurfaceLattice:
    """Sites on a surface; make one with `SurfaceLattice.of`.

    Attributes
    ----------
    surface : Surface
        Where they lie.
    atlas : Atlas
        The page behind them.
    pitch_mm : float
        Side of a texel.
    site : (n,) int64
        Texel of each site, row by row from the top.
    points : SurfacePoints
        Place of each site.
    angle_rad : (n,) float64
        The direction field there, in the frame of the place's face.
    gutter : (t,) int64
        Texels around the charts that show what the surface shows there.
    gutter_points : SurfacePoints
        What they show.
    """

    surface: Surface
    atlas: Atlas
    pitch_mm: float
    site: NDArray[np.int64]
    points: SurfacePoints
    angle_rad: NDArray[np.float64]
    gutter: NDArray[np.int64]
    gutter_points: SurfacePoints

    def __len__(self) -> int:
        return len(self.site)

    @staticmethod
    def of(
        surface: Surface,
        directions: DirectionField,
        pitch_mm: float,
        *,
        atlas: Atlas | None = None,
        threads: int | None = None,
    ) -> "SurfaceLattice":
        """Lay a lattice over a surface.

        Parameters
        ----------
        surface : Surface
            Where.
        directions : DirectionField
            Where the lattice's up is.
        pitch_mm : float
            From site to site.
        atlas : Atlas, optional
            Charts to turn and lay out; those of a new unwrap without it.
        threads : int, optional
            None means every core; cannot change a site.

        Returns
        -------
        lattice : SurfaceLattice
            Ready.

        Raises
        ------
        InputError
            If the pitch is so wide that no site falls on the surface.
        WorkError
            If it is so narrow that no page can hold the sites.
        """
        from surftex.charts.oriented import oriented
        from surftex.charts.texels import texels

        charts = lattice_atlas(surface) if atlas is None else atlas
        atlas = oriented(surface, charts, directions.angle_rad, texel_mm=pitch_mm, gutter_px=GUTTER_PX)
        page = texels(surface, atlas, atlas.resolution, gutter_px=GUTTER_PX, threads=threads)
        core, around = np.flatnonzero(page.core), np.flatnonzero(~page.core)
        if len(core) == 0:
            raise InputError(f"no pixel of {pitch_mm:.4g} mm falls on the surface; make pixels smaller")
        points, beyond = (
            SurfacePoints.trusted(frozen(page.points.face[part]), frozen(page.points.barycentric[part]))
            for part in (core, around)
        )
        return SurfaceLattice(
            surface, atlas, float(pitch_mm), frozen(page.texel[core]), points, frozen(directions.at(points)),
            frozen(page.texel[around]), beyond,
        )  # fmt: skip

    @property
    def side(self) -> int:
        """Texels of the page's side."""
        return self.atlas.resolution

    @cached_property
    def page(self) -> NDArray[np.int32]:
        """(side, side) int32: the site nearest to each texel on the page."""
        number = np.full(self.side**2, -1, np.int32)
        number[self.site] = np.arange(len(self), dtype=np.int32)
        mapped = (number >= 0).reshape(self.side, self.side)
        return frozen(number[nearest_mapped(mapped)])

    def nearest(self, points: SurfacePoints) -> NDArray[np.int32]:
        """Find the site nearest to places, on the page of their faces.

        Parameters
        ----------
        points : SurfacePoints
            k places.

        Returns
        -------
        site : (k,) int32
            Its number.
        """
        uv = self._uv(points)
        column, row = (np.clip(each, 0, 1 - 1e-9) * self.side for each in (uv[:, 0], 1.0 - uv[:, 1]))
        return self.page[row.astype(np.int64), column.astype(np.int64)]

    def table(
        self, offset: ArrayLike, random: Stream, *, threads: int | None = None, tick: Tick | None = None
    ) -> NDArray[np.int32]:
        """Walk offsets from every site.

        Parameters
        ----------
        offset : (e, 2) int
            Texels to the right and down.
        random : Stream
            Of the small steps that are added.
        threads : int, optional
            None means every core; cannot change the table.
        tick : callable, optional
            Told the finished share.

        Returns
        -------
        table : (n + 1, e) int32
            Number of the site that each offset leads to; n where it leaves the surface.
        """
        from surftex.kernels.lattice import walk_offsets

        steps = np.asarray(offset, np.float64).reshape(-1, 2) * [self.pitch_mm, -self.pitch_mm]
        count, surface = len(self), self.surface
        found = np.full((count + 1, len(steps)), count, np.int32)
        place = np.einsum("pk,pki->pi", self.points.barycentric, surface.flat[self.points.face])
        shift = random.uniform(count, 2) - 0.5
        to_page, page, face = self._to_page(), self.page, self.points.face

        def walk(first: int, last: int) -> None:
            walk_offsets(
                surface.flat, surface.neighbor, surface.neighbor_edge, surface.transport, to_page, page, face,
                place, self.angle_rad, shift, steps, first, last, found,
            )  # fmt: skip

        slices(walk, count, size=_SLICE, threads=threads, tick=tick)
        return found

    def image(self, value: NDArray[np.floating], *, even: bool = True) -> SurfaceImage:
        """Make a picture on the surface of numbers at the sites.

        Parameters
        ----------
        value : (n,) or (n, c) float
            One row per site.
        even : bool
            Move texels at the seams a little, so that both sides look up the same.

        Returns
        -------
        picture : SurfaceImage
            Whose gutter shows what the surface shows beyond each chart.
        """
        from surftex.charts.equalise import equalise
        from surftex.charts.seams import seam_samples

        side = self.side
        page = np.asarray(value, np.float32)[self.page]
        flat = page.reshape(side * side, -1)
        beyond = bilinear(page, self._uv(self.gutter_points))
        flat[self.gutter] = beyond.reshape(len(beyond), -1)
        if even:
            page = equalise(seam_samples(self.surface, self.atlas, side), page, mips=1).image
        return SurfaceImage(self.atlas.corner_uv, frozen(page), self.pitch_mm)

    def _uv(self, points: SurfacePoints) -> NDArray[np.float64]:
        return np.einsum("pk,pkc->pc", points.barycentric, self.atlas.corner_uv[points.face])

    def _to_page(self) -> NDArray[np.float64]:
        """(m, 2, 3) column and row of the page from a place in a face's frame: two factors and a sum."""
        corner = self.atlas.corner_px(self.side)
        flat = self.surface.flat
        across, second = flat[:, 1, 0], flat[:, 2]
        one = (corner[:, 1] - corner[:, 0]) / across[:, None]
        two = (corner[:, 2] - corner[:, 0] - one * second[:, :1]) / second[:, 1:]
        start = corner[:, 0] - one * flat[:, 0, :1] - two * flat[:, 0, 1:]
        return np.ascontiguousarray(np.stack([one, two, start], axis=2))
