"""The look of skin by its biology: bounds, order of colours, what is refused."""

import re

import numpy as np
import pytest

import surftex as sx
from surftex.errors import InputError
from surftex.optics import lookup, skin_color
from surftex.optics.making import Making, make_table
from surftex.optics.tissue import PARAMETERS
from surftex.randomness import stream


def biology(count, seed=0):
    numbers = stream(seed, "biology").uniform(count, 6).T
    return {
        name: each.low + share * (each.high - each.low)
        for share, (name, each) in zip(numbers, PARAMETERS.items(), strict=True)
    }


def test_every_look_is_in_range():
    skin = lookup(biology(5000))
    assert skin.clamped == {}
    for values in (skin.base_color, skin.roughness, skin.specular, skin.subsurface_weight):
        assert np.isfinite(values).all()
        assert values.min() >= 0
        assert values.max() <= 1
    assert skin.subsurface_radius_mm.min() > 0.01
    assert skin.subsurface_radius_mm.max() < 20


def test_more_melanin_darkens_and_more_blood_reddens():
    melanin = lookup({"melanin": np.geomspace(0.002, 0.45, 50)}).base_color
    assert (np.diff(melanin, axis=0) < 0).all()
    blood = lookup({"blood": np.geomspace(0.002, 0.15, 50)}).base_color
    assert (np.diff(blood[:, 1] / blood[:, 0]) < 0).all()
    pale, blue = lookup({"oxygenation": [1.0, 0.3], "blood": 0.05}).base_color
    assert pale[0] > blue[0]


def test_red_light_wanders_farthest():
    radius = lookup({"melanin": 0.02}).subsurface_radius_mm[0]
    assert radius[0] > radius[1] > radius[2]


def test_what_leaves_its_range_is_moved_and_counted():
    skin = lookup({"melanin": [0.0, 0.02, 0.9, 0.5], "blood": 0.012})
    assert skin.clamped == {"melanin": 3}
    edge = lookup({"melanin": [0.002, 0.02, 0.45, 0.45]})
    assert edge.clamped == {}
    assert lookup({"stratum_corneum_cm": np.full(2, 0.01, np.float32) / 10}).clamped == {}  # rounding alone
    assert lookup({"stratum_corneum_cm": [0.00099, 0.0041]}).clamped == {"stratum_corneum_cm": 2}
    assert np.array_equal(skin.base_color, edge.base_color)


def test_threads_change_no_byte():
    parameters = biology(200_000)
    one, two = (lookup(parameters, threads=threads) for threads in (1, 2))
    assert one.base_color.tobytes() == two.base_color.tobytes()


def test_skin_color_is_the_look_up():
    color = sx.optics.skin_color(melanin=0.1, blood=0.02)
    assert np.allclose(color, lookup({"melanin": [0.1], "blood": [0.02]}).base_color[0])
    assert skin_color().shape == (3,)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"melanine": 0.1}, "skin has no parameter 'melanine'; known are pheomelanin, melanin"),
        ({"melanin": 0.9}, "melanin is 0.9; it goes from 0.002 to 0.45"),
        ({"blood": np.nan}, "blood is nan"),
        ({"blood": "much"}, "blood is 'much'; it takes one number"),
    ],
)
def test_a_wrong_colour_is_refused(wrong, message):
    with pytest.raises(InputError, match=message.replace("(", r"\(")):
        skin_color(**wrong)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"melanine": 0.1}, "skin has no parameter"),
        ({"melanin": [0.1, np.nan]}, "melanin holds 1 values that are not finite, of 2; the first is"),
        ({"melanin": np.nan}, "melanin is nan; it takes a finite number"),
        ({"melanin": "dark"}, "melanin holds <U4, not numbers"),
        ({"melanin": [[1], [1, 2]]}, "melanin is ragged"),
        ({"melanin": [0.1], "blood": [0.1, 0.1]}, "blood holds 2 samples where melanin holds 1"),
        ([0.1], "parameters of skin come by name, such as {'melanin': 0.02}; this is a list"),
        (None, "this is None"),
        ({"melanin": [0.1, 0.2], "blood": [0.1, 0.1, 0.1]}, "blood holds 3 samples where melanin holds 2"),
        ({"melanin": [[0.1]]}, "melanin has 2 axes"),
    ],
)
def test_a_wrong_look_up_is_refused(wrong, message):
    with pytest.raises(InputError, match=re.escape(message)):
        lookup(wrong)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"table": "mine.npz"}, "table is a string; it takes what load_table has read"),
        ({"threads": 0}, "threads is 0; it takes at least 1"),
        ({"threads": "two"}, "threads is 'two'; it takes one number"),
    ],
)
def test_a_wrong_table_or_count_of_threads_is_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        lookup({}, **wrong)


def test_what_no_float_holds_is_beyond_the_range(recwarn):
    assert lookup({"melanin": [1e300, 0.02]}).clamped == {"melanin": 1}
    assert not recwarn.list


def test_a_table_of_one_node_counts_every_other_value():
    counts = dict.fromkeys(PARAMETERS, 1) | {"melanin": 2}
    table = make_table(Making(nodes=counts, paths=300, beam_paths=0, step_nm=50.0))
    skin = lookup({"melanin": [0.01, 0.3], "blood": [0.012, 0.1], "oxygenation": 0.3}, table=table)
    assert skin.clamped == {"blood": 1, "oxygenation": 2}
    usual = lookup({"melanin": [0.01, 0.3]}, table=table)
    assert usual.clamped == {}
    assert np.array_equal(skin.base_color, usual.base_color)
    assert np.isfinite(skin.base_color).all()
    assert table.outside("blood", [0.012, np.float32(0.012), 0.013]).tolist() == [False, False, True]
