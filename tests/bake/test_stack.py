from dataclasses import dataclass, field

import numpy as np
import pytest

from surftex.bake.stack import Stack, laid_over
from surftex.materials.layers import Layers
from surftex.surface.points import Samples, SurfacePoints


@dataclass
class Face:
    """A pattern whose height and region are the number of the face, which counts what it is asked."""

    add: float
    asked: list = field(default_factory=list)
    channels = ("height_mm", "base_color", "region")

    def at(self, samples):
        face = samples.points.face
        self.asked.append(len(face))
        height = (face + self.add).astype(np.float32)
        return Layers(
            {"height_mm": height, "base_color": np.repeat(height[:, None], 3, axis=1), "region": face + 1},
            {"height_mm": face % 3 == 0},
        )


def samples(count=300):
    face = np.arange(count, dtype=np.int32) % 50
    return Samples(SurfacePoints(face, np.tile([0.2, 0.3, 0.5], (count, 1))), np.ones(count, np.float32))


def quarter(points, footprint):
    return np.where(points.face < 10, 0.25 * (points.face % 5), 0.0)


def test_a_layer_is_asked_only_where_it_covers():
    below, above, unseen = Face(0.5), Face(7.0), Face(1.0)
    stack = Stack((below, above, unseen), (None, quarter, lambda points, _: np.zeros(len(points))))
    some, told = samples(), []
    found = stack.at(some, ("height_mm", "base_color", "region"), told=told.append)
    cover = quarter(some.points, None).astype(np.float32)
    assert (below.asked, above.asked, unseen.asked) == ([300], [np.count_nonzero(cover)], [])
    for channel in found:
        every = [pattern.at(some)[channel] for pattern in (below, above)]
        assert found[channel] == pytest.approx(laid_over(every[0], every[1], cover))
        assert found[channel].dtype == every[0].dtype
    assert (told[1]["height_mm"] == ((some.points.face % 3 == 0) & (cover > 0))).all()
