"""Charts without a bad face: those that fold, flip, overlap or stretch too much are cut off and laid out flat."""

import numpy as np
from numpy.typing import NDArray

from surftex.charts.atlas import Atlas
from surftex.charts.overlap import overlapping_faces
from surftex.charts.quality import face_quality
from surftex.surface.surface import Surface

NOTCH_PX = 2.5
"""Stretches of a chart's border nearer than this on the page share texels in a bilinear lookup."""

APART_PX = 4.0
"""Stretches farther apart than this on the surface, in texels, are not one place."""

NOTCH_ROUNDS = 3
"""How often to look again: cutting a face off makes new borders, and now and then a new notch."""

TYPICAL_COVERAGE = 0.6
"""Share of the page that charts cover once they are packed; tells how fine a notch may be."""


def true_scale(
    surface: Surface, corner_uv: NDArray[np.float64], chart: NDArray[np.int32]
) -> NDArray[np.float64]:
    """Draw every chart in millimetres, by the areas of its faces.

    Parameters
    ----------
    surface : Surface
        m faces.
    corner_uv : (m, 3, 2) float64
        Charts on any plane, each at a scale of its own.
    chart : (m,) int32
        Chart of each face.

    Returns
    -------
    sheet : (m, 3, 2) float64
        Each chart as large as on the surface, with its lower left corner at the origin.
    """
    first, second = corner_uv[:, 1] - corner_uv[:, 0], corner_uv[:, 2] - corner_uv[:, 0]
    drawn = np.bincount(chart, 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]))
    scale = np.sqrt(drawn / np.bincount(chart, surface.face_area_mm2))
    sheet = corner_uv / np.where(scale > 0, scale, 1)[chart][:, None, None]
    low = np.full((len(drawn), 2), np.inf)
    np.minimum.at(low, chart, sheet.min(axis=1))
    return sheet - low[chart][:, None]


