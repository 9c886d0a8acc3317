"""The face: masks and lines drawn once on a canonical face, carried to a head by a few landmarks picked on it.

The canonical face is that of MediaPipe [1]_, whose landmarks are kept in ``data/face.json``; masks and lines are our own.

References
----------
.. [1] The MediaPipe Authors. Canonical face model. Apache License 2.0.
"""

import json
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError, SurfaceError
from surftex.features.curves import curve_table
from surftex.features.growth import spline
from surftex.features.landmarks import Warp
from surftex.fields.sources import SpannedField, file_positions
from surftex.fields.spans import Span
from surftex.surface.closest import closest_points
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_BACK_CM, _FRONT_CM = -5.0, -2.5
"""Masks of the front fade out between these depths of the canonical face."""

_FARTHEST_CM = 1.5
"""A control of a line that lands farther from the surface than this has missed the face."""


@cache
def face_atlas() -> Mapping[str, Any]:
    """Read the canonical face.

    Returns
    -------
    atlas : mapping
        ``landmarks``: place of each name, cm; ``masks``; ``lines``.
    """
    text = resources.files("surftex.fields").joinpath("data/face.json").read_text("utf-8")
    return json.loads(text)


def face_mask(surface: Surface, picks: Mapping[str, SurfacePoints], name: str) -> SpannedField:
    """Make a mask of a part of the face.

    Parameters
    ----------
    surface : Surface
        A head; m faces.
    picks : mapping of str to SurfacePoints
        One point for each landmark that was picked; at least four.
    name : str
        Such as ``lips``; one of the masks of `face_atlas`.

    Returns
    -------
    mask : SpannedField
        1 inside, 0 outside, soft at its border.

    Raises
    ------
    RecipeError
        If there is no such mask, or the landmarks do not fit.
    """
    drawn = _known(name, face_atlas()["masks"], "mask")
    soft = float(drawn["soft"])
    warp = Warp.between(*_pairs(surface, picks, to_face=True))

    def outside(places: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far outside the mask places in space are, in parts of its softness: -1 in, 1 out."""
        return _outside(drawn, warp(places)) / soft

    place = surface.vertices + surface.origin_mm
    corner = outside(place)[surface.faces]
    edge = surface.edge_length.max(axis=1)
    # No point of a face is farther from its nearest corner than this.
    reach = edge / np.sqrt(3)
    room = warp.steepness(place[surface.faces[:, 0]], edge) * reach / soft
    low, high = _softened(corner.max(axis=1) + room), _softened(corner.min(axis=1) - room)
    open_faces = high > low  # on all others the mask is the same everywhere

    def field(points: SurfacePoints, footprint_mm: NDArray | float = 0.0) -> NDArray[np.float64]:
        value = low[points.face]
        rows = np.flatnonzero(open_faces[points.face])
        if len(rows):
            some = SurfacePoints.trusted(points.face[rows], points.barycentric[rows])
            value[rows] = _softened(outside(file_positions(surface, some)))
        return value

    def span() -> Span:
        return low, high

    return SpannedField(field, span)


def face_lines(
    surface: Surface,
    picks: Mapping[str, SurfacePoints],
    names: tuple[str, ...],
    *,
    width: float = 1.0,
    depth: float = 1.0,
    threads: int | None = None,
) -> NDArray:
    """Draw lines of the face.

    Parameters
    ----------
    surface : Surface
        A head.
    picks : mapping of str to SurfacePoints
        One point for each landmark that was picked; at least four.
    names : tuple of str
        Groups of lines, such as ``crows_feet``; of those of `face_atlas`.
    width : float
        Times the width of each group.
    depth : float
        Times its depth.
    threads : int, optional
        None means every core; cannot change the result.

    Returns
    -------
    table : (p,) structured array
        Rows of `surftex.features.curves`, with ``width_mm`` and ``depth_mm``.

    Raises
    ------
    RecipeError
        If there is no such group, the landmarks do not fit, or a line misses the surface.
    """
    warp = Warp.between(*_pairs(surface, picks, to_face=False))
    controls, curve, wide, deep = [], [], [], []
    for name in names:
        group = _known(name, face_atlas()["lines"], "line")
        for line, scale in zip(group["curves"], group["scales"], strict=True):
            controls.append(np.asarray(line, np.float64))
            curve.append(np.full(len(line), len(wide)))
            wide.append(group["width_mm"] * width * scale)
            deep.append(group["depth_mm"] * depth * scale)
    place = warp(np.concatenate(controls))
    points, distance = _on_skin(surface, picks, place)
    if (distance > _FARTHEST_CM * warp.scale).any():
        raise RecipeError(
            f"face_lines: {int((distance > _FARTHEST_CM * warp.scale).sum())} of {len(place)} places miss the surface, by up "
            f"to {distance.max():.3g} mm; pick more landmarks, or check those that there are"
        )
    pieces = spline(surface, points, np.concatenate(curve), threads=threads)
    return curve_table(surface, pieces, width_mm=np.array(wide), depth_mm=np.array(deep))


def _on_skin(
    surface: Surface, picks: Mapping[str, SurfacePoints], place: NDArray[np.float64]
) -> tuple[SurfacePoints, NDArray[np.float64]]:
    """Lay places onto the component that most landmarks lie on, past eyeballs and lashes."""
    component = surface.component
    picked = np.concatenate([component[point.face] for point in picks.values()])
    own = np.flatnonzero(component == np.bincount(picked).argmax())
    skin = Surface.from_arrays(surface.vertices, surface.faces[own])
    points, distance = closest_points(skin, place - surface.origin_mm)
    return SurfacePoints(own[points.face].astype(np.int32), points.barycentric), distance


def _softened(outside: NDArray[np.float64]) -> NDArray[np.float64]:
    """Value of a mask: 1 from -1 down, 0 from 1 up."""
    t = np.clip((1 - outside) / 2, 0.0, 1.0)
    return t * t * (3 - 2 * t)


def _pairs(
    surface: Surface, picks: Mapping[str, SurfacePoints], *, to_face: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Pair picked landmarks in space and on the canonical face, those that are carried first."""
    known = face_atlas()["landmarks"]
    for name in picks:
        _known(name, known, "landmark")
    if not picks:
        raise RecipeError(f"no landmarks are picked; known are {', '.join(known)}")
    space = np.concatenate([file_positions(surface, point) for point in picks.values()])
    face = np.array([known[name] for name in picks], np.float64)
    try:
        Warp.between(space, face)
    except SurfaceError as problem:
        raise RecipeError(str(problem)) from None
    return (space, face) if to_face else (face, space)


def _known(name: str, known: Mapping[str, Any], what: str) -> Any:
    if name not in known:
        from difflib import get_close_matches

        near = get_close_matches(name, list(known), 1)
        hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}"
        raise RecipeError(f"the face has no {what} {name!r}; {hint}")
    return known[name]


