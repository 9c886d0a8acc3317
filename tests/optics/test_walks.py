"""Light's walks against closed forms, published slabs and brute force; errors are stated as standard errors."""

from dataclasses import replace

import numpy as np
import pytest

from surftex.errors import InputError
from surftex.optics import slab
from surftex.optics.border import facet_tables, fold_angle
from surftex.optics.brdf import Absorbers
from surftex.optics.paths import (
    LEFT,
    SURFACE,
    crossing_paths,
    rayleigh_scattering,
    turn_tables,
    volume_paths,
    walk_layers,
)
from surftex.optics.tissue import PARAMETERS, Tissue, absorption, baseline
from surftex.randomness import stream
from tests.oracles import optics as oracle

USUAL = {name: each.usual for name, each in PARAMETERS.items()}


def error(share, count):
    """Standard error of a share of n photons that either come or do not."""
    return np.sqrt(share * (1 - share) / count)


@pytest.mark.parametrize(
    ("n", "g", "thickness_cm", "reflected", "transmitted"),
    [
        (1.0, 0.75, 0.02, 0.09739, 0.66096),  # van de Hulst 1980, table 35; in Prahl 1989
        (1.5, 0.0, np.inf, 0.2600, 0.0),  # Giovanelli 1955
    ],
)
def test_slabs_reflect_what_is_published(n, g, thickness_cm, reflected, transmitted):
    count = 300_000
    found = slab(n, 10.0, 90.0, g, thickness_cm, count, seed=4)
    assert abs(found[0] - reflected) < 3 * error(reflected, count)
    assert abs(found[1] - transmitted) <= 3 * error(transmitted, count)


@pytest.mark.parametrize(("albedo", "reflected"), [(0.99, 0.752721), (0.9, 0.414947), (0.5, 0.115226)])
def test_half_space_is_chandrasekhars(albedo, reflected):
    count = 100_000  # 1 - H(1) sqrt(1 - a), isotropic scattering, light from straight above
    found, _ = slab(1.0, (1 - albedo) / albedo, 1.0, 0.0, np.inf, count, seed=2)
    assert abs(found - reflected) < 3 * error(reflected, count)


def test_light_that_nothing_absorbs_goes_somewhere():
    reflected, transmitted = slab(1.4, 0.0, 50.0, 0.8, 0.05, 20_000)
    assert reflected + transmitted == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"n": 0.5}, "n is 0.5; it goes from 1 to 10"),
        ({"g": 1.0}, "g is 1; it goes from -0.9999"),
        ({"mu_a": -1.0}, "mu_a is -1; it goes from 0"),
        ({"thickness_cm": 0.0}, "thickness_cm is 0; it must be above 0"),
        ({"n": "glass"}, "n is 'glass'; it takes one number"),
        ({"mu_a": None}, "mu_a is None; it takes one number"),
        ({"mu_s": np.ones(2)}, "mu_s is array"),
        ({"thickness_cm": np.nan}, "thickness_cm is nan; it takes at least 0"),
        ({"paths": 2.5}, "paths is 2.5; it takes a whole number"),
        ({"paths": 0}, "paths is 0; it goes from 1 to 100000000"),
        ({"paths": 10**400}, "it takes one number"),
        ({"seed": "seven"}, "seed is 'seven'; it takes one number"),
        ({"seed": np.inf}, "seed is inf; it takes a whole number"),
        ({"thickness_cm": np.inf, "mu_a": 0.0}, "light would never end"),
    ],
)
def test_a_wrong_slab_is_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        slab(**{"n": 1.0, "mu_a": 10.0, "mu_s": 90.0, "g": 0.5, "thickness_cm": 0.1} | wrong)


def border_share(fold, cosine, count=200_000, facets="ggx"):
    """Share that the border reflects, and the directions of all rays; cosine (count,) below 0 from inside."""
    from surftex.kernels.photons import reflect_border

    kind, direction = np.zeros(count, np.int8), np.zeros((count, 3))
    steepness, escape = facet_tables(Tissue(fold=fold, facets=facets))
    reflect_border(np.uint64(7), 0, cosine, 1.55, fold, steepness, escape, kind, direction)
    return kind == 0, direction