def bad_faces(surface: Surface, sheet: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Find the faces of unpacked charts that a bake cannot use.

    Parameters
    ----------
    surface : Surface
        m faces.
    sheet : (m, 3, 2) float64
        Charts in millimetres, as `true_scale` draws them.

    Returns
    -------
    bad : (m,) bool
        Mirrored, without area, stretched, or far from the chart's density.
    """
    quality = face_quality(surface, sheet)
    return ~quality.good(1.0) | (quality.orientation < 0)


def overlap_faces(surface: Surface, atlas: Atlas, resolution: int) -> NDArray[np.int32]:
    """Find faces that lie on others.

    Parameters
    ----------
    surface : Surface
        m faces.
    atlas : Atlas
        Its unwrap, packed.
    resolution : int
        Side of the page in texels.

    Returns
    -------
    face : (k,) int32
        The smaller face of each pair that shares a texel, ascending.
    """
    _, pairs = overlapping_faces(atlas.corner_px(resolution), resolution)
    return _smaller(surface, pairs)


def notch_faces(
    surface: Surface,
    sheet: NDArray[np.float64],
    chart: NDArray[np.int32],
    seam: NDArray[np.bool_],
    alone: NDArray[np.bool_],
    resolution: int,
) -> NDArray[np.bool_]:
    """Find faces beside notches: places where bilinear lookup would mix two parts of one chart.

    There a chart's border comes very near to another stretch of its own border that is far away on the
    surface.

    Parameters
    ----------
    surface : Surface
        m faces.
    sheet : (m, 3, 2) float64
        Charts in millimetres, as `true_scale` draws them.
    chart : (m,) int32
        Chart of each face.
    seam : (m, 3) bool
        Edges where charts end.
    alone : (m,) bool
        Faces that are cut off already.
    resolution : int
        Side in texels of the page that the charts will be packed on.

    Returns
    -------
    alone : (m,) bool
        With the smaller face of each such pair; without them the notches are wide.
    """
    from surftex.kernels.notches import mark_notches

    page_px_per_mm = resolution * np.sqrt(TYPICAL_COVERAGE / surface.area_mm2)
    corner = sheet * page_px_per_mm
    space = surface.vertices[surface.faces]
    alone = alone.copy()
    for _ in range(NOTCH_ROUNDS):
        cut = alone[surface.neighbor] & (surface.neighbor >= 0)
        face, edge = np.nonzero((seam | cut) & ~alone[:, None])
        if len(face) == 0:
            break
        start, end = corner[face, edge], corner[face, (edge + 1) % 3]
        count = np.maximum(1, np.ceil(np.linalg.norm(end - start, axis=1))).astype(np.int64)
        index = np.repeat(np.arange(len(face)), count)
        step = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        along = ((step + 0.5) / count[index])[:, None]
        page = start[index] * (1 - along) + end[index] * along
        place = space[face, edge][index] * (1 - along) + space[face, (edge + 1) % 3][index] * along
        head, chain = np.full(1 << len(page).bit_length(), -1), np.zeros(len(page), np.int64)
        apart_mm = APART_PX / page_px_per_mm
        if not mark_notches(
            page, place, face[index], chart, surface.face_area_mm2, NOTCH_PX, apart_mm, head, chain, alone
        ):
            break
    return alone


def _smaller(surface: Surface, pairs: NDArray[np.integer]) -> NDArray[np.int32]:
    """Choose the smaller face of each pair, each once."""
    area = surface.face_area_mm2[pairs]
    return np.unique(np.where(area[:, 0] < area[:, 1], pairs[:, 0], pairs[:, 1])).astype(np.int32)


def stand_ins(surface: Surface, face: NDArray[np.int64]) -> NDArray[np.float64]:
    """Draw faces flat for the packer, which cannot hold slivers: none is thinner than a thousandth of its length.

    Parameters
    ----------
    surface : Surface
        m faces.
    face : (k,) int64
        Faces to draw.

    Returns
    -------
    sheet : (k, 3, 2) float64
        Millimetres, longest edge along x, lower left corner at the origin.
    """
    drawn = _along_longest(surface, face)
    drawn[..., 1] *= np.maximum(1, 1e-3 * np.ptp(drawn[..., 0], axis=1) / np.ptp(drawn[..., 1], axis=1))[
        :, None
    ]
    return drawn


def _along_longest(surface: Surface, face: NDArray[np.int64]) -> NDArray[np.float64]:
    """Draw faces in millimetres with the longest edge along x, in the corner of the first quadrant."""
    longest = surface.edge_length[face].argmax(axis=1)
    index = np.arange(len(face))
    flat = surface.flat[face] @ np.array([1, 1j])
    along = flat[index, (longest + 1) % 3] - flat[index, longest]
    turned = (flat - flat[index, longest][:, None]) * (along.conj() / np.abs(along))[:, None]
    drawn = np.stack([turned.real, turned.imag], axis=2)
    return drawn - drawn.min(axis=1, keepdims=True)


def true_to_shape(
    surface: Surface, corner_uv: NDArray[np.float64], face: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Redraw single-face charts exactly, from their middle and their longest edge's direction.

    Parameters
    ----------
    surface : Surface
        m faces.
    corner_uv : (m, 3, 2) float64
        A page.
    face : (k,) int64
        Faces that are charts of their own.

    Returns
    -------
    corner_uv : (m, 3, 2) float64
        The page with these faces true to their shape.
    """
    exact, longest = _along_longest(surface, face), surface.edge_length[face].argmax(axis=1)
    index = np.arange(len(face))
    page = corner_uv[face] @ np.array([1, 1j])
    along = page[index, (longest + 1) % 3] - page[index, longest]
    length = np.abs(along)
    turn = np.where(length > 0, along / np.where(length > 0, length, 1), 1)
    density = (length / surface.edge_length[face, longest])[:, None]
    turned = (exact @ np.array([1, 1j])) * density * turn[:, None]
    drawn = np.stack([turned.real, turned.imag], axis=2)
    shift = corner_uv[face].max(axis=1) + corner_uv[face].min(axis=1) - drawn.max(axis=1) - drawn.min(axis=1)
    result = corner_uv.copy()
    result[face] = drawn + shift[:, None] / 2
    return result
