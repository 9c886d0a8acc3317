import numpy as np
import pytest

import surftex as sx
from surftex.errors import InputError
from surftex.exemplar.bands import Bands
from surftex.exemplar.metrics import copying, near_distance, pattern_distance
from surftex.randomness import stream
from tests.exemplar.pictures import echo, noise, pebbles


def test_the_planted_offset_is_chosen():
    model = sx.learn_texture(echo(right=7, down=3), order="pair", pairs=6)
    assert [0, 0, 7, 3] in model.target.pair_type.tolist()


def test_noise_teaches_nothing():
    model = sx.learn_texture(noise(160), order="pair")
    assert len(model.target.pair_type) < 8
    drawn = model.synthesize(160, 160, seed=3)
    assert near_distance(drawn, noise(160)) < 1.3 * near_distance(noise(160, seed=9), noise(160))


def test_quads_draw_stones_where_pairs_draw_blotches():
    left, right = pebbles(256)[:, :128], pebbles(256)[:, 128:]
    pattern = {}
    for order in ("pair", "quad"):
        drawn = sx.learn_texture(left, order=order).synthesize(128, 128, seed=2)
        pattern[order] = pattern_distance(drawn, left, 2) / pattern_distance(right, left, 2)
    assert pattern["quad"] < 0.75 * pattern["pair"]  # measured 2.0 and 3.5


def test_nothing_is_copied():
    left, right = pebbles(256)[:, :128], pebbles(256)[:, 128:]
    drawn = sx.learn_texture(left).synthesize(128, 128, seed=2)
    coherence, largest = copying(drawn, left)
    assert coherence < 1.2 * copying(right, left)[0]
    assert largest <= 64
    assert copying(left[10:80, 20:90], left)[0] > 0.99  # the measure sees a copy


def test_threads_cannot_matter():
    picture = pebbles(96)
    model = sx.learn_texture(picture, threads=1)
    assert model.nbytes == sx.learn_texture(picture, threads=3).nbytes
    one, three = (model.synthesize(200, 170, seed=5, sweeps=5, threads=n) for n in (1, 3))
    assert one.tobytes() == three.tobytes()
    assert (one != model.synthesize(200, 170, seed=6, sweeps=5)).any()


def test_the_texture_tiles():
    drawn = sx.learn_texture(pebbles(128)).synthesize(96, 96, seed=1).astype(int)
    step = np.abs(np.diff(np.concatenate([drawn, drawn[:, :1]], axis=1), axis=1)).mean(axis=0)
    assert step[-1] < step[:-1].mean() + 3 * step[:-1].std()


def test_colors_keep_their_company():
    grey = pebbles(128).astype(float)
    color = np.stack([grey, 0.7 * grey + 30, 255 - grey], axis=2).astype(np.uint8)
    drawn = sx.learn_texture(color).synthesize(96, 96, seed=1)
    assert drawn.shape == (96, 96, 3)
    related = np.corrcoef(drawn.reshape(-1, 3).T)
    assert related[0, 1] > 0.95
    assert related[0, 2] < -0.95


def test_height_is_drawn_beside_the_picture():
    grey = pebbles(128)
    model = sx.learn_texture(grey, height=grey / 255, pairs=8)
    maps = model.maps(96, 96, 1)
    assert set(maps) == {"picture", "height"}
    assert np.corrcoef(maps["picture"].ravel(), maps["height"].ravel())[0, 1] > 0.9


def test_a_mask_hides_what_it_hides():
    picture = np.concatenate([pebbles(128), np.full((128, 64), 255, np.uint8)], axis=1)
    mask = np.arange(192)[None] < 128 + np.zeros((128, 1))
    drawn = sx.learn_texture(picture, mask=mask, order="pair", pairs=8).synthesize(96, 96)
    assert (drawn == 255).mean() < 0.01


