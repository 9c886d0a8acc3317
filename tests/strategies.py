"""What hypothesis draws: soups of triangles, expressions, recipes, pictures, texture models."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from surftex.recipe.write import toml_value

NAMES = ("up", "wear", "grain2")
"""Fields of drawn recipes, and names in drawn expressions."""

_REALS = st.floats(-1e6, 1e6, allow_nan=False).map(lambda value: round(value, 6))


@st.composite
def soups(draw, most=14):
    """Vertices and faces that anything may be wrong with: coincident places, needles, edges of many faces, any winding."""
    count = draw(st.integers(3, most))
    lattice = draw(arrays.arrays(np.int8, (count, 3), elements=st.integers(-2, 2))).astype(np.float64)
    shift = draw(arrays.arrays(np.float64, (count, 3), elements=st.sampled_from([0.0, 0.0, 1e-9, 1e-3, 0.4])))
    faces = draw(
        arrays.arrays(np.int64, (draw(st.integers(1, 2 * most)), 3), elements=st.integers(0, count - 1))
    )
    return (lattice + shift) * draw(st.sampled_from([1e-6, 1.0, 1e6])), faces


def expressions(names=(*NAMES, "x", "y", "z")):
    """Text that the language of masks allows."""
    leaf = st.sampled_from(names) | st.floats(-1e3, 1e3, allow_nan=False).map(repr) | st.just("pi")

    def above(inner):
        pair = st.tuples(inner, inner)
        return st.one_of(
            st.tuples(pair, st.sampled_from(["+", "-", "*", "/", "**", "<", ">=", "and", "or"])).map(
                lambda each: f"({each[0][0]} {each[1]} {each[0][1]})"
            ),
            st.tuples(st.sampled_from(["abs", "sqrt", "sin", "cos", "floor"]), inner).map(
                lambda each: f"{each[0]}({each[1]})"
            ),
            st.tuples(st.sampled_from(["min", "max"]), pair).map(
                lambda each: f"{each[0]}({', '.join(each[1])})"
            ),
            st.tuples(st.sampled_from(["clamp", "smoothstep", "mix"]), inner, inner, inner).map(
                lambda each: f"{each[0]}({', '.join(each[1:])})"
            ),
            inner.map("-({})".format),
            st.tuples(inner, inner, inner).map(lambda each: f"({each[0]} if {each[1]} else {each[2]})"),
        )

    return st.recursive(leaf, above, max_leaves=8)


def fields():
    """Tables of the [fields] of a recipe."""
    lengths = st.floats(0.1, 50.0).map(lambda value: f"{value:.3f} mm")
    axis = st.lists(st.integers(-3, 3), min_size=3, max_size=3).filter(any)
    return st.one_of(
        st.fixed_dictionaries({"gradient": axis}, optional={"start": st.just("-3 mm"), "end": lengths}),
        st.fixed_dictionaries(
            {"noise": st.integers(1, 12), "wavelength": lengths}, optional={"low": _REALS, "high": _REALS}
        ),
        st.fixed_dictionaries({"curvature": st.sampled_from(["convex", "concave"]), "radius": lengths}),
        st.fixed_dictionaries({"slope": axis}),
        expressions(("x", "y", "z")),
    )


@st.composite
def recipes(draw):
    """Text of recipes that can be read."""
    seed, side = draw(st.integers(0, 2**31 - 1)), draw(st.integers(16, 64))
    lines = [f"surftex = 1\nseed = {seed}", "[bake]", f"resolution = {side}", "[fields]"]
    lines += [f"{name} = {_inline(draw(fields()))}" for name in NAMES]
    for _ in range(draw(st.integers(1, 2))):
        lines += ["[[layer]]", 'material = "leather"', f"cell_size = {draw(st.floats(5.0, 9.0)):.3f}",
                  f"crista_height = {draw(st.floats(0.01, 0.5)):.4f}", f"pore_density = {draw(st.floats(0, 0.1)):.4f}",
                  f"mask = {toml_value(draw(expressions()))}"]  # fmt: skip
    return "\n".join(lines) + "\n"


def _inline(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml_value(each)}" for key, each in value.items()) + " }"
    return toml_value(value)


def pictures():
    """Pixels of 8 or 16 bits, grey or colour."""
    shape = st.tuples(st.integers(1, 20), st.integers(1, 20)).flatmap(
        lambda size: st.sampled_from([size, (*size, 3)])
    )
    return st.one_of(arrays.arrays(kind, shape) for kind in (np.uint8, np.uint16))


@st.composite
def texture_models(draw):
    """Models learnt from drawn pictures: flat ones, stripes, noise."""
    from surftex.exemplar.learn import learn_texture

    side = draw(st.integers(32, 44))
    levels = draw(st.integers(3, 6))
    pixels = np.random.Generator(np.random.PCG64(draw(st.integers(0, 99)))).integers(0, levels, (side, side))
    if draw(st.booleans()):
        pixels = pixels[:, :1] + 0 * pixels
    return learn_texture((pixels * (255 // levels)).astype(np.uint8), pairs=2, spacings=(1,), radius=3)