def even_light(count=200_000):
    return np.sqrt(np.maximum(stream(3, "light").uniform(count, 1)[:, 0], 1e-9))


def test_smooth_border_is_fresnels():
    for cosine in (1.0, 0.5, 0.1):
        reflected, _ = border_share(0.0, np.full(200_000, cosine))
        exact, _ = oracle.fresnel(cosine, 1.0, 1.55)
        assert abs(reflected.mean() - exact) < 3 * error(exact, 200_000)


@pytest.mark.parametrize(("fold", "outside", "inside"), [(0.0, 0.0991, 0.6250), (0.35, 0.0588, 0.6083)])
def test_border_under_even_light(fold, outside, inside):
    reflected, _ = border_share(fold, even_light())
    assert abs(reflected.mean() - outside) < 3 * error(outside, 200_000) + 1e-4
    reflected, _ = border_share(fold, -even_light())
    assert abs((~reflected).mean() - inside) < 3 * error(inside, 200_000) + 1e-4


def test_rough_border_passes_as_much_either_way():
    """Reciprocity of the n^2-scaled transmission, over even light: (1 - R_out) = n^2 (1 - R_in)."""
    out, _ = border_share(0.5, even_light())
    into, _ = border_share(0.5, -even_light())
    passed_in, passed_out = 1 - out.mean(), into.mean()
    assert passed_in == pytest.approx(1.55**2 * passed_out, rel=3 * error(passed_out, 200_000) / passed_out)


@pytest.mark.parametrize(
    ("exponent", "fold", "degrees"), [(2, 0.75, 38.6), (3, 0.75, 35.5), (2, 0.3, 20.8), (3, 0.3, 14.1)]
)
def test_folds_slope_as_the_two_laws_say(exponent, fold, degrees):
    number = (np.arange(4096) + 0.5) / 4096
    assert np.degrees(fold_angle(number, fold, exponent)).mean() == pytest.approx(degrees, abs=0.06)
    angle = np.linspace(0, np.pi / 2, 20_001)
    density = np.cos(angle) * np.sin(angle) / (1 + np.cos(angle) ** 2 * (fold**2 - 1)) ** exponent
    below = np.cumsum(density) / density.sum()
    assert np.abs(np.interp(fold_angle(number, fold, exponent), angle, below) - number).max() < 6e-4


def test_collagen_scatters_by_rayleighs_law():
    upper, lower = np.transpose([rayleigh_scattering(Tissue(), nm) for nm in (400, 550, 700)])
    assert upper == pytest.approx([471.7, 132.0, 50.3], rel=2e-3)
    assert lower == pytest.approx([331.5, 92.7, 35.3], rel=2e-3)


@pytest.mark.parametrize(("nm", "more"), [(440.0, [1, 1, 1, 1]), (700.0, [1, 1, 30, 0.3])])
def test_crossing_walk_agrees_with_brute_force(nm, more):
    tissue, count = Tissue(fold=0.0, base_albedo=1.0), 4000
    layers = np.array([tissue.papillary_cm, tissue.reticular_cm])
    thickness = np.array([USUAL["stratum_corneum_cm"], USUAL["epidermis_cm"], *layers])
    depth = absorption(tissue, [nm], USUAL)[:, 0] * thickness * more
    number = np.linspace(0, 1, 513)
    angle = [lambda u, row=row: np.interp(u, number, row) for row in turn_tables(nm)]
    slow = oracle.crossing_albedo(
        tissue.index, angle, rayleigh_scattering(tissue, nm) * layers, depth, count, 5
    )
    paths = crossing_paths(tissue, nm, 100_000, seed=1, cosine=1.0)
    weight = paths.weight * np.exp(-paths.lengths @ depth)
    assert abs(weight.mean() - slow) < 3 * np.hypot(error(slow, count), weight.std() / 100_000**0.5)


