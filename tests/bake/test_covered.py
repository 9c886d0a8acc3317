"""A layer lies on the bodies of the mesh that its mask covers: as on a mesh of these alone, and nothing elsewhere."""

import json
from dataclasses import replace

import numpy as np
import pytest

import surftex as sx
from surftex.bake.bake import run
from surftex.bake.cost import recipe_costs
from surftex.bake.covered import BodiesTick, OnBodies, covered_bodies, fields_on, mask_on
from surftex.bake.fields import make_fields
from surftex.bake.growing import Growth, ground_key, grown_on
from surftex.bake.stack import layer_seed, place_layer, place_stack
from surftex.features.uniform import area_points
from surftex.fields.fieldset import FieldSet
from surftex.fields.sources import image_field
from surftex.kernels.pool import PartTick
from surftex.preview.live import Live
from surftex.randomness import stream
from surftex.recipe.read import recipe_from_text
from surftex.surface.bodies import Bodies
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.shapes import sphere
from surftex.surface.surface import Surface

BALL = sphere(1.0, subdivisions=2)
SIZES, AT = (9.0, 6.0, 4.0), (0.0, 30.0, 50.0)
ALONE = {"crocodile": 'cell_size = "2 mm"\nwrinkle_density = 20', "even": 'cell_size = "2.5 mm"',
         "skin": "mole_count = 9\npore_density = 1", "gravel": 'pixel_size = "0.7 mm"\nsweeps = 2'}  # fmt: skip


def three_balls():
    """Faces of three bodies in one shuffled row, with a part, an attribute and UVs."""
    count, vertices = len(BALL.faces), len(BALL.vertices)
    points = np.concatenate([BALL.vertices * size + [at, 0, 0] for size, at in zip(SIZES, AT, strict=True)])
    faces = np.concatenate([BALL.faces + body * vertices for body in range(3)])
    order = np.argsort(stream(1, "order").uniform(3 * count)[:, 0])
    body = np.repeat(np.arange(3), count)[order]
    uv = (points[faces[order]][..., :2] + 10) / 70
    return Surface.from_arrays(points, faces[order], part=body, part_names=("a", "b", "c"), corner_uv=uv,
                               attributes={"worn": np.repeat(1.0 * (body == 1)[:, None], 3, axis=1)})  # fmt: skip


WHOLE = three_balls()
NUMBER = {name: int(WHOLE.component[np.argmax(WHOLE.part == i)]) for i, name in enumerate("abc")}


def recipe(mask, preset="crocodile", fields="", **keys):
    keys = ({"generations": 20} if preset == "even" else {}) | keys
    more = "\n".join(f"{key} = {json.dumps(value)}" for key, value in keys.items())
    return recipe_from_text(
        f'surftex = 1\nseed = 5\n[fields]\n{fields}\n[[layer]]\nmaterial = "leather"\npreset = "calf"\n'
        f'cell_size = "4 mm"\npore_density = 0\n[[layer]]\npreset = "{preset}"\n{ALONE[preset]}\n'
        f"mask = {json.dumps(mask)}\n{more}",
        allow_outside=True,
    )


def placed(made, **options):
    fields = make_fields(made, WHOLE)
    return place_layer(made, 1, WHOLE, fields, **options)[0]


def alone(name):
    """The mesh of one body, cut out by hand, and the face of the whole that each of its faces is."""
    face = np.flatnonzero(WHOLE.part == "abc".index(name))
    used = sorted({*WHOLE.faces[face].ravel().tolist()})
    number = {vertex: i for i, vertex in enumerate(used)}
    return Surface.from_arrays(
        WHOLE.vertices[used], [[number[v] for v in row] for row in WHOLE.faces[face].tolist()], corner_uv=WHOLE.corner_uv[face]
    ), face  # fmt: skip


def samples(surface, face, count=600):
    here = area_points(surface, stream(3, "samples").uniform(count, 3))
    foot = np.full(count, 0.05, np.float32)
    there = SurfacePoints(face[here.face], here.barycentric)
    return Samples(here, foot), Samples(there, foot)


