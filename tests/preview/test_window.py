"""The window, off screen: the panel moves parameters, clicks draw on the surface, and the picture follows."""

import os
import subprocess
import sys

import numpy as np
import pytest

from surftex.errors import InputError, RecipeError, WorkError
from surftex.files.strokes import Stroke, read_strokes
from surftex.preview import scene
from surftex.preview.desk import Desk
from surftex.preview.environment import environment
from surftex.preview.overlays import distinct, seam_lines, walked
from surftex.preview.panel import hit, layout
from surftex.preview.picking import pick
from surftex.preview.session import Drawing
from surftex.preview.studio import STUDIOS
from surftex.recipe.read import load_recipe, recipe_from_text
from surftex.surface.closest import closest_points
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import plane, sphere

RECIPE = """
surftex = 1
[bake]
unwrapper = "uvunwrap"
[[layer]]
preset = "calf"
cell_size = 2.0
wrinkle_density = 0.0
[[layer]]
material = "leather"
preset = "goat"
cell_size = 2.0
mask = 0.5
"""
SIZE = (720, 620)
LEFT = SIZE[0] - 372


@pytest.fixture(scope="module")
def ball():
    return sphere(6.0, subdivisions=3)


@pytest.fixture
def desk(ball):
    made = Desk(recipe_from_text(RECIPE), ball, resolution=128)
    assert made.worker.wait()
    yield made
    made.close()


@pytest.fixture
def window(desk):
    from surftex.preview.window import Window

    try:
        made = Window(desk, SIZE, off_screen=True)
    except WorkError as problem:
        pytest.skip(f"nothing to draw on: {problem}")
    yield made
    made.close()


def chosen(window, text, kind="chip"):
    return next(each for each in layout(window.desk, 372, SIZE[1]) if each.kind == kind and each.text == text)


def click(window, item):
    window.refresh()
    window.press(LEFT + item.left + item.width / 2, item.top + item.height / 2)
    window.release()


def test_a_slider_of_the_window_changes_the_picture_and_undo_brings_it_back(window):
    desk = window.desk
    click(window, chosen(window, "cristae"))
    assert desk.group == "cristae"
    before = window.picture().astype(int)
    slider = chosen(window, "crista height", "slider")
    start = LEFT + slider.left + slider.share * slider.width
    window.press(start, slider.top + 25)
    assert window.drag(LEFT + slider.left + 0.9 * slider.width, slider.top + 25)
    assert window.release()
    assert desk.session.value("crista_height") == pytest.approx(0.9 * slider.action[1].high, rel=0.02)
    assert desk.worker.wait()
    after = window.picture().astype(int)
    assert (np.abs(after - before)[:, : LEFT - 10].max(axis=2) > 3).mean() > 0.01
    click(window, chosen(window, "undo"))
    assert desk.worker.wait()
    click(window, chosen(window, "cristae"))
    assert np.abs(window.picture().astype(int) - before)[:, : LEFT - 10].max() <= 2
    assert len(desk.session.history) == 0


def test_the_panel_offers_fields_of_the_right_kind(ball, tmp_path):
    (tmp_path / "lines.json").write_text('{"strokes": [{"points": [[6, 0, 0], [0, 6, 0]]}]}')
    fields = """[fields]
    grain = { axis = [0, 0, 1] }
    lines = { curves = "lines.json" }
    wear = 0.5
    """
    shaped = Desk(
        recipe_from_text(RECIPE.replace("[bake]", f"{fields}\n[bake]"), folder=tmp_path), ball, resolution=64
    )
    offered = {}
    for group in shaped.groups:
        shaped.choose(group=group)
        for item in layout(shaped, 372, 4000):
            if item.action[:2] == ("do", "set"):
                offered.setdefault(item.action[2], []).append(item.text)
    shaped.close()
    assert offered["direction"] == offered["stress"] == ["grain"]
    assert offered["wrinkle_curves"] == ["lines"]
    assert all("wear" not in names for names in offered.values())