def test_volume_walk_agrees_with_brute_force():
    index, scattering, forward = np.array([1.5, 1.3]), np.array([60.0, 30.0]), np.array([0.8, 0.0])
    absorbing, border, count = np.array([5.0, 8.0]), np.array([0, 0.03, 0.1]), 6000
    slow = oracle.layers_analog(index, absorbing, scattering, forward, np.diff(border), count, 3)
    lengths, weight, _, kind, _, _ = walk_layers(
        index, scattering, forward, border, absorbing, 100_000, key=stream(1, "test").key
    )
    weight = weight * np.exp(-lengths @ absorbing)
    reflected, transmitted = np.where(kind == LEFT, weight, kind == SURFACE), np.where(kind == 2, weight, 0)
    for fast, exact in ((reflected, slow[0]), (transmitted, slow[1])):
        assert abs(fast.mean() - exact) < 3 * np.hypot(error(exact, count), fast.std() / 100_000**0.5)


def test_one_path_set_serves_every_absorber():
    """Reuse against walks that absorption ends one by one: 12 draws of biology at 3 wavelengths."""
    tissue, count, score = Tissue(base_albedo=0.8), 30_000, []
    draws = stream(11, "biology").uniform(12, 6)
    for k, nm in enumerate((450.0, 560.0, 640.0)):
        paths = crossing_paths(tissue, nm, 2 * count, seed=1)
        for i, draw in enumerate(draws):
            biology = {
                name: each.low + share**2 * (each.high - each.low)
                for share, (name, each) in zip(draw, PARAMETERS.items(), strict=True)
            }
            thickness = [biology["stratum_corneum_cm"], biology["epidermis_cm"], 0.02, 0.18]
            depth = absorption(tissue, [nm], biology)[:, 0] * thickness
            reused = paths.weight * np.exp(-paths.lengths @ depth)
            table = Absorbers(*depth[:, None]).albedo(paths)[0, 0, 0]
            assert table == pytest.approx(reused.mean(), rel=1e-9)
            slow = crossing_paths(tissue, nm, count, seed=100 + 12 * k + i, depth=depth).weight
            spread = np.hypot(slow.std() / count**0.5, reused.std() / (2 * count) ** 0.5)
            score.append((reused.mean() - slow.mean()) / spread)
    assert len(score) == 36
    assert 0.8 < np.sqrt(np.mean(np.square(score))) < 1.2
    assert np.abs(score).max() < 4


def test_roulette_is_fair():
    """Weights under a roulette twice as eager as the absorption asks for agree with those of whole paths."""
    index, scattering, forward = np.array([1.4]), np.array([100.0]), np.array([0.0])
    border, key = np.array([0, 0.1]), stream(2, "test").key
    results = []
    for least in (8.0, 0.0):
        lengths, weight, _, kind, _, _ = walk_layers(
            index, scattering, forward, border, np.array([least]), 200_000, key=key + int(least)
        )
        results.append(np.where(kind == LEFT, weight * np.exp(-3.0 * lengths[:, 0]), 0.0))
    spread = np.hypot(*(each.std() / 200_000**0.5 for each in results))
    assert abs(results[0].mean() - results[1].mean()) < 3 * spread


def test_threads_change_no_path():
    for walk in (
        lambda threads: crossing_paths(Tissue(), 500.0, 9000, threads=threads),
        lambda threads: volume_paths(
            Tissue(), 500.0, 9000, stratum_corneum_cm=0.001, epidermis_cm=0.01, threads=threads
        ),
    ):
        one, two = walk(1), walk(2)
        for name in ("lengths", "weight", "kind", "leaving", "wander_cm"):
            assert getattr(one, name).tobytes() == getattr(two, name).tobytes()


def test_light_that_leaves_never_exceeds_what_came():
    tissue = replace(Tissue(), base_albedo=1.0)
    paths = crossing_paths(tissue, 700.0, 20_000)
    assert (paths.kind < 3).all()
    assert (paths.kind == 2).mean() < 1e-3  # given up; nothing absorbs, so all but these come back
    assert (np.abs(np.linalg.norm(paths.leaving, axis=1) - 1) < 1e-6).all()
    assert baseline(700.0) < baseline(400.0)
