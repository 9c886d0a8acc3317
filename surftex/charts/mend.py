"""Charts without a bad face: those that fold, flip, overlap or stretch too much are cut off and laid out flat."""

import numpy as np
from numpy.typing import NDArray

from surftex.charts.atlas import Atlas
from surftex.charts.overlap import overlapping_faces
from surftex.charts.quality import face_quality
from surftex.surface.surface import Surface


def bad_faces(surface: Surface, corner_uv: NDArray[np.float64], resolution: int | None) -> NDArray[np.bool_]:
    """Find the faces of an unwrap that a bake cannot use.

    Parameters
    ----------
    surface : Surface
        m faces.
    corner_uv : (m, 3, 2) float64
        Charts; a page where `resolution` is given, else on any plane with a scale of its own each.
    resolution : int or None
        Side of the page on which faces may not overlap; None where charts are not packed yet.

    Returns
    -------
    bad : (m,) bool
        Mirrored, without area, stretched, far from its chart's density, or lying on another face.
    """
    atlas = Atlas.of(surface, corner_uv / max(1.0, np.abs(corner_uv).max()))
    quality = face_quality(surface, corner_uv)
    area = surface.face_area_mm2
    total = np.bincount(atlas.chart, area)
    mean = np.sqrt(np.bincount(atlas.chart, area * quality.density**2) / total)[atlas.chart]
    bad = ~quality.good(mean) | (quality.orientation < 0)
    if resolution is not None:
        _, pairs = overlapping_faces(atlas.corner_px(resolution), resolution)
        smaller = np.where(area[pairs[:, 0]] < area[pairs[:, 1]], pairs[:, 0], pairs[:, 1])
        bad[smaller] = True
    return bad


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