def same(tables, others):
    assert tables.keys() == others.keys()
    for kind, table in tables.items():
        assert table.dtype == others[kind].dtype
        assert table.tobytes() == others[kind].tobytes(), kind


@pytest.mark.parametrize(
    ("mask", "covers"),
    [
        (1, "abc"), (0.5, "abc"), (0, ""), ("part('b')", "b"), ("0.3 * part('a') + part('c')", "ac"), ("worn", "b"),
        ("1 - part('b')", "ac"), ("x > 40", "c"), ("smoothstep(37, 46, x)", "c"), ("clamp(-x, 0, 1)", "a"),
        ("part('b') * patchy", "b"), ("patchy", "abc"), ("max(patchy - 2, 0)", ""), ("rising", "bc"),
        ("y > 5", "ab"), ("part('b') * (y > 9)", ""), ("near < 3", "abc"),
    ],
)  # fmt: skip
def test_masks_leave_out_what_they_surely_do_not_cover(mask, covers):
    fields = """patchy = { noise = 2, wavelength = "4 mm" }
worn = { attribute = "worn" }
rising = { gradient = [1, 0, 0], start = "20 mm", end = "60 mm" }
near = { distance_to = "part('b') * (y > 1)" }"""
    made = recipe(mask, fields=fields)
    fields = make_fields(made, WHOLE)
    covered = covered_bodies(WHOLE, fields, made.layer[1].mask)
    if mask != "near < 3":  # how far a distance is bounded is not told here, only that it is on the safe side
        assert {name for name in "abc" if covered[NUMBER[name]]} == {*covers}
    points = area_points(WHOLE, stream(0, "look").uniform(4000, 3))
    seen = fields.scalar(made.layer[1].mask)(points) > 0
    assert covered[WHOLE.component[points.face[seen]]].all()


@pytest.mark.parametrize(("black_mm", "covers"), [(9.3, "bc"), (8.0, "abc")])
def test_pictures_that_are_white_close_by_leave_out_a_body(black_mm, covers):
    at = (np.arange(1400) + 0.5) / 20 - 10  # mm along x, as the UVs have it; rows go down
    white = np.hypot(at, at[::-1, None]) > black_mm
    fields = FieldSet(WHOLE, {"picture": image_field(WHOLE, white.astype(float))})
    assert (fields.scalar("picture").span()[1] > 0)[WHOLE.part == 0].any()
    covered = covered_bodies(WHOLE, fields, "0.5 * picture")
    assert {name for name in "abc" if covered[NUMBER[name]]} == {*covers}


@pytest.mark.slow
@pytest.mark.parametrize("preset", ALONE)
def test_a_layer_lies_on_a_body_as_on_a_mesh_of_it_alone(preset):
    made = recipe("part('b')", preset)
    pattern = placed(made)
    body, face = alone("b")
    twin = made.layer[1].material.place(body, layer_seed(made.seed, 1), fields=make_fields(recipe(1), body))
    assert isinstance(pattern, OnBodies)
    renamed = {kind: table.copy() for kind, table in twin.features.items()}
    for table in renamed.values():
        table["face"] = face[table["face"]]
    same(dict(pattern.features), renamed)
    here, there = samples(body, face)
    one, two = twin.at(here), pattern.at(there)
    assert one.channels.keys() == two.channels.keys() == {*made.layer[1].material.channels}
    for name in one.channels:
        assert one[name].tobytes() == two[name].tobytes(), name


@pytest.mark.parametrize("mask", [0.5, "0.2 + x * x", "part('a') + part('b') + part('c')"])
def test_a_mask_on_every_body_changes_nothing_that_is_placed(mask):
    made = recipe(mask)
    pattern = placed(made)
    whole = made.layer[1].material.place(WHOLE, layer_seed(5, 1), fields=make_fields(made, WHOLE))
    assert type(pattern) is type(whole)
    same(dict(pattern.features), dict(whole.features))


