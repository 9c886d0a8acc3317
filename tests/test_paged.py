"""Pages in files: the same numbers, room that is taken beforehand, memory that is given back."""

import errno
import os

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
