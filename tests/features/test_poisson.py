import numpy as np
import pytest

from surftex.errors import InputError
from surftex.features.darts import GAP, SATURATION, Darts, undisputed
from surftex.features.poisson import Sites, poisson_disk
from surftex.features.uniform import scatter
from surftex.geodesics.directions import DirectionField
from surftex.geodesics.windows import flood_points, within
from surftex.randomness import stream
from surftex.surface.shapes import cylinder, plane, sphere
from surftex.surface.surface import Surface
from tests.oracles.features import one_after_another, regions_hit


def cube(side_mm=20.0):
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) * side_mm
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6],
             [0, 6, 4], [1, 5, 7], [1, 7, 3]]  # fmt: skip
    return Surface.from_arrays(corners, faces)


def norms(surface: Surface, sites: Sites, points):
    """Point, site and elliptic norm of all pairs within the major semi-axis, and a little beyond."""
    records = flood_points(surface, sites.points, sites.axis_mm[:, 0] * 1.01)
    start, site, _, vector = within(records, points)
    cosine, sine = np.cos(sites.angle_rad[site]), np.sin(sites.angle_rad[site])
    x = (cosine * vector[:, 0] + sine * vector[:, 1]) / sites.axis_mm[site, 0]
    y = (cosine * vector[:, 1] - sine * vector[:, 0]) / sites.axis_mm[site, 1]
    return np.repeat(np.arange(len(points)), np.diff(start)), site, np.hypot(x, y)


def assert_full_and_apart(surface: Surface, sites: Sites, probes: int):
    point, _, norm = norms(surface, sites, scatter(surface, stream(9, "probes"), count=probes))
    nearest = np.full(probes, np.inf)
    np.minimum.at(nearest, point, norm)
    assert (nearest >= 1 + GAP).sum() == 0
    later, earlier, norm = norms(surface, sites, sites.points)
    assert norm[earlier < later].min() >= 1 - 1e-9


CASES = {
    "fine mesh": (lambda: sphere(20.0, subdivisions=5), 2.0, 1.0),
    "coarse mesh": (lambda: sphere(20.0, subdivisions=1), 1.0, 1.0),
    "twelve faces": (cube, 1.0, 1.0),
    "twelve faces, ellipses": (cube, 2.0, 2.5),
    "ellipses": (lambda: sphere(20.0, subdivisions=4), 3.0, 5 / 3),
    "borders": (lambda: plane(30.0, cells=20), 1.5, 1.0),
    "narrow tube": (lambda: cylinder(0.6, 40.0), 3.0, 1.5),
}


@pytest.mark.parametrize("case", CASES)
def test_no_gap_is_left_and_no_site_lies_in_an_earlier_region(case):
    make, spacing, ratio = CASES[case]
    surface = make()
    along = DirectionField.smoothest(surface) if ratio > 1 else None
    sites = poisson_disk(surface, spacing, stream(1, case), ratio=ratio, direction=along)
    assert_full_and_apart(surface, sites, 20_000)


@pytest.mark.slow
def test_a_million_points_find_no_gap():
    surface = sphere(40.0, subdivisions=6)
    assert_full_and_apart(surface, poisson_disk(surface, 1.7, stream(2, "million")), 1_000_000)


def test_sizes_may_vary_over_the_surface():
    surface = cube()

    def spacing(points):
        return 0.8 + 1.6 * np.clip(points.positions(surface)[:, 0] / 20, 0, 1)

    sites = poisson_disk(surface, spacing, stream(3, "vary"), ratio=lambda points: np.full(len(points), 1.5))
    assert np.allclose(sites.axis_mm[:, 0], spacing(sites.points))
    assert np.allclose(sites.axis_mm[:, 0] / sites.axis_mm[:, 1], 1.5)
    assert_full_and_apart(surface, sites, 20_000)


def test_the_number_of_sites_is_that_of_random_packing():
    counts = []
    for seed in range(6):
        sheet = plane(60.0, cells=4)
        place = poisson_disk(sheet, 1.0, stream(seed, "packing")).points.positions(sheet)
        counts.append(((place > 5) & (place < 55))[:, :2].all(axis=1).sum() / 2500)
    assert np.mean(counts) == pytest.approx(SATURATION, abs=0.006)


def test_threads_change_nothing():
    surface = sphere(20.0, subdivisions=4)
    one, two = (poisson_disk(surface, 1.0, stream(4, "threads"), threads=threads) for threads in (1, 2))
    assert one.features.tobytes() == two.features.tobytes()


