import json

import numpy as np
import pytest

import surftex as sx
from surftex.errors import InputError
from surftex.exemplar.store import as_json, packed, unpacked
from surftex.randomness import stream
from tests.exemplar.pictures import noise, pebbles


@pytest.fixture(scope="module")
def model():
    return sx.learn_texture(pebbles(96))


def test_what_was_written_is_read(model, tmp_path):
    for name in ("stone.stex", "stone.json"):
        model.save(tmp_path / name)
        again = sx.load_model(tmp_path / name)
        for key in ("pair_type", "quad_shape", "quad_band", "quarter", "pair_used"):
            assert (getattr(again.target, key) == getattr(model.target, key)).all(), key
        assert again.target.pair == pytest.approx(model.target.pair, abs=0.003)
        assert again.target.quad == pytest.approx(model.target.quad, abs=0.003)
        assert packed(again) == packed(unpacked(packed(again)))
    assert (tmp_path / "stone.stex").stat().st_size == model.nbytes


def test_a_model_of_pairs_takes_few_bytes():
    assert sx.learn_texture(pebbles(128), order="pair").nbytes <= 4096


def test_names_and_places_that_do_not_fit(model, tmp_path):
    with pytest.raises(InputError, match=r"\.stex or \.json"):
        model.save(tmp_path / "stone.png")
    with pytest.raises(InputError, match="no such texture model"):
        sx.load_model(tmp_path / "none.stex")


def failure(data):
    try:
        unpacked(data)
    except InputError as problem:
        return str(problem)
    return None


def test_damage_is_told_in_a_line(model):
    whole = packed(model)
    random = stream(1, "test", "damage")
    cases = [whole[:cut] for cut in range(0, len(whole), 97)] + [
        b"",
        b"{}",
        b"[1]",
        b'{"data": 3}',
        whole + b"x",
    ]
    for turn in range(200):
        broken = bytearray(whole if turn % 2 else as_json(model).encode())
        for at in (random.uniform(3, first=3 * turn)[:, 0] * len(broken)).astype(int):
            broken[at] = int(255 * random.uniform(1, first=10**6 + at)[0, 0])
        cases.append(bytes(broken))
    told = [message for message in map(failure, cases) if message is not None]
    assert not any("\n" in message for message in told)
    assert len(told) > len(cases) // 2


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"surftex_texture": 9}, "format 9"),
        ({"kind": "spell"}, "damaged"),
        ({"bands": {"names": ["grey"], "low": [5], "high": [1], "axes": [], "levels": 32}}, "ranges"),
        (
            {"bands": {"names": ["infrared"], "low": [0], "high": [1], "axes": [], "levels": 32}},
            "bands called",
        ),
    ],
)
def test_heads_that_lie(change, what):
    head = json.loads(as_json(sx.learn_texture(noise(64), order="pair", pairs=3)))
    with pytest.raises(InputError, match=what):
        unpacked(json.dumps({**head, **change}).encode())


def test_arrays_that_lie_about_their_size():
    head = json.loads(as_json(sx.learn_texture(noise(64), order="pair", pairs=3)))
    head["target"]["pair"]["shape"] = [10**6, 10**6]
    with pytest.raises(InputError, match="cut off"):
        unpacked(json.dumps(head).encode())


def test_bands_keep_colors():
    grey = noise(64).astype(float)
    color = np.stack([grey, 255 * (grey / 255) ** 2, 255 - grey], axis=2).astype(np.uint8)
    model = sx.learn_texture(color, order="pair", pairs=3)
    again = unpacked(packed(model))
    assert again.bands.axes == pytest.approx(model.bands.axes, abs=1e-6)
    assert np.abs(again.bands.low - model.bands.low).max() < 0.001
    assert np.ptp(model.bands.curve) > 1
    assert again.bands.curve == pytest.approx(model.bands.curve, abs=1e-4)


def test_models_without_curves_are_read():
    head = json.loads(as_json(sx.learn_texture(noise(64), order="pair", pairs=3)))
    del head["bands"]["curve"], head["bands"]["step"]
    assert not unpacked(json.dumps(head).encode()).bands.curve.any()
