"""Where numbers on a surface come from: a picture through the mesh's own UVs, a part, an axis, noise.

Each function returns a `Field`: called with points (and the samples' footprints, where known) it gives one
number per point, and never depends on other points. The fields made here also know their `span`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.errors import RecipeError
from surftex.fields.noise import Noise
from surftex.fields.spans import Pixels, Span, over_corners
from surftex.surface.parts import chosen_faces
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

Field = Callable[..., NDArray[np.float64]]
"""``field(points, footprint_mm=0.0) -> (n,) float64``."""

_MOST_TOLD = 8
"""Numbers of a picture that a message lists."""


@dataclass(frozen=True, eq=False)
class SpannedField:
    """A `Field` with bounds on every face.

    Attributes
    ----------
    value : Field
        What it is at points.
    span : callable
        ``span()`` gives the least and the greatest value possible on each of the m faces, (m,) each.
    narrow : callable, optional
        The same, narrower where that takes time; without it `span` is as narrow as is known.
    """

    value: Field
    span: Callable[[], Span]
    narrow: Callable[[], Span] | None = None

    def __call__(self, points: SurfacePoints, footprint_mm: NDArray | float = 0.0) -> NDArray[np.float64]:
        """Evaluate at points."""
        return self.value(points, footprint_mm)


def file_positions(surface: Surface, points: SurfacePoints) -> NDArray[np.float64]:
    """Places in space as the file counts them.

    Parameters
    ----------
    surface : Surface
        Where the points lie.
    points : SurfacePoints
        n points.

    Returns
    -------
    positions : (n, 3) float64
        Millimetres from the file's own zero.
    """
    return points.positions(surface) + surface.origin_mm


def constant_field(value: float) -> Field:
    """Give the same number everywhere.

    Parameters
    ----------
    value : float
        The number.

    Returns
    -------
    field : Field
        Constant.
    """
    return lambda points, footprint_mm=0.0: np.full(len(points), float(value))


def made_once(make: Callable[[], SpannedField]) -> SpannedField:
    """Put off the work of a field until it is first asked, and keep what it made.

    Parameters
    ----------
    make : callable
        Makes the field; it is called once, whichever thread asks first.

    Returns
    -------
    field : SpannedField
        As `make` makes it.
    """
    lock, made = Lock(), list[SpannedField]()

    def field() -> SpannedField:
        with lock:
            if not made:
                made.append(make())
        return made[0]

    return SpannedField(
        lambda points, footprint_mm=0.0: field()(points, footprint_mm), lambda: field().span()
    )


def span_of(field: Field, surface: Surface) -> Span:
    """Bound a field on each face.

    Parameters
    ----------
    field : Field
        With or without a span.
    surface : Surface
        m faces.

    Returns
    -------
    low : (m,) float64
        -inf where nothing is known.
    high : (m,) float64
        inf where nothing is known.
    """
    if isinstance(field, SpannedField):
        return field.span()
    return np.full(len(surface.faces), -np.inf), np.full(len(surface.faces), np.inf)


def carried(field: SpannedField, face: NDArray[np.integer]) -> SpannedField:
    """Carry a field over to some faces of its surface that are a surface of their own.

    Parameters
    ----------
    field : SpannedField
        On the whole.
    face : (k,) int
        Face of the whole that each own face is.

    Returns
    -------
    field : SpannedField
        The same numbers at the same places.
    """
    there = np.asarray(face, np.int32)

    def value(points: SurfacePoints, footprint_mm: NDArray | float = 0.0) -> NDArray[np.float64]:
        return field(SurfacePoints.trusted(there[points.face], points.barycentric), footprint_mm)

    def span() -> Span:
        low, high = field.span()
        return low[there], high[there]

    return SpannedField(value, span)


def corner_field(values: NDArray[np.float64]) -> SpannedField:
    """Interpolate numbers at the corners of faces.

    Parameters
    ----------
    values : (m, 3) float64
        At the corners of each face.

    Returns
    -------
    field : SpannedField
        Linear inside faces.
    """
    return SpannedField(
        lambda points, footprint_mm=0.0: np.einsum("pk,pk->p", points.barycentric, values[points.face]),
        lambda: over_corners(values),
    )


def part_field(surface: Surface, name: str) -> SpannedField:
    """Give 1 on a part of the mesh and 0 elsewhere.

    Parameters
    ----------
    surface : Surface
        With named parts.
    name : str
        As `surftex.surface.parts.chosen_faces` looks it up: material slots first, then groups, then nodes.

    Returns
    -------
    field : Field
        0 or 1.

    Raises
    ------
    RecipeError
        If the mesh has no such part; with the names it has.
    """
    on_part = chosen_faces(surface.labels, name, "the mesh", error=RecipeError).astype(np.float64)
    return SpannedField(lambda points, footprint_mm=0.0: on_part[points.face], lambda: (on_part, on_part))


def gradient_field(
    surface: Surface, axis: ArrayLike, start_mm: float | None = None, end_mm: float | None = None
) -> SpannedField:
    """Rise from 0 to 1 along an axis.

    Parameters
    ----------
    surface : Surface
        Whose extent is taken where an end is not given.
    axis : (3,) float
        Direction in the file's axes; any length but 0.
    start_mm : float, optional
        Coordinate along the axis where the field is 0.
    end_mm : float, optional
        Coordinate along the axis where the field is 1.

    Returns
    -------
    field : Field
        0 to 1, linear between the ends.

    Raises
    ------
    RecipeError
        If the axis has no length, or the ends coincide.
    """
    along = np.asarray(axis, np.float64)
    length = np.linalg.norm(along)
    if along.shape != (3,) or not 0 < length < np.inf:
        raise RecipeError(f"axis = {axis} is no direction; write three numbers such as [0, 0, 1]")
    along = along / length
    extent = (surface.vertices + surface.origin_mm) @ along
    start = float(extent.min()) if start_mm is None else start_mm
    end = float(extent.max()) if end_mm is None else end_mm
    if start == end:
        raise RecipeError(
            f"a gradient that starts and ends at {start:g} mm has no slope; does the surface extend along it?"
        )

    def risen(places: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.clip((places @ along - start) / (end - start), 0.0, 1.0)

    return SpannedField(
        lambda points, footprint_mm=0.0: risen(file_positions(surface, points)),
        lambda: over_corners(risen(surface.vertices + surface.origin_mm)[surface.faces]),
    )


def noise_field(surface: Surface, noise: Noise, low: float = 0.0, high: float = 1.0) -> SpannedField:
    """Let noise vary a number.

    Parameters
    ----------
    surface : Surface
        Where the points lie.
    noise : Noise
        What is evaluated at their places.
    low : float
        Value for noise of -1; the field never goes below.
    high : float
        Value for noise of 1; the field never goes above.

    Returns
    -------
    field : Field
        From `low` to `high`.
    """

    def field(points: SurfacePoints, footprint_mm: NDArray | float = 0.0) -> NDArray[np.float64]:
        share = 0.5 + 0.5 * noise.at(points.positions(surface), footprint_mm).astype(np.float64)
        return low + (high - low) * np.clip(share, 0.0, 1.0)

    every = np.ones(len(surface.faces))
    return SpannedField(field, lambda: (min(low, high) * every, max(low, high) * every))


def image_field(
    surface: Surface, picture: NDArray[np.floating], name: str = "image", label: int | None = None
) -> SpannedField:
    """Read a picture through the mesh's own UVs, between texels bilinearly, repeating outside 0..1.

    Parameters
    ----------
    surface : Surface
        With UVs of its own.
    picture : (h, w) float
        Row 0 on top.
    name : str
        What messages call the picture.
    label : int, optional
        Give 1 where the nearest texel is this number, and 0 elsewhere.

    Returns
    -------
    field : SpannedField
        The picture's numbers.

    Raises
    ------
    RecipeError
        If the mesh has no UVs, the picture has another shape or values that are not finite, no texel has the
        label, or the picture varies beside the mesh's own unwrap only.
    """
    if surface.corner_uv is None:
        raise RecipeError(
            f"{name} needs the mesh's own UVs, and {surface.name} has none; paint it over an axis instead"
        )
    pixels = np.asarray(picture, np.float64)
    if pixels.ndim != 2 or pixels.size == 0:
        raise RecipeError(f"{name} has shape {pixels.shape}; a mask is one number per pixel, (height, width)")
    if not np.isfinite(pixels).all():
        raise RecipeError(f"{name} holds {np.count_nonzero(~np.isfinite(pixels))} pixels that are not finite")
    if label is not None:
        labelled = pixels == label
        if not labelled.any():
            held = np.unique(pixels)
            some = ", ".join(f"{value:g}" for value in held[:_MOST_TOLD])
            more = f" and {len(held) - _MOST_TOLD} more" if len(held) > _MOST_TOLD else ""
            raise RecipeError(f"no pixel of {name} has the label {label}; it holds {some}{more}")
        pixels = labelled.astype(np.float64)
    corner_uv, (height, width) = surface.corner_uv, pixels.shape
    low, high = Pixels(pixels).over(corner_uv)
    if low.min() == high.max() and pixels.min() < pixels.max():
        raise RecipeError(
            f"{name} varies, but is {low[0]:g} wherever {surface.name} has UVs; was it painted for another mesh?"
        )

    def field(points: SurfacePoints, footprint_mm: NDArray | float = 0.0) -> NDArray[np.float64]:
        uv = np.einsum("pk,pki->pi", points.barycentric, corner_uv[points.face])
        column = uv[:, 0] * width - 0.5
        row = (1 - uv[:, 1]) * height - 0.5
        if label is not None:
            column, row = np.rint(column), np.rint(row)
        left, top = np.floor(column), np.floor(row)
        across, down = column - left, row - top
        i, j = left.astype(np.int64) % width, top.astype(np.int64) % height
        right, below = (i + 1) % width, (j + 1) % height
        upper = pixels[j, i] * (1 - across) + pixels[j, right] * across
        lower = pixels[below, i] * (1 - across) + pixels[below, right] * across
        return upper * (1 - down) + lower * down

    return SpannedField(field, lambda: (low, high), lambda: Pixels(pixels).within(corner_uv))
