"""Entries of a recipe's ``[fields]``: named numbers and directions on the surface.

A number or an expression stands for itself; everything else is a table with one key that says what it is:
``image``, ``part``, ``gradient``, ``noise`` or ``curvature`` for numbers, ``strokes``, ``axis`` or
``direction`` for directions.
"""

from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    StrictFloat,
    StrictInt,
    StrictStr,
    Tag,
)

from surftex.errors import RecipeError
from surftex.units import length_mm


def _length(value: Any) -> Any:
    try:
        return length_mm(value) if isinstance(value, (str, int, float)) else value
    except RecipeError as problem:
        raise ValueError(str(problem)) from None


Millimetres = Annotated[float, BeforeValidator(_length), Field(allow_inf_nan=False)]
PositiveMillimetres = Annotated[float, BeforeValidator(_length), Field(gt=0, allow_inf_nan=False)]
Number = Annotated[StrictFloat | StrictInt, Field(allow_inf_nan=False)]
Axis = Annotated[tuple[Number, Number, Number], Field(description="Direction in the file's axes.")]


class _Entry(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class ImageEntry(_Entry):
    """A picture read through the mesh's own UVs: 0 is black, 1 is white."""

    image: StrictStr
    channel: Literal["luminance", "red", "green", "blue", "alpha"] = "luminance"


class PartEntry(_Entry):
    """1 on a part of the mesh, 0 elsewhere."""

    part: StrictStr


class GradientEntry(_Entry):
    """From 0 to 1 along an axis, over the mesh's extent or between two coordinates."""

    gradient: Axis
    start: Millimetres | None = None
    end: Millimetres | None = None


class NoiseEntry(_Entry):
    """Noise between `low` and `high`; ``noise`` is the number of octaves."""

    noise: Annotated[StrictInt, Field(ge=1, le=12)]
    wavelength: PositiveMillimetres
    gain: Annotated[Number, Field(gt=0, le=1)] = 0.5
    low: Number = 0.0
    high: Number = 1.0


class CurvatureEntry(_Entry):
    """1 where the surface bends outward (convex) or inward (concave) as much as a ball of `radius`."""

    curvature: Literal["convex", "concave"]
    radius: PositiveMillimetres


class StrokesEntry(_Entry):
    """A direction that runs along strokes: a JSON file of polylines."""

    strokes: StrictStr


class AxisEntry(_Entry):
    """A direction that follows an axis of space, laid onto the surface."""

    axis: Axis


class DirectionEntry(_Entry):
    """A direction from the surface alone: the smoothest there is, or the one that it bends most in."""

    direction: Literal["smooth", "curvature"]


KINDS: dict[str, type[_Entry]] = {
    "image": ImageEntry,
    "part": PartEntry,
    "gradient": GradientEntry,
    "noise": NoiseEntry,
    "curvature": CurvatureEntry,
    "strokes": StrokesEntry,
    "axis": AxisEntry,
    "direction": DirectionEntry,
}
"""The key that says what an entry is, and the entry."""


def _kind(value: Any) -> str | None:
    if isinstance(value, _Entry):
        return next(key for key, model in KINDS.items() if isinstance(value, model))
    if isinstance(value, dict):
        found = [key for key in KINDS if key in value]
        return found[0] if len(found) == 1 else None
    return "expression" if isinstance(value, (str, int, float)) and not isinstance(value, bool) else None


FieldEntry = Annotated[
    Annotated[StrictStr | StrictFloat | StrictInt, Tag("expression")]
    | Annotated[ImageEntry, Tag("image")]
    | Annotated[PartEntry, Tag("part")]
    | Annotated[GradientEntry, Tag("gradient")]
    | Annotated[NoiseEntry, Tag("noise")]
    | Annotated[CurvatureEntry, Tag("curvature")]
    | Annotated[StrokesEntry, Tag("strokes")]
    | Annotated[AxisEntry, Tag("axis")]
    | Annotated[DirectionEntry, Tag("direction")],
    Discriminator(
        _kind,
        custom_error_type="field_kind",
        custom_error_message=f"a field is a number, an expression, or a table with one of {', '.join(KINDS)}",
    ),
]
"""One entry of ``[fields]``."""

DIRECTIONS = (StrokesEntry, AxisEntry, DirectionEntry)
"""Entries that are directions; all others are numbers."""
