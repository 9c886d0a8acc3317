"""What is refused for its number alone: the line names the kind, and values that would do."""

import pytest

from surftex.errors import RecipeError
from surftex.materials.limits import Expected, refuse_more

CELLS = (Expected("cell", 4000.0, "cell_size", 1.0, -2), Expected("pocket", 8000.0, "cell_size", 1.0, -2))


def told(*expected, most):
    with pytest.raises(RecipeError) as refused:
        refuse_more("leather", expected, 1234.0, most)
    return str(refused.value)


def test_what_fits_is_not_refused():
    refuse_more("leather", CELLS, 1.0, 12_000)


def test_the_kind_and_a_value_that_would_do_are_named():
    said = told(*CELLS, Expected("pore", 1000.0, "pore_density", 2.0), most=4000)
    assert said == (
        "leather.cell_size: 1,230 mm^2 would hold about 13,000 features, most of them pockets (4,000 cells, 8,000 pockets, "
        "1,000 pores), more than the 4,000 allowed; raise cell_size to 2.03 mm, scale a mesh whose unit is wrong (units, "
        "size; --units, --size), or raise max_features (--max-features)"
    )
    assert 12_000 / 2.03**2 + 1000 <= 4000


def test_where_one_parameter_cannot_do_others_are_named_too():
    said = told(*CELLS, Expected("pore", 9000.0, "pore_density", 2.0), most=7000)
    assert "; raise cell_size to 1.75 mm and lower pore_density to 0.653, scale" in said
    assert 12_000 / 1.75**2 + 9000 * 0.653 / 2 <= 7000


def test_large_values_are_written_out():
    assert "; raise cell_size to 2480 mm, scale" in told(Expected("cell", 6e7, "cell_size", 1.0, -2), most=10)


def test_of_an_expression_only_the_sense_is_told():
    said = told(Expected("pore", 9000.0, "pore_density", "2 * wear"), most=7000)
    assert said.startswith("leather.pore_density: 1,230 mm^2 would hold about 9,000 pores, more than")
    assert "; lower pore_density, scale" in said


def test_what_there_is_no_room_for_is_refused_whatever_is_allowed():
    said = told(Expected("pixel", 9e6, "pixel_size", 0.5, -2, 4_000_000), most=10**9)
    assert (
        "9,000,000 pixels, more than the 4,000,000 that there is room for; raise pixel_size to 0.758 mm, or"
        in said
    )
    assert "--max-features" not in said