def test_scaling_everything_changes_nothing():
    small, large = (poisson_disk(sphere(s * 10.0), s * 2.0, stream(5, "scale")) for s in (1.0, 8.0))
    assert (small.points.face == large.points.face).all()
    assert np.abs(small.points.barycentric - large.points.barycentric).max() < 1e-9


def spectral_power(place, window, wave):
    """Power of the sites' periodogram at some waves (k, 2), 1 on average for sites at random."""
    return np.abs(np.exp(1j * place @ wave.T).T @ window) ** 2 / (window**2).sum()


def test_the_spectrum_of_elliptic_sites_has_an_elliptic_hole():
    sheet, ratio = plane(40.0, cells=2), 2.0
    angle = np.arange(12) * np.pi / 12
    ellipse = 2 * np.pi * np.stack([np.cos(angle) / np.sqrt(ratio), np.sin(angle) * np.sqrt(ratio)], axis=1)
    nudged = 0.7 + 0.02 * np.arange(-3, 4)
    across, along = (2 * np.pi * np.outer(nudged, axis) for axis in ((0.0, 1.0), (1.0, 0.0)))
    power = {"hole": [], "beyond": [], "across": [], "along": []}
    for seed in range(4):
        sites = poisson_disk(sheet, np.sqrt(ratio), stream(seed, "spectrum"), ratio=ratio,
                             direction=DirectionField.constant(sheet))  # fmt: skip
        place = sites.points.positions(sheet)[:, :2]
        window = np.prod(np.sin(np.pi * place / 40) ** 2, axis=1)
        for name, wave in (
            ("hole", 0.45 * ellipse),
            ("beyond", 1.15 * ellipse),
            ("across", across),
            ("along", along),
        ):
            power[name].append(spectral_power(place, window, wave))
    assert np.mean(power["hole"], axis=0).max() < 0.3  # measured 0.15, with 4 draws at each of 12 angles
    assert np.mean(power["beyond"]) == pytest.approx(0.85, abs=4 * 0.85 / np.sqrt(48))
    # one wave length, inside the hole across the ellipses and outside along them
    assert np.mean(power["along"]) > 3 * np.mean(power["across"])


def test_darts_are_disputed_as_pair_by_pair():
    numbers = stream(6, "disputed").uniform(300, 4)
    position, reach = numbers[:, :3] * 4, 0.2 + 0.6 * numbers[:, 3]
    count = len(numbers)
    darts = Darts(np.arange(count), np.zeros(count, np.int32), np.zeros(count, np.int64), np.zeros((count, 2)),
                  np.stack([reach, reach], axis=1), np.zeros(count), position)  # fmt: skip
    assert (undisputed(darts) == one_after_another(position, reach)).all()


def test_exclusive_regions_are_those_of_the_plane():
    sheet = plane(10.0, cells=3)
    sites = poisson_disk(sheet, 2.0, stream(7, "regions"), ratio=2.0,
                         direction=DirectionField.constant(sheet, np.pi / 4))  # fmt: skip
    some = Sites(sites.points, sites.axis_mm, sites.angle_rad)
    probes = scatter(sheet, stream(8, "regions"), count=4000)
    point, _, norm = norms(sheet, some, probes)
    hit = np.zeros(len(probes), bool)
    hit[point[norm < 1]] = True
    truth = regions_hit(probes.positions(sheet)[:, :2], sites.points.positions(sheet)[:, :2], sites.axis_mm,
                        np.full(len(sites), np.pi / 4))  # fmt: skip
    assert (hit == truth).mean() > 0.9995


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"spacing_mm": 0.0}, "positive"),
        ({"spacing_mm": 1.0, "ratio": 0.5}, "at least 1"),
        ({"spacing_mm": 0.01, "max_sites": 1000}, "max_sites = 1000"),
        ({"spacing_mm": lambda points: np.full(len(points), np.nan)}, "spacing_mm"),
    ],
)
def test_mistakes_are_named(given, words):
    with pytest.raises(InputError, match=words):
        poisson_disk(plane(10.0), given.pop("spacing_mm"), stream(0, "mistakes"), **given)


def test_progress_is_told_and_can_cancel():
    told: list[float] = []
    poisson_disk(plane(10.0), 1.0, stream(1, "tick"), tick=told.append)
    assert told[-1] == 1.0
    assert told == sorted(told)

    def stop(_: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        poisson_disk(plane(10.0), 1.0, stream(1, "tick"), tick=stop)