def test_clicks_draw_strokes_and_cut_sections(window, tmp_path):
    desk = window.desk
    middle = (LEFT / 2, SIZE[1] / 2)
    assert not window.press(*middle)  # turning is the camera's
    click(window, chosen(window, "section"))
    assert window.press(middle[0] - 60, middle[1])
    assert window.press(middle[0] + 60, middle[1] + 20)
    assert desk.section is not None
    assert desk.section.along_mm[-1] > 1
    assert np.ptp(desk.section.height_mm) > 0.01
    flat = window.picture()
    click(window, chosen(window, "stroke"))
    assert desk.section is None
    assert (window.picture() != flat).any()
    for shift in (-50, 0, 50):
        window.press(middle[0] + shift, middle[1] + shift / 2)
    click(window, chosen(window, "done"))
    assert desk.session.value("direction") == "grain"
    assert desk.session.value("stress") == "grain"
    assert desk.worker.wait()
    window.save_as = tmp_path / "made.toml"
    click(window, chosen(window, "save"))
    assert {each.name for each in tmp_path.iterdir()} == {"made.toml", "made-grain.json"}
    assert "saved" in desk.message
    click(window, chosen(window, "spots"))
    window.press(*middle)
    assert "spots" in desk.session.recipe.fields_
    assert window.press(LEFT + 1, 1)
    assert window.press(1, 1) is False  # past the surface


def test_every_button_and_overlay_does_something(window):
    desk = window.desk
    plain = window.picture()
    for name in ("seams", "charts", "regions", "features"):
        click(window, chosen(window, name))
        assert (window.picture()[:, : LEFT - 10] != plain[:, : LEFT - 10]).any(), name
        click(window, chosen(window, name))
    assert desk.overlays == {"drawn"}
    click(window, chosen(window, "raking"))
    assert (window.picture()[:, : LEFT - 10] != plain[:, : LEFT - 10]).mean() > 0.05
    click(window, chosen(window, "seed 0"))
    assert desk.session.recipe.seed == 1
    click(window, chosen(window, ">"))
    assert desk.session.recipe.layer[0].preset != "calf"
    click(window, next(each for each in layout(desk, 372, SIZE[1]) if each.action == ("do", "toggle", 1)))
    assert desk.session.recipe.layer[1].mask == 0
    click(window, chosen(window, "2 goat"))
    assert desk.layer == 1
    click(window, chosen(window, "colour"))
    window.refresh()
    red = next(each for each in layout(desk, 372, SIZE[1]) if each.kind == "slider")
    window.press(LEFT + red.left + 1, red.top + 25)
    assert desk.session.value("color", 1)[0] < 0.01
    window.release()
    with pytest.raises(InputError):
        desk.choose(tool="hammer")
    desk.do("set", "cell_size", -3)
    assert "cell_size" in desk.message
    desk.choose(group="cells")
    low = layout(desk, 372, 520)
    more = next(each for each in low if each.text == "more")
    sliders = [each.text for each in low if each.kind == "slider"]
    rest = layout(desk, 372, 520, more.action[1])
    assert any(each.text == "back" for each in rest)
    assert not {each.text for each in rest if each.kind == "slider"} & set(sliders)
    assert hit(low, -5, -5) is None


