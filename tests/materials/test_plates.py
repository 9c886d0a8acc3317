"""The plates of a leather: the kernel against the formulas, and the formulas against the plane."""

from typing import Any

import numba
import numpy as np
import pytest
from scipy.spatial import Voronoi, cKDTree

from surftex.arrays import frozen
from surftex.features.uniform import area_points
from surftex.kernels.exponential import exponential, logarithm_of_sum
from surftex.kernels.jit import kernel
from surftex.kernels.plates import BLOCK, MOST, PAIRS, ROWS, plates
from surftex.materials.leather.cells import _both_ways
from surftex.materials.leather.model import Leather
from surftex.randomness import stream
from surftex.surface.shapes import sphere
from tests.oracles.leather import pairs_both_ways, plate

SITES = 140


def plane_sites(seed):
    rng = np.random.default_rng(seed)
    places = []
    while len(places) < SITES:
        dart = rng.uniform(0, 10, 2)
        if not places or np.min(np.hypot(*(np.array(places) - dart).T)) > 0.55:
            places.append(dart)
    return np.array(places)


def run(places, samples, *, k=5, exponent=6.0, rounding=0.0, wave=0.0, blend=0.0, seed=0, compare=False):
    rng = np.random.default_rng(seed)
    distance, site = cKDTree(places).query(samples, k=k)
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    start = np.arange(len(places) + 1, dtype=np.int64) * len(places)
    other = np.tile(np.arange(len(places), dtype=np.int32), len(places))
    shift = frozen(rng.normal(size=(len(places), 2)))
    waves = [frozen((wave * rng.normal(size=len(samples))).astype(np.float32)) for _ in range(2)]
    n = len(samples)
    own, ratio, border = np.zeros(n, np.int32), np.zeros(n, np.float32), np.zeros(n, np.float32)
    own_mm, furrow = np.zeros(n, np.float32), np.zeros(n, np.float32)
    key = stream(3, "borders").key
    plates(site.astype(np.int32), distance, frozen(start), frozen(other), frozen(apart.ravel()),
           frozen(np.column_stack([places, np.zeros(len(places))])), shift, *waves, int(np.isinf(exponent)),
           rounding, np.uint64(key), blend, np.zeros(ROWS * BLOCK), np.zeros(MOST * BLOCK, np.int64),
           np.full(PAIRS, -1), np.zeros(PAIRS), own, ratio, border, own_mm, furrow)  # fmt: skip
    twin = [] if not compare else [
        plate(site[i], distance[i], apart, shift, np.array([waves[0][i], waves[1][i]], float), exponent, rounding, key,
              blend or 1.0)
        for i in range(n)
    ]  # fmt: skip
    return (own, ratio, border, own_mm, furrow), twin


@pytest.mark.parametrize(
    ("exponent", "rounding", "wave", "blend"),
    [(6.0, 0.0, 0.0, 0.0), (np.inf, 0.0, 0.0, 0.0), (6.0, 0.08, 0.0, 0.1), (6.0, 0.05, 0.02, 0.15)],
)
def test_kernel_reads_as_the_formulas(exponent, rounding, wave, blend):
    samples = np.random.default_rng(1).uniform(1, 9, (300, 2))
    found, twin = run(
        plane_sites(2), samples, exponent=exponent, rounding=rounding, wave=wave, blend=blend, compare=True
    )
    wanted = [np.array(column) for column in zip(*twin, strict=True)]
    assert np.array_equal(found[0], wanted[0])
    for have, want in zip(found[1:4], wanted[1:4], strict=True):
        assert np.allclose(have, want, atol=2e-6)
    if blend:
        assert np.allclose(found[4], wanted[4], atol=2e-6)
    else:
        assert (found[4] == 0.5).all()