def test_threads_change_no_byte():
    made = recipe("1 - part('a')")
    same(dict(placed(made, threads=1).features), dict(placed(made, threads=3).features))


def test_fields_have_the_values_of_the_whole():
    made = recipe(
        "part('b')",
        fields='along = { axis = [0.2, 1, 0.3] }\nsmooth = { direction = "smooth" }\nwave = "x + 3 * part(\'b\') + rough"\n'
        'rough = { noise = 1, wavelength = "3 mm" }',
    )
    fields = make_fields(made, WHOLE)
    bodies = Bodies.of(WHOLE, np.arange(3) == NUMBER["b"])
    there = fields_on(bodies, fields)
    here = area_points(bodies.surface, stream(2, "points").uniform(300, 3))
    points = bodies.points_there(here)
    assert (WHOLE.part[points.face] == 1).all()
    assert (here.positions(bodies.surface) == points.positions(WHOLE)).all()
    for name in ("along", "smooth"):
        assert (there.direction(name).at(here) == fields.direction(name).at(points)).all()
    assert (there.scalar("wave * 2")(here) == fields.scalar("wave * 2")(points)).all()
    for own, whole in zip(there.scalar("wave").span(), fields.scalar("wave").span(), strict=True):
        assert (own == whole[bodies.face]).all()
    assert (there.scalar("2 - part('b')")(here) == 1).all()
    assert len(bodies.points_here(points)) == 300
    others = SurfacePoints(np.flatnonzero(WHOLE.part != 1)[:9], np.full((9, 3), 1 / 3))
    assert len(bodies.points_here(others)) == 0


def test_bodies_keep_what_hangs_on_their_faces():
    normal = np.repeat(WHOLE.frame[:, None, 2], 3, axis=1)
    whole = replace(WHOLE, corner_normal=normal)
    bodies = Bodies.of(whole, np.arange(3) != NUMBER["b"])
    face, surface = bodies.face, bodies.surface
    assert (whole.component[face] != NUMBER["b"]).all()
    assert (bodies.own[face] == np.arange(len(face))).all()
    for name in ("corner_uv", "corner_normal", "part", "frame", "flat", "vertex_normal"):
        of_whole = getattr(whole, name)
        of_whole = of_whole[bodies.vertex] if name == "vertex_normal" else of_whole[face]
        assert (getattr(surface, name) == of_whole).all(), name
    assert (surface.attributes["worn"] == whole.attributes["worn"][face]).all()
    with pytest.raises(sx.InputError, match="keep at least one"):
        Bodies.of(whole, np.zeros(3, bool))


def test_curves_on_other_bodies_are_left_out_and_the_rest_numbered_anew():
    from surftex.features.curves import ROW

    table = np.zeros(6, ROW)
    table["face"] = np.concatenate([np.flatnonzero(WHOLE.part == part)[:2] for part in (0, 1, 1)])
    table["curve"] = [0, 0, 1, 1, 2, 2]
    found = Bodies.of(WHOLE, np.arange(3) == NUMBER["b"]).curves_here(table)
    assert found["curve"].tolist() == [0, 0, 1, 1]
    assert found["face"].tolist() == [0, 1, 0, 1]


@pytest.mark.parametrize("preset", ["crocodile", "even", "skin"])
def test_strokes_on_bodies_that_a_layer_does_not_cover_are_told(tmp_path, preset):
    strokes = [[[x, 0, 9], [x, 3, 8]] for x in (2, -2)] + [[[30, 0, 6], [30, 3, 5]]]
    (tmp_path / "lines.json").write_text(json.dumps({"strokes": strokes}))
    lines = f'lines = {{ curves = "{tmp_path}/lines.json" }}'
    for mask, says in (
        ("part('b')", ["2 of 3 strokes of 'lines' lie on bodies"]),
        ("part('c')", ["3 of 3 strokes of 'lines' lie on bodies"]),
        ("part('a')", ["1 of 3 strokes of 'lines' lies on a body"]),
        ("part('a') + part('b')", []),
    ):
        made = recipe(mask, preset, lines, wrinkle_curves="lines")
        stack = place_stack(made, WHOLE, make_fields(made, WHOLE))
        told = [text for text in stack.warnings if "strokes" in text]
        assert told == [f"layer[2]: {text} that this layer does not cover" for text in says]


