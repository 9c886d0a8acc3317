"""`FieldSet`: the named numbers and directions of a recipe, on one surface, ready for every layer."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from surftex.errors import InputError, RecipeError, naming
from surftex.fields.expressions import AXES, RESERVED, Expression
from surftex.fields.sources import (
    Field,
    SpannedField,
    file_positions,
    made_once,
    part_field,
    span_of,
)
from surftex.fields.spans import Span, over_corners
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_MOST_LEVELS, _LEVELS_OF_A_FIELD = 300, 8
"""Nesting of expressions through all fields that one builds on; a field counts as so many, besides its own."""

if TYPE_CHECKING:
    from surftex.fields.vectors import VectorField
    from surftex.geodesics.directions import DirectionField


@dataclass(frozen=True)
class Derived:
    """A field that is worked out from another one, such as the distance to a mask's border.

    Attributes
    ----------
    of : str or float
        An expression over other fields.
    make : callable
        ``make(field)`` makes the field from that of the expression; called once, when it is first asked.
    """

    of: str | float
    make: Callable[[SpannedField], SpannedField]


class FieldSet:
    """Named fields on a surface, and the reader of expressions over them.

    Parameters
    ----------
    surface : Surface
        Where the fields live.
    numbers : mapping of str to Field, Derived, str or float
        A `Field` (``field(points, footprint_mm=0.0) -> (n,)``), one derived from others, an expression over
        others, or a number.
    directions : mapping of str to callable
        ``directions[name]()`` makes the `DirectionField` or `VectorField`, when it is first asked for.
    curves : mapping of str to callable
        ``curves[name]()`` makes rows of curves (`surftex.features.curves`), when they are first asked for.
    points : mapping of str to callable
        ``points[name]()`` gives the single places that the distance of that name is measured to.

    Raises
    ------
    RecipeError
        If a name is reserved or used twice, an expression is wrong, names an unknown field or part, or if
        expressions refer to each other in a circle.
    """

    def __init__(
        self,
        surface: Surface,
        numbers: Mapping[str, Field | Derived | str | float] = MappingProxyType({}),
        directions: Mapping[str, "Callable[[], DirectionField | VectorField]"] = MappingProxyType({}),
        curves: Mapping[str, Callable[[], NDArray]] = MappingProxyType({}),
        points: Mapping[str, Callable[[], SurfacePoints]] = MappingProxyType({}),
    ) -> None:
        self.surface = surface
        self._fields: dict[str, Field] = {}
        self._expressions: dict[str, Expression] = {}
        self._directions = dict(directions)
        self._made: dict[str, DirectionField | VectorField] = {}
        self._curves, self._drawn = dict(curves), dict[str, NDArray]()
        self._points = dict(points)
        derived: dict[str, Expression] = {}
        for name, value in numbers.items():
            check_name(name)
            if name in directions or name in curves:
                other = "a direction" if name in directions else "curves"
                raise RecipeError(f"the name {name!r} is both a number and {other}")
            if isinstance(value, Derived):
                derived[name] = Expression.parse(value.of)
                self._fields[name] = made_once(lambda name=name, value=value: self._derived(name, value))
            elif callable(value):
                self._fields[name] = value
            else:
                self._expressions[name] = Expression.parse(value)
        every = {**self._expressions, **derived}
        for name, expression in every.items():
            with naming(f"fields.{name}"):
                self._check(expression)
        refuse_circles(every)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all numbers, sorted."""
        return tuple(sorted({*self._fields, *self._expressions}))

    @property
    def direction_names(self) -> tuple[str, ...]:
        """Names of all directions, sorted."""
        return tuple(sorted(self._directions))

    def __contains__(self, name: object) -> bool:
        return name in self._fields or name in self._expressions

    def __getitem__(self, name: str) -> SpannedField:
        """Look up the field of one name."""
        return self.scalar(name)

    def scalar(self, value: str | float) -> SpannedField:
        """Read a number or an expression over the named fields.

        Parameters
        ----------
        value : str or float
            For example ``0.5`` or ``"1 - 0.7 * toe"``.

        Returns
        -------
        field : SpannedField
            ``field(points, footprint_mm=0.0) -> (n,) float64``, finite; ``field.span()`` bounds it, and ``field.narrow()``
            more narrowly where it reads pictures.

        Raises
        ------
        RecipeError
            If the expression is wrong or names what does not exist.
        """
        expression = Expression.parse(value)
        self._check(expression)

        def field(points: SurfacePoints, footprint_mm: NDArray | float = 0.0) -> NDArray[np.float64]:
            return _Evaluation(self, points, footprint_mm).of(expression)

        return SpannedField(
            field, lambda: _Bounds(self).of(expression), lambda: _Bounds(self, narrow=True).of(expression)
        )

    def direction(self, name: str) -> "DirectionField":
        """Look up the direction field of one name; it is made at first use.

        Parameters
        ----------
        name : str
            One of `direction_names`.

        Returns
        -------
        direction : DirectionField
            An angle per face; of vectors, their directions.

        Raises
        ------
        RecipeError
            If no direction has this name.
        """
        from surftex.fields.vectors import VectorField

        made = self.made_direction(name)
        if isinstance(made, VectorField):
            made = self._made[name + " directions"] = (
                self._made.get(name + " directions") or made.directions()
            )
        return made  # type: ignore[return-value]

    def vectors(self, name: str) -> "VectorField":
        """Look up the vectors of one name; those of a plain direction are 1 mm long.

        Parameters
        ----------
        name : str
            One of `direction_names`.

        Returns
        -------
        vectors : VectorField
            Directions with lengths.

        Raises
        ------
        RecipeError
            If no direction has this name.
        """
        from surftex.fields.vectors import VectorField

        made = self.made_direction(name)
        return made if isinstance(made, VectorField) else VectorField.along(made)

    @property
    def point_names(self) -> tuple[str, ...]:
        """Names of all fields with places, sorted."""
        return tuple(sorted(self._points))

    @property
    def curve_names(self) -> tuple[str, ...]:
        """Names of all curves, sorted."""
        return tuple(sorted(self._curves))

    def curves(self, name: str) -> NDArray:
        """Look up the curves of one name; they are made at first use.

        Parameters
        ----------
        name : str
            One of `curve_names`.

        Returns
        -------
        table : (p,) structured array
            Rows of `surftex.features.curves`, with ``width_mm`` and ``depth_mm`` of each curve.

        Raises
        ------
        RecipeError
            If no curves have this name, or they cannot be made on this surface.
        """
        if name not in self._curves:
            if name in self or name in self._directions:
                kind = "number" if name in self else "direction"
                raise RecipeError(f"field {name!r} is a {kind}; curves are made from strokes")
            raise RecipeError(f"unknown curves {name!r}{_hint(name, self._curves, 'curves')}")
        if name not in self._drawn:
            self._drawn[name] = self._curves[name]()
        return self._drawn[name]

    def points(self, name: str) -> SurfacePoints:
        """Look up the places of one name.

        Parameters
        ----------
        name : str
            Of a field that is the distance to the places of a file.

        Returns
        -------
        points : SurfacePoints
            In the order of the file.

        Raises
        ------
        RecipeError
            If no places have this name.
        """
        if name not in self._points:
            raise RecipeError(f"unknown places {name!r}{_hint(name, self._points, 'places')}")
        return self._points[name]()

    def made_direction(self, name: str) -> "DirectionField | VectorField":
        """Look up what the direction of one name was made as.

        Parameters
        ----------
        name : str
            One of `direction_names`.

        Returns
        -------
        made : DirectionField or VectorField
            Made at first use.

        Raises
        ------
        RecipeError
            If no direction has this name.
        """
        if name not in self._directions:
            if name in self or name in self._curves:
                kind = "a number" if name in self else "curves"
                raise RecipeError(f"field {name!r} is {kind}; directions are made from strokes or an axis")
            raise RecipeError(f"unknown direction {name!r}{_hint(name, self._directions, 'directions')}")
        if name not in self._made:
            self._made[name] = self._directions[name]()
        return self._made[name]

    def _derived(self, name: str, value: Derived) -> SpannedField:
        try:
            return value.make(self.scalar(value.of))
        except InputError as problem:
            raise RecipeError(f"fields.{name}: {problem}") from None

    def _check(self, expression: Expression) -> None:
        for name in sorted(expression.names):
            if name in self._directions or name in self._curves:
                kind = "is a direction" if name in self._directions else "is curves"
                raise RecipeError(f"{expression.text!r}: field {name!r} {kind}, not a number")
            if name not in self:
                raise RecipeError(
                    f"{expression.text!r}: unknown field {name!r}{_hint(name, self.names, 'fields')}"
                )
        for part in sorted(expression.parts):
            part_field(self.surface, part)


