"""Mask expressions: arithmetic over named numbers, such as ``1 - 0.7 * toe`` or ``smoothstep(0, 40, z)``.

The text is parsed with Python's grammar and then read against a short list of what is allowed: numbers,
names, ``+ - * / **``, comparisons (1 where true, 0 where not), ``and or not``, ``a if c else b``, and the
functions of `FUNCTIONS`. Nothing is ever executed. ``x``, ``y`` and ``z`` are millimetres in the file's own
axes; ``part("upper")`` is 1 on that part of the mesh and 0 elsewhere.
"""

import ast
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError
from surftex.fields import spans
from surftex.fields.spans import Span, SpanRule

Values = NDArray[np.float64]
Resolve = Callable[[str], Values]
ResolveSpan = Callable[[str], Span]

AXES = ("x", "y", "z")
"""Names of a point's coordinates."""

_LONGEST, _DEEPEST = 2000, 60


def _clamp(value: Values, low: Values | float, high: Values | float) -> Values:
    return np.minimum(np.maximum(value, low), high)


def _smoothstep(low: Values, high: Values, value: Values) -> Values:
    share = np.where(high == low, np.where(value >= high, 1.0, 0.0), (value - low) / np.subtract(high, low))
    t = _clamp(share, 0.0, 1.0)
    return t * t * (3 - 2 * t)


def _mix(first: Values, second: Values, share: Values) -> Values:
    return first + (second - first) * share


def _lowest(*values: Values) -> Values:
    return _fold(np.minimum, values)


def _highest(*values: Values) -> Values:
    return _fold(np.maximum, values)


FUNCTIONS: Mapping[str, tuple[Callable[..., Values], int, int, SpanRule]] = {
    "min": (_lowest, 2, 16, lambda *a: (_lowest(*(s[0] for s in a)), _lowest(*(s[1] for s in a)))),
    "max": (_highest, 2, 16, lambda *a: (_highest(*(s[0] for s in a)), _highest(*(s[1] for s in a)))),
    "clamp": (_clamp, 3, 3, spans.at_corners(_clamp)),
    "smoothstep": (_smoothstep, 3, 3, spans.stepped(_smoothstep)),
    "mix": (_mix, 3, 3, spans.mixed),
    "abs": (np.abs, 1, 1, spans.absolute),
    "sqrt": (np.sqrt, 1, 1, spans.root),
    "sin": (np.sin, 1, 1, spans.wave),
    "cos": (np.cos, 1, 1, spans.wave),
    "floor": (np.floor, 1, 1, spans.at_corners(np.floor)),
}
"""Function, fewest and most arguments, and the span of what it gives."""

RESERVED = frozenset({*FUNCTIONS, *AXES, "pi", "part"})
"""Names that a field cannot have."""

_BINARY: Mapping[type, tuple[Callable[..., Values], SpanRule]] = {
    ast.Add: (np.add, spans.at_corners(np.add)),
    ast.Sub: (np.subtract, spans.at_corners(np.subtract)),
    ast.Mult: (np.multiply, spans.multiply),
    ast.Div: (np.divide, spans.divide),
    ast.Pow: (np.power, spans.power),
}
_COMPARE: Mapping[type, tuple[Callable[..., Values], SpanRule]] = {
    ast.Lt: (np.less, spans.at_corners(np.less)),
    ast.LtE: (np.less_equal, spans.at_corners(np.less_equal)),
    ast.Gt: (np.greater, spans.at_corners(np.greater)),
    ast.GtE: (np.greater_equal, spans.at_corners(np.greater_equal)),
    ast.Eq: (np.equal, spans.equal),
    ast.NotEq: (np.not_equal, lambda a, b: spans.negated(spans.equal(a, b))),
}


@dataclass(frozen=True)
class _Node:
    """One step of an expression: its value at points, and its span over faces."""

    value: Callable[[Resolve], Any]
    span: Callable[[ResolveSpan], Span]

    @staticmethod
    def of(function: Callable[..., Any], rule: SpanRule, nodes: "list[_Node]") -> "_Node":
        """Apply a function to what some steps give."""
        return _Node(
            lambda resolve: function(*[each.value(resolve) for each in nodes]),
            lambda resolve: rule(*[each.span(resolve) for each in nodes]),
        )


