"""Walking distance as a field, against the straight lines of a plane of few faces."""

import numpy as np
import pytest

from surftex.features.uniform import area_points
from surftex.fields.distances import distance_field, point_pieces
from surftex.randomness import stream
from surftex.surface.shapes import plane


@pytest.mark.parametrize("limit", [3.0, 60.0])
def test_a_limit_within_three_edges_leaves_nothing_to_guess(limit):
    sheet = plane(200.0, 200.0, cells=8)
    assert 20.0 < sheet.mean_edge_mm < 33.0
    start = area_points(sheet, stream(1, "starts").uniform(5, 3))
    away = distance_field(sheet, point_pieces(sheet, start), limit_mm=limit)
    points = area_points(sheet, stream(2, "places").uniform(4000, 3))
    place, from_mm = points.positions(sheet), start.positions(sheet)
    true = np.minimum(np.linalg.norm(place[:, None] - from_mm, axis=2).min(axis=1), limit)
    value = away(points)
    np.testing.assert_allclose(value, true, atol=1e-9)
    low, high = away.span()
    assert (low[points.face] <= value + 1e-9).all()
    assert (value <= high[points.face] + 1e-9).all()
