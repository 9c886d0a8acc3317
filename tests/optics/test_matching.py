"""BRDFs by counting, and render models matched to them: known parameters come back, and no search finds better."""

import numpy as np
import pytest

from surftex.errors import InputError
from surftex.optics import making
from surftex.optics.brdf import Absorbers, Bins, surface_lobe
from surftex.optics.making import Making, make_table
from surftex.optics.matching import bin_geometry, bin_parts, match
from surftex.optics.paths import Paths, crossing_paths
from surftex.optics.shaders import SHADERS, shader_named
from surftex.optics.tissue import Tissue
from surftex.randomness import stream
from tests.oracles import optics as oracle

BINS = Bins(6, 6)
DIFFUSE = np.array([[0.5, 0.3, 0.2], [0.1, 0.05, 0.02]])


def brdfs_of(shader, shape, reflectance):
    """BRDFs of the model itself, averaged over bins: (2, 3, bins)."""
    parts = [each.reshape(BINS.count, -1).mean(1) for each in shader.parts(shape, bin_geometry(BINS))]
    return DIFFUSE[..., None] * parts[0] + parts[1] + reflectance * parts[2]


@pytest.mark.parametrize("name", SHADERS)
@pytest.mark.parametrize("place", [0.3, 0.55, 0.8])
def test_known_parameters_come_back(name, place):
    shader = shader_named(name)
    shape = float(np.exp(np.interp(place, [0, 1], np.log(shader.shapes[[0, -1]]))))
    found = match(shader, BINS, brdfs_of(shader, shape, 0.05))
    assert found.shape == pytest.approx([shape] * 2, rel=2e-3)
    assert found.reflectance == pytest.approx([0.05] * 2, rel=4e-3)
    assert found.diffuse == pytest.approx(DIFFUSE, rel=2e-3)
    assert found.residual.max() < 4e-3  # shapes between the tabulated ones


@pytest.mark.parametrize("name", SHADERS)
def test_no_search_finds_better(name):
    """The twin: a plain search over shape and reflectance, each diffuse factor by least squares."""
    shader = shader_named(name)
    brdf = brdfs_of(shader, shader.shapes[50], 0.05)
    brdf = brdf * (1 + 0.2 * stream(1, "noise").uniform(brdf.size, 1).reshape(brdf.shape))
    found = match(shader, BINS, brdf)
    parts = bin_parts(name, BINS)
    for n, one in enumerate(brdf):
        best = np.inf
        for shape in range(0, 96, 3):
            base, fixed, scaled = parts[:, :, shape].T
            for level in np.linspace(0, 1, 41):
                rest = one - fixed - level * scaled
                factor = np.maximum(rest @ base / (base @ base), 0)
                best = min(best, ((rest - factor[:, None] * base) ** 2).sum())
        assert found.residual[n] <= np.sqrt(best / (one**2).sum()) * (1 + 1e-6)


@pytest.mark.parametrize("name", SHADERS)
def test_channels_without_diffuse_light_bend_no_reflectance(name):
    """Where some channels want less diffuse light than none, a fine search over reflectance finds nothing better."""
    shader, (base, fixed, scaled) = shader_named(name), bin_parts(name, BINS)[:, :, 50].T
    brdf = brdfs_of(shader, shader.shapes[50], 0.05) - 0.12 * base
    found = match(shader, BINS, brdf, shape=float(shader.shapes[50]))
    assert (found.diffuse == 0).any()
    for n, one in enumerate(brdf):
        best = np.inf
        for level in np.linspace(0, 0.3, 3001):
            rest = one - fixed - level * scaled
            factor = np.maximum(rest @ base / (base @ base), 0)
            best = min(best, ((rest - factor[:, None] * base) ** 2).sum())
        assert found.residual[n] <= np.sqrt(best / (one**2).sum()) * (1 + 1e-9) + 1e-7


def test_bins_that_face_light_and_eye_count_more():
    """A diffuse factor that changes from 0.4, facing, to 0.1, grazing: the weighed match says what is seen from the front."""
    shader, parts = shader_named("ggx-lambert"), bin_parts("ggx-lambert", BINS)[:, :, 50].T
    facing = BINS.facing(1.0)
    assert facing[0] == pytest.approx(11 / 12)
    assert facing.reshape(6, 6, 6)[1, 4, 2] == pytest.approx(np.sqrt(9 / 12 * 3 / 12))
    brdf = np.tile((0.1 + 0.3 * (facing > 0.8)) * parts[0] + parts[1] + 0.05 * parts[2], (1, 3, 1))
    held = {"shape": float(shader.shapes[50]), "reflectance": 0.05}
    alike = match(shader, BINS, brdf, **held).diffuse
    assert alike == pytest.approx(np.full((1, 3), 0.1 + 0.3 * (facing > 0.8).mean()))
    assert match(shader, BINS, brdf, **held, weight=BINS.facing(0.0)).diffuse == pytest.approx(alike)
    assert (match(shader, BINS, brdf, **held, weight=BINS.facing(40.0)).diffuse > 0.39).all()


def test_a_held_surface_stays_held():
    shader = shader_named("ggx-lambert")
    found = match(shader, BINS, brdfs_of(shader, 0.3, 0.05), shape=0.35, reflectance=0.0465)
    assert found.shape == pytest.approx([0.35] * 2)
    assert (found.reflectance == 0.0465).all()


