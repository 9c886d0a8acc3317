"""A growth that is kept: cut off anywhere it goes on to the same bytes, and it knows what it belongs to."""

import signal
import time

import numpy as np
import pytest

from surftex.bake.bake import run
from surftex.bake.growing import Growth
from surftex.errors import InputError
from surftex.features.growth_surface import SurfaceGround
from surftex.files.features import load_features, save_features
from surftex.recipe.model import Recipe
from surftex.surface.shapes import sphere
from tests.test_cli import started, write_obj

LAYER = {"material": "cells", "cell_size": 2.5, "generations": 60, "blob_density": 0.0}
SETTINGS = {"resolution": 32, "maps": ("height",), "unwrapper": "uvunwrap"}


def recipe(seed=3, layers=None, **changes):
    layers = layers or [{**LAYER, **changes}]
    return Recipe.of(Recipe.model_validate({"layer": layers}), seed=seed, **SETTINGS)


@pytest.fixture(scope="module")
def ball():
    return sphere(10.0, subdivisions=3)


@pytest.fixture(scope="module")
def whole(ball):
    return run(recipe(), ball).maps.features


class Cut:
    """Watches, and cuts a bake off at a generation."""

    def __init__(self, generation):
        self.generation, self.counts = generation, []

    def __call__(self, stage, share):
        pass

    def detail(self, stage, text):
        self.counts.append(text)
        if text.endswith(f"generation {self.generation}"):
            raise KeyboardInterrupt


def test_a_growth_that_is_cut_off_goes_on_to_the_same_bytes(ball, whole, tmp_path):
    path = tmp_path / "growth.npz"
    watch = Cut(25)
    with pytest.raises(KeyboardInterrupt, match=f"interrupted in generation 24; .* from {path}"):
        run(recipe(), ball, growth=Growth(path), progress=watch)
    assert len(watch.counts) == 25
    assert " particles, generation 24" in watch.counts[-2]
    assert load_features(path)["particle"]["generation"].max() == 24
    went_on = Cut(-1)
    grown = run(recipe(), ball, growth=Growth(path), progress=went_on).maps.features
    assert went_on.counts[0].endswith("generation 25")
    for kind in ("particle", "cell"):
        np.testing.assert_array_equal(grown[kind], whole[kind])
    np.testing.assert_array_equal(load_features(path)["particle"], whole["particle"])


def test_a_growth_that_is_cut_off_in_the_middle_of_a_move_goes_on_too(ball, whole, tmp_path, monkeypatch):
    path, move, calls = tmp_path / "growth.npz", SurfaceGround.move, []

    def cut(*arguments):
        move(*arguments)
        calls.append(1)
        if len(calls) == 58:  # of a generation without births, whose arrays are those of the one before
            raise KeyboardInterrupt

    monkeypatch.setattr(SurfaceGround, "move", cut)
    with pytest.raises(KeyboardInterrupt, match="interrupted in generation 57"):
        run(recipe(), ball, growth=Growth(path))
    monkeypatch.undo()
    grown = run(recipe(), ball, growth=Growth(path)).maps.features
    np.testing.assert_array_equal(grown["particle"], whole["particle"])


def test_a_finished_growth_grows_older_or_is_carved_anew(ball, whole, tmp_path):
    path = tmp_path / "growth.npz"
    run(recipe(generations=40), ball, growth=Growth(path))
    older = run(recipe(), ball, growth=Growth(path)).maps.features
    np.testing.assert_array_equal(older["cell"], whole["cell"])
    carved = Cut(-1)
    run(recipe(relief=0.3), ball, growth=Growth(path), progress=carved)
    assert not carved.counts


def test_layers_of_growth_are_told_apart(ball, tmp_path):
    path = tmp_path / "growth.npz"
    two = recipe(layers=[LAYER, {"material": "leather", "preset": "calf", "cell_size": 2.0}, LAYER])
    first = run(two, ball, growth=Growth(path)).maps.features
    assert set(load_features(path)) == {"growth", "particle", "layer3_particle"}
    watch = Cut(-1)
    again = run(two, ball, growth=Growth(path), progress=watch).maps.features
    assert not watch.counts
    for kind in first:
        np.testing.assert_array_equal(first[kind], again[kind])


def test_frames_are_seen_at_even_steps_to_the_end(ball):
    growth = Growth(frames=4)
    run(recipe(), ball, growth=growth)
    assert [generation for generation, _ in growth.seen] == [15, 30, 45, 60]
    counts = [len(features["particle"]) for _, features in growth.seen]
    assert counts == sorted(counts)
    assert [features["particle"]["generation"].max() for _, features in growth.seen] == [15, 30, 45, 60]


def test_what_does_not_belong_is_refused_in_a_line(ball, whole, tmp_path):
    path = tmp_path / "growth.npz"
    run(recipe(generations=20), ball, growth=Growth(path))
    with pytest.raises(
        InputError,
        match="grew on another mesh, on other bodies of it, or on a tile of another side; name another",
    ):
        run(recipe(), sphere(11.0, subdivisions=3), growth=Growth(path))
    with pytest.raises(InputError, match="grew with other values of births, cell_size, seed;"):
        run(recipe(seed=4, cell_size=2.0, births=0.04), ball, growth=Growth(path))
    with pytest.raises(InputError, match="20 generations old, beyond the 10 asked for"):
        run(recipe(generations=10), ball, growth=Growth(path))
    save_features(path, whole)
    with pytest.raises(InputError, match="no growth that could go on; --features takes those"):
        run(recipe(), ball, growth=Growth(path))
    path.write_bytes(b"no zip")
    with pytest.raises(InputError, match=r"is no features file.*; a growth is written by --growth"):
        run(recipe(), ball, growth=Growth(path))
    with pytest.raises(InputError, match="no layer grows"):
        run(recipe(layers=[{"preset": "calf"}]), ball, growth=Growth(path))
    with pytest.raises(InputError, match="name of a file in a folder that is there"):
        Growth(tmp_path / "none" / "growth.npz")
    for frames in (-1, 1_000_000):
        with pytest.raises(InputError, match=f"frames is {frames}; it takes 0 to 2000"):
            Growth(frames=frames)


def test_ctrl_c_keeps_the_growth_and_nothing_else(tmp_path):
    write_obj(tmp_path / "ball.obj", sphere(40.0, subdivisions=5))
    options = [
        "--material",
        "cells",
        "--units",
        "mm",
        "--set",
        "cells.cell_size=0.9",
        "--growth",
        "growth.npz",
    ]
    process = started("bake", "ball.obj", *options, "--resolution", "64", "-v", folder=tmp_path)
    said = ""
    while "reading the mesh" not in said:
        line = process.stderr.readline()
        assert line, said
        said += line
    time.sleep(1.5)
    process.send_signal(signal.SIGINT)
    _, rest = process.communicate(timeout=60)
    assert process.returncode == 130
    last = rest.splitlines()[-1]
    if "nothing was written" not in last:  # the growth had begun
        assert last.startswith("surftex: interrupted in generation ")
        assert last.endswith("; the same command goes on from growth.npz")
        assert sorted(path.name for path in tmp_path.iterdir()) == ["ball.obj", "growth.npz"]
        assert load_features(tmp_path / "growth.npz")["particle"]["generation"].max() > 0
