"""Layouts of labels, and how they age."""

import itertools

import numpy as np
import pytest
from scipy.ndimage import binary_dilation, binary_erosion, generate_binary_structure, label

import surftex as sx
from surftex.errors import InputError
from surftex.exemplar.erosion import erosion_series, worn_after
from surftex.exemplar.lattice import Table
from surftex.exemplar.store import packed, unpacked
from tests.exemplar.pictures import cracks, noise, patches

CROSS = generate_binary_structure(2, 1)


@pytest.fixture(scope="module")
def net():
    return cracks()


@pytest.fixture(scope="module")
def drawn(net):
    return sx.learn_labels(net).synthesize(192, 192, seed=2)


def pieces(worn):
    """Pieces of what is sound, for each thousand pixels."""
    return 1000 * label(worn == 0)[1] / worn.size


def test_a_net_of_cracks_is_drawn_as_a_net(net, drawn):
    assert drawn.mean() == pytest.approx(net.mean(), abs=0.02)
    assert pieces(drawn) == pytest.approx(pieces(net), rel=0.6)
    thick = [binary_erosion(each == 1, CROSS, iterations=3).mean() for each in (net, drawn)]
    assert thick[1] < 1.5 * thick[0] + 0.01


def test_three_labels_keep_their_shares():
    exemplar = patches(128, labels=3)
    drawn = sx.learn_labels(exemplar).synthesize(128, 128, seed=1)
    for each in range(3):
        assert (drawn == each).mean() == pytest.approx((exemplar == each).mean(), abs=0.08)
    lonely = np.mean([(drawn == np.roll(drawn, shift, axis)).mean() for axis in (0, 1) for shift in (1, -1)])
    assert lonely > 0.85  # neighbours are mostly alike: blobs and no noise


def test_threads_and_files_change_no_byte(net, drawn):
    model = sx.learn_labels(net)
    assert packed(unpacked(packed(model))) == packed(unpacked(packed(unpacked(packed(model)))))
    again = sx.learn_labels(net).synthesize(192, 192, seed=2, threads=3)
    assert again.tobytes() == drawn.tobytes()
    assert model.nbytes < 4096


def test_ages_are_nested_and_those_of_morphology(drawn):
    worn = drawn == 1
    series = erosion_series(worn, shrink=1, grow=3, wrap=False)
    assert len(series) == 5
    for young, old in itertools.pairwise(series):
        assert (old | ~young).all()
        assert young.sum() < old.sum()
    assert (series[1] == worn).all()
    assert (series[0] == binary_erosion(worn, CROSS, border_value=1)).all()
    for steps in (1, 2, 3):
        assert (series[1 + steps] == binary_dilation(worn, CROSS, iterations=steps)).all()


def test_ages_go_over_the_rim_of_what_tiles():
    worn = np.zeros((9, 9), bool)
    worn[4, 0] = True
    assert erosion_series(worn, shrink=0, grow=1, wrap=True)[1][4, 8]
    assert not erosion_series(worn, shrink=0, grow=1, wrap=False)[1][4, 8]


def test_ages_are_counted_on_any_lattice():
    line = np.column_stack([np.arange(1, 11), np.arange(-1, 9), np.full((10, 2), 10)]).astype(np.int32)
    line[0, 1] = 10
    offset = np.array([(1, 0), (-1, 0), (0, 1), (0, -1)], np.int32)
    chain = Table(offset, np.vstack([line, np.full((1, 4), 10, np.int32)]))
    mask = np.zeros(11, bool)
    mask[:3] = True
    assert worn_after(chain, mask, back=5, on=4).tolist() == [-2, -1, 0, 1, 2, 3, 4, 5, 5, 5]


@pytest.mark.parametrize(
    ("labels", "what"),
    [
        (np.zeros((64, 64), int), "one label only"),
        (noise(64) % 9, "at most 8 labels"),
        (noise(64) / 9, "whole numbers"),
        (noise(20) % 2, "32 x 32 at least"),
        (noise(64, bands=3) % 2, "whole numbers"),
    ],
)
def test_what_is_no_label_map_is_told_in_a_line(labels, what):
    with pytest.raises(InputError, match=what) as told:
        sx.learn_labels(labels)
    assert "\n" not in str(told.value)


def test_ages_that_make_no_sense_are_refused():
    with pytest.raises(InputError, match="shape"):
        erosion_series(np.zeros(3))
    with pytest.raises(InputError, match="0 to 1000 steps"):
        erosion_series(np.zeros((3, 3)), grow=-1)
