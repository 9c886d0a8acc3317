"""The session behind window and page: commands, undo, what is computed again, and recipes that bake what was seen."""

import itertools
import threading

import numpy as np
import pytest

from surftex.bake.bake import bake, run
from surftex.errors import InputError, RecipeError
from surftex.kernels.pool import Stopped, slices, stopped_by
from surftex.preview import focus
from surftex.preview.controls import controls
from surftex.preview.live import Live
from surftex.preview.session import Session
from surftex.preview.worker import Worker
from surftex.recipe.read import load_recipe, recipe_for, recipe_from_text
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import plane, sphere

TWO = """
surftex = 1
seed = 5
[bake]
resolution = 64
unwrapper = "uvunwrap"
[fields]
up = "smoothstep(-1, 1, y)"
[[layer]]
preset = "calf"
cell_size = 2.0
wrinkle_count = 2
[[layer]]
material = "leather"
preset = "crocodile"
cell_size = 3.0
mask = "up"
"""


@pytest.fixture(scope="module")
def ball():
    return sphere(4.0, subdivisions=2)


@pytest.fixture
def session(ball):
    made = Session(recipe_from_text(TWO), ball)
    yield made
    made.close()


def test_every_command_can_be_undone_and_done_again(session):
    states = [session.recipe.written_out()]
    line = SurfacePoints([3, 40], np.full((2, 3), 1 / 3))
    for act in (
        lambda: session.set("sulcus_depth", "0.1 mm"),
        lambda: session.set_mask("1 - up", 1),
        lambda: session.toggle(1),
        lambda: session.seed(9),
        lambda: session.preset("goat", 1),
        lambda: session.stroke("grain", line),
        lambda: session.set("direction", "grain"),
        lambda: session.pick("spots", SurfacePoints([3], [[1, 0, 0]])),
    ):
        act()
        states.append(session.recipe.written_out())
        assert states[-1] != states[-2]
    for state in reversed(states[:-1]):
        assert session.undo() is not None
        assert session.recipe.written_out() == state
    assert session.undo() is None
    for state in states[1:]:
        assert session.redo() is not None
        assert session.recipe.written_out() == state
    assert session.redo() is None


def test_a_slider_that_moves_on_is_one_step(session):
    before = session.recipe
    for depth in (0.05, 0.06, 0.07):
        session.set("sulcus_depth", depth)
    session.set("sulcus_width", 0.2)
    assert session.history == ("set layer 1 sulcus_depth", "set layer 1 sulcus_width")
    session.undo()
    session.undo()
    assert session.recipe == before


def test_strokes_that_differ_in_numbers_alone_lie_in_files_of_their_own(session):
    line, files = SurfacePoints([3, 40], np.full((2, 3), 1 / 3)), set()
    for width in (0.5, 1.5):
        session.stroke("fold", line, "curves", width_mm=width)
        files.add(session.recipe.fields_["fold"].curves)
        session.undo()
    assert len(files) == 2


def test_what_does_not_fit_changes_nothing(session):
    before = session.state
    for act in (
        lambda: session.set("sulcus_dept", 1),
        lambda: session.set("sulcus_depth", -1),
        lambda: session.set("direction", "nowhere"),
        lambda: session.preset("calfskin"),
        lambda: session.toggle(7),
        lambda: session.stroke("up", SurfacePoints([3, 40], np.full((2, 3), 1 / 3))),
        lambda: session.stroke("one", SurfacePoints([3], [[1, 0, 0]])),
    ):
        with pytest.raises(RecipeError):
            act()
    assert session.state is before


def test_a_saved_recipe_bakes_the_same_bytes(session, ball, tmp_path):
    session.set("sulcus_depth", 0.123)
    session.set("color", [0.2, 0.1, 0.05])
    session.stroke("grain", SurfacePoints([3, 40], np.full((2, 3), 1 / 3)))
    session.set("cell_ratio", 1.6)
    session.set("direction", "grain")
    session.set("stress", None)
    path = session.save(tmp_path / "made.toml")[-1]
    assert sorted(each.name for each in tmp_path.iterdir()) == ["made-grain.json", "made.toml"]
    read = load_recipe(path)
    told, meant = read.written_out(), session.recipe.written_out()
    for each in (told, meant):
        each.pop("fields")
        for layer in each["layer"]:
            layer.pop("preset", None)
    assert told == meant
    one, two = run(session.recipe, ball).maps, run(read, ball).maps
    assert set(one) == set(two)
    for name, image in one.items():
        np.testing.assert_array_equal(image, two[name])
    with pytest.raises(InputError, match="there already"):
        session.save(tmp_path / "made")
    session.toggle(1)
    session.save(tmp_path / "made", overwrite=True)
    assert load_recipe(path).layer[1].mask == 0


