"""`surftex learn` and `surftex synthesize`, in this process: files in, files out, one line for each bad picture."""

import json

import numpy as np
import pytest
from PIL import Image

from surftex.cli import main
from tests.exemplar.pictures import noise, pebbles


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
