"""Charts without a bad face: those that fold, flip, overlap or stretch too much are cut off and laid out flat."""

import numpy as np
from numpy.typing import NDArray

from surftex.charts.atlas import Atlas, chart_edges
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


def chart_density(
    surface: Surface, corner_uv: NDArray[np.float64], chart: NDArray[np.int32]
) -> NDArray[np.float64]:
    """Measure how large each face's chart is drawn.

    Parameters
    ----------
    surface : Surface
        m faces.
    corner_uv : (m, 3, 2) float64
        Charts on any plane.
    chart : (m,) int32
        Chart of each face.

    Returns
    -------
    density : (m,) float64
        Plane units along a millimetre, from the areas of the face's whole chart.
    """
    first, second = corner_uv[:, 1] - corner_uv[:, 0], corner_uv[:, 2] - corner_uv[:, 0]
    drawn = np.bincount(chart, 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]))
    return np.sqrt(drawn / np.bincount(chart, surface.face_area_mm2))[chart]


def bad_faces(surface: Surface, corner_uv: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Find the faces of unpacked charts that a bake cannot use.

    Parameters
    ----------
    surface : Surface
        m faces.
    corner_uv : (m, 3, 2) float64
        Charts on any plane, each at a scale of its own.

    Returns
    -------
    bad : (m,) bool
        Mirrored, without area, stretched, or far from the chart's density.
    """
    chart = Atlas.of(surface, corner_uv / max(1.0, np.abs(corner_uv).max())).chart
    quality = face_quality(surface, corner_uv)
    return ~quality.good(chart_density(surface, corner_uv, chart)) | (quality.orientation < 0)


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
    surface: Surface, corner_uv: NDArray[np.float64], alone: NDArray[np.bool_], resolution: int
) -> NDArray[np.bool_]:
    """Find faces beside notches: places where a chart's border comes so near to another stretch of its own border,
    far away on the surface, that bilinear lookup would mix the two sides.

    Parameters
    ----------
    surface : Surface
        m faces.
    corner_uv : (m, 3, 2) float64
        Charts on any plane, each at a scale of its own.
    alone : (m,) bool
        Faces that are cut off already.
    resolution : int
        Side in texels of the page that the charts will be packed on.

    Returns
    -------
    alone : (m,) bool
        With the smaller face of each such pair; without them the notches are wide.
    """
    from scipy.spatial import cKDTree

    page_px_per_mm = resolution * np.sqrt(TYPICAL_COVERAGE / surface.area_mm2)
    chart = Atlas.of(surface, corner_uv / max(1.0, np.abs(corner_uv).max())).chart
    density = chart_density(surface, corner_uv, chart)
    corner = corner_uv * (page_px_per_mm / np.where(density > 0, density, 1))[:, None, None]
    joined = ~chart_edges(surface, corner_uv / max(1.0, np.abs(corner_uv).max()))
    space = surface.vertices[surface.faces]
    alone = alone.copy()
    for _ in range(NOTCH_ROUNDS):
        cut = alone[surface.neighbor] & (surface.neighbor >= 0)
        face, edge = np.nonzero((~joined | cut) & ~alone[:, None])
        if len(face) == 0:
            break
        start, end = corner[face, edge], corner[face, (edge + 1) % 3]
        count = np.maximum(1, np.ceil(np.linalg.norm(end - start, axis=1))).astype(np.int64)
        index = np.repeat(np.arange(len(face)), count)
        step = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        along = ((step + 0.5) / count[index])[:, None]
        page = start[index] * (1 - along) + end[index] * along
        place = space[face, edge][index] * (1 - along) + space[face, (edge + 1) % 3][index] * along
        layer = chart[face[index], None] * (4 * NOTCH_PX)
        pairs = cKDTree(np.hstack([page, layer])).query_pairs(NOTCH_PX, output_type="ndarray")
        apart = np.linalg.norm(place[pairs[:, 0]] - place[pairs[:, 1]], axis=1) * page_px_per_mm
        both = face[index[pairs[apart > APART_PX]]]
        if len(both) == 0:
            break
        alone[_smaller(surface, both)] = True
    return alone


def _smaller(surface: Surface, pairs: NDArray[np.integer]) -> NDArray[np.int32]:
    """Choose the smaller face of each pair, each once."""
    area = surface.face_area_mm2[pairs]
    return np.unique(np.where(area[:, 0] < area[:, 1], pairs[:, 0], pairs[:, 1])).astype(np.int32)


def cut_off(surface: Surface, corner_uv: NDArray[np.float64], bad: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Lay bad faces out apart, each true to its shape.

    Parameters
    ----------
    surface : Surface
        m faces.
    corner_uv : (m, 3, 2) float64
        Charts on any plane.
    bad : (m,) bool
        Faces to cut off.

    Returns
    -------
    corner_uv : (m, 3, 2) float64
        Good faces inside the unit square, at one scale; bad ones in a grid to its right.
    """
    result = corner_uv - corner_uv.reshape(-1, 2).min(axis=0)
    result /= max(np.finfo(float).tiny, result.max())
    alone = np.flatnonzero(bad)
    flat = surface.flat[alone]
    flat = flat - flat.min(axis=1, keepdims=True)
    side = int(np.ceil(np.sqrt(len(alone))))
    cell = (
        np.stack([1.1 * side + np.arange(len(alone)) % side, np.arange(len(alone)) // side], axis=1)
        * 1.1
        / side
    )
    result[alone] = flat / flat.max(axis=(1, 2), keepdims=True) / side + cell[:, None]
    return result


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
        The page with these faces upright, at the density of the page.
    """
    quality = face_quality(surface, corner_uv)
    area = surface.face_area_mm2
    density = np.sqrt((area * quality.density**2).sum() / area.sum())
    longest = surface.edge_length[face].argmax(axis=1)
    index = np.arange(len(face))
    flat = surface.flat[face]
    here = (flat[index, (longest + 1) % 3] - flat[index, longest]) @ np.array([1, 1j])
    page = corner_uv[face]
    there = (page[index, (longest + 1) % 3] - page[index, longest]) @ np.array([1, 1j])
    turn = (
        np.where(np.abs(there) > 0, there / np.where(np.abs(there) > 0, np.abs(there), 1), 1)
        * here.conj()
        / np.abs(here)
    )
    middle = (page.max(axis=1) + page.min(axis=1)) / 2
    drawn = (flat @ np.array([1, 1j])) * turn[:, None] * density
    drawn = np.stack([drawn.real, drawn.imag], axis=2)
    drawn += (middle - (drawn.max(axis=1) + drawn.min(axis=1)) / 2)[:, None]
    result = corner_uv.copy()
    result[face] = drawn
    return result
