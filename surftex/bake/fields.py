"""The fields of a recipe, made on a surface: pictures and strokes are read here, all else computes itself."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surftex.bake.locating import located
from surftex.errors import InputError, RecipeError
from surftex.fields.attributes import attribute_field, occlusion_field, slope_field
from surftex.fields.curvature import curvature_field
from surftex.fields.fieldset import Derived, FieldSet
from surftex.fields.noise import Noise
from surftex.fields.sources import (
    Field,
    SpannedField,
    gradient_field,
    image_field,
    made_once,
    noise_field,
    part_field,
)
from surftex.randomness import stream
from surftex.recipe.fields import (
    CURVES,
    DIRECTIONS,
    AttributeEntry,
    AxisEntry,
    CurvatureEntry,
    CurvesEntry,
    DirectionEntry,
    DistanceEntry,
    FaceEntry,
    FaceLinesEntry,
    GradientEntry,
    ImageEntry,
    NoiseEntry,
    OcclusionEntry,
    PartEntry,
    SlopeEntry,
    StrokesEntry,
    VectorAttributeEntry,
    VectorsEntry,
    expression_of,
    places_file,
)
from surftex.recipe.model import Recipe
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

if TYPE_CHECKING:
    from surftex.fields.vectors import VectorField
    from surftex.files.strokes import Stroke
    from surftex.geodesics.directions import DirectionField

Made = Callable[[], "DirectionField | VectorField"]


def make_fields(recipe: Recipe, surface: Surface) -> FieldSet:
    """Make the fields of a recipe.

    Parameters
    ----------
    recipe : Recipe
        Whose ``[fields]`` to make.
    surface : Surface
        Where.

    Returns
    -------
    fields : FieldSet
        What takes time (directions, curves, distances, occlusion) is computed when it is first asked for, once.

    Raises
    ------
    RecipeError
        If a file cannot be read, or does not fit the surface; the message names the field, and its line.
    """
    numbers: dict[str, Field | Derived | str | float] = {}
    directions: dict[str, Made] = {}
    curves: dict[str, Callable[[], NDArray[Any]]] = {}
    points: dict[str, Callable[[], SurfacePoints]] = {}
    for name, entry in recipe.fields_.items():
        where = f"{recipe.where('fields', name)}fields.{name}: "
        with _Located(where):
            if isinstance(entry, DIRECTIONS):
                directions[name] = _located(where, _direction(entry, surface))
            elif isinstance(entry, CURVES):
                curves[name] = _located(where, _curves(entry, surface))
            else:
                numbers[name] = _number(name, entry, surface, recipe.seed, where)
                if (path := places_file(entry)) is not None:
                    points[name] = _located(where, lambda path=path: _drawn(path, surface)[1])
    with located(recipe, "fields"):
        return FieldSet(surface, numbers, directions, curves, points)


class _Located:
    """Puts the place of an entry before what is wrong with it."""

    def __init__(self, where: str) -> None:
        self.where = where

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: object, problem: object, trace: object) -> None:
        if isinstance(problem, InputError) and not str(problem).startswith(self.where):
            raise RecipeError(f"{self.where}{problem}") from None


def _located(where: str, make: Callable[[], Any]) -> Callable[[], Any]:
    def made() -> Any:
        with _Located(where):
            return make()

    return made


def _number(name: str, entry: Any, surface: Surface, seed: int, where: str) -> Field | Derived | str | float:
    match entry:
        case ImageEntry():
            return _image(entry, surface)
        case AttributeEntry():
            return attribute_field(surface, entry.attribute, entry.channel, entry.label)
        case PartEntry():
            return part_field(surface, entry.part)
        case GradientEntry():
            return gradient_field(surface, entry.gradient, entry.start, entry.end)
        case SlopeEntry():
            return slope_field(surface, entry.slope)
        case NoiseEntry():
            noise = Noise(stream(seed, "field", name), entry.wavelength, entry.noise, entry.gain)
            return noise_field(surface, noise, entry.low, entry.high)
        case CurvatureEntry():
            return made_once(_located(where, lambda: curvature_field(surface, entry.curvature, entry.radius)))
        case OcclusionEntry():
            return made_once(_located(where, lambda: occlusion_field(surface, entry.occlusion)))
        case DistanceEntry():
            return _distance(entry, surface, where)
        case FaceEntry():
            from surftex.fields.face import face_mask

            return face_mask(surface, _landmarks(entry.landmarks, surface), entry.face)
    return entry


def _image(entry: ImageEntry, surface: Surface) -> SpannedField:
    from surftex.files.pictures import read_codes, read_mask

    name = Path(entry.image).name
    pixels = (
        read_mask(entry.image, entry.channel)
        if entry.label is None
        else read_codes(entry.image, entry.channel)
    )
    if entry.size is not None and pixels.shape != entry.size[::-1]:
        raise RecipeError(
            f"{name} has {pixels.shape[1]} x {pixels.shape[0]} pixels, not size = {list(entry.size)}"
        )
    return image_field(surface, pixels, name, entry.label)


def _distance(entry: DistanceEntry, surface: Surface, where: str) -> Field | Derived:
    from surftex.fields.contours import contour
    from surftex.fields.distances import distance_field, point_pieces

    expression = expression_of(entry)
    if expression is not None:

        def border(mask: SpannedField) -> SpannedField:
            with _Located(where):
                level = float(entry.level)
                pieces = contour(surface, mask, level=level)
                return distance_field(surface, pieces, mask=mask, level=level, limit_mm=entry.limit)

        return Derived(expression, border)
    if isinstance(entry.distance_to, str):
        lines, points = _drawn(entry.distance_to, surface)
        pieces = lines.joined([lines, point_pieces(surface, points)])
    else:
        from surftex.surface.closest import closest_points

        place = np.array([entry.distance_to], np.float64) * surface.mm_per_unit - surface.origin_mm
        pieces = point_pieces(surface, closest_points(surface, place)[0])
    return made_once(_located(where, lambda: distance_field(surface, pieces, limit_mm=entry.limit)))


def _drawn(path: str, surface: Surface) -> Any:
    """Lines of a file as pieces, and its single places."""
    from surftex.files.strokes import read_strokes
    from surftex.geodesics.paths import polyline

    read = read_strokes(path, surface)
    lines = [stroke.points for stroke in _lines(read.strokes, path, surface)]
    single = [stroke.points for stroke in read.strokes if len(stroke.points) == 1] + [*read.points.values()]
    number = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    pieces, _ = polyline(surface, _joined(lines), number)
    return pieces, _joined(single)


def _lines(strokes: "Sequence[Stroke]", path: str, surface: Surface) -> "list[Stroke]":
    """Strokes of two points or more; each must lead somewhere, and stay on one piece of the mesh."""
    for i, stroke in enumerate(strokes):
        if len(stroke.points) < 2:
            continue
        where = f"{Path(path).name}: strokes[{i}]"
        if np.ptp(stroke.points.positions(surface), axis=0).max() <= 1e-6 * surface.mean_edge_mm:
            raise RecipeError(
                f"{where} has no length: its {len(stroke.points)} places are one on the surface"
            )
        component = surface.component[stroke.points.face]
        if (component != component[0]).any():
            at = int(np.argmax(component != component[0]))
            raise RecipeError(
                f"{where} leads from one piece of the mesh to another, which is not joined to it, between its places "
                f"{at} and {at + 1}; draw a stroke on each"
            )
    return [stroke for stroke in strokes if len(stroke.points) > 1]


def _joined(points: list[SurfacePoints]) -> SurfacePoints:
    return SurfacePoints(
        np.concatenate([np.zeros(0, np.int32), *[each.face for each in points]]),
        np.concatenate([np.zeros((0, 3)), *[each.barycentric for each in points]]),
    )


def _direction(entry: Any, surface: Surface) -> Made:
    make = _unturned(entry, surface)
    if not entry.perpendicular:
        return make

    def turned() -> "DirectionField | VectorField":
        from surftex.fields.vectors import VectorField

        made = make()
        if isinstance(made, VectorField):
            return VectorField(surface, lambda points: made.at(points)[:, ::-1] * np.array([-1.0, 1.0]))
        return made.turned(np.pi / 2)

    return turned


def _unturned(entry: Any, surface: Surface) -> Made:
    match entry:
        case StrokesEntry():
            points, angle = stroke_directions(entry.strokes, surface)
            return lambda: _directions().from_strokes(surface, points, angle, 2 if entry.perpendicular else 1)
        case AxisEntry():
            if not any(entry.axis):
                raise RecipeError("axis = [0, 0, 0] is no direction; write three numbers such as [0, 0, 1]")
            return lambda: _directions().from_axis(surface, entry.axis)
        case VectorsEntry():
            from surftex.fields.vectors import VectorField
            from surftex.files.pictures import read_picture

            picture, name = read_picture(entry.vectors), Path(entry.vectors).name
            vectors = VectorField.from_image(surface, picture, entry.longest, name)
            return lambda: vectors
        case VectorAttributeEntry():
            from surftex.fields.vectors import VectorField

            hung = VectorField.from_attribute(surface, entry.vector_attribute, entry.longest)
            return lambda: hung
        case DirectionEntry(direction="curvature"):
            return lambda: _directions().from_curvature(surface)
        case DirectionEntry(direction="least_curvature" | "langer"):
            return lambda: _directions().from_curvature(surface, "min")
    return lambda: _directions().smoothest(surface)


def _directions() -> "type[DirectionField]":
    from surftex.geodesics.directions import DirectionField

    return DirectionField


def _landmarks(path: str, surface: Surface) -> Mapping[str, SurfacePoints]:
    from surftex.files.strokes import read_strokes

    return read_strokes(path, surface).points


_CHORD = 0.5
"""Longest straight part of a drawn curve, in times its width: its groove bends without facets."""


def _curves(entry: CurvesEntry | FaceLinesEntry, surface: Surface) -> Callable[[], NDArray[Any]]:
    if isinstance(entry, FaceLinesEntry):
        from surftex.fields.face import face_lines

        picks = _landmarks(entry.landmarks, surface)
        return lambda: face_lines(surface, picks, entry.face_lines, width=entry.width, depth=entry.depth)
    from surftex.files.strokes import read_strokes

    strokes = _lines(read_strokes(entry.curves, surface).strokes, entry.curves, surface)
    if not strokes:
        raise RecipeError(f"{Path(entry.curves).name} holds no stroke of two points or more")

    def make() -> NDArray[Any]:
        from surftex.features.curves import curve_table
        from surftex.features.through import curves_through

        number = np.repeat(np.arange(len(strokes)), [len(stroke.points) for stroke in strokes])
        width = np.array([stroke.numbers.get("width_mm", entry.width) for stroke in strokes])
        points = _joined([stroke.points for stroke in strokes])
        pieces = curves_through(surface, points, number, chord_mm=_CHORD * width)
        depth = np.array([stroke.numbers.get("depth_mm", entry.depth) for stroke in strokes])
        return curve_table(surface, pieces, width_mm=width, depth_mm=depth)

    return make


def stroke_directions(path: str | Path, surface: Surface) -> tuple[SurfacePoints, NDArray[np.float64]]:
    """Read strokes as directions at places.

    Parameters
    ----------
    path : path
        As for `surftex.files.strokes.read_strokes`.
    surface : Surface
        What they were drawn on.

    Returns
    -------
    points : SurfacePoints
        Nearest the middle of each piece.
    angle_rad : (k,) float64
        Direction of each piece there.

    Raises
    ------
    RecipeError
        If the file cannot be read, or no stroke has a direction on the surface.
    """
    from surftex.files.strokes import read_strokes
    from surftex.surface.closest import closest_points

    name = Path(path).name
    lines = [stroke.points.positions(surface) for stroke in read_strokes(path, surface).strokes]
    pieces = [np.stack([line[:-1], line[1:]]) for line in lines if len(line) > 1]
    if not pieces:
        raise RecipeError(f"{name} holds no stroke of two points or more")
    start, end = np.concatenate(pieces, axis=1)
    points, _ = closest_points(surface, (start + end) / 2)
    along = np.einsum("pki,pi->pk", surface.frame[points.face, :2], end - start)
    size = np.linalg.norm(end - start, axis=1)
    kept = np.linalg.norm(along, axis=1) > 1e-6 * np.maximum(size, 1e-9 * surface.mean_edge_mm)
    if not kept.any():
        raise RecipeError(f"no stroke of {name} has a direction on the surface")
    chosen = SurfacePoints.trusted(points.face[kept], points.barycentric[kept])
    return chosen, np.arctan2(along[kept, 1], along[kept, 0])