def test_an_unknown_shader_lists_the_known():
    with pytest.raises(
        InputError, match="no shader 'phong'; known are ggx-lambert, principled, ashikhmin-shirley"
    ):
        shader_named("phong")


def test_models_are_reciprocal():
    geometry = bin_geometry(BINS, 1)
    turned = type(geometry)(geometry.outgoing, geometry.incident, geometry.half, geometry.half_incident)
    for shader in SHADERS.values():
        for there, back in zip(
            shader.parts(shader.shapes[40], geometry), shader.parts(shader.shapes[40], turned), strict=True
        ):
            assert there == pytest.approx(back, rel=1e-12)


def test_equal_light_fills_equal_bins():
    """A Lambertian surface of albedo 1, by counting: 1 / pi in every bin, within 4.5 standard errors."""
    count = 400_000
    u, v, w, t = stream(5, "lambert").uniform(count, 4).T
    sine, turn = np.sqrt(v), 2 * np.pi * t
    leaving = np.stack([sine * np.cos(turn), sine * np.sin(turn), np.sqrt(1 - v)], axis=1)
    cosine = np.sqrt(1 - u)
    step = BINS.incident(cosine)
    sent = np.bincount(step, minlength=BINS.zenith)
    hits = np.bincount(BINS.of(cosine, leaving), minlength=BINS.count)
    brdf = hits / np.repeat(sent, BINS.zenith * BINS.azimuth) / BINS.solid_angle
    assert np.abs(brdf * np.pi - 1).max() < 4.5 / np.sqrt(hits.mean())
    assert BINS.albedo(brdf) == pytest.approx(1.0, abs=1e-12)
    assert w.min() >= 0


def test_the_bare_surface_is_reciprocal_and_bright_as_its_border():
    lobe = surface_lobe(Tissue(), BINS, rays=1_000_000)
    cube = lobe.reshape(6, 6, 6)
    assert np.linalg.norm(cube - cube.swapaxes(0, 1)) < 0.03 * np.linalg.norm(cube)
    assert BINS.albedo(lobe) == pytest.approx(0.0588, abs=0.001)


def test_symmetrising_makes_the_crossing_walk_reciprocal_and_keeps_its_albedo():
    paths = crossing_paths(Tissue(), 600.0, 200_000)
    step = BINS.incident(paths.cosine)
    weight = paths.weight / np.bincount(step)[step] / BINS.solid_angle
    brdf = np.zeros((BINS.count, 1, 1, 1))
    one = np.array([0.5])
    Absorbers(one * 0, one * 0.1, one * 0.1, one * 0.2).sums(
        paths, weight, BINS.of(paths.cosine, paths.leaving), np.ones(1), brdf
    )
    raw = brdf[:, 0, 0, 0]
    even = BINS.symmetric(raw)
    cube, odd = even.reshape(6, 6, 6), raw.reshape(6, 6, 6)
    assert np.array_equal(cube, cube.swapaxes(0, 1))
    assert BINS.albedo(even) == pytest.approx(BINS.albedo(raw), rel=1e-12)
    assert np.linalg.norm(odd - odd.swapaxes(0, 1)) > 0.1 * np.linalg.norm(odd)  # the walk itself is not


@pytest.mark.parametrize("shape", [(1, 1, 1), (27, 3, 9), (5, 2, 8), (16, 1, 17)])
def test_absorption_of_all_combinations_is_that_of_each(shape):
    """Bins of 0 to 9 paths, some paths of weight 0, depths from nothing to beyond what counts; 1e-12 of each number."""
    e, s, d = shape
    numbers = stream(8, "absorb")
    sums = 12 * numbers.uniform(40, 4) ** 3
    weight = np.maximum(numbers.uniform(40, 1, first=500)[:, 0] - 0.1, 0)
    bin_of = np.repeat(np.arange(12), [0, 1, 2, 3, 4, 5, 0, 6, 7, 9, 3, 0])
    corneum, epidermis, papillary, reticular = (
        8 * numbers.uniform(count, 1, first=1000 + 100 * k)[:, 0] for k, count in enumerate((s, e, d, d))
    )
    share, total = np.array([0.2, -0.1]), np.zeros((12, 2, e, s * d))
    paths = Paths(sums, weight, np.ones(40, np.int8), np.zeros((40, 3)), np.ones(40), np.zeros(40))
    Absorbers(corneum, epidermis, papillary, reticular).sums(paths, weight, bin_of, share, total)
    slow = oracle.absorbed(sums, weight, bin_of, corneum, epidermis, papillary, reticular, share, 12)
    assert np.allclose(total, slow, rtol=1e-12, atol=1e-15)
    assert (total[[0, 6, 11]] == 0).all()


def test_pieces_of_any_size_make_the_same_table(monkeypatch):
    """The thesis' walk fills thicknesses of the epidermis together, or one by one where there are many entries."""
    counts = {
        "pheomelanin": 1,
        "melanin": 2,
        "epidermis_cm": 3,
        "stratum_corneum_cm": 2,
        "blood": 2,
        "oxygenation": 1,
    }
    how = Making(engine="biospec", nodes=counts, paths=500, beam_paths=200, step_nm=50.0)
    tables, kept = [], [{}, {}, {}]
    for most, pieces in zip((2000, 16, 1), kept, strict=True):
        monkeypatch.setattr(making, "_MOST_ENTRIES", most)
        tables.append(make_table(how, kept=pieces).to_bytes())
    assert [len(pieces) for pieces in kept] == [1, 2, 3]
    assert tables[0] == tables[1] == tables[2]