def _outside(drawn: Mapping[str, Any], place: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) cm to the border of a mask, below 0 inside; places at the back of the head are outside."""
    if "balls" in drawn:
        return np.min([_to_ellipsoid(place, np.array(ball)) for ball in drawn["balls"]], axis=0)
    flat = place[:, :2]
    if "outline" in drawn:
        away = _to_polygon(flat, np.array(drawn["outline"]))
    else:
        away = np.min([_to_ellipsoid(flat, np.array(each)) for each in drawn["ellipses"]], axis=0)
    behind = np.clip((_FRONT_CM - place[:, 2]) / (_FRONT_CM - _BACK_CM), 0, 1)
    return away + 10 * float(drawn["soft"]) * behind


def _to_ellipsoid(place: NDArray[np.float64], shape: NDArray[np.float64]) -> NDArray[np.float64]:
    """About the distance to an ellipse or ellipsoid: right on its border, and no steeper than a distance."""
    size = place.shape[1]
    half = shape[size:]
    return (np.linalg.norm((place - shape[:size]) / half, axis=1) - 1) * half.min()


def _to_polygon(place: NDArray[np.float64], corner: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance to a polygon, below 0 inside."""
    best = np.full(len(place), np.inf)
    inside = np.zeros(len(place), bool)
    for start, end in zip(corner, np.roll(corner, -1, axis=0), strict=True):
        along, step = end - start, place - start
        share = np.clip(step @ along / (along @ along), 0, 1)
        best = np.minimum(best, np.hypot(*(step - share[:, None] * along).T))
        crosses = (start[1] > place[:, 1]) != (end[1] > place[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            at = start[0] + (place[:, 1] - start[1]) / (end[1] - start[1]) * along[0]
        inside ^= crosses & (place[:, 0] < at)
    return np.where(inside, -best, best)