@dataclass(frozen=True)
class Expression:
    """A checked expression; make one with `Expression.parse`.

    Attributes
    ----------
    text : str
        As written.
    names : frozenset of str
        Fields that it refers to, without coordinates and constants.
    parts : frozenset of str
        Parts of the mesh that it refers to.
    depth : int
        Of its nesting.
    """

    text: str
    names: frozenset[str]
    parts: frozenset[str]
    depth: int
    _root: _Node

    @staticmethod
    def parse(value: str | float | int) -> "Expression":
        """Read and check an expression.

        Parameters
        ----------
        value : str or float
            A number stands for itself.

        Returns
        -------
        expression : Expression
            Its names are not yet known to exist.

        Raises
        ------
        RecipeError
            Naming the expression, the column and what is not allowed there.
        """
        text = value
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            if not _is_finite(value):
                raise RecipeError(f"{value!r:.60} is not finite")
            text = repr(float(value))
        if not isinstance(text, str):
            raise RecipeError(
                f"{value!r} is not an expression; write a number or text such as '1 - 0.7 * toe'"
            )
        if len(text) > _LONGEST:
            raise RecipeError(f"an expression of {len(text)} characters; at most {_LONGEST} are read")
        try:
            tree = ast.parse(text.strip(), mode="eval")
        except SyntaxError as problem:
            raise RecipeError(f"{_short(text)!r} at column {problem.offset or 1}: {problem.msg}") from None
        except (ValueError, RecursionError, MemoryError):
            raise RecipeError(f"{_short(text)!r} cannot be read as an expression") from None
        reader = _Reader(text.strip())
        root = reader.read(tree.body, 0)
        return Expression(text.strip(), frozenset(reader.names), frozenset(reader.parts), reader.depth, root)

    def evaluate(self, resolve: Resolve, count: int) -> Values:
        """Compute the expression at points.

        Parameters
        ----------
        resolve : callable
            Gives the (n,) values of a name: a field's, ``x``, ``y``, ``z``, or ``part:NAME``.
        count : int
            n.

        Returns
        -------
        values : (n,) float64
            Finite.

        Raises
        ------
        RecipeError
            If a value is not finite, such as after a division by zero.
        """
        with np.errstate(all="ignore"):
            values = np.broadcast_to(np.asarray(self._root.value(resolve), np.float64), (count,))
        wrong = np.count_nonzero(~np.isfinite(values))
        if wrong:
            raise RecipeError(
                f"{_short(self.text)!r} has no finite value at {wrong} of {count} points; "
                "does it divide by zero, take the root of what is below 0, or grow without end?"
            )
        return np.array(values)

    def span(self, resolve: ResolveSpan, count: int) -> Span:
        """Bound the expression over faces, from the bounds of what it refers to.

        Parameters
        ----------
        resolve : callable
            Gives the span of a name, as `evaluate` takes its values.
        count : int
            Faces.

        Returns
        -------
        low : (count,) float64
            No value on the face is less; -inf where nothing is known.
        high : (count,) float64
            No value is greater; inf where nothing is known.
        """
        with np.errstate(all="ignore"):
            low, high = self._root.span(resolve)
        return np.array(np.broadcast_to(low, (count,))), np.array(np.broadcast_to(high, (count,)))


