"""`Atlas`: where each corner of each face lies on a square page, and what that does to lengths.

u runs right and v up, inside 0 to 1; an atlas of several pages (UDIM) goes on to the right and up, a page to each unit
square. On a page of texels, columns run right and rows run down, and texel centres lie at one half: column = u width,
row = (1 - v) height.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, frozen, read_only_view
from surftex.surface.surface import Surface, hanging_together

SAME_UV = 1e-6
"""Corners of two faces closer than this, as a share of the page, lie at one place of it."""


@dataclass(frozen=True, eq=False)
class Atlas:
    """An unwrap of a surface; make one with `surftex.charts.unwrap.unwrap` or `Atlas.of`.

    Attributes
    ----------
    corner_uv : (m, 3, 2) float64
        Place of each face's corners on the page.
    chart : (m,) int32
        Chart of each face: faces that hang together over edges that are no seams.
    seam : (m, 3) bool
        Whether edge i is a border of the face's chart: a seam, or a border of the mesh.
    unwrapper : str
        Who made it: ``"uvunwrap"``, ``"xatlas"``, or ``"own"`` for the file's own.
    resolution : int
        Page side in texels that the gaps were made for; 0 where that is unknown.
    gutter_px : int
        Free texels around each chart at that resolution; 0 where that is unknown.
    notes : tuple of str
        What was decided on the way, a line each.
    """

    corner_uv: NDArray[np.float64]
    chart: NDArray[np.int32]
    seam: NDArray[np.bool_]
    unwrapper: str
    resolution: int
    gutter_px: int
    notes: tuple[str, ...]

    @staticmethod
    def of(
        surface: Surface,
        corner_uv: ArrayLike,
        *,
        unwrapper: str = "own",
        resolution: int = 0,
        gutter_px: int = 0,
        notes: tuple[str, ...] = (),
    ) -> "Atlas":
        """Find seams and charts of an unwrap.

        Parameters
        ----------
        surface : Surface
            What is unwrapped; m faces.
        corner_uv : (m, 3, 2) float
            Place of each corner on the page.
        unwrapper : str
            Who made it.
        resolution : int
            Page side in texels that it was made for.
        gutter_px : int
            Free texels around each chart.
        notes : tuple of str
            What was decided on the way.

        Returns
        -------
        atlas : Atlas
            With read-only copies.
        """
        uv = checked(corner_uv, "corner_uv", (len(surface.faces), 3, 2), np.float64)
        seam = chart_edges(surface, uv)
        return Atlas(
            corner_uv=frozen(uv.copy()),
            chart=hanging_together(surface, seam),
            seam=frozen(seam),
            unwrapper=unwrapper,
            resolution=int(resolution),
            gutter_px=int(gutter_px),
            notes=tuple(notes),
        )

    @property
    def chart_count(self) -> int:
        """Number of charts."""
        return int(self.chart.max()) + 1

    @cached_property
    def tile(self) -> NDArray[np.int64]:
        """(m,) int64: number of each face's page, 1001 + column + 10 row, counted from the lower left."""
        middle = (self.corner_uv[:, 0] + self.corner_uv[:, 1] + self.corner_uv[:, 2]) / 3
        column, row = np.floor(middle).astype(np.int64).T
        return frozen(1001 + column + 10 * row)

    @cached_property
    def tiles(self) -> tuple[int, ...]:
        """Numbers of all pages, ascending."""
        return tuple(np.unique(self.tile).tolist())

    def page(self, tile: int) -> "Atlas":
        """Take one page of several.

        Parameters
        ----------
        tile : int
            Its number.

        Returns
        -------
        page : Atlas
            Moved so that the page fills 0 to 1; faces of other pages lie outside.
        """
        if tile == 1001:
            return self
        return replace(self, corner_uv=frozen(self.corner_uv - tile_origin(tile)))

    def corner_px(self, width: int, height: int | None = None) -> NDArray[np.float64]:
        """Place the corners on a page of texels.

        Parameters
        ----------
        width : int
            Columns of the page.
        height : int, optional
            Rows; as `width` without it.

        Returns
        -------
        corner : (m, 3, 2) float64
            Column and row of each corner; rows run down, texel centres lie at one half. Read-only.
        """
        height = width if height is None else height
        corner = np.zeros_like(self.corner_uv)
        corner[..., 0] = self.corner_uv[..., 0] * width
        corner[..., 1] = (1.0 - self.corner_uv[..., 1]) * height
        return frozen(corner)

    def jacobian_mm(self, surface: Surface, width: int, height: int | None = None) -> NDArray[np.float64]:
        """Say how many millimetres a step of a texel is, per face.

        Parameters
        ----------
        surface : Surface
            What is unwrapped.
        width : int
            Columns of the page.
        height : int, optional
            Rows; as `width` without it.

        Returns
        -------
        jacobian : (m, 2, 2) float64
            Columns are the steps, in the face's frame, for one texel to the right and one texel up. Zero on
            faces without area on the page.
        """
        from surftex.kernels.page import measure_steps

        steps = np.zeros((len(self.corner_uv), 2, 2))
        measure_steps(self.corner_px(width, height), surface.flat, steps)
        return steps

    def texels_per_mm(self, surface: Surface, width: int) -> float:
        """Measure the density of the page.

        Parameters
        ----------
        surface : Surface
            What is unwrapped.
        width : int
            Side of the page in texels.

        Returns
        -------
        density : float
            Texels along a millimetre, from the areas of all faces.
        """
        first, second = (
            self.corner_uv[:, 1] - self.corner_uv[:, 0],
            self.corner_uv[:, 2] - self.corner_uv[:, 0],
        )
        area = 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).sum()
        return float(width * np.sqrt(area / surface.area_mm2))

    def seam_length_mm(self, surface: Surface) -> float:
        """Measure the seams, each once; borders of the mesh are none.

        Parameters
        ----------
        surface : Surface
            What is unwrapped.

        Returns
        -------
        length : float
            Millimetres.
        """
        inside = self.seam & (surface.neighbor >= 0)
        return float(surface.edge_length[inside].sum() / 2)


def tile_origin(tile: ArrayLike) -> NDArray[np.float64]:
    """Find the lower left corner of pages.

    Parameters
    ----------
    tile : int or (k,) int
        Their UDIM numbers.

    Returns
    -------
    uv : (2,) or (k, 2) float64
        u and v.
    """
    number = np.asarray(tile) - 1001
    return np.stack([number % 10, number // 10], axis=-1).astype(np.float64)


def chart_edges(surface: Surface, corner_uv: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Find the edges where charts end, from the places of both corners on both sides.

    Parameters
    ----------
    surface : Surface
        What is unwrapped; m faces.
    corner_uv : (m, 3, 2) float64
        Place of each corner on the page.

    Returns
    -------
    seam : (m, 3) bool
        True at borders of the mesh, where the two sides of an edge lie apart on the page, and where the page
        is folded over along an edge.
    """
    from surftex.kernels.page import find_seams

    seam = np.zeros(surface.neighbor.shape, bool)
    corner = read_only_view(corner_uv, np.float64)
    find_seams(corner, surface.neighbor, surface.neighbor_edge, SAME_UV, seam)
    return seam