def test_a_stroke_is_one_step_and_goes_on_in_a_recipe_that_was_saved(window, tmp_path):
    desk = window.desk
    middle = (LEFT / 2, SIZE[1] / 2)

    def drawn(made, tool="stroke", across=40):
        made.choose(tool=tool)
        for shift in (-across, across):
            place = window.scene.place(middle[0] + shift, middle[1] + across / 2)
            assert place is not None
            made.click(place)
        made.done()

    drawn(desk)
    assert desk.session.history == ("stroke grain",)
    desk.do("undo")
    assert "grain" not in desk.session.recipe.fields_
    assert desk.session.value("direction") is None
    desk.worker.wait()
    desk.choose(tool="turn")
    plain = window.picture().astype(int)
    desk.choose(overlay="drawn")
    drawn(desk)
    desk.do("set", "direction", None)
    desk.do("set", "stress", None)
    assert desk.worker.wait()
    desk.choose(tool="turn")
    assert np.abs(window.picture().astype(int) - plain)[:, : LEFT - 10].max() <= 2
    desk.choose(overlay="drawn")
    blue = window.picture().astype(int)[:, : LEFT - 10]
    assert ((blue[..., 2] > 200) & (blue[..., 0] < 100)).sum() > 80
    drawn(desk, tool="lines")
    assert desk.worker.wait()
    assert desk.session.recipe.layer[desk.layer].material.wrinkle_curves == "drawn"
    desk.do("undo")
    desk.do("set", "direction", "grain")
    desk.do("save", tmp_path / "made.toml")
    again = Desk(load_recipe(tmp_path / "made.toml"), desk.surface, resolution=64)
    drawn(again, across=20)
    assert len(again.session.state.drawings["grain"].strokes) == 2
    assert again.session.history == ("stroke grain",)
    again.do("save", tmp_path / "made.toml", overwrite=True)
    assert len(read_strokes(tmp_path / "made-grain.json", desk.surface).strokes) == 2
    again.close()


def test_drawn_curves_are_shown_smooth_as_they_are_baked_and_strokes_of_a_direction_straight():
    sheet = plane(60.0, cells=5)
    points = closest_points(sheet, np.array([[5.0, 5, 0], [30, 50, 0], [55, 5, 0]]))[0]
    top, straight = (
        walked(sheet, Drawing(use, (Stroke(points),)))[0].reshape(-1, 3) for use in ("curves", "direction")
    )
    assert abs(top[:, 1].max() - 50) < 0.3
    on_leg = np.abs(straight[:, 1] - 5 - 1.8 * np.minimum(straight[:, 0] - 5, 55 - straight[:, 0]))
    assert on_leg.max() < 1e-6
    away = np.abs(top[:, 1] - 5 - 1.8 * np.minimum(top[:, 0] - 5, 55 - top[:, 0]))
    assert 1 < away.max() < 10


def test_saving_away_from_the_mesh_says_what_baking_takes(ball, tmp_path):
    mesh = tmp_path / "ball.obj"
    mesh.write_text("v 0 0 0\n")
    recipe = recipe_from_text(RECIPE)
    recipe = recipe.model_copy(update={"mesh": recipe.mesh.model_copy(update={"path": str(mesh)})})
    desk = Desk(recipe, ball, resolution=64)
    desk.do("save", tmp_path / "here.toml")
    assert desk.message == f"saved {tmp_path / 'here.toml'}"
    load_recipe(tmp_path / "here.toml")
    desk.do("save", tmp_path / "away" / "there.toml")
    assert "--allow-outside" in desk.message
    with pytest.raises(RecipeError, match="allow-outside"):
        load_recipe(tmp_path / "away" / "there.toml")
    desk.close()


def test_a_field_of_another_kind_is_left_alone_and_a_refusal_is_the_end(ball, monkeypatch):
    text = RECIPE.replace("[[layer]]", '[fields]\ngrain = "x"\nspots = "y"\n[[layer]]', 1)
    desk = Desk(recipe_from_text(text), ball, resolution=64)
    ends = [SurfacePoints([face], np.full((1, 3), 1 / 3)) for face in (3, 40)]
    desk.choose(tool="stroke")
    for end in ends:
        desk.click(end)
    desk.done()
    assert desk.session.value("direction") == "grain_2"
    assert desk.session.recipe.fields_["grain"] == "x"
    desk.choose(tool="spots")
    desk.click(ends[0])
    assert "spots_2" in desk.session.recipe.fields_
    before = desk.session.state

    def refused(*_):
        raise RecipeError("no room")

    monkeypatch.setattr(desk.session, "stroke", refused)
    desk.do("set", "direction", None)
    desk.choose(tool="stroke")
    for end in ends:
        desk.click(end)
    desk.done()
    assert desk.message == "no room"
    assert desk.session.value("direction") is None
    assert desk.session.state.drawings == before.drawings
    desk.close()