def test_live_shows_what_a_bake_shows(ball):
    recipe = recipe_from_text(TWO)
    live = Live(ball, recipe, resolution=64)
    frame = live.draw(recipe)
    assert frame.effort == "placed"
    assert frame.changed == {"base_color", "surface", "normal"}
    maps = bake(ball, recipe)
    core, texel = live.texels.core, live.texels.texel
    height = maps["height"].ravel()[texel]
    np.testing.assert_allclose(
        live.height_mm[core], height[core], atol=8e-4
    )  # tails of profiles, at coarse texels
    rough = maps["roughness"].ravel()[texel][core]
    np.testing.assert_allclose(
        frame.pictures["surface"].reshape(-1, 3)[texel[core], 1] / 255, rough, atol=0.003
    )
    normal = frame.pictures["normal"].reshape(-1, 3)[texel[core]] / 32767.5 - 1
    normal[:, 1] *= live.tangents[live.texels.host[core], 0, 3]
    np.testing.assert_allclose(normal, maps["normal"].reshape(-1, 3)[texel[core]], atol=2e-3)


def test_no_more_is_computed_than_a_change_asks_for(session, ball):
    live = Live(ball, session.recipe, resolution=64)
    live.draw(session.recipe)
    for change, effort, pictures in (
        (lambda: None, "kept", set()),
        (lambda: session.set("crista_height", 0.2), "shaped", {"normal"}),
        (lambda: session.set("pore_dye", 0.9), "shaped", {"base_color", "surface"}),
        (lambda: session.set("sulcus_width", 0.2), "shaped", {"normal", "base_color", "surface"}),
        (lambda: session.set("waviness", 0.2), "gathered", {"normal", "base_color", "surface"}),
        (lambda: session.toggle(1), "kept", {"normal", "base_color", "surface"}),
        (lambda: session.toggle(1), "kept", {"normal", "base_color", "surface"}),
        (lambda: session.set("cell_size", 2.1), "placed", {"normal", "base_color", "surface"}),
        (lambda: session.seed(6), "placed", {"normal", "base_color", "surface"}),
    ):
        change()
        assert live.effort(session.recipe) == effort
        frame = live.draw(session.recipe)
        assert (frame.effort, set(frame.changed)) == (effort, pictures)
    live.draw(session.recipe)
    anew = Live(ball, session.recipe, resolution=64)
    anew.draw(session.recipe)
    np.testing.assert_allclose(live.height_mm, anew.height_mm, atol=2e-6)


def test_a_first_look_is_local_and_like_the_whole(monkeypatch):
    monkeypatch.setattr(focus, "_CELLS", 350)
    sheet = plane(24.0, cells=40)
    recipe = recipe_for("calf", changes=["wrinkle_density=0"])
    live = Live(sheet, recipe, resolution=256)
    live.draw(recipe)
    before = live.height_mm.copy()
    other = recipe_for("calf", changes=["wrinkle_density=0", "cell_size=0.7", "seed=3"])
    frame = live.first_look(other, np.array([12.0, 12.0, 0.0]))
    assert frame is not None
    assert frame.first_look
    changed = live.height_mm != before
    assert 0.1 < changed.mean() < 0.6
    place = live.texels.points.positions(sheet)
    centre = place[changed].mean(axis=0)
    assert np.linalg.norm(centre - [12, 12, 0]) < 1.5
    local = live.height_mm[changed]
    whole = Live(sheet, other, resolution=256)
    whole.draw(other)
    assert local.mean() == pytest.approx(whole.height_mm[changed].mean(), rel=0.1)
    assert local.std() == pytest.approx(whole.height_mm[changed].std(), rel=0.1)
    assert live.first_look(recipe_for("crocodile"), np.zeros(3)) is None  # a handful of cells


@pytest.mark.parametrize("name", ["calf", "milled"])
def test_a_first_look_that_would_hold_too_much_is_left_out(name, monkeypatch):
    monkeypatch.setattr(focus, "_MANY", 300)
    ball = sphere(6.0, subdivisions=1)
    recipe = recipe_for(name, changes=["cell_size=3"])
    live = Live(ball, recipe, resolution=64)
    live.draw(recipe)
    fine = recipe_for(name, changes=["cell_size=0.02", "bake.max_features=40000"])
    piece = focus.piece_around(fine, ball, np.zeros(3))
    assert piece is not None
    assert len(piece.face) == 1  # larger than four thousand cells
    assert live.first_look(fine, np.zeros(3)) is None
    with pytest.raises(RecipeError, match="more than"):
        live.draw(fine)


