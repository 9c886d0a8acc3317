import numpy as np
import pytest
from scipy.stats import chisquare

from surftex.errors import InputError
from surftex.features.uniform import scatter
from surftex.randomness import stream
from surftex.surface.shapes import cylinder, plane, sphere


def test_points_are_uniform_by_area():
    ball = sphere(radius_mm=10.0, subdivisions=2)
    points = scatter(ball, stream(1, "uniform"), count=200_000)
    hits = np.bincount(points.face, minlength=len(ball.faces))
    assert chisquare(hits, 200_000 * ball.face_area_mm2 / ball.area_mm2).pvalue > 1e-4


def test_points_are_uniform_inside_a_face():
    points = scatter(plane(1.0, cells=1), stream(2, "uniform"), count=100_000)
    for corner in range(3):
        inside = np.bincount((points.barycentric[:, corner] * 10).astype(int), minlength=10)
        share = np.diff(1 - (1 - np.linspace(0, 1, 11)) ** 2)
        assert chisquare(inside, 100_000 * share).pvalue > 1e-4
    assert points.barycentric.min() >= 0
    assert np.abs(points.barycentric.sum(axis=1) - 1).max() < 1e-12


def test_a_poisson_process_has_the_mean_and_the_variance_of_its_law():
    sheet = plane(10.0, cells=2)
    counts = np.array([len(scatter(sheet, stream(i, "law"), density_per_mm2=0.4)) for i in range(2000)])
    assert counts.mean() == pytest.approx(40, abs=4 * np.sqrt(40 / 2000))
    assert counts.var() == pytest.approx(40, rel=4 * np.sqrt(2 / 2000))


def test_more_density_only_adds_points():
    ball = sphere(subdivisions=2)
    few = scatter(ball, stream(3, "prefix"), density_per_mm2=0.1)
    many = scatter(ball, stream(3, "prefix"), density_per_mm2=0.5)
    assert len(few) < len(many)
    assert (many.face[: len(few)] == few.face).all()
    assert (many.barycentric[: len(few)] == few.barycentric).all()


def test_a_weight_thins_and_moves_nothing():
    tube = cylinder()

    def weight(points):
        return np.clip(points.positions(tube)[:, 2] / 60, 0, 1)

    plain = scatter(tube, stream(4, "thin"), density_per_mm2=1.0)
    thinned = scatter(tube, stream(4, "thin"), density_per_mm2=1.0, weight=weight)
    rows = {tuple(row) for row in plain.barycentric}
    assert all(tuple(row) in rows for row in thinned.barycentric)
    assert len(thinned) / len(plain) == pytest.approx(0.5, abs=0.03)
    height = thinned.positions(tube)[:, 2] / 60
    assert height.mean() == pytest.approx(2 / 3, abs=4 * np.sqrt(1 / 18 / len(thinned)))


def test_a_weight_per_face_keeps_to_its_faces_and_its_density():
    ball = sphere(subdivisions=3)
    weight = (ball.vertices[ball.faces][:, :, 2].mean(axis=1) > 0) * 0.5
    points = scatter(ball, stream(5, "faces"), density_per_mm2=2.0, weight=weight)
    assert (weight[points.face] > 0).all()
    expected = 2.0 * float((weight * ball.face_area_mm2).sum())
    assert len(points) == pytest.approx(expected, abs=4 * np.sqrt(expected))


def test_a_count_is_met_under_a_weight():
    sheet = plane(10.0)
    points = scatter(sheet, stream(6, "count"), count=1234, weight=lambda p: np.full(len(p), 0.2))
    assert len(points) == 1234


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "not both"),
        ({"count": 3, "density_per_mm2": 1.0}, "not both"),
        ({"count": -1}, "at least 0"),
        ({"density_per_mm2": np.nan}, "at least 0"),
        ({"count": 5, "weight": lambda p: np.full(len(p), 2.0)}, r"leaves 0\.\.1"),
        ({"count": 5, "weight": lambda p: np.zeros(len(p))}, "too few"),
        ({"count": 5, "weight": np.zeros(512)}, "0 on every face"),
    ],
)
def test_mistakes_are_named(given, words):
    with pytest.raises(InputError, match=words):
        scatter(plane(10.0), stream(7, "mistakes"), **given)