def test_what_lies_behind_the_surface_is_hidden(window):
    desk = window.desk
    plain = window.picture()
    for side, seen in ((-1.0, False), (1.0, True)):
        point = pick(desk.surface, [0.3, 0.2, 30.0 * side], [0.0, 0.0, -side])
        assert point is not None
        desk.points = [point]
        desk.path = point.positions(desk.surface) + np.array([[-0.4, 0, 0.01 * side], [0.4, 0, 0.01 * side]])
        desk.version += 1
        assert (window.picture() != plain).any() == seen


def test_events_of_the_window_reach_the_panel_and_leave_the_camera_alone(window):
    desk, interactor = window.desk, window.scene.plotter.iren.interactor
    window.connect()

    def event(name, x, y):
        interactor.SetEventInformation(round(x), SIZE[1] - 1 - round(y), 0, 0)
        interactor.InvokeEvent(name)

    camera = window.scene.plotter.camera
    before = camera.GetPosition()
    desk.choose(group="cristae")
    event("TimerEvent", 0, 0)
    slider = chosen(window, "crista height", "slider")
    event("LeftButtonPressEvent", LEFT + slider.left + 0.2 * slider.width, slider.top + 25)
    event("MouseMoveEvent", LEFT + slider.left + 0.8 * slider.width, slider.top + 25)
    event("LeftButtonReleaseEvent", LEFT + slider.left + 0.8 * slider.width, slider.top + 25)
    assert desk.session.value("crista_height") == pytest.approx(0.8 * slider.action[1].high, rel=0.03)
    event("MouseWheelBackwardEvent", LEFT + 20, 300)
    assert camera.GetPosition() == before
    assert desk.worker.wait()
    event("TimerEvent", 0, 0)
    assert window.scene.drawn


def test_picking_meets_the_nearest_face(ball):
    point = pick(ball, [0.3, 0.2, 30.0], [0.0, 0.0, -2.0])
    assert point is not None
    place = point.positions(ball)[0]
    np.testing.assert_allclose(place[:2], [0.3, 0.2], atol=1e-9)
    assert place[2] > 5.8
    assert pick(ball, [9.0, 0.0, 30.0], [0.0, 0.0, -1.0]) is None


def test_light_from_around_has_the_boxes_where_the_studio_says():
    picture = environment(STUDIOS["studio"], 64)
    row, column = np.unravel_index(picture[..., 0].argmax(), picture.shape[:2])
    towards = np.array(STUDIOS["studio"].boxes[0].towards)
    towards /= np.linalg.norm(towards)
    up, turn = np.cos((row + 0.5) / 64 * np.pi), ((column + 0.5) / 64 - 1) * np.pi
    seen = np.array([np.sqrt(1 - up**2) * np.sin(turn), up, np.sqrt(1 - up**2) * np.cos(turn)])
    assert min(np.linalg.norm(seen - np.array(box.towards) / np.linalg.norm(box.towards))
               for box in STUDIOS["studio"].boxes) < 0.5  # fmt: skip
    assert picture[0].mean() > picture[-1].mean()


def test_neighbours_have_colours_of_their_own(desk):
    colors = distinct(np.arange(-1, 40))
    assert len(np.unique(colors, axis=0)) > 38
    lines = seam_lines(desk.surface, desk.live.atlas)
    assert lines.shape[1:] == (2, 3)
    assert np.linalg.norm(lines[:, 0] - lines[:, 1], axis=1).min() > 0


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux tells by its environment")
@pytest.mark.parametrize("display", [None, ":987"])
def test_without_a_display_it_says_so_in_one_line(meshes, display):
    env = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    env |= {"DISPLAY": display} if display else {}
    command = [sys.executable, "-m", "surftex", "preview", str(meshes / "torus.obj"), "--units", "mm"]
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 3
    assert done.stderr.count("\n") == 1
    assert "display" in done.stderr
    assert (display or "no display") in done.stderr


def test_without_opengl_it_says_so_instead_of_dying(monkeypatch, desk):
    monkeypatch.setattr(scene, "_PROBE", "import os; os.abort()")
    with pytest.raises(WorkError, match="OpenGL"):
        scene.Scene(desk)