def test_work_that_nobody_wants_ends(ball):
    recipe = recipe_from_text(TWO)
    live = Live(ball, recipe, resolution=64)
    stop = threading.Event()
    stop.set()
    with pytest.raises(Stopped):
        live.draw(recipe, stop=stop)
    assert live.draw(recipe).effort == "placed"
    with stopped_by(stop), pytest.raises(Stopped):
        slices(lambda a, b: None, 10, size=1, threads=1)
    assert len(slices(lambda a, b: None, 10, size=1, threads=2)) == 10


@pytest.mark.parametrize("name", ["calf", "skin", "milled"])
def test_controls_hold_what_a_material_is_set_to(name):
    material = recipe_for(name).layer[0].material
    made = controls(material)
    assert {control.key for control in made} == set(type(material).model_fields) - {"kind"}
    groups = [group for group, _ in itertools.groupby(control.group for control in made)]
    assert len(groups) == len(set(groups))
    for control in made:
        value = getattr(material, control.key)
        assert control.text
        assert control.shown(value)
        if control.kind in ("number", "whole"):
            assert control.low <= value <= control.high
            assert type(material).model_validate({**material.model_dump(), control.key: control.shown(value)
                                                  if control.unit else value})  # fmt: skip
            for end in (control.low, control.high):
                nudged = (
                    end + (1e-9 if end == control.low else -1e-9) if control.kind == "number" else int(end)
                )
                type(material).model_validate({**material.model_dump(), control.key: nudged})
    units = {control.key: control.unit for control in made}
    if name == "calf":
        assert units["cell_size"] == units["sulcus_depth"] == "mm"
        assert units["variation"] == ""


def test_the_worker_draws_what_was_asked_for_last(session, ball):
    live = Live(ball, session.recipe, resolution=64)
    frames, troubles, started = [], [], threading.Event()
    draw = live.draw

    def slow(recipe, *, stop, tick):
        started.set()
        if recipe.seed == 1:
            assert stop.wait(60)  # until somebody asks for something else
        return draw(recipe, stop=stop, tick=tick)

    live.draw = slow
    worker = Worker(live, frames.append, troubles.append)
    for seed in (1, 2):
        session.seed(seed)
        worker.ask(session.recipe, np.zeros(3))
        assert started.wait(60)
    assert worker.wait(120)
    assert len(frames) == 1
    whole = Live(ball, session.recipe, resolution=64)
    whole.draw(session.recipe)
    np.testing.assert_array_equal(live.height_mm, whole.height_mm)
    worker.ask(recipe_from_text(TWO.replace("cell_size = 2.0", "cell_size = 1e-4")), np.zeros(3))
    assert worker.wait(120)
    assert len(troubles) == 1
    assert "features" in troubles[0]
    worker.close()


def test_moles_lie_where_they_were_picked(tmp_path):
    ball = sphere(20.0, subdivisions=3)
    session = Session(recipe_for("skin", changes=["pore_density=0"]), ball)
    picks = SurfacePoints([5, 300, 900], [[0.2, 0.3, 0.5], [0.6, 0.2, 0.2], [1 / 3, 1 / 3, 1 / 3]])
    for i in range(3):
        session.pick("spots", SurfacePoints(picks.face[i : i + 1], picks.barycentric[i : i + 1]))
    with pytest.raises(RecipeError, match="places 'spot' do not exist"):
        session.set("mole_points", "spot")
    session.set("mole_points", "spots")
    path = session.save(tmp_path / "moles.toml")[-1]
    maps = run(load_recipe(path, changes=["bake.resolution=64", "bake.unwrapper=uvunwrap"]), ball).maps
    assert maps.features is not None
    moles = maps.features["mole"]
    np.testing.assert_array_equal(moles["face"], picks.face)
    np.testing.assert_allclose(moles["barycentric"], picks.barycentric, atol=1e-12)
    session.pick("spots", SurfacePoints([40], [[1 / 3, 1 / 3, 1 / 3]]))
    more = run(session.recipe.model_copy(update={"bake": maps_settings(64)}), ball).maps.features
    assert more is not None
    np.testing.assert_array_equal(more["mole"][:3], moles)  # a further mole changes none of the others
    session.close()


def maps_settings(resolution):
    return recipe_from_text(TWO).bake.model_copy(update={"resolution": resolution})
