"""Stills: what is seen where, normal maps against true relief, shadows, options, files."""

import numpy as np
import pytest

from surftex.charts.atlas import Atlas
from surftex.errors import InputError, RecipeError
from surftex.files.images import read_png
from surftex.kernels.view import nearest_faces
from surftex.preview import render as stills
from surftex.preview.camera import camera_for
from surftex.preview.render import render, render_file, render_files
from surftex.preview.shading import lit, shaded
from surftex.preview.sheet import contact_sheet, written
from surftex.preview.studio import SoftBox, Studio, lamps_of
from surftex.preview.texture import Pyramid, linear_light
from surftex.surface.shapes import plane, sphere
from surftex.surface.surface import Surface
from tests.oracles.view import nearest_faces_slowly

SMALL = {"size": (120, 90), "samples": 1}


def test_nearest_faces_agree_with_the_obvious_twin():
    random = np.random.Generator(np.random.PCG64(3))
    corner = np.concatenate([random.uniform(-5, 45, (60, 3, 2)), random.uniform(0.5, 2, (60, 3, 1))], axis=2)
    face, weight = np.full((30, 40), -1, np.int32), np.zeros((30, 40, 3), np.float32)
    near = np.zeros((30, 40), np.float32)
    nearest_faces(corner, 0, face, weight, near)
    true_face, true_weight = nearest_faces_slowly(corner, 30, 40)
    assert (face == true_face).mean() > 0.999  # ties of float32 depths may fall either way
    assert (face >= 0).sum() > 500
    same = (face == true_face) & (face >= 0)
    np.testing.assert_allclose(weight[same], true_weight[same], atol=1e-5)


def test_camera_frames_what_it_should():
    points = sphere(30.0, subdivisions=3).vertices
    pixels = camera_for(points, (300, 200)).project(points)
    assert pixels[:, 0].min() > 0
    assert pixels[:, 0].max() < 300
    assert np.ptp(pixels[:, 1]) == pytest.approx(0.84 * 200, rel=1e-6)
    close = camera_for(points, (300, 200), view="front", zoom=10, target=(0, 0, 30))
    np.testing.assert_allclose(close.project(np.array([0.0, 0, 30]))[:2], (150, 100), atol=1e-6)
    right = camera_for(points, (300, 200), view="front").project(
        np.array([[0.0, 0, 0], [10, 0, 0], [0, 10, 0]])
    )
    assert right[1, 0] > right[0, 0]
    assert right[2, 1] < right[0, 1]


def test_a_ball_is_lit_from_above_left_and_throws_a_shadow():
    picture = render(sphere(30.0, subdivisions=4), **SMALL, view="front").astype(float)
    middle, reach = np.array([45, 60]), 20
    assert (
        picture[middle[0] - reach, middle[1] - reach].mean()
        > 1.3 * picture[middle[0] + reach, middle[1] + reach].mean()
    )
    standing = render(sphere(30.0, subdivisions=4), **SMALL).astype(float)
    floating = render(sphere(30.0, subdivisions=4), **SMALL, floor=False).astype(float)
    assert standing[-12:].mean() < floating[-12:].mean() - 2
    np.testing.assert_array_equal(standing[:5], floating[:5])


def test_a_crate_without_normals_is_not_lifted_into_what_stands_before_it():
    """Its corners' normals lean by 55 degrees: its sides are no facets of a round body."""
    ball = sphere(50.0, subdivisions=3)
    corner = np.array([[x, y, z] for z in (-105, -95) for y in (-100, 100) for x in (-150, 150)], float)
    side = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6],
            [1, 3, 5], [3, 7, 5]]  # fmt: skip
    faces = np.concatenate([ball.faces, np.add(side, len(ball.vertices))])
    both = Surface.from_arrays(np.concatenate([ball.vertices, corner]), faces)
    picture = render(both, **SMALL)
    assert picture.max(axis=2).min() > 20  # 0 where its points came to lie within the ball


def test_raking_light_follows_what_is_seen():
    """Both flanks of a ball, looked at from one place, are lit alike: the lamps stand around the flank."""
    ball = sphere(30.0, subdivisions=4)
    left, right = (
        render(ball, **SMALL, view="front", light="raking", zoom=12, target=target).astype(float).mean()
        for target in ((-22.0, 0, 20.0), (22.0, 0, 20.0))
    )
    assert left == pytest.approx(right, rel=0.2)  # 141 and 124; 124 and 35 with lamps around the camera


def test_the_same_picture_twice():
    ball = sphere(30.0, subdivisions=2)
    np.testing.assert_array_equal(render(ball, **SMALL), render(ball, **SMALL))


