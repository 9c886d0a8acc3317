"""`surftex learn` and `surftex synthesize`, in this process: files in, files out, one line for each bad picture."""

import json

import numpy as np
import pytest
from PIL import Image

import surftex as sx
from surftex.cli import main
from surftex.exemplar.labels import LabelModel
from tests.exemplar.pictures import cracks, noise, patches, patchwork, pebbles


@pytest.fixture
def stones(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Image.fromarray(pebbles(96)).save("stones.png")
    return tmp_path


def test_a_picture_becomes_a_model_and_a_model_a_picture(stones, capsys):
    assert main(["learn", "stones.png", "-o", "stones.stex", "--pairs", "6", "--json", "-q"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["bytes"] == (stones / "stones.stex").stat().st_size
    assert (report["pairs"], report["quads"]) == (6, 18)
    draw = ["synthesize", "stones.stex", "--size", "48x40", "--seed", "3", "--sweeps", "4", "-q"]
    assert main([*draw, "-o", "a.png", "--compare", "stones.png", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert set(report["metrics"]) == {"near", "pattern1", "pattern2", "gabor", "coherence", "largest_px"}
    assert main([*draw, "-o", "b.png", "--threads", "1"]) == 0
    assert (stones / "a.png").read_bytes() == (stones / "b.png").read_bytes()
    assert np.asarray(Image.open("a.png")).shape == (40, 48)


def test_maps_lie_beside_the_picture(stones):
    Image.fromarray(pebbles(96) // 2).save("height.png")
    assert (
        main(["learn", "stones.png", "--height", "height.png", "--order", "pair", "-o", "s.json", "-q"]) == 0
    )
    assert main(["synthesize", "s.json", "--size", "32x32", "-o", "s.png", "-q"]) == 0
    assert (stones / "s_height.png").is_file()


def test_a_shrunk_picture_is_the_mean_of_squares(stones, capsys):
    assert main(["learn", "stones.png", "--shrink", "2", "--order", "pair", "-o", "s.stex", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["exemplar"] == [48, 48]


def bad_pictures(folder):
    small, flat = Image.fromarray(noise(20)), Image.new("L", (64, 64), 90)
    clear = Image.fromarray(noise(64, bands=4))
    whole = (folder / "stones.png").read_bytes()
    Image.fromarray(noise(64, bands=3)).save(folder / "photo.jpg")
    photo = (folder / "photo.jpg").read_bytes()
    bomb = bytearray(whole)
    bomb[16:24] = (60000).to_bytes(4, "big") * 2
    frame = photo.index(b"\xff\xc0")
    jpeg_bomb = photo[: frame + 5] + b"\xff\xff\xff\xff" + photo[frame + 9 :]
    for name, picture in (("small.png", small), ("flat.png", flat), ("clear.png", clear)):
        picture.save(folder / name)
    Image.new("CMYK", (64, 64), (9, 99, 30, 0)).save(folder / "print.jpg")
    for name, data in (
        ("cut.png", whole[: len(whole) // 2]), ("cut.jpg", photo[: len(photo) // 2]), ("bomb.png", bytes(bomb)),
        ("bomb.jpg", jpeg_bomb), ("head.png", whole[:20]), ("head.jpg", photo[:30]), ("text.png", b"hello"),
        ("bent.png", whole[:60] + bytes(40) + whole[100:]),
    ):  # fmt: skip
        (folder / name).write_bytes(data)
    return {
        "small.png": "20 x 20 pixels", "flat.png": "flat", "clear.png": "partly transparent", "print.jpg": "CMYK",
        "cut.png": "cut off", "cut.jpg": "cut off", "bomb.png": "scale it down", "bomb.jpg": "scale it down",
        "head.png": "cut off", "head.jpg": "cut off", "text.png": "neither PNG nor JPEG", "bent.png": "damaged",
        "none.png": "no such picture", ".": "folder",
    }  # fmt: skip


def test_each_bad_picture_is_told_in_a_line(stones, capsys):
    for name, what in bad_pictures(stones).items():
        assert main(["learn", name, "-o", "x.stex"]) == 2, name
        told = capsys.readouterr().err
        assert what in told
        assert name in told
        assert told.count("\n") == 1
    assert not (stones / "x.stex").exists()


def test_16_bits_are_read(stones):
    Image.fromarray(pebbles(64).astype(np.uint16) * 257).save("deep.png")
    assert main(["learn", "deep.png", "--order", "pair", "-o", "deep.stex", "-q"]) == 0


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (["learn", "stones.png", "-o", "x.png"], ".stex or .json"),
        (["learn", "stones.png", "-o", "nowhere/x.stex"], "no folder"),
        (["learn", "stones.png", "-o", "x.stex", "--shrink", "0"], "1 to 64"),
        (["learn", "stones.png", "-o", "x.stex", "--spacings", "1,b"], "not a whole number"),
        (["synthesize", "stones.png", "-o", "x.png"], "no texture model"),
        (["synthesize", "none.stex", "-o", "x.png"], "no such texture model"),
        (["synthesize", "none.stex", "-o", "x.jpg"], "written as .png"),
    ],
)
def test_what_does_not_fit_is_told_in_a_line(stones, capsys, arguments, what):
    assert main(arguments) == 2
    told = capsys.readouterr().err
    assert what in told
    assert told.count("\n") == 1


def test_a_composite_is_learnt_and_drawn_and_aged(stones, capsys):
    label = np.where(cracks(96, 12) == 1, 2, patches(96)).astype(np.uint8)
    Image.fromarray(patchwork(label)).save("rock.png")
    Image.fromarray(label * 100).save("labels.png")
    learn = ["learn", "rock.png", "--labels", "labels.png", "--over", "--order", "pair", "--pairs", "3"]
    assert main([*learn, "-o", "rock.stex", "--json", "-q"]) == 0
    assert json.loads(capsys.readouterr().out)["labels"] == 3
    draw = ["synthesize", "rock.stex", "--sweeps", "2", "-q", "-o", "a.png"]
    assert main([*draw, "--size", "40x32", "--age", "1"]) == 0
    assert set(np.unique(np.asarray(Image.open("a_labels.png")))) <= {0, 127, 255}
    assert main([*draw, "--labels", "labels.png"]) == 0
    assert np.asarray(Image.open("a.png")).shape == (96, 96)
    assert main([*draw, "--labels", "stones.png"]) == 2
    assert "a label map has at most 8" in capsys.readouterr().err
    assert main([*draw, "--size", "40x32", "--sweeps", "-3"]) == 2
    assert "sweeps is -3" in capsys.readouterr().err
    assert main(["learn", "rock.png", "--labels", "stones.png", "-o", "x.stex"]) == 2
    assert main(["learn", "rock.png", "--labels", "labels.png", "--segment", "2", "-o", "x.stex"]) == 2
    assert main(["erode", "rock.stex", "-o", "age.png", "--size", "32x32", "--grow", "1", "-q"]) == 0
    assert [path.name for path in sorted(stones.glob("age_?.png"))] == ["age_0.png", "age_1.png", "age_2.png"]
    for shrink, grow in (("-4", "3"), ("-2", "3"), ("1", "-3"), ("1", "1001")):
        steps = [f"--shrink={shrink}", f"--grow={grow}", "--size", "32x32"]
        assert main(["erode", "rock.stex", "-o", "never.png", *steps]) == 2
        assert "they take 0 to 1000 steps" in capsys.readouterr().err


def test_a_composite_that_nothing_lies_over_is_not_worn(stones, capsys):
    label = patches(96)
    Image.fromarray(patchwork(label)).save("rock.png")
    Image.fromarray((label * 100).astype(np.uint8)).save("labels.png")
    learn = ["learn", "rock.png", "--labels", "labels.png", "--order", "pair", "--pairs", "3"]
    assert main([*learn, "-o", "rock.stex", "-q"]) == 0
    assert (
        main(["erode", "rock.stex", "-o", "age.png", "--size", "32x32", "--shrink", "0", "--grow", "0"]) == 2
    )
    assert "lies over" in capsys.readouterr().err


def test_masks_and_layouts_are_worn(stones, capsys):
    Image.fromarray(cracks(96, 12) * 255).save("net.png")
    assert main(["learn", "net.png", "--as-labels", "-o", "net.stex", "-q"]) == 0
    for subject in ("net.png", "net.stex"):
        assert main(["erode", subject, "-o", "worn.png", "--size", "48x48", "-q"]) == 0
        shares = [np.asarray(Image.open(f"worn_{k}.png")).mean() for k in range(5)]
        assert shares == sorted(shares)
    assert main(["erode", "stones.png", "-o", "worn.png"]) == 2
    assert "at most 8" in capsys.readouterr().err


def test_pictures_are_filled_and_knitted(stones, capsys):
    hole = np.zeros((96, 96), np.uint8)
    hole[40:60, 30:60] = 255
    Image.fromarray(hole).save("hole.png")
    quick = ["--order", "pair", "--radius", "4", "-q"]
    assert main(["fill", "stones.png", "--mask", "hole.png", "-o", "filled.png", *quick]) == 0
    assert (np.asarray(Image.open("filled.png")) == pebbles(96))[hole == 0].all()
    assert main(["knit", "stones.png", "stones.png", "stones.png", "-o", "long.png", *quick]) == 0
    assert np.asarray(Image.open("long.png")).shape == (96, 288)
    assert main(["knit", "stones.png", "-o", "long.png"]) == 2
    assert main(["fill", "stones.png", "--mask", "none.png", "-o", "x.png"]) == 2
    assert capsys.readouterr().err.count("\n") == 2
    assert main(["fill", "gone.png", "--mask", "hole.png", "-o", "x.png"]) == 2
    assert capsys.readouterr().err.count("gone.png") == 1


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (["--over"], "--over: no use for one texture"),
        (["--within", "0=labels.png"], "--within: no use for one texture"),
        (["--as-labels", "--over", "--pairs", "4"], "--over and --pairs: no use for a layout"),
        (["--labels", "labels.png", "--mask", "labels.png"], "--mask: no use for a composite"),
    ],
)
def test_options_of_another_kind_of_model_are_refused(stones, capsys, arguments, what):
    Image.fromarray((patches(96) * 100).astype(np.uint8)).save("labels.png")
    assert main(["learn", "labels.png", "-o", "x.stex", *arguments]) == 2
    assert what in capsys.readouterr().err
    assert not (stones / "x.stex").exists()


def test_a_layout_is_learnt_where_the_mask_is_white(stones):
    label, mask = np.zeros((96, 96), np.uint8), np.zeros((96, 96), np.uint8)
    label[:, :48], mask[:, 40:] = patches(96)[:, :48] > 0, 255
    label[:, 60:70] = 1
    Image.fromarray(label).save("labels.png")
    Image.fromarray(mask).save("mask.png")
    assert main(["learn", "labels.png", "--as-labels", "--mask", "mask.png", "-o", "x.stex", "-q"]) == 0
    model = sx.load_model("x.stex")
    assert isinstance(model, LabelModel)
    assert model.shares[1] == pytest.approx(label[:, 40:].mean(), abs=0.01)


def test_what_to_compare_with_is_checked_before_anything_is_drawn(stones, capsys, monkeypatch):
    learn = ["learn", "stones.png", "--order", "pair", "--pairs", "3", "-q"]
    assert main([*learn, "-o", "s.stex"]) == 0
    assert main([*learn, "--shrink", "2", "-o", "half.stex"]) == 0
    Image.fromarray(noise(20)).save("small.png")
    Image.new("L", (64, 64), 90).save("flat.png")
    Image.new("L", (2000, 1100), 90).save("large.png")
    Image.fromarray(np.repeat(pebbles(96)[..., None], 3, axis=2)).save("tinted.png")
    draw = ["synthesize", "s.stex", "-o", "a.png", "--sweeps", "2"]
    with monkeypatch.context() as patch:
        patch.setattr("surftex.bake.texturing.drawn_maps", lambda *_, **__: pytest.fail("it was drawn"))
        for name, size, what in (
            ("small.png", "40x40", "small.png: has 20 x 20 pixels"), ("flat.png", "40x40", "flat.png: is flat"),
            ("large.png", "40x40", "large.png: has 2000 x 1100 pixels"), ("none.png", "40x40", "none.png"),
            ("stones.png", "20x40", "the drawing: has 20 x 40 pixels"),
        ):  # fmt: skip
            assert main([*draw, "--compare", name, "--size", size]) == 2
            told = capsys.readouterr().err
            assert what in told
            assert told.count("\n") == 1
    assert not (stones / "a.png").exists()
    assert main([*draw, "--compare", "tinted.png", "--size", "40x40"]) == 0
    assert "tinted.png is in colour, the drawing grey" in capsys.readouterr().err
    half = ["synthesize", "half.stex", "-o", "a.png", "--sweeps", "2", "--size", "40x40"]
    assert main([*half, "--compare", "stones.png"]) == 0
    assert "with --shrink 2 they are more alike" in capsys.readouterr().err
    assert main([*half, "--compare", "stones.png", "--shrink", "2"]) == 0
    assert "warning" not in capsys.readouterr().err
    assert main([*half, "--shrink", "2"]) == 2
    assert "--compare" in capsys.readouterr().err


def test_options_of_learning_are_refused_where_a_model_is_given(stones, capsys):
    assert main(["learn", "stones.png", "--order", "pair", "--pairs", "3", "-o", "s.stex", "-q"]) == 0
    Image.fromarray((patches(96) > 0).astype(np.uint8) * 255).save("hole.png")
    fill = ["fill", "stones.png", "--mask", "hole.png", "-o", "f.png"]
    assert main([*fill, "--model", "s.stex", "--zone", "30", "--order", "pair"]) == 2
    assert "--order and --zone" in capsys.readouterr().err
    assert main([*fill, "--zone", "0"]) == 2
    assert "zone is 0" in capsys.readouterr().err
