"""Features of a leather that do not belong together: too few cells for what hangs between them."""

import numpy as np
import pytest

import surftex as sx
from surftex.errors import RecipeError
from surftex.surface.shapes import cylinder, plane, sphere, torus

LEATHER = sx.Leather(
    cell_size=4.0, pocket_depth=0.01, wrinkle_count=3, wrinkle_length=10.0, invasion=0.8, pore_density=0.0
)
SURFACES = {
    "ball": sphere(10.0, subdivisions=3),
    "torus": torus(10.0, 3.0),
    "plane": plane(20.0),
    "tube": cylinder(),
}


@pytest.fixture(params=SURFACES, scope="module")
def placed(request):
    surface = SURFACES[request.param]
    return surface, dict(LEATHER.place(surface, seed=3).features)


def given(placed, **changes):
    surface, features = placed
    kept = {kind: table for kind, table in {**features, **changes}.items() if table is not None}
    return LEATHER.place(surface, seed=3, features=kept)


def test_what_was_placed_has_the_cells_it_needs(placed):
    assert given(placed).features.keys() == {"cell", "crack", "wrinkle", "pocket"}


def test_pockets_are_no_more_than_so_many_cells_can_have(placed):
    """Euler: of regions that cover a closed surface, three at each corner, there are twice as many corners, less 2 chi."""
    few = placed[1]["cell"][: len(placed[1]["cell"]) // 2]
    with pytest.raises(
        RecipeError,
        match=rf"{len(placed[1]['pocket'])} pockets .* {len(few)} cells, which have \d+ at the most",
    ):
        given(placed, cell=few)


def test_pockets_without_three_cells_are_refused(placed):
    lone = placed[1]["pocket"][:1]
    with pytest.raises(
        RecipeError, match="1 pocket lies where there are 2 cells, and a pocket is where three meet"
    ):
        given(placed, cell=placed[1]["cell"][:2], pocket=lone)


@pytest.mark.parametrize("kind", ["crack", "wrinkle"])
def test_lines_between_cells_ask_for_two(placed, kind):
    rest = {"pocket": None, "crack": None, "wrinkle": None, kind: placed[1][kind]}
    leather = LEATHER.model_copy(update={"wrinkle_count": 0, "pocket_depth": 0.0, "invasion": 0.0})
    kept = {name: table for name, table in {**placed[1], **rest}.items() if table is not None}
    leather.place(placed[0], seed=3, features=kept)
    with pytest.raises(
        RecipeError, match=f"a {kind} runs where there is 1 cell, and such lines run between two"
    ):
        leather.place(placed[0], seed=3, features={**kept, "cell": kept["cell"][:1]})


def test_a_body_by_itself_needs_cells_of_its_own():
    ball = sphere(10.0, subdivisions=3)
    both = sx.Surface.from_arrays(
        np.concatenate([ball.vertices, ball.vertices + 50]),
        np.concatenate([ball.faces, ball.faces + len(ball.vertices)]),
    )
    features = dict(LEATHER.place(both, seed=3).features)
    away = features["cell"]["face"] >= len(ball.faces)
    with pytest.raises(RecipeError, match="a crack runs where there are 0 cells"):
        LEATHER.place(both, seed=3, features={**features, "cell": features["cell"][~away]})
    with pytest.raises(
        RecipeError, match="pockets lie where there are 0 cells, and a pocket is where three meet"
    ):
        LEATHER.model_copy(update={"invasion": 0.0, "wrinkle_count": 0}).place(
            both, seed=3, features={"cell": features["cell"][~away], "pocket": features["pocket"]}
        )