def stretched(cells=16, side=40.0):
    """A sheet whose unwrap gives its left half ten times the room per mm of its right half."""
    from surftex.surface.surface import Surface

    sheet = plane(side, cells=cells)
    x = sheet.vertices[sheet.faces][..., 0] / side
    uv = sheet.corner_uv.copy()
    uv[..., 0] = np.where(x < 0.5, x * 2 * 10 / 11, 10 / 11 + (x - 0.5) * 2 / 11)
    return Surface.from_arrays(sheet.vertices, sheet.faces, corner_uv=uv)


def test_density_follows_the_area_whatever_the_unwrap_stretches():
    from surftex.fields.fieldset import FieldSet
    from surftex.fields.sources import image_field

    surface = stretched()
    columns = (np.arange(440) + 0.5) / 440
    grey = np.tile(np.where(columns < 10 / 11, 0.5 + 0.4 * np.sin(columns * 40), 0.5), (64, 1))
    fields = FieldSet(surface, {"likely": image_field(surface, grey)})
    points = scatter(surface, stream(8, "stretch"), density_per_mm2=fields.scalar("20 * likely"))
    place = points.positions(surface)
    # two strips, 20 mm by 4 mm each, over which the picture has the same mean on the surface
    for low, high in ((0.0, 20.0), (20.0, 40.0)):
        x = np.linspace(low, high, 20_001)
        u = np.where(x < 20, x / 20 * 10 / 11, 10 / 11 + (x - 20) / 20 / 11)
        expected = 20 * np.interp(u, columns, grey[0]).mean() * 20 * 40
        found = ((place[:, 0] >= low) & (place[:, 0] < high)).sum()
        assert found == pytest.approx(expected, abs=4 * np.sqrt(expected))
    flat = scatter(surface, stream(9, "stretch"), density_per_mm2=5.0).positions(surface)
    cells = np.histogram2d(flat[:, 0], flat[:, 1], bins=8, range=[[0, 40], [0, 40]])[0].ravel()
    assert chisquare(cells).pvalue > 1e-4


def test_a_power_gathers_points_where_a_field_is_high():
    from surftex.fields.sources import gradient_field

    sheet = plane(10.0, cells=4)
    field = gradient_field(sheet, [1, 0, 0])
    for power in (0.5, 1.0, 4.0):
        points = scatter(sheet, stream(10, "power"), count=20_000, weight=field, power=power)
        mean = points.positions(sheet)[:, 0].mean() / 10
        assert mean == pytest.approx((power + 1) / (power + 2), abs=0.01)


def test_a_narrow_field_is_met_and_a_wide_one_moves_nothing():
    from surftex.fields.sources import SpannedField, gradient_field

    sheet = plane(10.0, cells=200)
    narrow = gradient_field(sheet, [1, 0, 0], 9.9, 10.0)
    points = scatter(sheet, stream(11, "narrow"), count=500, weight=narrow)
    assert (points.positions(sheet)[:, 0] > 9.9).all()
    assert points.positions(sheet)[:, 0].mean() == pytest.approx(9.9 + 0.2 / 3, abs=0.005)
    wide = gradient_field(sheet, [1, 0, 0])
    plain = scatter(sheet, stream(12, "wide"), density_per_mm2=3.0)
    thinned = scatter(
        sheet,
        stream(12, "wide"),
        density_per_mm2=SpannedField(
            lambda p, f=0.0: 3 * wide(p), lambda: tuple(3 * end for end in wide.span())
        ),
    )
    assert {tuple(row) for row in thinned.barycentric} < {tuple(row) for row in plain.barycentric}


def test_a_field_that_breaks_its_span_or_has_none_is_refused():
    from surftex.fields.fieldset import FieldSet
    from surftex.fields.sources import SpannedField, gradient_field

    sheet = plane(10.0)
    ones = np.ones(len(sheet.faces))
    liar = SpannedField(lambda p, f=0.0: np.full(len(p), 2.0), lambda: (0 * ones, ones))
    with pytest.raises(InputError, match="of its span"):
        scatter(sheet, stream(13, "span"), density_per_mm2=liar)
    fields = FieldSet(sheet, {"up": gradient_field(sheet, [1, 0, 0])})
    with pytest.raises(InputError, match=r"no upper bound on .* of 512 faces"):
        scatter(sheet, stream(13, "span"), density_per_mm2=fields.scalar("1 / up"))
    with pytest.raises(InputError, match="without a span"):
        scatter(sheet, stream(13, "span"), density_per_mm2=lambda p: np.ones(len(p)))
