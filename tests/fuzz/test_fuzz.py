"""A short run of the hunt: damage to every reader is a line of refusal, or sound. ``python -m tests.fuzz`` is the long one."""

import pytest

from tests.fuzz.hunt import trial
from tests.fuzz.targets import TARGETS

RUNS = 20


@pytest.mark.parametrize("name", TARGETS)
def test_damage_is_refused_or_harmless(name, tmp_path):
    fates = [trial(name, tmp_path, number) for number in range(RUNS)]
    assert set(fates) <= {"taken", "refused"}, sorted(set(fates))
    assert "refused" in fates
