"""Composites: each label keeps its own texture, layouts lie within layouts, and what lies over them grows."""

import itertools

import numpy as np
import pytest

import surftex as sx
from surftex.errors import InputError
from surftex.exemplar.store import packed, unpacked
from tests.exemplar.pictures import cracks, noise, patches, patchwork

LABEL = patches(160, 9.0)
PICTURE = patchwork(LABEL)


@pytest.fixture(scope="module")
def model():
    return sx.learn_composite(PICTURE, LABEL, pairs=8)


def step(picture, label, which):
    """Mean step between neighbours within a label."""
    inside = (label[:, 1:] == which) & (label[:, :-1] == which)
    return np.abs(np.diff(picture.astype(float), axis=1))[inside].mean()


def test_each_label_keeps_its_texture(model):
    maps = model.maps(128, 128, 1)
    for which in (0, 1):
        here, there = maps["labels"] == which, which == LABEL
        assert maps["picture"][here].mean() == pytest.approx(PICTURE[there].mean(), abs=4)
        assert maps["picture"][here].std() == pytest.approx(PICTURE[there].std(), rel=0.2)
        assert step(maps["picture"], maps["labels"], which) == pytest.approx(
            step(PICTURE, LABEL, which), rel=0.25
        )


def test_a_painted_layout_is_taken(model):
    painted = np.zeros((48, 64), np.uint8)
    painted[:, 32:] = 1
    maps = model.maps(64, 48, 1, labels=painted, sweeps=20)
    assert (maps["labels"] == painted).all()
    assert maps["picture"][:, :32].mean() > maps["picture"][:, 32:].mean() + 50
    with pytest.raises(InputError, match="names label 2; the model has 2"):
        model.maps(64, 48, 1, labels=painted * 2)
    with pytest.raises(InputError, match="64 x 48 pixels, the picture 64 x 64"):
        model.maps(64, 64, 1, labels=painted)


def test_threads_and_files_change_no_byte(model):
    again = sx.learn_composite(PICTURE, LABEL, pairs=8, threads=1)
    assert packed(again) == packed(model)
    one, three = (model.synthesize(70, 50, 3, sweeps=4, threads=n) for n in (1, 3))
    assert one.tobytes() == three.tobytes()
    read = unpacked(packed(model))
    assert packed(unpacked(packed(read))) == packed(read)
    assert read.target.pair_used.tolist() == model.target.pair_used.tolist()


def test_layouts_lie_within_layouts():
    inner = patches(160, 3.0, seed=9)
    leaf = np.where(LABEL == 1, 1 + inner, 0).astype(np.uint8)
    nested = sx.learn_composite(patchwork(leaf), LABEL, within={1: inner}, order="pair", pairs=6)
    assert nested.labels == 3
    label = nested.label_map(128, 128, 2)
    assert set(np.unique(label)) == {0, 1, 2}
    assert (label == 0).mean() == pytest.approx((leaf == 0).mean(), abs=0.1)
    read = unpacked(packed(nested))
    assert read.layout.parts[0] is None
    assert read.layout.parts[1].leaves == 2


def test_what_lies_over_a_composite_grows():
    worn = cracks(160)
    label = np.where(worn == 1, 2, LABEL).astype(np.uint8)
    model = sx.learn_composite(patchwork(label), label, over=True, order="pair", pairs=6)
    ages = [model.label_map(96, 96, 1, age=age) for age in (-1, 0, 2)]
    shares = [(each == 2).mean() for each in ages]
    assert shares[0] < shares[1] < shares[2]
    assert shares[1] == pytest.approx(worn.mean(), abs=0.03)
    for young, old in itertools.pairwise(ages):
        assert (old[young == 2] == 2).all()
        assert (old[old < 2] == young[old < 2]).all()
    assert unpacked(packed(model)).over is not None


@pytest.mark.parametrize(
    ("labels", "options", "what"),
    [
        (patches(96), {}, "they must be aligned"),
        (np.zeros((160, 160), int), {}, "one label only"),
        (np.minimum(LABEL, 1) * 9, {}, "at most 8 labels"),
        (np.where(np.arange(160 * 160).reshape(160, 160) < 100, 2, LABEL), {}, "label 2 has 100 pixels"),
        (LABEL, {"within": {5: LABEL}}, "label 5 is parted"),
        (LABEL, {"within": {1: LABEL}}, "into 1 label"),
        (patches(160, labels=8), {"within": {1: patches(160, 1.0)}}, "at most 8 are drawn together"),
    ],
)
def test_label_maps_that_do_not_fit_are_told_in_a_line(labels, options, what):
    with pytest.raises(InputError, match=what) as told:
        sx.learn_composite(PICTURE, labels, **options)
    assert "\n" not in str(told.value)


def test_a_composite_without_a_cover_has_no_age(model):
    with pytest.raises(InputError, match="no label of this model lies over"):
        model.label_map(64, 64, age=1)


def test_noise_teaches_labels_nothing():
    model = sx.learn_composite(noise(128), patches(128), order="pair")
    assert model.target.pair_used[:2].sum(axis=1).max() < 10


def test_a_picture_is_parted_by_itself():
    found = sx.segment(PICTURE, 2)
    assert ((found == 0) == (LABEL == 1)).mean() > 0.95  # 0 is the darkest
    assert sx.segment(np.repeat(PICTURE[..., None], 3, axis=2), 2).tobytes() == found.tobytes()
    for labels, scale in ((1, 2.0), (9, 2.0), (2, 0.0)):
        with pytest.raises(InputError, match=r"it takes|is parted into"):
            sx.segment(PICTURE, labels, scale=scale)


def test_one_ground_is_enough_for_what_lies_over_it():
    label = cracks(160).astype(np.uint8)
    model = sx.learn_composite(patchwork(label), label, over=True, order="pair", pairs=6)
    assert model.labels == 2
    read = unpacked(packed(model))
    shares = [(read.maps(64, 64, 1, age=age, sweeps=4)["labels"] == 1).mean() for age in (-1, 0, 2)]
    assert 0 <= shares[0] < shares[1] < shares[2] < 1
    with pytest.raises(InputError, match="one label only"):
        sx.learn_composite(patchwork(label), np.zeros_like(label), over=True)
