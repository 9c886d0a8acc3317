"""Entries of a recipe's ``[fields]``: named numbers, directions and curves on the surface.

A number or an expression stands for itself; everything else is a table with one key that says what it is, see
`KINDS`.
"""

from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    Discriminator,
    Field,
    StrictBool,
    StrictFloat,
    StrictInt,
    StrictStr,
    Tag,
    field_validator,
)

from surftex.errors import RecipeError
from surftex.materials.checked import Checked
from surftex.units import length_mm


def _length(value: Any) -> Any:
    try:
        return length_mm(value) if isinstance(value, (str, int, float)) else value
    except RecipeError as problem:
        raise ValueError(str(problem)) from None


Millimetres = Annotated[float, BeforeValidator(_length), Field(ge=-1e7, le=1e7, allow_inf_nan=False)]
PositiveMillimetres = Annotated[float, BeforeValidator(_length), Field(gt=0, le=1e7, allow_inf_nan=False)]


def _moderate(number: float) -> float:
    if not abs(number) <= _LARGEST:  # its squares and products would be inf
        raise ValueError(f"{number!r:.60} is beyond {_LARGEST:g}, or no number")
    return number


_LARGEST = 1e100
Number = Annotated[StrictFloat | StrictInt, AfterValidator(_moderate)]
Axis = Annotated[tuple[Number, Number, Number], Field(description="Direction in the file's axes.")]


class ImageEntry(Checked):
    """A picture read through the mesh's own UVs: 0 is black, 1 is white; or 1 where it has one whole number."""

    image: StrictStr
    channel: Literal["luminance", "red", "green", "blue", "alpha"] = "luminance"
    label: Annotated[StrictInt, Field(ge=0, le=65535)] | None = None
    size: (
        Annotated[tuple[StrictInt, StrictInt], Field(description="Width and height it must have.")] | None
    ) = None


class AttributeEntry(Checked):
    """Numbers of the mesh's own vertices or faces: a PLY property, ``color``, ``_CUSTOM`` of a GLB as ``custom``."""

    attribute: StrictStr
    channel: Literal["luminance", "red", "green", "blue", "alpha", "x", "y", "z"] = "luminance"
    label: StrictInt | None = None


class SlopeEntry(Checked):
    """The cosine between the surface's normal and a direction: 1 facing it, 0 across, -1 facing away."""

    slope: Axis


class OcclusionEntry(Checked):
    """0 in the open, towards 1 in folds and holes; what is farther off than ``occlusion`` does not count."""

    occlusion: PositiveMillimetres


class DistanceEntry(Checked):
    """Walking distance in mm to a mask's border (negative inside), a point, or what a JSON file of strokes holds."""

    distance_to: Annotated[
        Annotated[StrictStr, Tag("text")] | Annotated[Axis, Tag("place")],
        Discriminator(lambda value: "text" if isinstance(value, str) else "place"),
    ]
    level: Number = 0.5
    limit: PositiveMillimetres | None = None


class PartEntry(Checked):
    """1 on a part of the mesh (a material slot, a group or a node of the file), 0 elsewhere."""

    part: StrictStr


class GradientEntry(Checked):
    """From 0 to 1 along an axis, over the mesh's extent or between two coordinates."""

    gradient: Axis
    start: Millimetres | None = None
    end: Millimetres | None = None


class NoiseEntry(Checked):
    """Noise between `low` and `high`; ``noise`` is the number of octaves."""

    noise: Annotated[StrictInt, Field(ge=1, le=12)]
    wavelength: PositiveMillimetres
    gain: Annotated[Number, Field(gt=0, le=1)] = 0.5
    low: Number = 0.0
    high: Number = 1.0


class CurvatureEntry(Checked):
    """1 where the surface bends outward (convex) or inward (concave) as much as a ball of `radius`."""

    curvature: Literal["convex", "concave"]
    radius: PositiveMillimetres


class _Turnable(Checked):
    perpendicular: StrictBool = False


class StrokesEntry(_Turnable):
    """A direction that runs along strokes, or at right angles to them: a JSON file of polylines."""

    strokes: StrictStr


class AxisEntry(_Turnable):
    """A direction that follows an axis of space, laid onto the surface."""

    axis: Axis


class DirectionEntry(_Turnable):
    """A direction from the surface alone: the smoothest, the most or the least bent one, or that of skin's lines."""

    direction: Literal["smooth", "curvature", "least_curvature", "langer"]


class VectorsEntry(_Turnable):
    """Directions with lengths: red and green of a picture along u and v, blue of 1 as long as ``longest``."""

    vectors: StrictStr
    longest: PositiveMillimetres


class VectorAttributeEntry(_Turnable):
    """Directions with lengths: three numbers at each vertex or face, in mm unless ``longest`` scales them."""

    vector_attribute: StrictStr
    longest: PositiveMillimetres | None = None


class FaceEntry(Checked):
    """1 on a part of the face, 0 elsewhere; landmarks are picked in a JSON file of named points."""

    face: StrictStr
    landmarks: StrictStr