def bumps(x, y):
    """A relief and its slope, millimetres."""
    k = 2 * np.pi / 2.5
    return (
        0.08 * np.sin(k * x) * np.sin(k * y),
        0.08 * k * np.cos(k * x) * np.sin(k * y),
        0.08 * k * np.sin(k * x) * np.cos(k * y),
    )


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_normal_map_looks_like_the_relief_that_it_stands_for(mirrored):
    """Shading with slopes from the map equals shading of displaced triangles, mirrored unwraps included."""
    from surftex.maps.mapset import MapSet
    from surftex.maps.normal import surface_tangents

    flat = plane(10.0, cells=8)
    fine = plane(10.0, cells=240)
    raised = fine.vertices.copy()
    raised[:, 2] = bumps(*fine.vertices.T[:2])[0]
    x, y = np.meshgrid((np.arange(512) + 0.5) / 51.2, 10 - (np.arange(512) + 0.5) / 51.2)
    _, along, upward = bumps(x, y)
    normal = np.stack([-along, -upward, np.ones_like(x)], axis=2)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    uv = flat.corner_uv.copy()
    if mirrored:
        uv[..., 0] = 1 - uv[..., 0]
        normal = normal[:, ::-1]
    atlas = Atlas.of(flat, uv)
    # A mirrored u carries the tangent with it: the map tells slopes along u.
    normal = normal * ([-1, 1, 1] if mirrored else [1, 1, 1])
    maps = MapSet(
        maps={"normal": normal.astype(np.float32)},
        surface=flat,
        atlas=atlas,
        tangents=surface_tangents(flat, atlas),
    )
    raking = Studio((SoftBox((-1.0, 0.5, 0.45), (0.1, 0.1), 1.0, lamps=2),), above=0.05, below=0.05)
    options = {"size": (160, 160), "samples": 2, "view": "front", "light": raking, "floor": False}
    told = render(maps, **options)[20:-20, 20:-20].astype(float)
    true = render((raised, fine.faces), **options)[20:-20, 20:-20].astype(float)
    plain = render(flat, **options)[20:-20, 20:-20].astype(float)
    assert np.corrcoef(told.ravel(), true.ravel())[0, 1] > 0.97
    assert np.abs(told - true).mean() < 0.35 * np.abs(plain - true).mean()


def test_a_mirror_in_an_even_room_has_no_dark_slopes():
    """Far walls of a relief mirror what lies below the plane of the mesh: they show its horizon, not black."""
    floor = plane(10.0, cells=1)
    studio = Studio((), above=0.5, below=0.5)
    up = np.array([0.0, 0, 1])
    scene = lit(floor.vertices, floor.faces, studio, lamps_of(studio, np.eye(3), up), up, floor.vertices)
    lean, turn, low = (grid.ravel() for grid in np.meshgrid(
        np.radians(np.arange(0, 75, 3)), np.radians(np.arange(0, 360, 15)), np.radians((2, 10, 30, 60))
    ))  # fmt: skip
    normal = np.stack([np.sin(lean) * np.cos(turn), np.sin(lean) * np.sin(turn), np.cos(lean)], axis=1)
    to_eye = np.stack([np.cos(low), 0 * low, np.sin(low)], axis=1)
    metal = np.array([[1, 1, 1, 1, 0.2, 1, 0.04, 0.04, 0.04, 0, 0, 1, 1]])
    place = np.tile([5.0, 5.0, 0.0], (len(lean), 1))
    light = shaded(scene, *(
        array.astype(np.float32)
        for array in (np.repeat(metal, len(lean), axis=0), place, normal, np.tile(up, (len(lean), 1)), to_eye)
    ))  # fmt: skip
    assert light.min() > 0.9 * light.max()


def test_shadows_are_as_fine_as_what_is_shown():
    """The edge of a wide roof throws a shadow that close-ups see sharp, not in steps of the roof's own size."""
    roof = np.array([[0.0, -100, 20], [200, -100, 20], [200, 100, 20], [0, 100, 20]])
    studio = Studio((SoftBox((0.0, 0.0, 1.0), (0.0, 0.0), 1.0, lamps=1),), above=0.0, below=0.0)
    up = np.array([0.0, 0, 1])
    lamps = lamps_of(studio, np.eye(3), up)
    across = np.linspace(-1, 1, 401)
    floor = np.stack([across, 0 * across, 0 * across], axis=1)
    upright = np.tile(up, (len(floor), 1))
    wide = {}
    for name, shown in (("roof", roof), ("floor", floor)):
        scene = lit(roof, np.array([[0, 1, 2], [0, 2, 3]], np.int32), studio, lamps, up, shown)
        light = scene.gather(floor, upright, upright)[0][:, 0]
        wide[name] = float(((light > 0.05) & (light < 0.95)).mean() * 2)
        assert abs(across[np.argmin(np.abs(light - 0.5))]) < 0.3
    assert wide["floor"] < 0.02 < wide["roof"]


