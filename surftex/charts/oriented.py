"""An unwrap whose charts are turned so that a direction field runs along the columns of the page.

Patterns that are drawn texel by texel look up their neighbours along the field; where field and page run alike,
neighbours lie on texels and nothing is lost by rounding.
"""

import numpy as np
from numpy.typing import NDArray

from surftex.charts.atlas import Atlas
from surftex.errors import WorkError
from surftex.surface.surface import Surface

LARGEST_SIDE = 16384
"""Texels of a page's side beyond which charts are not laid out."""

_STEP = 32
"""Sides of pages are multiples of this, so that mips can be made."""


def oriented(
    surface: Surface, atlas: Atlas, up_rad: NDArray[np.float64], *, texel_mm: float, gutter_px: int
) -> Atlas:
    """Turn the charts of an unwrap, bring them to one scale, and lay them out anew.

    Parameters
    ----------
    surface : Surface
        m faces.
    atlas : Atlas
        Its unwrap.
    up_rad : (m,) float64
        Direction in the frame of each face that shall point up on the page.
    texel_mm : float
        Side of a texel on the surface.
    gutter_px : int
        Free texels around each chart.

    Returns
    -------
    atlas : Atlas
        Square; `resolution` is its side in texels.

    Raises
    ------
    WorkError
        If the page would be larger than `LARGEST_SIDE`.
    """
    corner, chart = atlas.corner_uv, atlas.chart
    first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    page_area = 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    area = surface.face_area_mm2
    jacobian = atlas.jacobian_mm(surface, 1)
    along = np.stack([np.cos(up_rad), np.sin(up_rad)], axis=1)
    adjugate = np.stack(
        [jacobian[:, 1, 1], -jacobian[:, 0, 1], -jacobian[:, 1, 0], jacobian[:, 0, 0]], axis=1
    )
    on_page = np.einsum("fij,fj->fi", adjugate.reshape(-1, 2, 2), along) @ np.array([1, 1j])
    unit = on_page / np.maximum(np.abs(on_page), np.finfo(float).tiny)
    mean = np.bincount(chart, area * unit.real) + 1j * np.bincount(chart, area * unit.imag)
    turn = 1j * np.conj(mean) / np.maximum(np.abs(mean), np.finfo(float).tiny)
    turn = np.where(np.abs(turn) > 0.5, turn, 1.0)
    scale = np.sqrt(np.bincount(chart, area) / np.maximum(np.bincount(chart, np.abs(page_area)), 1e-300))
    place = (corner @ np.array([1, 1j])) * (turn * scale / texel_mm)[chart][:, None]
    low_x, low_y = _least(chart, place.real), _least(chart, place.imag)
    wide, high = -_least(chart, -place.real) - low_x, -_least(chart, -place.imag) - low_y
    size = np.ceil(np.stack([wide, high], axis=1)).astype(np.int64) + 1 + 2 * gutter_px
    origin, side = _shelves(size)
    if side > LARGEST_SIDE:
        raise WorkError(
            f"the charts need a page of {side} x {side} texels of {texel_mm:.4g} mm; at most {LARGEST_SIDE} are laid out"
        )
    corner_px = np.stack([place.real - low_x[chart][:, None], place.imag - low_y[chart][:, None]], axis=2)
    corner_px += (origin + gutter_px + 0.5)[chart][:, None]
    return Atlas.of(
        surface, corner_px / side, unwrapper=atlas.unwrapper, resolution=side, gutter_px=gutter_px,
        notes=atlas.notes,
    )  # fmt: skip


def _least(chart: NDArray[np.int32], values: NDArray[np.float64]) -> NDArray[np.float64]:
    least = np.full(int(chart.max()) + 1, np.inf)
    np.minimum.at(least, chart, values.min(axis=1))
    return least


def _shelves(size: NDArray[np.int64]) -> tuple[NDArray[np.int64], int]:
    """Lay boxes out in rows, the highest first, on the smallest square page that holds them."""
    order = np.lexsort([np.arange(len(size)), -size[:, 0], -size[:, 1]])
    side = _rounded(max(int(np.sqrt(size.prod(axis=1).sum())), int(size.max())))
    while True:
        origin = np.zeros_like(size)
        x = y = row = 0
        for k in order:
            wide, high = int(size[k, 0]), int(size[k, 1])
            if x + wide > side:
                x, y, row = 0, y + row, 0
            origin[k] = x, y
            x, row = x + wide, max(row, high)
        if y + row <= side:
            return origin, side
        side = _rounded(max(side + 1, int(1.03 * side)))


def _rounded(side: int) -> int:
    return -(-side // _STEP) * _STEP
