"""What is laid over the look: charts and regions in colours of their own, seams as lines, features as dots, what was drawn."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.charts.atlas import Atlas
from surftex.features.through import curves_through
from surftex.geodesics.paths import polyline
from surftex.geodesics.pieces import barycentric_of
from surftex.preview.live import Live
from surftex.preview.session import Drawing
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

COLOURS = ("charts", "regions")
"""Overlays that take the place of the colour."""

MOST_DOTS = 60_000
"""Features of a kind that are drawn; of more, every so many-th."""

_STEP = np.uint32(2654435769)


def painted(live: Live, what: str) -> NDArray[np.uint8]:
    """Paint the page of what is shown by charts, or by regions.

    Parameters
    ----------
    live : Live
        Drawn at least once.
    what : str
        One of `COLOURS`.

    Returns
    -------
    picture : (h, w, 3) uint8
        sRGB codes; grey where there is no region.
    """
    number = live.atlas.chart[live.texels.host] if what == "charts" else live.channel("region")
    page = np.full((live.resolution**2, 3), 120, np.uint8)
    page[live.texels.texel] = distinct(number)
    return page.reshape(live.resolution, live.resolution, 3)


def distinct(number: NDArray[np.integer]) -> NDArray[np.uint8]:
    """Give every number a colour unlike that of its neighbours.

    Parameters
    ----------
    number : (n,) int
        Below 0 is grey.

    Returns
    -------
    color : (n, 3) uint8
        Pastel.
    """
    mixed = (number.astype(np.int64) + 1).astype(np.uint32) * _STEP
    mixed ^= mixed >> np.uint32(15)
    hue = (mixed & np.uint32(1023)).astype(np.float32) / 1024 * 6
    light = 150 + 90 * ((mixed >> np.uint32(10)) & np.uint32(255)).astype(np.float32) / 255
    parts = [np.clip(np.abs((hue - shift) % 6 - 3) - 1, 0, 1) for shift in (0, 2, 4)]
    color = light[:, None] * (0.45 + 0.55 * np.stack(parts, axis=1))
    color[number < 0] = 120
    return color.astype(np.uint8)


def seam_lines(surface: Surface, atlas: Atlas) -> NDArray[np.float64]:
    """Lines where the unwrap is cut.

    Parameters
    ----------
    surface : Surface
        What is unwrapped.
    atlas : Atlas
        Its unwrap.

    Returns
    -------
    lines : (n, 2, 3) float64
        Ends of each edge, in the frame of `Surface.vertices`.
    """
    face, side = np.nonzero(atlas.seam)
    ends = surface.faces[face, side], surface.faces[face, (side + 1) % 3]
    return np.stack([surface.vertices[end] for end in ends], axis=1)


def walked(surface: Surface, drawing: Drawing) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lines and places that were drawn, as they lie on the surface: curves smooth, as they are baked, others straight.

    Parameters
    ----------
    surface : Surface
        What they were drawn on.
    drawing : Drawing
        Of one field.

    Returns
    -------
    lines : (n, 2, 3) float64
        Ends of straight pieces, in the frame of `Surface.vertices`; none of a stroke that no way connects.
    dots : (k, 3) float64
        Single places.
    """
    lines, dots = [np.zeros((0, 2, 3))], [np.zeros((0, 3))]
    for stroke in drawing.strokes:
        one = np.zeros(len(stroke.points), np.int32)
        if drawing.use == "curves":
            pieces = curves_through(surface, stroke.points, one, chord_mm=[surface.mean_edge_mm])
        else:
            pieces, _ = polyline(surface, stroke.points, one)
        ends = [
            SurfacePoints.trusted(pieces.face, barycentric_of(surface, pieces.face, place)).positions(surface)
            for place in (pieces.start, pieces.end)
        ]
        lines.append(np.stack(ends, axis=1))
    dots += [point.positions(surface) for point in drawing.points.values()]
    return np.concatenate(lines), np.concatenate(dots)


def feature_dots(surface: Surface, features: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[np.float64]]:
    """Places of features, by kind.

    Parameters
    ----------
    surface : Surface
        Where they lie.
    features : mapping of str to structured array
        As patterns have them.

    Returns
    -------
    dots : dict of str to (n, 3) float64
        In the frame of `Surface.vertices`, at most `MOST_DOTS` of each kind.
    """
    dots = {}
    for kind, table in features.items():
        if len(table) and {"face", "barycentric"} <= set(table.dtype.names or ()):
            rows = table[:: -(-len(table) // MOST_DOTS)]
            points = SurfacePoints.trusted(
                np.ascontiguousarray(rows["face"]), np.ascontiguousarray(rows["barycentric"])
            )
            dots[kind] = points.positions(surface)
    return dots