def test_one_pass_finds_and_locates_as_two_do():
    ball = sphere(10.0, subdivisions=3)
    leather = Leather.preset("calf", cell_size=2.0, waviness=0.1, wrinkle_density=0.0)
    cells = leather.place(ball, 1).cells
    points = area_points(ball, stream(1, "samples").uniform(3000, 3))
    wave = [frozen(stream(2, name).uniform(3000)[:, 0].astype(np.float32) - 0.5) for name in "ab"]
    one = cells.at(leather, points, (wave[0], wave[1]))
    two = cells.at(leather.model_copy(update={"scale_overlap": 0.1}), points, (wave[0], wave[1]))
    for name in ("own", "ratio", "border_mm", "own_mm", "furrow"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert one.own.min() >= 0


def test_what_kernels_call_counts_no_references_to_arrays():
    run(plane_sites(2), np.full((2, 2), 5.0))
    known: Any = plates
    anew = numba.njit(error_model="numpy", nogil=True)(known.py_func)  # cached code cannot be looked at
    anew.compile(known.signatures[0])
    (code,) = anew.inspect_llvm().values()
    assert "call void @NRT_incref" not in code


def test_border_distance_is_that_to_the_voronoi_edges():
    places = plane_sites(4)
    samples = np.random.default_rng(5).uniform(2, 8, (2000, 2))
    found, _ = run(places, samples)
    diagram = Voronoi(places)
    ends = np.array([diagram.vertices[ridge] for ridge in diagram.ridge_vertices if -1 not in ridge])
    a, b = ends[:, 0], ends[:, 1]
    span = b - a
    t = np.clip(((samples[:, None] - a) * span).sum(-1) / (span**2).sum(-1), 0, 1)
    truth = np.linalg.norm(samples[:, None] - (a + t[..., None] * span), axis=-1).min(axis=1)
    assert np.quantile(np.abs(found[2] - truth), 0.998) < 1e-6


def test_ratio_runs_from_the_site_to_the_border():
    places = plane_sites(6)
    inside = places[(np.abs(places - 5) < 3).all(axis=1)]
    at_sites, _ = run(places, inside)
    assert at_sites[1].max() < 0.2
    samples = np.random.default_rng(7).uniform(2, 8, (4000, 2))
    found, _ = run(places, samples)
    near = found[2] < 0.01
    assert near.any()
    assert found[1][near].min() > 0.95
    assert found[1].max() <= 1


def test_furrow_numbers_have_no_steps():
    places = plane_sites(8)
    steepest = []
    for count in (3000, 30000):
        line = np.column_stack([np.linspace(2, 8, count), np.linspace(3, 7.3, count)])
        found, _ = run(places, line, blend=0.08)
        steepest.append(np.abs(np.diff(found[4])).max())
    assert steepest[1] < steepest[0] / 8
    assert np.ptp(found[4]) > 0.3


@kernel
def exponentials(x, result):
    for i in range(len(x)):
        result[i] = exponential(x[i])


def test_exponential_is_that_of_the_library():
    x = np.concatenate([np.linspace(-86, 86, 20_001), [0.0, -1e3, 1e3]])
    result = np.zeros(len(x))
    exponentials(x, result)
    np.testing.assert_allclose(result, np.exp(np.clip(x, -86, 86)), rtol=2e-12)
    assert result[20_001] == 1.0


@kernel
def logarithms(x, result):
    for i in range(len(x)):
        result[i] = logarithm_of_sum(x[i])


def test_logarithm_is_that_of_the_library():
    x = np.linspace(1, 16, 20_001)
    result = np.zeros(len(x))
    logarithms(x, result)
    np.testing.assert_allclose(result, np.log(x), atol=1e-12)
    assert result[0] == 0.0


def test_samples_are_located_alike_alone_and_in_blocks():
    samples = np.random.default_rng(11).uniform(1, 9, (BLOCK + 37, 2))
    places = plane_sites(2)
    whole, _ = run(places, samples, rounding=0.05, blend=0.15)
    part, _ = run(places, samples[BLOCK - 3 :], rounding=0.05, blend=0.15)
    for all_of_them, some in zip(whole, part, strict=True):
        np.testing.assert_array_equal(all_of_them[BLOCK - 3 :], some)
    few, twin = run(places, samples[:40], k=2, rounding=0.05, blend=0.15, compare=True)
    for have, want in zip(few, map(np.array, zip(*twin, strict=True)), strict=True):
        np.testing.assert_allclose(have, want, atol=2e-6)
    one, _ = run(places, samples[:40], k=[1], blend=0.15)
    assert (one[1] == 0).all()
    assert np.isinf(one[2]).all()
    assert (one[4] == 0.5).all()


def test_pairs_of_neighbours_are_the_same_from_both_ends():
    random = np.random.default_rng(5)
    count = 40
    rows = [random.permutation(count)[: random.integers(0, 12)].astype(np.int32) for _ in range(count)]
    start = np.cumsum([0, *map(len, rows)])
    other, length = np.concatenate(rows), random.random(start[-1])
    expected = pairs_both_ways(start, other, length)
    begin, found, apart = _both_ways(start, other.copy(), length.copy())
    for i, row in enumerate(expected):
        assert found[begin[i] : begin[i + 1]].tolist() == [who for who, _ in row]
        assert apart[begin[i] : begin[i + 1]].tolist() == [far for _, far in row]
    assert _both_ways(np.zeros(1, np.int64), np.zeros(0, np.int32), np.zeros(0))[0].tolist() == [0]
