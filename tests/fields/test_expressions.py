"""Expressions: agree with Python on what is allowed, refuse everything else, and say where."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from surftex.errors import RecipeError
from surftex.fields.expressions import Expression

NAMES = {"toe": np.array([0.0, 0.25, 1.0]), "wear": np.array([2.0, -1.0, 0.5])}


def value(text, **names):
    known = {**NAMES, **{name: np.asarray(each, float) for name, each in names.items()}}
    return Expression.parse(text).evaluate(known.__getitem__, 3)


leaves = st.sampled_from(["toe", "wear", "2", "0.5", "pi"])
trees = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(["+", "-", "*", "<", ">="]), inner).map(
            lambda t: f"({t[0]} {t[1]} {t[2]})"
        ),
        inner.map(lambda t: f"abs({t})"),
        st.tuples(inner, inner).map(lambda t: f"max({t[0]}, {t[1]})"),
        st.tuples(inner, inner, inner).map(lambda t: f"({t[0]} if {t[1]} > 0.5 else {t[2]})"),
    ),
    max_leaves=12,
)


@given(trees)
def test_an_expression_means_what_python_means(text):
    expected = [
        float(eval(text, {"__builtins__": {}}, {"toe": a, "wear": b, "abs": abs, "max": max, "pi": math.pi}))
        for a, b in zip(NAMES["toe"], NAMES["wear"], strict=True)
    ]
    np.testing.assert_allclose(value(text), expected, rtol=1e-12)


def test_numbers_functions_and_logic():
    np.testing.assert_array_equal(value("1 - 0.7 * toe"), 1 - 0.7 * NAMES["toe"])
    np.testing.assert_array_equal(value("smoothstep(0, 1, toe)"), [0, 0.15625, 1])
    np.testing.assert_array_equal(value("smoothstep(0.5, 0.5, toe)"), [0, 0, 1])
    np.testing.assert_array_equal(value("clamp(wear, 0, 1)"), [1, 0, 0.5])
    np.testing.assert_array_equal(value("mix(2, 4, toe)"), [2, 2.5, 4])
    np.testing.assert_array_equal(value("0 < toe < 1"), [0, 1, 0])
    np.testing.assert_array_equal(value("toe > 0 and not wear > 0 or toe == 0"), [1, 1, 0])
    np.testing.assert_array_equal(Expression.parse(3).evaluate(NAMES.__getitem__, 3), [3, 3, 3])
    assert Expression.parse("part('upper') * toe + x").names == {"toe"}
    assert Expression.parse("part('upper') * toe + x").parts == {"upper"}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("__import__('os').system('x')", "not allowed"),
        ("toe.__class__", "a Python Attribute is not allowed"),
        ("[1, 2][0]", "a Python Subscript is not allowed"),
        ("(lambda: 1)()", "a Python Call is not allowed"),
        ("'text'", "the constant"),
        ("1j", "the constant 1j"),
        ("True", "the constant True"),
        ("toe // 2", "the operator FloorDiv"),
        ("toe; wear", "at column 4"),
        ("1 +", "at column"),
        ("", "at column"),
        ("smothstep(0, 1, toe)", "did you mean smoothstep"),
        ("clamp(toe)", "clamp takes 3 arguments, not 1"),
        ("max(*toe, toe)", "a Python Starred is not allowed"),
        ("min(toe, key=1)", "not allowed"),
        ("max + 1", "max is a function"),
        ("part(upper)", "name of a part in quotes"),
        ("1e999", "the constant inf"),
        ("9" * 400, "the constant"),
        ("-" * 1500 + "1", ""),
        ("abs(" * 150 + "1" + ")" * 150, "60 deep"),
        ("1" * 3000, "at most 2000"),
        ("toe\x00", ""),
    ],
)
def test_anything_else_is_refused(text, says):
    with pytest.raises(RecipeError) as refused:
        value(text)
    assert says in str(refused.value)
    assert len(str(refused.value)) < 400


def test_a_huge_power_is_an_error_and_not_a_long_wait():
    with pytest.raises(RecipeError, match="no finite value at 3 of 3 points"):
        value("9 ** 9 ** 9 ** 9")


def test_division_by_zero_is_an_error():
    with pytest.raises(RecipeError, match="at 1 of 3 points; does it divide by zero"):
        value("1 / toe")


spanned = st.recursive(
    st.sampled_from(["toe", "wear", "2", "0.5", "0", "-1.5"]),
    lambda inner: st.one_of(
        st.tuples(
            inner, st.sampled_from(["+", "-", "*", "/", "**", "<", ">=", "==", "!=", "and", "or"]), inner
        ).map(lambda t: f"({t[0]} {t[1]} {t[2]})"),
        inner.map(lambda t: f"(not {t})"),
        st.tuples(st.sampled_from(["abs", "sqrt", "sin", "floor", "-"]), inner).map(
            lambda t: f"{t[0]}({t[1]})"
        ),
        st.tuples(st.sampled_from(["clamp", "smoothstep", "mix", "min"]), inner, inner, inner).map(
            lambda t: f"{t[0]}({t[1]}, {t[2]}, {t[3]})"
        ),
        st.tuples(inner, inner, inner).map(lambda t: f"({t[0]} if {t[1]} > 0.5 else {t[2]})"),
    ),
    max_leaves=8,
)
ends = st.tuples(st.floats(-3, 3), st.floats(0, 4))


@pytest.mark.parametrize("toe", [(-1.5, 3.0), (-2.0, 1.0), (0.5, 1.0)])
@pytest.mark.parametrize(
    ("text", "tight"),
    [
        ("abs(toe)", True), ("toe ** 2", True), ("toe ** 3", True), ("-toe * wear", True), ("toe / (2 + wear)", True),
        ("toe < wear", True), ("not toe", False), ("toe == wear", False), ("toe and wear", False), ("cos(9 * toe)", False),
        ("smoothstep(0.1, 0.9, toe)", True), ("smoothstep(wear, 0.9, toe)", False), ("sqrt(abs(toe))", True),
        ("clamp(toe, 0, wear)", True), ("mix(toe, wear, 0.3)", True), ("floor(3 * toe)", True), ("2 ** toe", True),
        ("toe if wear > 0.5 else 7", False), ("max(toe, wear, 0)", True), ("-2 <= toe <= 0.5", False),
    ],
)  # fmt: skip
def test_a_span_of_each_operation_holds_and_fits(text, tight, toe):
    low, high, values = span_and_values(text, toe, (0.25, 1.0))
    assert low - 1e-9 <= values.min()
    assert values.max() <= high + 1e-9
    if tight:
        assert values.min() - low < 0.05 * (1 + high - low)
        assert high - values.max() < 0.05 * (1 + high - low)


@given(spanned, ends, ends)
def test_a_span_holds_every_value(text, toe, wear):
    low, high, values = span_and_values(text, toe, wear)
    room = 1e-9 * (1 + np.abs(values))
    assert (values >= low - room).all()
    assert (values <= high + room).all()


def span_and_values(text, toe, wear):
    """The span over a box of values (least, size), and the finite values on a grid in it."""
    expression = Expression.parse(text)
    low_high = {name: (low, low + size) for name, (low, size) in {"toe": toe, "wear": wear}.items()}
    share = np.linspace(0, 1, 41)
    grid = np.meshgrid(share, share)
    names = {
        name: low + (high - low) * axis.ravel()
        for (name, (low, high)), axis in zip(low_high.items(), grid, strict=True)
    }
    low, high = expression.span(lambda name: tuple(np.full(1, end) for end in low_high[name]), 1)
    with np.errstate(all="ignore"):
        values = np.broadcast_to(expression._root.value(names.__getitem__), (41 * 41,)).astype(float)
    return float(low[0]), float(high[0]), values[np.isfinite(values)]
