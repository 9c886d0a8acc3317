"""A learnt texture on surfaces: its statistics are those of the model, seams do not show, threads change no byte."""

import numpy as np
import pytest

import surftex as sx
from surftex.bake.bake import run
from surftex.bake.fields import make_fields
from surftex.charts.atlas import Atlas
from surftex.charts.surface_lattice import SurfaceLattice
from surftex.charts.unwrap import unwrap
from surftex.errors import InputError, RecipeError
from surftex.exemplar.lattice import Table
from surftex.exemplar.measure import distance, pair_shares
from surftex.exemplar.relaxation import asked_offsets
from surftex.geodesics.directions import DirectionField
from surftex.materials.composite.drawing import named_model
from surftex.randomness import stream
from surftex.recipe.read import recipe_files, recipe_from_text
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.shapes import sphere, torus
from tests.exemplar.pictures import cracks, patches, patchwork, pebbles

PITCH = 0.5


def cells(place, count):
    """Number of the nearest of some of the places."""
    return np.linalg.norm(place[:, None] - place[:: len(place) // count], axis=2).argmin(axis=1)


@pytest.fixture(scope="module")
def drawn():
    """Gravel on a torus cut into many charts: lattice, table, levels."""
    surface = torus(16.0, 7.0, columns=48, rows=24)
    model = named_model("gravel")
    piece = cells(surface.vertices[surface.faces].mean(axis=1), 40)
    apart = (
        unwrap(surface, resolution=512).corner_uv / 50
        + np.stack([piece % 7, piece // 7], axis=1)[:, None] / 8
    )
    lattice = SurfaceLattice.of(
        surface, DirectionField.smoothest(surface), PITCH, atlas=Atlas.of(surface, apart)
    )
    assert lattice.atlas.chart_count >= 40
    offset = asked_offsets(model.target)
    table = Table(offset, lattice.table(offset, stream(0, "composite", "steps")))
    return model, lattice, table, model.levels_on(table, 0, sweeps=60)


def shares(level, table, site, column):
    """(63,) share of each difference between sites and their neighbours."""
    difference = level[0, table.table[site, column]].astype(int) - level[0, site].astype(int)
    return np.bincount(difference + 31, minlength=63) / len(site)


def test_the_surface_has_the_statistics_of_the_model(drawn):
    model, _, table, level = drawn
    found = pair_shares(table, level, model.target.pair_type)[0]
    assert distance(found, model.target.pair[0]).mean() < 0.012


def test_seams_do_not_show_in_the_pattern(drawn):
    """Pairs that cross a seam differ from the others no more than pairs that cross the border of a random cell."""
    _, lattice, table, level = drawn
    chart = lattice.atlas.chart[lattice.points.face]
    cell = cells(lattice.points.positions(lattice.surface) + 1.3, 37)
    ratio = []
    for step in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (-1, 1)):
        column = int(np.flatnonzero((table.offset == step).all(axis=1))[0])
        there = table.table[:-1, column]
        site = np.flatnonzero(there < len(lattice))
        there = there[site]
        crossing, pretended = chart[site] != chart[there], cell[site] != cell[there]
        seam, border, inside = (
            site[some] for some in (crossing, ~crossing & pretended, ~crossing & ~pretended)
        )
        assert min(len(seam), len(border)) > 400
        count = min(len(seam), len(border))
        seam, border = (
            seam[np.arange(count) * len(seam) // count],
            border[np.arange(count) * len(border) // count],
        )
        known = shares(level, table, inside, column)
        ratio.append([distance(shares(level, table, some, column), known) for some in (seam, border)])
    seam, border = np.mean(ratio, axis=0)
    assert seam < 1.3 * border  # measured 1.00; the same texture tiled by UV: 2.7


@pytest.fixture(scope="module")
def ball():
    return sphere(12.0, subdivisions=3)


GRAVEL = {"pixel_size": 0.6, "sweeps": 8}


def test_threads_and_unwraps_change_no_byte(ball):
    gravel = sx.Composite.preset("gravel", **GRAVEL)
    one = sx.bake(ball, gravel, resolution=128, seed=3, threads=1, unwrapper="uvunwrap")
    two = sx.bake(ball, gravel, resolution=128, seed=3, threads=2, unwrapper="uvunwrap")
    for name in one:
        assert one[name].tobytes() == two[name].tobytes(), name
    other = sx.bake(ball, gravel, resolution=64, seed=3, unwrapper="xatlas")
    assert one.features["pixel"].tobytes() == other.features["pixel"].tobytes()
    assert (
        one.features["pixel"].tobytes()
        != sx.bake(ball, gravel, resolution=32, seed=4).features["pixel"].tobytes()
    )


def test_a_bake_from_features_gives_the_same_bytes(ball):
    gravel = sx.Composite.preset("gravel", **GRAVEL)
    one = sx.bake(ball, gravel, resolution=64)
    two = sx.bake(ball, gravel, resolution=64, features=dict(one.features))
    for name in one:
        assert one[name].tobytes() == two[name].tobytes(), name
    with pytest.raises(RecipeError, match="no pixels of this texture"):
        sx.bake(sphere(11.0, subdivisions=3), gravel, resolution=64, features=dict(one.features))


def test_coarse_samples_read_the_mean(ball):
    pattern = sx.Composite.preset("gravel", **GRAVEL).place(ball, 1)
    points = SurfaceLattice.of(ball, DirectionField.smoothest(ball), 1.0).points
    fine, coarse = (
        pattern.at(Samples(points, np.full(len(points), width, np.float32)))["base_color"]
        for width in (0.1, 5.0)
    )
    assert coarse.mean() == pytest.approx(fine.mean(), rel=0.03)
    assert coarse.std() < 0.3 * fine.std()


def test_the_height_that_was_learnt_is_the_relief(ball, tmp_path):
    stones = pebbles(96)
    sx.learn_texture(stones, height=stones, roughness=255 - stones, order="pair", pairs=6).save(
        tmp_path / "s.stex"
    )
    stone = sx.Composite(model=str(tmp_path / "s.stex"), relief="0.5 mm", pixel_size=0.6, sweeps=20)
    maps = sx.bake(ball, stone, resolution=128)
    assert maps["height"].min() == pytest.approx(-0.25, abs=0.02)
    assert maps["height"].max() == pytest.approx(0.25, abs=0.02)
    tone = maps["base_color"].mean(axis=2)
    assert np.corrcoef(tone.ravel(), maps["height"].ravel())[0, 1] > 0.8
    assert np.corrcoef(tone.ravel(), maps["roughness"].ravel())[0, 1] < -0.4


RECIPE = 'surftex = 1\n[[layer]]\nmaterial = "composite"\nmodel = "{}"\npixel_size = "1.5 mm"\nsweeps = 2\n'


def test_a_recipe_names_the_model_by_its_file(ball, tmp_path):
    inner = tmp_path / "inner"
    inner.mkdir()
    for folder in (tmp_path, inner):
        named_model("gravel").save(folder / "stone.stex")
    recipe = recipe_from_text(RECIPE.format("stone.stex"), folder=inner)
    assert recipe_files(recipe) == [inner / "stone.stex"]
    assert len(run(recipe, ball).maps.features["pixel"]) > 500
    assert recipe_files(recipe_from_text(RECIPE.format("gravel"), folder=inner)) == []
    with pytest.raises(RecipeError, match=r"recipe:4: layer\.0\.model.*--allow-outside"):
        recipe_from_text(RECIPE.format("../stone.stex"), folder=inner)
    outside = recipe_from_text(RECIPE.format("../stone.stex"), folder=inner, allow_outside=True)
    assert recipe_files(outside) == [tmp_path / "stone.stex"]


@pytest.mark.parametrize(
    ("options", "what"),
    [
        ({"model": "none.stex"}, "no such texture model"),
        ({"model": "granit"}, "on the shelf, which holds gingham, gravel"),
        ({"model": "gravel", "pixel_size": 1e-3}, "raise pixel_size"),
        ({"model": "gravel", "direction": "grain"}, "grain"),
    ],
)
def test_what_cannot_be_drawn_is_told_in_a_line(ball, options, what):
    with pytest.raises(InputError, match=what) as told:
        sx.bake(ball, sx.Composite(**options), resolution=64)
    assert "\n" not in str(told.value)


@pytest.fixture(scope="module")
def rock(tmp_path_factory):
    """Light and dark patches with cracks over them, as a model file."""
    label = np.where(cracks(128, 16) == 1, 2, patches(128)).astype(np.uint8)
    model = sx.learn_composite(patchwork(label), label, over=True, order="pair", pairs=2, radius=4)
    path = tmp_path_factory.mktemp("rock") / "rock.stex"
    model.save(path)
    return str(path), (label == 2).mean()


def regions(surface, path, threads=None, **options):
    """Labels of the pixels, and the height of each over the middle of the surface."""
    fields = sx.Recipe.model_validate(
        {"fields": {"low": {"gradient": [0, 0, -1]}}, "layer": [{"material": "leather"}]}
    )
    rock = sx.Composite(model=path, pixel_size=0.5, sweeps=4, **options)
    pattern = rock.place(surface, 3, fields=make_fields(fields, surface), threads=threads)
    points = SurfacePoints(pattern.features["pixel"]["face"], pattern.features["pixel"]["barycentric"])
    return pattern, pattern.features["pixel"]["label"], points.positions(surface)[:, 2]


def test_a_layout_is_drawn_on_the_surface(ball, rock):
    pattern, label, _ = regions(ball, rock[0])
    assert set(np.unique(label)) == {0, 1, 2}
    assert (label == 2).mean() == pytest.approx(rock[1], abs=0.06)
    again, _, _ = regions(ball, rock[0], threads=1)
    assert again.features["pixel"].tobytes() == pattern.features["pixel"].tobytes()
    points = SurfacePoints(pattern.features["pixel"]["face"], pattern.features["pixel"]["barycentric"])
    answer = pattern.at(Samples(points, np.full(len(points), 0.1, np.float32)))
    assert (answer["region"] == label).mean() > 0.999
    tone = [answer["base_color"][label == each].mean() for each in range(3)]
    assert tone == sorted(tone, reverse=True)


def test_masks_choose_the_labels_and_ages_grow_where_they_say(ball, rock):
    _, young, height = regions(ball, rock[0], labels=("low > 0.5",))
    assert (young[(height > 1) & (young < 2)] == 0).all()
    assert (young[(height < -1) & (young < 2)] == 1).all()
    _, old, _ = regions(ball, rock[0], labels=("low > 0.5",), age="2 * low")
    assert (old[young == 2] == 2).all()
    grown = (old == 2) & (young != 2)
    assert grown[height < -6].mean() > 3 * grown[height > 6].mean()
    _, less, _ = regions(ball, rock[0], labels=("low > 0.5",), age=-0.5)
    assert (young[less == 2] == 2).all()
    assert (less == 2).sum() < (young == 2).sum()


@pytest.mark.parametrize(
    ("options", "what"),
    [
        ({"labels": ("low", "low", "low")}, "labels has 3 masks; the model has 2 labels"),
        ({"labels": ("lowly",)}, "lowly"),
        ({"model": "gravel", "age": 1.0}, "labels and age are for composites"),
    ],
)
def test_labels_that_do_not_fit_are_told_in_a_line(ball, rock, options, what):
    with pytest.raises(RecipeError, match=what) as told:
        regions(ball, options.pop("model", rock[0]), **options)
    assert "\n" not in str(told.value)


def test_a_layout_alone_is_no_material(ball, tmp_path):
    sx.learn_labels(cracks(96, 12)).save(tmp_path / "net.stex")
    with pytest.raises(InputError, match="a layout without textures"):
        sx.bake(ball, sx.Composite(model=str(tmp_path / "net.stex")), resolution=64)
