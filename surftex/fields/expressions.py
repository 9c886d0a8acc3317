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

Values = NDArray[np.float64]
Resolve = Callable[[str], Values]
_Node = Callable[[Resolve], Any]

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


FUNCTIONS: Mapping[str, tuple[Callable[..., Values], int, int]] = {
    "min": (lambda *a: _fold(np.minimum, a), 2, 16),
    "max": (lambda *a: _fold(np.maximum, a), 2, 16),
    "clamp": (_clamp, 3, 3),
    "smoothstep": (_smoothstep, 3, 3),
    "mix": (_mix, 3, 3),
    "abs": (np.abs, 1, 1),
    "sqrt": (np.sqrt, 1, 1),
    "sin": (np.sin, 1, 1),
    "cos": (np.cos, 1, 1),
    "floor": (np.floor, 1, 1),
}
"""Function, fewest and most arguments."""

RESERVED = frozenset({*FUNCTIONS, *AXES, "pi", "part"})
"""Names that a field cannot have."""

_BINARY: Mapping[type, Callable[..., Values]] = {
    ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.divide, ast.Pow: np.power,
}  # fmt: skip
_COMPARE: Mapping[type, Callable[..., Values]] = {
    ast.Lt: np.less, ast.LtE: np.less_equal, ast.Gt: np.greater, ast.GtE: np.greater_equal,
    ast.Eq: np.equal, ast.NotEq: np.not_equal,
}  # fmt: skip


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
    """

    text: str
    names: frozenset[str]
    parts: frozenset[str]
    _value: _Node

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
        text = (
            repr(float(value)) if isinstance(value, (int, float)) and not isinstance(value, bool) else value
        )
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
        value_of = reader.read(tree.body, 0)
        return Expression(text.strip(), frozenset(reader.names), frozenset(reader.parts), value_of)

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
            values = np.broadcast_to(np.asarray(self._value(resolve), np.float64), (count,))
        wrong = np.count_nonzero(~np.isfinite(values))
        if wrong:
            raise RecipeError(
                f"{_short(self.text)!r} has no finite value at {wrong} of {count} points; "
                "does it divide by zero?"
            )
        return np.array(values)


class _Reader:
    """Turns a syntax tree into nested functions, or refuses it."""

    def __init__(self, text: str) -> None:
        self.text, self.names, self.parts = text, set[str](), set[str]()

    def refuse(self, node: ast.AST, problem: str) -> RecipeError:
        return RecipeError(f"{_short(self.text)!r} at column {getattr(node, 'col_offset', 0) + 1}: {problem}")

    def read(self, node: ast.AST, depth: int) -> _Node:
        if depth > _DEEPEST:
            raise self.refuse(node, f"nested more than {_DEEPEST} deep")
        match node:
            case ast.Constant(value=int() | float() as number) if _is_finite(number):
                constant = np.float64(number)
                return lambda _: constant
            case ast.Name(id=name):
                return self._name(node, name)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
                function, a, b = _BINARY[type(op)], self.read(left, depth + 1), self.read(right, depth + 1)
                return lambda resolve: function(a(resolve), b(resolve))
            case ast.UnaryOp(op=ast.USub(), operand=inner):
                a = self.read(inner, depth + 1)
                return lambda resolve: -a(resolve)
            case ast.UnaryOp(op=ast.UAdd(), operand=inner):
                return self.read(inner, depth + 1)
            case ast.UnaryOp(op=ast.Not(), operand=inner):
                a = self.read(inner, depth + 1)
                return lambda resolve: np.where(a(resolve) != 0, 0.0, 1.0)
            case ast.Compare(left=left, ops=ops, comparators=rest) if all(type(op) in _COMPARE for op in ops):
                return self._comparison([self.read(each, depth + 1) for each in (left, *rest)], ops)
            case ast.BoolOp(op=op, values=values):
                nodes = [self.read(each, depth + 1) for each in values]
                every = isinstance(op, ast.And)
                return lambda resolve: _truth([each(resolve) for each in nodes], every=every)
            case ast.IfExp(test=test, body=body, orelse=other):
                c, a, b = (self.read(each, depth + 1) for each in (test, body, other))
                return lambda resolve: np.where(c(resolve) != 0, a(resolve), b(resolve))
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
                return self._call(node, name, arguments, depth)
        known = f"numbers, fields, + - * / ** < >, {', '.join(FUNCTIONS)} and part('name')"
        raise self.refuse(node, f"{_described(node)} is not allowed; known are {known}")

    def _name(self, node: ast.AST, name: str) -> _Node:
        if name == "pi":
            return lambda _: np.float64(math.pi)
        if name in FUNCTIONS or name == "part":
            raise self.refuse(node, f"{name} is a function; write {name}(...)")
        if name not in AXES:
            self.names.add(name)
        return lambda resolve: resolve(name)

    def _comparison(self, nodes: list[_Node], ops: list[ast.cmpop]) -> _Node:
        functions = [_COMPARE[type(op)] for op in ops]

        def compare(resolve: Resolve) -> Values:
            values = [each(resolve) for each in nodes]
            links = [
                function(a, b) for function, a, b in zip(functions, values[:-1], values[1:], strict=True)
            ]
            return _truth(links, every=True)

        return compare

    def _call(self, node: ast.AST, name: str, arguments: list[ast.expr], depth: int) -> _Node:
        if name == "part":
            match arguments:
                case [ast.Constant(value=str(part))]:
                    self.parts.add(part)
                    return lambda resolve: resolve(f"part:{part}")
            raise self.refuse(node, "part takes the name of a part in quotes, such as part('upper')")
        if name not in FUNCTIONS:
            near = get_close_matches(name, [*FUNCTIONS, "part"], 1)
            hint = f"; did you mean {near[0]}?" if near else f"; known are {', '.join(FUNCTIONS)}, part"
            raise self.refuse(node, f"unknown function {name!r}{hint}")
        function, fewest, most = FUNCTIONS[name]
        if not fewest <= len(arguments) <= most:
            takes = f"{fewest}" if fewest == most else f"{fewest} to {most}"
            raise self.refuse(node, f"{name} takes {takes} arguments, not {len(arguments)}")
        nodes = [self.read(each, depth + 1) for each in arguments]
        return lambda resolve: function(*[each(resolve) for each in nodes])


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
