"""Height and finish of leather from distances: the kernel against its slow twin."""

from typing import Any

import numpy as np
import pytest

from surftex.kernels.leather import BLOCK
from surftex.materials.grooves import Line
from surftex.materials.leather.cells import Plates
from surftex.materials.leather.model import Leather
from surftex.materials.leather.relief import Skeleton, layers
from tests.oracles import leather as oracle

LEATHERS = {
    "plain": Leather(),
    "all": Leather(
        variation=0.7, sulcus_variation=0.6, crista_exponent=3.5, scale_overlap=0.4, wrinkle_fold=0.5, crown_height=0.3,
        crown_width=0.8, crown_pit_depth=0.2, crown_pit_width=0.2, pocket_depth=0.2, pocket_width=0.5, pore_depth=0.1,
        pore_width=0.1, grain_height=0.02, wear=0.6, mottle=0.2, cell_tone=0.2, dye=0.8, pore_dye=0.7,
    ),
    "polished": Leather(crista_exponent=2.0, roughness=0.05, crest_roughness=0.0),
    "ostrich": Leather.preset("ostrich"),
    "lizard": Leather.preset("lizard"),
}  # fmt: skip


def distances(random, n, reach):
    """Some of them 0, some of them inf."""
    found = reach * random.random(n)
    found[::7], found[1::7] = np.inf, 0
    return found.astype(np.float32)


def lines(random, n):
    at = np.flatnonzero(random.random(n) < 0.4)
    part = [random.random(len(at)).astype(np.float32) for _ in range(5)]
    own = random.random(len(at)) < 0.3
    return Line(
        at,
        part[0],
        part[1],
        part[2],
        random.random(len(at)) < 0.5,
        np.where(own, part[3], np.float32(0)),
        np.where(own, part[4], np.float32(0)),
    )


def skeleton(seed, n, bare):
    random = np.random.default_rng(seed)
    share = [random.random(n).astype(np.float32) for _ in range(6)]
    noise = [(2 * random.random(n) - 1).astype(np.float32) for _ in range(3)]
    plates = Plates(
        np.arange(n, dtype=np.int32), 1.2 * share[0], distances(random, n, 1.0), share[1], share[2], noise[0]
    )
    elements: dict[str, Any] = {
        "cracks": (lines(random, n),),
        "wrinkles": (lines(random, n), lines(random, n)),
        "pocket_mm": distances(random, n, 1.0),
        "pore_mm": distances(random, n, 0.3),
        "crown_mm": distances(random, n, 2.0),
        "crown_scale": 0.5 + share[3],
    }
    if bare:
        elements = {name: () if name.endswith("s") else None for name in elements}
    return Skeleton(
        plates=plates, cell_mm=0.5 + share[3], level=share[4], tone=share[5], grain=noise[1], mottle=noise[2], **elements
    )  # fmt: skip


@pytest.mark.parametrize("bare", [True, False], ids=["cells alone", "all elements"])
@pytest.mark.parametrize("footprint", [0.0, 0.01, 0.4, 3.0])
@pytest.mark.parametrize("name", LEATHERS)
def test_layers_are_those_of_the_slow_twin(name, footprint, bare):
    n = 3 * BLOCK + 17
    found = skeleton(1, n, bare)
    patch = np.full(n, footprint, np.float32) * np.linspace(0.8, 1.2, n, dtype=np.float32)
    told, expected = layers(LEATHERS[name], found, patch), oracle.layers(LEATHERS[name], found, patch)
    assert told.channels.keys() == expected.keys()
    for channel, numbers in expected.items():
        assert told[channel].dtype == (np.int32 if channel == "region" else np.float32)
        np.testing.assert_allclose(told[channel], numbers, atol=2e-6, err_msg=channel)


def test_samples_do_not_depend_on_their_neighbours():
    found = skeleton(2, 300, bare=True)
    patch = np.full(300, 0.02, np.float32)
    whole = layers(LEATHERS["all"], found, patch)["height_mm"]
    tail = Skeleton(
        plates=Plates(*(getattr(found.plates, name)[250:] for name in Plates.__dataclass_fields__)),
        **{name: getattr(found, name)[250:] for name in ("cell_mm", "level", "tone", "grain", "mottle")},
        cracks=(), wrinkles=(), pocket_mm=None, pore_mm=None, crown_mm=None, crown_scale=None,
    )  # fmt: skip
    np.testing.assert_array_equal(layers(LEATHERS["all"], tail, patch[250:])["height_mm"], whole[250:])