class _Reader:
    """Turns a syntax tree into nested functions, or refuses it."""

    def __init__(self, text: str) -> None:
        self.text, self.names, self.parts, self.depth = text, set[str](), set[str](), 0

    def refuse(self, node: ast.AST, problem: str) -> RecipeError:
        return RecipeError(f"{_short(self.text)!r} at column {getattr(node, 'col_offset', 0) + 1}: {problem}")

    def read(self, node: ast.AST, depth: int) -> _Node:
        if depth > _DEEPEST:
            raise self.refuse(node, f"nested more than {_DEEPEST} deep")
        self.depth = max(self.depth, depth)
        match node:
            case ast.Constant(value=int() | float() as number) if _is_finite(number):
                return _constant(float(number))
            case ast.Name(id=name):
                return self._name(node, name)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
                return _Node.of(*_BINARY[type(op)], [self.read(each, depth + 1) for each in (left, right)])
            case ast.UnaryOp(op=ast.USub(), operand=inner):
                return _Node.of(np.negative, lambda a: (-a[1], -a[0]), [self.read(inner, depth + 1)])
            case ast.UnaryOp(op=ast.UAdd(), operand=inner):
                return self.read(inner, depth + 1)
            case ast.UnaryOp(op=ast.Not(), operand=inner):
                return _Node.of(
                    lambda a: np.where(a != 0, 0.0, 1.0), spans.negated, [self.read(inner, depth + 1)]
                )
            case ast.Compare(left=left, ops=ops, comparators=rest) if all(type(op) in _COMPARE for op in ops):
                return self._comparison([self.read(each, depth + 1) for each in (left, *rest)], ops)
            case ast.BoolOp(op=op, values=values):
                return _joined([self.read(each, depth + 1) for each in values], every=isinstance(op, ast.And))
            case ast.IfExp(test=test, body=body, orelse=other):
                return _Node.of(
                    lambda c, a, b: np.where(c != 0, a, b),
                    spans.chosen,
                    [self.read(each, depth + 1) for each in (test, body, other)],
                )
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
                return self._call(node, name, arguments, depth)
        known = f"numbers, fields, + - * / ** < >, {', '.join(FUNCTIONS)} and part('name')"
        raise self.refuse(node, f"{_described(node)} is not allowed; known are {known}")

    def _name(self, node: ast.AST, name: str) -> _Node:
        if name == "pi":
            return _constant(math.pi)
        if name in FUNCTIONS or name == "part":
            raise self.refuse(node, f"{name} is a function; write {name}(...)")
        if name not in AXES:
            self.names.add(name)
        return _looked_up(name)

    def _comparison(self, nodes: list[_Node], ops: list[ast.cmpop]) -> _Node:
        pairs = zip(nodes[:-1], nodes[1:], ops, strict=True)
        return _joined([_Node.of(*_COMPARE[type(op)], [a, b]) for a, b, op in pairs], every=True)

    def _call(self, node: ast.AST, name: str, arguments: list[ast.expr], depth: int) -> _Node:
        if name == "part":
            match arguments:
                case [ast.Constant(value=str(part))]:
                    self.parts.add(part)
                    return _looked_up(f"part:{part}")
            raise self.refuse(node, "part takes the name of a part in quotes, such as part('upper')")
        if name not in FUNCTIONS:
            near = get_close_matches(name, [*FUNCTIONS, "part"], 1)
            hint = f"; did you mean {near[0]}?" if near else f"; known are {', '.join(FUNCTIONS)}, part"
            raise self.refuse(node, f"unknown function {name!r}{hint}")
        function, fewest, most, rule = FUNCTIONS[name]
        if not fewest <= len(arguments) <= most:
            takes = f"{fewest}" if fewest == most else f"{fewest} to {most}"
            raise self.refuse(node, f"{name} takes {takes} arguments, not {len(arguments)}")
        return _Node.of(function, rule, [self.read(each, depth + 1) for each in arguments])


def _constant(number: float) -> _Node:
    value, span = np.float64(number), spans.constant(number)
    return _Node(lambda _: value, lambda _: span)


def _looked_up(name: str) -> _Node:
    return _Node(lambda resolve: resolve(name), lambda resolve: resolve(name))


def _joined(nodes: list[_Node], *, every: bool) -> _Node:
    """Whether every one of some steps is true, or any."""
    combine = np.minimum if every else np.maximum

    def rule(*each: Span) -> Span:
        known = [spans.truth(span) for span in each]
        return _fold(combine, tuple(k[0] for k in known)), _fold(combine, tuple(k[1] for k in known))

    return _Node.of(lambda *values: _truth(list(values), every=every), rule, nodes)


def _fold(function: Callable[..., Values], values: tuple[Values, ...]) -> Values:
    result = values[0]
    for value in values[1:]:
        result = function(result, value)
    return result


def _truth(values: list[Values], *, every: bool) -> Values:
    combine = np.logical_and if every else np.logical_or
    return np.asarray(_fold(combine, tuple(np.asarray(value) != 0 for value in values)), np.float64)


def _is_finite(number: int | float) -> bool:
    if isinstance(number, bool):
        return False
    try:
        return math.isfinite(number)
    except OverflowError:
        return False


def _described(node: ast.AST) -> str:
    if isinstance(node, ast.Constant):
        return f"the constant {_short(repr(node.value))}"
    if isinstance(node, (ast.BinOp, ast.UnaryOp)):
        return f"the operator {type(node.op).__name__}"
    return f"a Python {type(node).__name__}"


def _short(text: str) -> str:
    return text if len(text) <= 60 else text[:57] + "..."