def test_lamps_of_a_box_lie_in_no_line():
    """Seen along any direction they come one after another: shadows of an edge fade in as many steps."""
    studio = Studio((SoftBox((0.0, 0.0, 1.0), (0.3, 0.3), 1.0, lamps=49),), above=0.0, below=0.0)
    lamps = lamps_of(studio, np.eye(3), np.array([0.0, 1, 0]))
    towards = lamps.frame[lamps.group == 0, 2]
    places = towards[:, :2] / towards[:, 2:] / 0.3
    assert np.abs(places.mean(axis=0)).max() < 0.1
    for turn in np.radians(np.arange(0, 180, 5)):
        along = np.sort(places @ [np.cos(turn), np.sin(turn)])
        assert (along[6:] - along[:-6]).min() > 0.03  # of a grid of 7 by 7, seven lie in a line


def test_pictures_are_halved_and_blended():
    image = np.zeros((8, 8, 1))
    image[::2] = 1.0
    pyramid = Pyramid(image)
    places = np.array([[0.3, 0.0625], [0.3, 0.1875], [0.3, 0.125]])
    np.testing.assert_allclose(pyramid.at(places, np.zeros(3))[:, 0], [1, 0, 0.5], atol=1e-3)
    np.testing.assert_allclose(pyramid.at(places, np.ones(3))[:, 0], 0.5, atol=1e-3)
    np.testing.assert_allclose(pyramid.at(places[:1], np.array([0.5])), 0.75, atol=1e-3)
    assert linear_light(np.array([0, 188, 255], np.uint8)).tolist() == pytest.approx([0, 0.5, 1], abs=0.005)


def test_files_and_mistakes(tmp_path, meshes):
    path = render_file(meshes / "bottle.glb", tmp_path / "bottle.png", **SMALL)
    assert read_png(path).shape == (90, 120, 3)
    assert [p.name for p in tmp_path.iterdir()] == ["bottle.png"]
    with pytest.raises(InputError, match=r"\.png"):
        render_file(meshes / "bottle.glb", tmp_path / "bottle.jpg")
    ball = sphere(10.0, subdivisions=1)
    for wrong in (
        {"view": "nowhere"},
        {"view": (30.0, 95.0)},
        {"view": (float("nan"), 5.0)},
        {"light": "candle"},
        {"zoom": 0},
        {"up": "w"},
        {"background": "pink"},
        {"samples": 0},
    ):
        with pytest.raises(RecipeError):
            render(ball, **{**SMALL, **wrong})
    with pytest.raises(InputError, match="cannot draw"):
        render(3)


def test_where_a_picture_cannot_go_is_told_before_any_work(tmp_path):
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "file").write_text("")
    for render_one in (render_file, render_files):
        with pytest.raises(InputError, match="is a folder"):
            render_one("no mesh at all", tmp_path / "folder.png")
        with pytest.raises(InputError, match="is a file; name a folder"):
            render_one("no mesh at all", tmp_path / "file" / "a.png")
    path = render_file(sphere(10.0, subdivisions=1), tmp_path / "new" / "sub" / "a.png", **SMALL)
    assert read_png(path).shape == (90, 120, 3)


def test_sheet_has_room_for_all_and_letters():
    images = [np.full((20, 30, 3), 50 * k, np.uint8) for k in range(5)]
    sheet = contact_sheet(images, ["one", "two", "three", "4", "5"], columns=3, gap=10)
    assert sheet.shape == (2 * (20 + 30 + 10) + 10, 3 * 40 + 10, 3)
    assert (sheet[10:30, 50:80] == 50).all()
    assert (sheet[38:48, 10:40] == 20).any()
    assert written("H", 1)[:, :3].astype(int).tolist() == [
        [1, 0, 1],
        [1, 0, 1],
        [1, 1, 1],
        [1, 0, 1],
        [1, 0, 1],
    ]
    with pytest.raises(InputError, match="labels"):
        contact_sheet(images, ["one"])