class _Evaluation:
    """One call: remembers what several names need in common."""

    def __init__(self, fields: FieldSet, points: SurfacePoints, footprint_mm: NDArray | float) -> None:
        self.fields, self.points, self.footprint_mm = fields, points, footprint_mm
        self.known: dict[str, NDArray[np.float64]] = {}

    def of(self, expression: Expression) -> NDArray[np.float64]:
        return expression.evaluate(self.resolve, len(self.points))

    def resolve(self, name: str) -> NDArray[np.float64]:
        if name not in self.known:
            self._find(name)
        return self.known[name]

    def _find(self, name: str) -> None:
        if name in AXES:
            place = file_positions(self.fields.surface, self.points)
            self.known.update(zip(AXES, place.T, strict=True))
        elif name.startswith("part:"):
            self.known[name] = part_field(self.fields.surface, name.removeprefix("part:"))(self.points)
        elif name in self.fields._fields:
            self.known[name] = self.fields._fields[name](self.points, self.footprint_mm)
        else:
            with naming(f"fields.{name}"):
                self.known[name] = self.of(self.fields._expressions[name])


class _Bounds:
    """The spans of the fields of one set, over all faces."""

    def __init__(self, fields: FieldSet, *, narrow: bool = False) -> None:
        self.fields, self.surface, self.narrow = fields, fields.surface, narrow
        self.known: dict[str, Span] = {}

    def of(self, expression: Expression) -> Span:
        return expression.span(self.resolve, len(self.surface.faces))

    def resolve(self, name: str) -> Span:
        if name not in self.known:
            self.known[name] = self._found(name)
        return self.known[name]

    def _found(self, name: str) -> Span:
        if name in AXES:
            place = self.surface.vertices[:, AXES.index(name)] + self.surface.origin_mm[AXES.index(name)]
            return over_corners(place[self.surface.faces])
        if name.startswith("part:"):
            return part_field(self.surface, name.removeprefix("part:")).span()
        if name in self.fields._fields:
            field = self.fields._fields[name]
            if self.narrow and isinstance(field, SpannedField) and field.narrow is not None:
                return field.narrow()
            return span_of(field, self.surface)
        return self.of(self.fields._expressions[name])