class FaceLinesEntry(Checked):
    """Lines of the face, carried to a head by the landmarks of a JSON file; width and depth times what is usual."""

    face_lines: Annotated[tuple[StrictStr, ...], Field(min_length=1)]
    landmarks: StrictStr
    width: Annotated[Number, Field(gt=0, le=20)] = 1.0
    depth: Annotated[Number, Field(gt=0, le=20)] = 1.0

    @field_validator("face_lines", mode="before")
    @classmethod
    def _one_or_many(cls, value: Any) -> Any:
        return (value,) if isinstance(value, str) else value


class CurvesEntry(Checked):
    """Curves through the strokes of a JSON file; its own ``width_mm`` and ``depth_mm`` go before these."""

    curves: StrictStr
    width: PositiveMillimetres = 1.0
    depth: PositiveMillimetres = 0.2


KINDS: dict[str, type[Checked]] = {
    "image": ImageEntry,
    "attribute": AttributeEntry,
    "part": PartEntry,
    "gradient": GradientEntry,
    "slope": SlopeEntry,
    "noise": NoiseEntry,
    "curvature": CurvatureEntry,
    "occlusion": OcclusionEntry,
    "distance_to": DistanceEntry,
    "strokes": StrokesEntry,
    "axis": AxisEntry,
    "direction": DirectionEntry,
    "vectors": VectorsEntry,
    "vector_attribute": VectorAttributeEntry,
    "curves": CurvesEntry,
    "face": FaceEntry,
    "face_lines": FaceLinesEntry,
}
"""The key that says what an entry is, and the entry."""


def _kind(value: Any) -> str | None:
    if isinstance(value, Checked):
        return next(key for key, model in KINDS.items() if isinstance(value, model))
    if isinstance(value, dict):
        found = [key for key in KINDS if key in value]
        return found[0] if len(found) == 1 else None
    return "expression" if isinstance(value, (str, int, float)) and not isinstance(value, bool) else None


FieldEntry = Annotated[
    Annotated[StrictStr | StrictFloat | StrictInt, Tag("expression")]
    | Annotated[ImageEntry, Tag("image")]
    | Annotated[AttributeEntry, Tag("attribute")]
    | Annotated[PartEntry, Tag("part")]
    | Annotated[GradientEntry, Tag("gradient")]
    | Annotated[SlopeEntry, Tag("slope")]
    | Annotated[NoiseEntry, Tag("noise")]
    | Annotated[CurvatureEntry, Tag("curvature")]
    | Annotated[OcclusionEntry, Tag("occlusion")]
    | Annotated[DistanceEntry, Tag("distance_to")]
    | Annotated[StrokesEntry, Tag("strokes")]
    | Annotated[AxisEntry, Tag("axis")]
    | Annotated[DirectionEntry, Tag("direction")]
    | Annotated[VectorsEntry, Tag("vectors")]
    | Annotated[VectorAttributeEntry, Tag("vector_attribute")]
    | Annotated[CurvesEntry, Tag("curves")]
    | Annotated[FaceEntry, Tag("face")]
    | Annotated[FaceLinesEntry, Tag("face_lines")],
    Discriminator(
        _kind,
        custom_error_type="field_kind",
        custom_error_message=f"a field is a number, an expression, or a table with one of {', '.join(KINDS)}",
    ),
]
"""One entry of ``[fields]``."""

DIRECTIONS = (StrokesEntry, AxisEntry, DirectionEntry, VectorsEntry, VectorAttributeEntry)
"""Entries that are directions."""

CURVES = (CurvesEntry, FaceLinesEntry)
"""Entries that are curves; all others are numbers."""

_FILES = ("image", "strokes", "vectors", "curves", "landmarks")


def named_files(entry: Any) -> tuple[str, ...]:
    """List the keys of an entry that name files.

    Parameters
    ----------
    entry : FieldEntry
        Of a recipe.

    Returns
    -------
    keys : tuple of str
        ``distance_to`` among them where it ends in ``.json``.
    """
    if not isinstance(entry, BaseModel):
        return ()
    keys = tuple(key for key in _FILES if isinstance(getattr(entry, key, None), str))
    strokes = (
        isinstance(entry, DistanceEntry)
        and isinstance(entry.distance_to, str)
        and expression_of(entry) is None
    )
    return (*keys, "distance_to") if strokes else keys


def places_file(entry: Any) -> str | None:
    """Give the file of places that an entry measures the distance to.

    Parameters
    ----------
    entry : FieldEntry
        Of a recipe.

    Returns
    -------
    path : str or None
        None for every other entry.
    """
    if not isinstance(entry, DistanceEntry) or not isinstance(entry.distance_to, str):
        return None
    return entry.distance_to if expression_of(entry) is None else None


def expression_of(entry: Any) -> str | float | None:
    """Give the expression that an entry is, or is worked out from.

    Parameters
    ----------
    entry : FieldEntry
        Of a recipe.

    Returns
    -------
    expression : str or float or None
        None for an entry that needs no other.
    """
    if isinstance(entry, DistanceEntry):
        text = entry.distance_to
        return text if isinstance(text, str) and not text.lower().endswith(".json") else None
    return None if isinstance(entry, BaseModel) else entry
