"""The face on the shipped head: masks and lines lie where they belong, and stay inside their bounds."""

import json

import numpy as np
import pytest

from surftex.bake.fields import make_fields
from surftex.errors import RecipeError
from surftex.features.curves import curve_pieces
from surftex.fields.face import face_atlas, face_lines
from surftex.files.meshes import load
from surftex.recipe.read import recipe_from_text
from surftex.surface.closest import closest_points
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

LAYER = '\n[[layer]]\npreset = "calf"\n'


@pytest.fixture(scope="module")
def head(meshes):
    return load(meshes / "head.ply", units="mm")


@pytest.fixture(scope="module")
def picks(meshes):
    return json.loads((meshes / "head_landmarks.json").read_text())["points"]


def fields(text, head, meshes):
    return make_fields(recipe_from_text(f"[fields]\n{text}{LAYER}", name="r.toml", folder=meshes), head)


def at(head, place):
    return closest_points(head, np.atleast_2d(place) - head.origin_mm)[0]


def test_masks_are_where_they_belong(head, picks, meshes):
    text = "\n".join(
        f'{name} = {{ face = "{name}", landmarks = "head_landmarks.json" }}' for name in face_atlas()["masks"]
    )
    made = fields(text, head, meshes)
    middle = {
        "lips": np.mean([picks["lip_top"], picks["lip_bottom"]], axis=0),
        "nose": picks["nose_tip"],
        "chin": picks["chin"],
        "forehead": np.mean([picks["brow_middle"], picks["hairline"]], axis=0),
        "eyelids": np.mean([picks["left_eye_inner"], picks["left_eye_outer"]], axis=0),
    }
    for name, place in middle.items():
        point = at(head, place)
        assert made.scalar(name)(point)[0] > 0.9, name
        for other in middle:
            if other != name:
                assert made.scalar(other)(point)[0] < 0.1, (name, other)
    back = at(head, [0, 0, -500])
    for name in face_atlas()["masks"]:
        assert made.scalar(name)(back)[0] == 0, name
    assert made.scalar("ears")(at(head, [90, -10, 0]))[0] > 0.5


def test_spans_hold(head, meshes):
    made = fields('lips = { face = "lips", landmarks = "head_landmarks.json" }', head, meshes)
    lips = made.scalar("lips")
    low, high = lips.span()
    random = np.random.Generator(np.random.PCG64(1))
    face = random.integers(0, len(head.faces), 20000)
    value = lips(SurfacePoints(face, random.dirichlet([1, 1, 1], 20000)))
    assert (value >= low[face] - 1e-9).all()
    assert (value <= high[face] + 1e-9).all()
    assert high.mean() < 0.1  # and they are of use


def test_lines_lie_where_they_belong(head, picks, meshes):
    made = fields(
        'l = { face_lines = ["crows_feet", "smile"], landmarks = "head_landmarks.json", depth = 2 }',
        head,
        meshes,
    )
    table = made.curves("l")
    atlas = face_atlas()["lines"]
    assert len(np.unique(table["curve"])) == sum(
        len(atlas[name]["curves"]) for name in ("crows_feet", "smile")
    )
    pieces = curve_pieces(head, table)
    start = pieces.points(head, 0.0).positions(head) + head.origin_mm
    crows = table["depth_mm"] == 2 * atlas["crows_feet"]["depth_mm"]
    corner = np.array([picks["left_eye_outer"], picks["right_eye_outer"]])
    apart = np.linalg.norm(start[crows][:, None] - corner, axis=2).min(axis=1)
    assert apart.max() < 35
    assert apart.min() < 8
    outward = np.abs(start[crows][:, 0]) > 0.95 * np.abs(corner[:, 0]).min()
    assert outward.all()
    wing, mouth = np.array(picks["nose_left"]), np.array(picks["mouth_left"])
    smile = start[~crows & (start[:, 0] > 0)]
    assert np.linalg.norm(smile - wing, axis=1).min() < 8
    assert np.linalg.norm(smile - mouth, axis=1).min() < 14
    assert smile[:, 1].min() < mouth[1] + 8


PICKS = 'landmarks = "head_landmarks.json"'
MISTAKES = [
    (
        f'a = {{ face = "lipps", {PICKS} }}',
        "r.toml:2: fields.a: the face has no mask 'lipps'; did you mean lips",
    ),
    (f'a = {{ face_lines = "smiles", {PICKS} }}', "the face has no line 'smiles'; did you mean smile"),
    ('a = { face = "lips", landmarks = "none.json" }', "does not exist"),
    ('a = { face = "lips" }', "landmarks: this key is needed"),
]


@pytest.mark.parametrize(("text", "says"), MISTAKES)
def test_mistakes_are_located(head, meshes, text, says):
    with pytest.raises(RecipeError) as caught:
        fields(text, head, meshes).curves("a")
    assert says in str(caught.value)


def test_too_few_landmarks_and_unknown_ones(head, picks, tmp_path):
    few = {name: picks[name] for name in list(picks)[:3]}
    for points, says in (
        (few, "3 landmarks are too few"),
        ({**picks, "elbow": [0, 0, 0]}, "no landmark 'elbow'"),
    ):
        (tmp_path / "p.json").write_text(json.dumps({"points": points}))
        with pytest.raises(RecipeError, match=says):
            fields('a = { face = "lips", landmarks = "p.json" }', head, tmp_path)


def test_lines_lie_on_the_skin_where_lashes_stand_before_it(head, picks, meshes):
    places = np.array(list(picks.values()))
    corner = places[list(picks).index("left_eye_outer")] - head.origin_mm
    near = np.flatnonzero(np.linalg.norm(head.vertices[head.faces].mean(axis=1) - corner, axis=1) < 9)
    lash = head.vertices + 0.5 * head.vertex_normal
    both = Surface.from_arrays(
        np.concatenate([head.vertices, lash]),
        np.concatenate([head.faces, head.faces[near] + len(head.vertices)]),
        origin_mm=tuple(head.origin_mm),
    )
    points, away = closest_points(head, places - head.origin_mm)
    assert away.max() < 5
    named = {
        name: SurfacePoints(points.face[i : i + 1], points.barycentric[i : i + 1])
        for i, name in enumerate(picks)
    }
    table = face_lines(both, named, ("crows_feet",))
    assert len(np.unique(table["curve"])) == len(face_atlas()["lines"]["crows_feet"]["curves"])
    assert table["face"].max() < len(head.faces)