def check_name(name: str) -> None:
    """Refuse names that an expression could not mean.

    Parameters
    ----------
    name : str
        Of a field.

    Raises
    ------
    RecipeError
        If it is no identifier, or means something else already.
    """
    if not name.isidentifier() or not name.isascii():
        raise RecipeError(
            f"{name!r} cannot name a field: letters, digits and underscores, and no digit first"
        )
    if name in RESERVED:
        raise RecipeError(f"{name!r} cannot name a field: it is a function or a coordinate already")


def refuse_circles(expressions: Mapping[str, Expression]) -> None:
    """Refuse definitions that need themselves, or build on one another too often: each is evaluated inside the next.

    Parameters
    ----------
    expressions : mapping of str to Expression
        What each definition is worked out from.

    Raises
    ------
    RecipeError
        With the circle, from its first name back to it; or the name that too much lies under.
    """
    levels: dict[str, int] = {}
    for start in sorted(expressions):
        path: list[str] = []
        stack = [iter([start])]
        while stack:
            name = next(stack[-1], None)
            if name is None:
                stack.pop()
                if path:
                    own = path.pop()
                    below = max((levels.get(each, 0) for each in expressions[own].names), default=0)
                    levels[own] = below + expressions[own].depth + _LEVELS_OF_A_FIELD
                    if levels[own] > _MOST_LEVELS:
                        raise RecipeError(
                            f"too many fields build on one another below {own!r}; write fewer steps"
                        )
                continue
            if name in path:
                circle = [*path[path.index(name) :], name]
                raise RecipeError(f"fields refer to each other in a circle: {' -> '.join(circle)}")
            if name in expressions and name not in levels:
                path.append(name)
                stack.append(iter(sorted(expressions[name].names)))


def _hint(name: str, known: Mapping | tuple[str, ...], what: str) -> str:
    near = get_close_matches(name, list(known), 1)
    if near:
        return f"; did you mean {near[0]!r}?"
    return f"; {what} of this recipe: {', '.join(sorted(known))}" if known else f"; this recipe has no {what}"
