"""The fields of a recipe, made on a surface: pictures and strokes are read here, all else computes itself."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from surftex.errors import RecipeError
from surftex.fields.curvature import curvature_field
from surftex.fields.fieldset import FieldSet
from surftex.fields.noise import Noise
from surftex.fields.sources import Field, gradient_field, image_field, noise_field, part_field
from surftex.randomness import stream
from surftex.recipe.fields import (
    DIRECTIONS,
    AxisEntry,
    CurvatureEntry,
    DirectionEntry,
    GradientEntry,
    ImageEntry,
    NoiseEntry,
    PartEntry,
    StrokesEntry,
)
from surftex.recipe.model import Recipe
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

if TYPE_CHECKING:
    from surftex.geodesics.directions import DirectionField


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
        Directions are computed when they are first asked for.

    Raises
    ------
    RecipeError
        If a file cannot be read, or does not fit the surface; the message names the field.
    """
    numbers: dict[str, Field | str | float] = {}
    directions: dict[str, Callable[[], DirectionField]] = {}
    for name, entry in recipe.fields_.items():
        try:
            if isinstance(entry, DIRECTIONS):
                directions[name] = _direction(name, entry, surface)
            else:
                numbers[name] = _number(name, entry, surface, recipe.seed)
        except RecipeError as problem:
            raise RecipeError(f"fields.{name}: {problem}") from None
    return FieldSet(surface, numbers, directions)


def _number(name: str, entry: Any, surface: Surface, seed: int) -> Field | str | float:
    match entry:
        case ImageEntry():
            from surftex.files.pictures import read_mask

            return image_field(surface, read_mask(entry.image, entry.channel), Path(entry.image).name)
        case PartEntry():
            return part_field(surface, entry.part)
        case GradientEntry():
            return gradient_field(surface, entry.gradient, entry.start, entry.end)
        case NoiseEntry():
            noise = Noise(stream(seed, "field", name), entry.wavelength, entry.noise, entry.gain)
            return noise_field(surface, noise, entry.low, entry.high)
        case CurvatureEntry():
            return curvature_field(surface, entry.curvature, entry.radius)
    return entry


def _direction(name: str, entry: Any, surface: Surface) -> "Callable[[], DirectionField]":
    if isinstance(entry, StrokesEntry):
        points, angle = read_strokes(entry.strokes, surface)
        return lambda: _directions().from_strokes(surface, points, angle)
    if isinstance(entry, AxisEntry):
        if not any(entry.axis):
            raise RecipeError("axis = [0, 0, 0] is no direction; write three numbers such as [0, 0, 1]")
        return lambda: _directions().from_axis(surface, entry.axis)
    if isinstance(entry, DirectionEntry) and entry.direction == "curvature":
        return lambda: _directions().from_curvature(surface)
    return lambda: _directions().smoothest(surface)


def _directions() -> "type[DirectionField]":
    from surftex.geodesics.directions import DirectionField

    return DirectionField


def read_strokes(path: str | Path, surface: Surface) -> tuple[SurfacePoints, np.ndarray]:
    """Read strokes and lay them onto a surface.

    Parameters
    ----------
    path : path
        JSON: ``{"strokes": [[[x, y, z], ...], ...]}``, polylines in the mesh file's own axes and unit.
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
    from surftex.surface.closest import closest_points

    file = Path(path)
    try:
        if file.stat().st_size > 64 * 2**20:
            raise RecipeError(f"{file.name} has {file.stat().st_size} bytes; are these strokes?")
        content = json.loads(file.read_bytes())
        lines = [np.asarray(line, np.float64).reshape(-1, 3) for line in content["strokes"]]
    except OSError as problem:
        raise RecipeError(f"strokes {str(file)!r} cannot be read: {problem.strerror}") from None
    except (ValueError, KeyError, TypeError, RecursionError) as problem:
        if isinstance(problem, RecipeError):
            raise
        raise RecipeError(
            f'{file.name} holds no strokes; write {{"strokes": [[[x, y, z], ...], ...]}}'
        ) from None
    pieces = [np.stack([line[:-1], line[1:]]) for line in lines if len(line) > 1]
    if not pieces:
        raise RecipeError(f"{file.name} holds no stroke of two points or more")
    start, end = np.concatenate(pieces, axis=1) * surface.mm_per_unit - surface.origin_mm
    if not (np.isfinite(start).all() and np.isfinite(end).all()):
        raise RecipeError(f"{file.name} holds coordinates that are not finite")
    points, _ = closest_points(surface, (start + end) / 2)
    along = np.einsum("pki,pi->pk", surface.frame[points.face, :2], end - start)
    kept = np.linalg.norm(along, axis=1) > 1e-9 * np.maximum(np.linalg.norm(end - start, axis=1), 1e-300)
    if not kept.any():
        raise RecipeError(f"no stroke of {file.name} has a direction on the surface")
    chosen = SurfacePoints.trusted(points.face[kept], points.barycentric[kept])
    return chosen, np.arctan2(along[kept, 1], along[kept, 0])
