"""A process that bakes all day holds no more in the evening; `python -m benchmarks.long_run` is the long one."""

import sys

import pytest

from benchmarks.long_run import bakes


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_memory_and_handles_stay_flat_over_many_bakes(tmp_path):
    morning, _, evening = bakes(24, tmp_path)
    assert evening.handles <= morning.handles
    assert evening.threads <= morning.threads
    assert evening.children == morning.children
    assert evening.memory_mb < morning.memory_mb + 25
