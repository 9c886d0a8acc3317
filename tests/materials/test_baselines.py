"""Materials look as an eye approved them: see `tests.materials.baselines`."""

import numpy as np
import pytest
from PIL import Image

from tests.materials import baselines


@pytest.mark.parametrize("name", baselines.PICTURES)
def test_a_material_looks_as_approved(name):
    approved = np.asarray(Image.open(baselines.path(name))).astype(int)
    found = baselines.PICTURES[name]().astype(int)
    assert found.shape == approved.shape
    changed = (np.abs(found - approved) > 2).any(axis=2).mean()
    assert changed < 0.01, (
        f"{changed:.0%} of the texels of {name} changed; `python -m tests.materials.baselines` draws it anew: look at it, "
        "and tell it in CHANGELOG.md under Looks"
    )
