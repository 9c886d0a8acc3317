"""Pages in files: the same numbers, room that is taken beforehand, memory that is given back."""

import errno
import gc
import os
from collections import deque

import numpy as np
import pytest

from surftex import paged
from surftex.errors import WorkError


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    monkeypatch.setattr(paged, "LARGEST_IN_MEMORY", 1 << 12)
    monkeypatch.setattr(paged, "_BLOCK_BYTES", 1 << 14)


def test_a_page_in_a_file_keeps_its_numbers_when_its_memory_is_taken_back(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    large, small = paged.page((128, 96, 3), np.float32), paged.page((8, 8), np.int32)
    assert paged.in_file(large.shape)
    assert not paged.in_file(small.shape)
    assert not large.any()
    numbers = np.arange(large.size, dtype=np.float32).reshape(large.shape)
    for rows in paged.blocks(large):
        large[rows] = numbers[rows]
    paged.let_go(large[3:5].reshape(-1, 3))
    paged.let_go(small)
    np.testing.assert_array_equal(large, numbers)
    assert not list(tmp_path.iterdir())  # the file has no name


def test_blocks_pass_every_row_once_in_even_steps():
    passed = list(paged.blocks(paged.page((129, 96, 3), np.float32)))
    assert [rows.start for rows in passed] == [0, *(rows.stop for rows in passed[:-1])]
    assert passed[-1].stop == 129
    assert all(rows.stop % 2 == 0 for rows in passed[:-1])
    assert len(passed) > 5


@pytest.mark.skipif(not hasattr(os, "posix_fallocate"), reason="room cannot be taken beforehand here")
def test_a_folder_without_room_is_told_in_a_line_before_any_work(monkeypatch):
    def full(*arguments):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(
        WorkError, match=r"no room for 2 MiB of maps: No space left on device; let TMPDIR name"
    ) as caught:
        paged.page((512, 512, 2), np.float32)
    assert "\n" not in str(caught.value)


@pytest.fixture
def kept(monkeypatch):
    gc.collect()  # pages that other tests left in circles
    monkeypatch.setattr(paged, "LARGEST_IN_MEMORY", 1 << 24)
    memory = deque(maxlen=2)
    monkeypatch.setattr(paged, "_KEPT", memory)
    return memory


def place_of(array):
    return array.__array_interface__["data"][0]


needs_memory_to_lend = pytest.mark.skipif(
    not paged._KEEPING, reason="this system takes no memory back lazily"
)


@needs_memory_to_lend
def test_a_page_takes_the_memory_of_one_that_nobody_holds_and_finds_zeros(kept):
    first = paged.page((1024, 512, 3), np.float32)
    first += 7
    row, place = first[3], place_of(first)
    del first
    assert not kept  # a view holds it
    np.testing.assert_array_equal(row, 7)
    other = paged.page((1024, 512, 3), np.float32)
    assert place_of(other) != place
    del row
    assert len(kept) == 1
    again = paged.page((512, 1024, 3), np.int32)
    assert place_of(again) == place
    assert again.dtype == np.int32
    assert not again.any()
    assert not kept
    assert again.flags.writeable
    assert again.flags.c_contiguous


@needs_memory_to_lend
def test_memory_of_other_sizes_is_left_and_no_more_is_kept_than_a_few_pages(kept):
    sides = (512, 768, 1024)
    pages = [paged.page((side, side), np.float32) for side in sides]
    places = [place_of(page) for page in pages]
    while pages:
        del pages[0]
    assert [len(memory) for memory in kept] == [4 * side**2 for side in sides[1:]]
    assert place_of(paged.page((1024, 1024), np.float32)) == places[2]
    assert len(kept) == 2


@needs_memory_to_lend
def test_small_pages_and_very_large_ones_are_not_kept(kept, monkeypatch):
    monkeypatch.setattr(paged, "_KEPT_BYTES", range(1 << 20, 1 << 21))
    for side in (511, 1024):
        paged.page((side, side), np.float32)[0, 0] = 1
    assert not kept
    paged.page((512, 512), np.float32)[0, 0] = 1
    assert len(kept) == 1


@needs_memory_to_lend
def test_no_memory_is_told_as_numpy_tells_it(kept, monkeypatch):
    def full(*arguments, **options):
        raise OSError(errno.ENOMEM, os.strerror(errno.ENOMEM))

    monkeypatch.setattr(paged.mmap, "mmap", full)
    with pytest.raises(MemoryError, match="no room for a page of 4 MiB"):
        paged.page((1024, 1024), np.float32)
