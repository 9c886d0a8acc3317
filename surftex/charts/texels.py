"""`texels`: what place of the surface each texel of a page shows.

* core: the texel's centre lies in a face; the lowest face wins on shared edges, so that threads cannot
  matter.
* gutter: within `gutter_px` of a chart; the texel shows what the surface shows beyond the chart's edge: the
  straight line from the nearest edge, unfolded over the neighbouring faces, so that bilinear lookup agrees
  on both sides. Far from edges, where only coarse mips look, blocks of texels may show the place in their middle.
* the rest stands for no place; `Texels.image` gives it the value of the nearest mapped texel.

Any range of rows has the same bytes as those rows of the whole page.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.charts.atlas import Atlas
from surftex.charts.bands import BAND_ROWS, Bands
from surftex.charts.fill import fill_nearest
from surftex.errors import InputError
from surftex.kernels.pool import Tick, slices
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.surface import Surface

EXACT_PX = 2.0
"""A good distance beyond which gutter texels share places, two by two, and beyond four times of it four by four: bilinear
lookup across an edge reads none of them in mip 0, and in coarser ones the middle of the texels that become one."""


@dataclass(frozen=True, eq=False)
class Texels:
    """Places of t mapped texels, in the order of their index.

    Attributes
    ----------
    width : int
        Columns of the page.
    height : int
        Rows of the page.
    rows : (int, int)
        First row and one past the last of those asked for.
    texel : (t,) int64
        Flat index into the whole page, row by row from the top; ascending.
    points : SurfacePoints
        What each texel shows.
    footprint_mm : (t,) float32
        Side of a square as large as the texel is on the surface.
    core : (t,) bool
        Whether the texel's centre lies in a chart; false in the gutter.
    host : (t,) int32
        Face whose chart the texel belongs to: the point's own in the core, that of the nearest edge in the
        gutter.
    turn_rad : (t,) float32
        Rotation that carries directions from the frame of `host` into the frame of the point's face.
    source : (t,) int32
        Row of the texel whose point and footprint each has: its own, but in blocks of the far gutter that of the first
        of those that are here.
    """

    width: int
    height: int
    rows: tuple[int, int]
    texel: NDArray[np.int64]
    points: SurfacePoints
    footprint_mm: NDArray[np.float32]
    core: NDArray[np.bool_]
    host: NDArray[np.int32]
    turn_rad: NDArray[np.float32]
    source: NDArray[np.int32]
    _corner_px: NDArray[np.float64] = field(repr=False)

    def __len__(self) -> int:
        return len(self.texel)

    @property
    def samples(self) -> Samples:
        """The points with their footprints, as patterns are asked."""
        return Samples(self.points, self.footprint_mm)

    @property
    def mapped(self) -> NDArray[np.bool_]:
        """(rows, width) bool: which of the texels asked for stand for a place."""
        result = np.zeros((self.rows[1] - self.rows[0], self.width), bool)
        result.ravel()[self.texel - self.rows[0] * self.width] = True
        return result

    @cached_property
    def host_points(self) -> SurfacePoints:
        """The point itself in the core; in the gutter, the host face's nearest point on the page.

        This is where a renderer takes the tangent frame from when its filter reaches the texel.
        """
        weight = self.points.barycentric.copy()
        gutter = np.flatnonzero(~self.core)
        corner = self._corner_px[self.host[gutter]]
        centre = np.stack([self.texel[gutter] % self.width, self.texel[gutter] // self.width], axis=1) + 0.5
        nearest = np.full(len(gutter), np.inf)
        for side in range(3):
            start, edge = corner[:, side], corner[:, (side + 1) % 3] - corner[:, side]
            squared = np.maximum((edge**2).sum(axis=1), np.finfo(float).tiny)
            along = np.clip(((centre - start) * edge).sum(axis=1) / squared, 0, 1)
            away = ((centre - start - along[:, None] * edge) ** 2).sum(axis=1)
            closer = np.flatnonzero(away < nearest)
            nearest[closer] = away[closer]
            weight[gutter[closer]] = 0
            weight[gutter[closer], side] = 1 - along[closer]
            weight[gutter[closer], (side + 1) % 3] = along[closer]
        return SurfacePoints.trusted(self.host, weight)

    def image(self, values: NDArray[Any]) -> NDArray[Any]:
        """Lay values out as a picture without holes.

        Parameters
        ----------
        values : (t,) or (t, c) array
            One row per mapped texel; any type.

        Returns
        -------
        image : (rows, width) or (rows, width, c) array
            Of the rows asked for; texels that stand for no place take the nearest mapped one's value. Where
            rows are baked apart, put them into one page and fill that by `surftex.charts.fill.fill_nearest`.

        Raises
        ------
        InputError
            If there is not one row per mapped texel.
        """
        values = np.asarray(values)
        if values.ndim not in (1, 2) or len(values) != len(self):
            raise InputError(f"values has shape {values.shape}; it takes ({len(self)},) or ({len(self)}, c)")
        first, last = self.rows
        page = np.zeros(((last - first) * self.width, *values.shape[1:]), values.dtype)
        page[self.texel - first * self.width] = values
        page = page.reshape(last - first, self.width, *values.shape[1:])
        if 0 < len(self) < (last - first) * self.width:
            fill_nearest([page], self.mapped)
        return page


def texels(
    surface: Surface,
    atlas: Atlas,
    resolution: int,
    *,
    gutter_px: int | None = None,
    exact_px: float = np.inf,
    rows: tuple[int, int] | None = None,
    threads: int | None = None,
    tick: Tick | None = None,
) -> Texels:
    """Map the texels of a square page to places on the surface.

    Parameters
    ----------
    surface : Surface
        What is baked.
    atlas : Atlas
        Its unwrap.
    resolution : int
        Side of the page in texels.
    gutter_px : int, optional
        Width of the gutter in texels; the atlas' own without it, or 16 where it has none.
    exact_px : float
        Distance from edges, in texels, beyond which two by two gutter texels share the place between them; four by
        four do beyond four times of it.
    rows : (int, int), optional
        First row and one past the last; the whole page without it.
    threads : int, optional
        None means every core; the result does not depend on it.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    texels : Texels
        Core and gutter texels of the rows.

    Raises
    ------
    InputError
        If the atlas has other faces than the surface, or the rows lie outside the page.
    """
    page = TexelPage.of(surface, atlas, resolution, gutter_px)
    return page.texels(
        (0, resolution) if rows is None else rows, exact_px=exact_px, threads=threads, tick=tick
    )


@dataclass(frozen=True, eq=False)
class TexelPage:
    """A page of an atlas, ready to be asked for rows of texels; make it with `TexelPage.of`."""

    surface: Surface
    resolution: int
    gutter_px: float
    corner: NDArray[np.float64]
    faces: Bands
    edge_face: NDArray[np.int32]
    edge_side: NDArray[np.int32]
    edges: Bands
    footprint_mm: NDArray[np.float32]

    @staticmethod
    def of(surface: Surface, atlas: Atlas, resolution: int, gutter_px: int | None = None) -> "TexelPage":
        """Find what may matter to which rows.

        Parameters
        ----------
        surface : Surface
            What is baked.
        atlas : Atlas
            Its unwrap.
        resolution : int
            Side of the page in texels.
        gutter_px : int, optional
            As for `texels`.

        Returns
        -------
        page : TexelPage
            For `TexelPage.texels`.

        Raises
        ------
        InputError
            If the atlas has other faces than the surface, or the page no texel.
        """
        if len(atlas.corner_uv) != len(surface.faces):
            raise InputError(
                f"the atlas has {len(atlas.corner_uv)} faces, the surface {len(surface.faces)}; unwrap anew"
            )
        if resolution < 1:
            raise InputError(f"resolution is {resolution}; it takes at least 1 texel")
        radius = float(default_gutter_px(atlas, resolution) if gutter_px is None else gutter_px)
        corner = atlas.corner_px(resolution)
        edge_face, edge_side = (frozen(part.astype(np.int32)) for part in np.nonzero(atlas.seam))
        ends = corner[edge_face, edge_side, 1], corner[edge_face, (edge_side + 1) % 3, 1]
        across, down = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
        area_px = 0.5 * np.abs(across[:, 0] * down[:, 1] - across[:, 1] * down[:, 0])
        side = np.sqrt(
            np.divide(surface.face_area_mm2, area_px, out=np.zeros(len(area_px)), where=area_px > 5e-13)
        )
        return TexelPage(
            surface, resolution, radius, corner, Bands.of_faces(corner, resolution), edge_face, edge_side,
            Bands.of(np.minimum(*ends) - radius, np.maximum(*ends) + radius, resolution), side.astype(np.float32),
        )  # fmt: skip

    def texels(
        self,
        rows: tuple[int, int],
        *,
        exact_px: float = np.inf,
        threads: int | None = None,
        tick: Tick | None = None,
    ) -> Texels:
        """Map texels of some rows.

        Parameters
        ----------
        rows : (int, int)
            First row and one past the last.
        exact_px : float
            As for `surftex.charts.texels.texels`.
        threads : int, optional
            None means every core; the result does not depend on it.
        tick : callable, optional
            Told the finished share.

        Returns
        -------
        texels : Texels
            Core and gutter texels of the rows.

        Raises
        ------
        InputError
            If the rows lie outside the page.
        """
        from surftex.kernels.gutter import (
            LARGEST_BLOCK,
            close_up,
            continue_band,
            find_leaders,
            nearest_edge_band,
        )
        from surftex.kernels.raster import raster_band

        surface, resolution, corner = self.surface, self.resolution, self.corner
        first, last = rows
        if not 0 <= first < last <= resolution:
            raise InputError(f"rows {first} to {last} lie outside the page's 0 to {resolution}")
        edge_face, edge_side = self.edge_face, self.edge_side
        flat, neighbor, neighbor_edge, transport = (
            surface.flat, surface.neighbor, surface.neighbor_edge, surface.transport
        )  # fmt: skip

        begin, end = first - first % LARGEST_BLOCK, min(last + -last % LARGEST_BLOCK, resolution)
        page = (end - begin, resolution)
        face, host, weight = np.full(page, -1, np.int32), np.zeros(page, np.int32), np.zeros((*page, 3))
        turn, core, follows = np.zeros(page, np.float32), np.zeros(page, bool), np.zeros(page, np.int8)

        def work(first_band: int, last_band: int) -> int:
            band = first_band + first // BAND_ROWS
            top, bottom = max(band * BAND_ROWS, begin), min((band + 1) * BAND_ROWS, end)
            here, shape = slice(top - begin, bottom - begin), (bottom - top, resolution)
            raster_band(corner, self.faces[band], top, face[here], weight[here])
            host[here] = face[here]
            core[here] = face[here] >= 0
            if self.gutter_px > 0:
                near, square, owner = (
                    np.full(shape, np.inf),
                    np.full(shape, -np.inf),
                    np.full(shape, -1, np.int32),
                )
                nearest_edge_band(
                    corner, edge_face, edge_side, self.edges[band], self.gutter_px, top, face[here], near, square, owner
                )  # fmt: skip
                continue_band(
                    corner, flat, neighbor, neighbor_edge, transport, edge_face, edge_side, top, owner, near,
                    float(exact_px), face[here], weight[here], host[here], turn[here], follows[here],
                )  # fmt: skip
            return int(np.count_nonzero(face[max(top, first) - begin : min(bottom, last) - begin] >= 0))

        bands = -(-last // BAND_ROWS) - first // BAND_ROWS
        count = sum(slices(work, bands, size=1, threads=threads, tick=tick))
        texel = np.zeros(count, np.int64)
        asked = slice((first - begin) * resolution, (last - begin) * resolution)
        parts: tuple[NDArray[Any], ...] = (face, host, weight, turn, core, follows)
        parts = tuple(part.reshape(-1, *part.shape[2:])[asked] for part in parts)
        close_up(first * resolution, *parts, texel)
        face, host, weight, turn, core, follows = (part[:count] for part in parts)
        source = np.zeros(len(texel), np.int32)
        find_leaders(texel, resolution, follows, source)
        return Texels(
            width=resolution,
            height=resolution,
            rows=(first, last),
            texel=texel,
            points=SurfacePoints.trusted(face, weight),
            footprint_mm=self.footprint_mm[host],
            core=core,
            host=host,
            turn_rad=turn,
            source=source,
            _corner_px=corner,
        )


def default_gutter_px(atlas: Atlas, resolution: int) -> int:
    """Choose the gutter of a bake: what the atlas has room for.

    Parameters
    ----------
    atlas : Atlas
        The unwrap.
    resolution : int
        Side of the page in texels.

    Returns
    -------
    gutter_px : int
        The atlas' own, scaled to this page; 16 where it has none.
    """
    if not atlas.gutter_px or not atlas.resolution:
        return 16
    return max(2, round(atlas.gutter_px * resolution / atlas.resolution))