def test_facets_of_a_smooth_mesh_throw_no_shadows_on_themselves():
    """A coarse ball with smooth normals is lit like a fine one, away from the outline."""
    options = {"size": (160, 160), "light": "raking", "view": "front", "floor": False}
    coarse, fine = (
        render(sphere(20.0, subdivisions=number), **options).astype(int)[..., 1] for number in (1, 5)
    )
    row, column = np.mgrid[:160, :160] - 79.5
    radius = np.sqrt((fine != fine[0, 0]).sum() / np.pi)
    inside = np.hypot(row, column) < 0.8 * radius
    assert np.percentile(np.abs(coarse - fine)[inside], 99) < 8


def test_turntables_views_lights_and_sheets(tmp_path, monkeypatch):
    taken = []

    def still(bodies, *, view, light, size):
        taken.append((view, light))
        return np.full((size[1], size[0], 3), len(taken), np.uint8)

    monkeypatch.setattr(stills, "render", still)
    ball, size = sphere(5.0, subdivisions=1), {"size": (40, 30)}
    paths = render_files(ball, tmp_path / "t.png", turntable=3, views=["front"], **size)
    assert [path.name for path in paths] == ["t-000.png", "t-001.png", "t-002.png"]
    assert taken == [((0.0, 5.0), "studio"), ((120.0, 5.0), "studio"), ((240.0, 5.0), "studio")]
    assert [read_png(path)[0, 0, 0] for path in paths] == [1, 2, 3]
    paths = render_files(
        ball, tmp_path / "v.png", views=["top", (10.0, 20.0)], lights=["studio", "raking"], **size
    )
    assert [path.name for path in paths] == [
        "v-top-studio.png", "v-top-raking.png", "v-10_20-studio.png", "v-10_20-raking.png",
    ]  # fmt: skip
    (sheet,) = render_files(ball, tmp_path / "s.png", views=["top", "front"], sheet=True, **size)
    assert read_png(sheet).shape[1] > 80
    with pytest.raises(RecipeError, match="turntable"):
        render_files(ball, tmp_path / "t.png", turntable=1)
    with pytest.raises(RecipeError, match="no view"):
        render_files(ball, tmp_path / "t.png", turntable=3, views=["sideways"])


def test_an_empty_picture_is_refused_with_where_the_subject_is(tmp_path, capsys):
    from surftex.cli.main import main

    ball = sphere(20.0, subdivisions=2)
    with pytest.raises(
        RecipeError, match=r"nothing is in view; the subject spans x -20 to 20, y .*, z .*: aim there"
    ):
        render(ball, target=(500, 0, 0), zoom=4, **SMALL)
    (tmp_path / "ball.obj").write_text(
        "".join(f"v {x} {y} {z}\n" for x, y, z in ball.vertices)
        + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in ball.faces)
    )
    aimed = [
        "render",
        str(tmp_path / "ball.obj"),
        "-o",
        str(tmp_path / "ball.png"),
        "--picture-size",
        "60x40",
    ]
    assert main([*aimed, "--view", "-90,10", "--target", "-5000,0,0", "--zoom", "4"]) == 2
    assert "nothing is in view" in capsys.readouterr().err
    assert not (tmp_path / "ball.png").exists()
    assert main([*aimed, "--view", "-90,10", "--target", "-5,0,0"]) == 0
    beside = {"target": (60, 0, 0), "zoom": 4, **SMALL}
    assert render(ball, view="right", **beside).any()
    for out in ({}, {"sheet": True}):
        with pytest.raises(RecipeError, match="nothing is in view"):  # from the second side
            render_files(ball, tmp_path / "side.png", views=["right", "front"], **out, **beside)
    assert not list(tmp_path.glob("side*"))


def test_normals_are_bent_until_they_mirror_the_horizon_and_no_further():
    from surftex.preview.shading import _mirroring, _towards

    random = np.random.Generator(np.random.PCG64(5))
    normal, facing, eye = (random.normal(size=(4000, 3)).astype(np.float32) for _ in range(3))
    eye, facing = (part / np.linalg.norm(part, axis=1)[:, None] for part in (eye, facing))
    facing = _towards(facing, eye)
    normal = _towards(facing + 0.8 * normal / np.linalg.norm(normal, axis=1)[:, None], eye)

    def height(of):
        mirror = 2 * (of * eye).sum(axis=1)[:, None] * of - eye
        return (mirror * facing).sum(axis=1)

    least = np.minimum(0.01, 0.9 * (facing * eye).sum(axis=1))
    bent, low = _mirroring(normal, facing, eye), height(normal) < least
    assert 200 < low.sum() < 3800
    np.testing.assert_array_equal(bent[~low], normal[~low])
    np.testing.assert_allclose(height(bent)[low], least[low], atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(bent, axis=1), 1, atol=1e-5)
