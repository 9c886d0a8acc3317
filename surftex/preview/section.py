"""Cross-sections: the height along a curve on a surface, or along a straight line on a flat map."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked
from surftex.errors import InputError
from surftex.geodesics.pieces import CurvePieces
from surftex.maps.mapset import MapSet
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.surface import Surface
from surftex.words import sort_of


@dataclass(frozen=True, eq=False)
class Section:
    """Heights along a way.

    Attributes
    ----------
    along_mm : (n,) float64
        Walked from the start, ascending.
    height_mm : (n,) float64
        Above the surface.
    """

    along_mm: NDArray[np.float64]
    height_mm: NDArray[np.float64]


def curve_points(
    surface: Surface, curve: CurvePieces, step_mm: float
) -> tuple[SurfacePoints, NDArray[np.float64]]:
    """Walk along the first curve of a set.

    Parameters
    ----------
    surface : Surface
        What it lies on.
    curve : CurvePieces
        Such as the shortest path between two points.
    step_mm : float
        Between two points.

    Returns
    -------
    points : SurfacePoints
        n points, both ends among them.
    along_mm : (n,) float64
        Way to each.

    Raises
    ------
    InputError
        If there is no curve, or the step is none.
    """
    first = np.flatnonzero(curve.curve == curve.curve[0]) if len(curve) else np.zeros(0, int)
    if not len(first) or not step_mm > 0:
        raise InputError(
            f"a section takes a curve and a step above 0, not {len(first)} pieces and {step_mm} mm"
        )
    length = curve.length_mm[first]
    ends = curve.start_mm[first] + length
    along = np.linspace(0, ends[-1], max(2, int(np.ceil(ends[-1] / step_mm)) + 1))
    piece = np.minimum(np.searchsorted(ends, along), len(first) - 1)
    share = np.clip((along - curve.start_mm[first][piece]) / np.maximum(length[piece], 1e-300), 0, 1)[:, None]
    chosen = first[piece]
    place = curve.start[chosen] * (1 - share) + curve.end[chosen] * share
    face = curve.face[chosen]
    flat = surface.flat[face]
    third = place[:, 1] / flat[:, 2, 1]
    second = (place[:, 0] - third * flat[:, 2, 0]) / flat[:, 1, 0]
    weight = np.clip(np.stack([1 - second - third, second, third], axis=1), 0, None)
    return SurfacePoints(face, weight / weight.sum(axis=1, keepdims=True)), along


def section(subject: Any, surface: Surface, curve: CurvePieces, *, step_mm: float | None = None) -> Section:
    """Cut a relief along a curve on its surface.

    Parameters
    ----------
    subject : Pattern or MapSet
        A pattern is asked at the points themselves; of a bake, the height map is read there.
    surface : Surface
        What the relief lies on.
    curve : CurvePieces
        Such as the shortest path between two points; the first one counts.
    step_mm : float, optional
        Between two samples; a five-hundredth of the curve without it.

    Returns
    -------
    section : Section
        In millimetres, walked along the surface.

    Raises
    ------
    InputError
        If the subject has no height.
    """
    total = float(curve.curve_length_mm[curve.curve[0]]) if len(curve) else 0.0
    step = step_mm if step_mm is not None else max(total / 500, 1e-9)
    points, along = curve_points(surface, curve, step)
    if isinstance(subject, MapSet):
        if "height" not in subject:
            raise InputError(f"this bake has no height; it made {', '.join(subject)}")
        corner = subject.atlas.corner_uv[points.face]
        uv = np.einsum("nk,nki->ni", points.barycentric, corner)
        image = subject["height"]
        place = np.stack([uv[:, 0] * image.shape[1] - 0.5, (1 - uv[:, 1]) * image.shape[0] - 0.5], axis=1)
        return Section(along, blended(image, place))
    if not hasattr(subject, "at"):
        raise InputError(f"cannot cut {sort_of(subject)}; give a pattern or a MapSet")
    layers = subject.at(Samples(points, np.full(len(points), step, np.float32)))
    if "height_mm" not in layers:
        raise InputError("this pattern has no height")
    return Section(along, layers["height_mm"].astype(np.float64))


def flat_section(
    height_mm: NDArray[np.floating], start: ArrayLike, end: ArrayLike, mm_per_texel: float
) -> Section:
    """Cut a flat height map along a straight line.

    Parameters
    ----------
    height_mm : (h, w) float
        Row 0 on top.
    start : (2,) float
        Column and row in texels; centres at one half.
    end : (2,) float
        Column and row.
    mm_per_texel : float
        Size of a texel.

    Returns
    -------
    section : Section
        Two samples for each texel of way.

    Raises
    ------
    InputError
        If an end lies outside the map, or both are one.
    """
    rows, columns = height_mm.shape
    ends = np.stack(
        [checked(value, name, (2,), np.float64) for value, name in ((start, "start"), (end, "end"))]
    )
    if (ends < 0).any() or (ends > [columns, rows]).any():
        raise InputError(f"the section {ends.ravel().tolist()} leaves the map of {columns} x {rows} texels")
    way = float(np.hypot(*(ends[1] - ends[0])))
    if way == 0:
        raise InputError(f"the section starts and ends at {ends[0].tolist()}; it takes two places")
    share = np.linspace(0, 1, max(2, int(np.ceil(2 * way)) + 1))[:, None]
    place = ends[0] * (1 - share) + ends[1] * share - 0.5
    return Section(share[:, 0] * way * mm_per_texel, blended(height_mm, place))


def blended(image: NDArray[np.floating], place: NDArray[np.float64]) -> NDArray[np.float64]:
    """Read a picture between its texels.

    Parameters
    ----------
    image : (h, w) float
        Row 0 on top.
    place : (n, 2) float
        Column and row, centres at whole numbers; clipped to the picture.

    Returns
    -------
    values : (n,) float64
        Bilinear.
    """
    rows, columns = image.shape
    x, y = np.clip(place[:, 0], 0, columns - 1), np.clip(place[:, 1], 0, rows - 1)
    c, r = np.minimum(x.astype(int), max(columns - 2, 0)), np.minimum(y.astype(int), max(rows - 2, 0))
    u, v = x - c, y - r
    right, below = np.minimum(c + 1, columns - 1), np.minimum(r + 1, rows - 1)
    upper = image[r, c] * (1 - u) + image[r, right] * u
    return upper * (1 - v) + (image[below, c] * (1 - u) + image[below, right] * u) * v