def test_places_on_bodies_that_a_layer_does_not_cover_are_told(tmp_path):
    (tmp_path / "spots.json").write_text(json.dumps({"points": [[x, 0, 9] for x in (0, 1, 30)]}))
    spots = f'spots = {{ distance_to = "{tmp_path}/spots.json" }}'
    for mask, says in (
        ("part('b')", ["2 of 3 places of 'spots' lie on bodies"]),
        ("part('a')", ["1 of 3 places of 'spots' lies on a body"]),
        ("part('a') + part('b')", []),
    ):
        made = recipe(mask, "skin", spots, mole_points="spots")
        stack = place_stack(made, WHOLE, make_fields(made, WHOLE))
        told = [text for text in stack.warnings if "places" in text]
        assert told == [f"layer[2]: {text} that this layer does not cover" for text in says]


def test_no_rounding_shows_a_layer_where_it_does_not_lie():
    made = recipe("part('b')")
    fields, pattern = make_fields(made, WHOLE), placed(made)
    points = area_points(WHOLE, stream(0, "look").uniform(500, 3))
    mask = mask_on(pattern, fields, "0.5 + x * x")
    assert mask is not None
    assert ((mask(points, 0.1) > 0) == (WHOLE.part[points.face] == 1)).all()
    elsewhere = pattern.at(Samples(points, np.ones(500, np.float32)))
    assert (elsewhere["region"][WHOLE.part[points.face] != 1] == -1).all()


def baked(made, **options):
    options |= {"resolution": 64, "maps": ["height", "region"], "uv": "unwrap", "unwrapper": "uvunwrap"}
    return sx.bake(WHOLE, made, **options)


def test_features_start_a_bake_that_covers_the_same_or_less(tmp_path):
    first = baked(recipe("1 - part('a')"))
    cells = first.features["layer2_cell"]
    assert {*WHOLE.part[cells["face"]].tolist()} == {1, 2}
    assert first.report["features"]["layer2_cell"] == len(cells)
    assert first.report["placed"]["layer"][1]["bodies"] == sorted(NUMBER[name] for name in "bc")
    assert "bodies" not in first.report["placed"]["layer"][0]
    first.save(tmp_path / "out")
    file = tmp_path / "out" / "features.npz"
    again = baked(recipe("1 - part('a')"), features=file)
    assert again["height"].tobytes() == first["height"].tobytes()
    less = baked(recipe("part('b')"), features=file)
    texel = again["region"] == less["region"]
    assert less["height"][texel].tobytes() == first["height"][texel].tobytes()
    assert less.report["features"] == first.report["features"]
    with pytest.raises(sx.InputError, match=r"placed on 2 of the 3 bodies .* layer\[2\].mask covers 1 more"):
        baked(recipe("1 - part('b')"), features=file)


@pytest.mark.parametrize("preset", ALONE)
def test_a_mask_that_covers_nothing_is_told_and_places_nothing(preset):
    made = recipe("part('b') * (x > 99)", preset)
    stack = place_stack(made, WHOLE, make_fields(made, WHOLE))
    assert {"layer[2]: its mask is 0 everywhere, so nothing of it is placed"} == {*stack.warnings}
    assert {*stack.patterns[1].channels} == {*placed(recipe("part('c')", preset)).channels}
    assert not stack.patterns[1].features
    _, some = samples(WHOLE, np.arange(len(WHOLE.faces)))
    shown = stack.at(some, ("height_mm", "base_color", "region"))
    for name, values in shown.items():
        assert values.tobytes() == stack.patterns[0].at(some)[name].tobytes()
    again = place_stack(made, WHOLE, make_fields(made, WHOLE), features=stack.features)
    assert again.warnings == stack.warnings