@pytest.mark.parametrize(
    ("picture", "options", "what"),
    [
        (noise(20), {}, "20 x 20 pixels"),
        (np.full((64, 64), 130, np.uint8), {}, "flat"),
        (np.dstack([noise(64, bands=3), noise(64)]), {}, "partly transparent"),
        (noise(64, bands=5), {}, "5 bands"),
        (noise(64).astype(float), {}, "run 0 to 1"),
        (noise(64), {"mask": np.ones((32, 64))}, "mask has shape"),
        (noise(64), {"mask": np.zeros((64, 64))}, "leaves 0 pixels"),
        (noise(64), {"height": np.ones((32, 64))}, "aligned"),
        (noise(64), {"order": "triple"}, "'quad' or 'pair'"),
        (noise(64), {"pairs": 1}, "2 to 100"),
        (noise(64), {"radius": 0}, "1 to 64"),
        (noise(64), {"spacings": (40,)}, "1 to 16"),
        (np.full((64, 64), np.nan), {}, "not finite"),
        (np.zeros((2, 64, 64, 3), np.uint8), {}, "has shape"),
    ],
)
def test_what_cannot_be_learnt_from_is_told_in_a_line(picture, options, what):
    with pytest.raises(InputError, match=what) as told:
        sx.learn_texture(picture, **options)
    assert "\n" not in str(told.value)


def test_16_bits_are_as_good_as_8():
    picture = noise(64).astype(np.uint16) * 257
    wide, narrow = (sx.learn_texture(each, order="pair", pairs=3) for each in (picture, noise(64)))
    assert (wide.synthesize(32, 32) == narrow.synthesize(32, 32)).all()


def test_sizes_that_make_no_sense_are_refused():
    model = sx.learn_texture(noise(64), order="pair", pairs=3)
    for width, height in ((8, 100), (10**6, 10**6)):
        with pytest.raises(InputError, match="the size is"):
            model.synthesize(width, height)


def test_fours_leave_out_the_tint_that_cannot_be_seen():
    grey = pebbles(64, 6).astype(float)
    tint = 255 * stream(1, "test", "tint").uniform(64 * 64, 2).reshape(64, 64, 2)
    picture = (
        np.stack([grey, grey, grey], axis=-1)
        + 0.2 * tint[..., :1] * [1, -1, 0]
        + 0.01 * tint[..., 1:] * [1, 1, -2]
    )
    model = sx.learn_texture(np.clip(picture, 0, 255).astype(np.uint8), pairs=3, spacings=(1,), radius=4)
    assert model.bands.telling == (0, 1)
    assert set(model.target.quad_band.tolist()) == {0, 1}
    beside = sx.learn_texture(
        np.clip(picture, 0, 255).astype(np.uint8),
        height=grey.astype(np.uint8),
        pairs=3,
        spacings=(1,),
        radius=4,
    )
    assert beside.bands.telling == (0, 1, 3)


@pytest.mark.slow
def test_tints_follow_their_light_along_curves():
    grey = pebbles(128).astype(float)
    bent = 255 * (grey / 255) ** 2
    color = np.stack([grey, 0.5 * grey + 0.5 * bent, bent], axis=2)
    drawn = sx.learn_texture(color.astype(np.uint8), order="pair").synthesize(96, 96, seed=1).astype(float)
    told = 255 * (drawn[..., 0] / 255) ** 2
    assert np.sqrt(((drawn[..., 2] - told) ** 2).mean()) < 4


def test_tints_that_go_their_own_way_are_left_alone():
    grey = pebbles(96).astype(np.float32)
    own = noise(96, seed=3).astype(np.float32)
    picture = np.stack([grey, grey, own], axis=2)
    bands = Bands.learnt(picture, ("red", "green", "blue"), np.ones(grey.shape, bool), 32)
    assert np.ptp(bands.curve, axis=2).max() == 0
    label = np.zeros(grey.shape, np.uint8)
    label[:, 48:] = 1
    picture[:, 48:, 2] = 0.5 * grey[:, 48:] + 40
    bands = Bands.learnt(picture, ("red", "green", "blue"), np.ones(grey.shape, bool), 32, label)
    spread = np.ptp(bands.curve, axis=2).max(axis=1)
    assert spread[0] == 0
    assert spread[1] > 5
    level = bands.levels_of(picture, label)
    back = bands.numbers_of(level + 0.5, label)
    assert np.abs(back - picture)[:, 48:].mean() < 4