def test_a_dry_run_counts_on_the_bodies_that_are_covered(tmp_path):
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in WHOLE.vertices.tolist())
    for part, name in enumerate("abc"):
        text += f"usemtl {name}\n"
        text += "".join(f"f {a} {b} {c}\n" for a, b, c in (WHOLE.faces[WHOLE.part == part] + 1).tolist())
    (tmp_path / "balls.obj").write_text(text)
    mesh = {"mesh": {"path": tmp_path / "balls.obj", "units": "mm"}}
    made = [sx.Recipe.of(recipe(mask), max_features=600) for mask in ("part('c')", 1, "x > 99")]
    made = [each.model_copy(update={"mesh": each.mesh.model_copy(update=mesh["mesh"])}) for each in made]
    part, whole, nothing = recipe_costs(made)
    assert "would hold about" in whole["problem"]
    placed_cells = len(placed(recipe("part('c')")).features["cell"])
    assert part["cells"] - nothing["cells"] == pytest.approx(placed_cells, rel=0.2)


def test_a_preview_places_anew_where_other_bodies_are_covered():
    live = Live(WHOLE, recipe("part('b')"), resolution=64)
    live.draw(recipe("part('b')"))
    for mask, effort in (
        ("0.5 * part('b')", "kept"),
        (0, "kept"),
        ("part('b')", "kept"),
        ("part('b') + part('c')", "placed"),
    ):
        assert live.draw(recipe(mask)).effort == effort
    fresh = Live(WHOLE, recipe(mask), resolution=64)
    fresh.draw(recipe(mask))
    assert (live.height_mm == fresh.height_mm).all()
    assert live.stack.features.keys() == fresh.stack.features.keys()
    assert live.draw(recipe(mask, crista_height=0.3)).effort == "shaped"
    fresh.draw(recipe(mask, crista_height=0.3))
    assert np.ptp(fresh.height_mm) > 0.2
    np.testing.assert_allclose(live.height_mm, fresh.height_mm, atol=2e-6)


def test_what_grows_on_bodies_is_kept_with_the_faces_of_the_whole():
    bodies = Bodies.of(WHOLE, np.arange(3) == NUMBER["c"])
    grown, kept = np.zeros(4, [("face", "i4")]), []
    grown["face"] = [0, 1, 5, 7]

    class Keeps(PartTick):
        def keep(self, generation, last, make):
            kept.append((generation, last, make()["particle"]["face"]))

    BodiesTick(Keeps(None), bodies).keep(3, 9, lambda: {"particle": grown})
    assert kept[0][:2] == (3, 9)
    assert (kept[0][2] == np.flatnonzero(WHOLE.part == 2)[[0, 1, 5, 7]]).all()


@pytest.mark.slow
def test_a_growth_goes_on_only_on_the_bodies_that_it_began_on(tmp_path):
    def key(mask, preset="even"):
        made = recipe(mask, preset)
        return ground_key(WHOLE, grown_on(made, WHOLE, make_fields(made, WHOLE)))

    assert key(0.5) == key(1) == ground_key(WHOLE) == key("part('b')", "crocodile")
    assert len({key(1), key("part('b')"), key("part('c')"), key("part('b') + part('c')")}) == 4
    made, file = recipe("part('b')", "even", generations=12), tmp_path / "grown.npz"
    run(made, WHOLE, growth=Growth(file))
    longer = recipe("part('b')", "even", generations=20)
    went_on = run(longer, WHOLE, growth=Growth(file)).maps
    same(dict(went_on.features), dict(run(longer, WHOLE).maps.features))
    with pytest.raises(sx.InputError, match="grew on another mesh, on other bodies of it"):
        run(recipe("part('c')", "even", generations=20), WHOLE, growth=Growth(file))
