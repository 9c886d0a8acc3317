"""Skin types as fits, moods of the blood, and the table of the package against what makes it."""

import numpy as np
import pytest

from surftex.errors import InputError
from surftex.optics import fit_reflectance, lookup, skin_type, skin_types
from surftex.optics.brdf import Bins, surface_lobe
from surftex.optics.colour import TYPES, difference, lab, typology_angle
from surftex.optics.fitting import FREE
from surftex.optics.making import Making, make_table
from surftex.optics.matching import match
from surftex.optics.nodes import straightened
from surftex.optics.paths import volume_paths
from surftex.optics.shaders import shader_named
from surftex.optics.spectra import chromophore, rgb_weights
from surftex.optics.subsurface import EDGES_MM, burley_within, fit_width, rings
from surftex.optics.table import SkinTable, shipped_table
from surftex.optics.tissue import PARAMETERS, Tissue, absorption
from surftex.randomness import stream


@pytest.mark.parametrize("name", ["dark", "tan", "very light"])
def test_the_fits_are_what_the_fit_gives(name):
    kind = skin_types()[name]
    fit = fit_reflectance(kind.nm, kind.reflectance, base_albedo=0.5)
    assert fit.rmse == pytest.approx(kind.rmse, abs=6e-5)
    for each in FREE:
        assert fit.biology[each] == pytest.approx(kind.biology[each], rel=2e-3)


def test_every_class_is_fitted_within_a_hundredth():
    types = skin_types()
    assert list(types) == list(TYPES)
    assert all(each.rmse <= 0.010 for each in types.values())
    for each in types.values():
        seen = lookup(each.biology).base_color[0] + 0.0415  # with what the border reflects at 8 degrees
        measured = each.reflectance @ rgb_weights(each.nm)
        assert difference(lab(measured), lab(seen)) < 3.5
        assert abs(typology_angle(measured) - typology_angle(seen)) < 8


def test_melanin_grows_from_type_to_type():
    melanin = [each.biology["melanin"] for each in skin_types().values()]
    assert (np.diff(melanin) < 0).all()


def test_a_spectrum_of_known_biology_is_found_again():
    kind = skin_types()["light"]
    usual = {name: each.usual for name, each in PARAMETERS.items()}
    biology = usual | {"melanin": 0.03, "blood": 0.02}
    spectrum = []
    for nm in kind.nm:
        paths = volume_paths(
            Tissue(), nm, 8000, stratum_corneum_cm=0.001, epidermis_cm=0.01, cosine=0.99, seed=9
        )
        light = paths.weight * np.exp(-paths.lengths @ absorption(Tissue(), [nm], biology)[:, 0])
        spectrum.append(light.mean() + np.mean(paths.kind == 0))
    fit = fit_reflectance(kind.nm, spectrum, base_albedo=0.5)
    assert fit.rmse < 0.006
    assert fit.biology["melanin"] == pytest.approx(0.03, rel=0.25)
    assert fit.biology["blood"] == pytest.approx(0.02, rel=0.25)


def test_blush_pallor_and_cyanosis_look_like_themselves():
    usual = skin_type("light")
    blush, pallor, blue = (
        lab(lookup(usual | change).base_color[0])
        for change in ({"blood": usual["blood"] * 3}, {"blood": usual["blood"] / 3}, {"oxygenation": 0.3})
    )
    rest = lab(lookup(usual).base_color[0])
    assert blush[1] > rest[1] + 2  # redder
    assert pallor[1] < rest[1] - 1
    assert pallor[0] > rest[0]
    assert blue[2] < rest[2] or blue[1] < rest[1]
    assert blue[0] < rest[0]


def test_an_unknown_type_lists_the_known():
    with pytest.raises(InputError, match="no skin type 'pink'; known are dark, brown, tan"):
        skin_type("pink")
    with pytest.raises(InputError, match="8 or more"):
        fit_reflectance([400.0, 500.0], [0.1, 0.2])
    with pytest.raises(InputError, match="no skin type"):
        skin_type(["dark"])


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"base_albedo": "white"}, "base_albedo is 'white'; it takes one number"),
        ({"base_albedo": 3}, "base_albedo is 3; it goes from 0 to 1"),
        ({"paths": 0}, "paths is 0; it goes from 1"),
        (
            {"nm": np.linspace(300, 700, 9)},
            "nm holds 2 wavelengths beyond the tables; the first is 300; they go from 380",
        ),
        ({"nm": None}, "nm has 0 axes"),
    ],
)
def test_a_wrong_fit_is_refused(wrong, message):
    given = {"nm": np.linspace(400, 700, 9), "reflectance": np.full(9, 0.3)} | wrong
    with pytest.raises(InputError, match=message):
        fit_reflectance(**given)


def test_the_table_of_the_package_is_what_its_code_makes():
    """A few nodes made anew, other photons: within their noise and what the polynomials miss."""
    table = shipped_table()
    few = {
        "pheomelanin": 2,
        "melanin": 3,
        "epidermis_cm": 1,
        "stratum_corneum_cm": 1,
        "blood": 3,
        "oxygenation": 2,
    }
    settings = dict(table.settings)
    making = Making(nodes=few, paths=6000, beam_paths=3000, seed=5)
    for name, value in making.settings().items():
        if name not in ("nodes", "paths", "beam_paths", "seed"):
            assert settings[name] == value, name
    again = make_table(making)
    shipped = table.at(again.axes)
    color = difference(lab(shipped[..., :3]), lab(again.values[..., :3]))
    assert color.mean() < 1.3  # 0.8 measured
    assert color.max() < 3
    assert np.abs(shipped[..., 3:5] - again.values[..., 3:5]).max() < 0.015
    assert np.abs(np.log(shipped[..., 5:] / again.values[..., 5:])).max() < 0.2


def test_the_dense_grid_reads_as_the_polynomials():
    table = shipped_table()
    value = {name: np.array([0.5 * (each.low + each.high)]) for name, each in PARAMETERS.items()}
    for melanin in (0.01, 0.05, 0.2):
        for blood in (0.005, 0.02, 0.1):
            value |= {"melanin": np.array([melanin]), "blood": np.array([blood])}
            exact = table.at(value).ravel()
            assert difference(lab(exact[:3]), lab(lookup(value).base_color[0])) < 0.5


def test_a_damaged_table_is_refused():
    data = shipped_table().to_bytes()
    assert np.array_equal(SkinTable.from_bytes(data).values, shipped_table().values)
    for wrong in (b"", b"no table", data[: len(data) // 2], data[:100] + b"x" + data[101:]):
        with pytest.raises(InputError, match=r"skin\.npz is"):
            SkinTable.from_bytes(wrong, "skin.npz")


@pytest.mark.parametrize("width_mm", [0.05, 0.3, 2.0])
def test_the_width_of_burleys_profile_comes_back(width_mm):
    share = np.diff(burley_within(np.append(EDGES_MM, 1e9), width_mm), prepend=0.0)
    found, error = fit_width(share)
    assert found == pytest.approx(width_mm, rel=5e-3)
    assert error < 5e-3
    assert rings(np.array([0.0, 100.0])).tolist() == [0, len(EDGES_MM)]


def test_white_is_white_and_absorbers_are_read_as_written():
    assert rgb_weights(np.arange(400, 701, 10.0)).sum(0) == pytest.approx([1, 1, 1])
    assert chromophore("oxyhaemoglobin", [420, 425]) == pytest.approx([453161, (453161 + 251096) / 2])
    with pytest.raises(InputError, match="nm must ascend"):
        rgb_weights([500.0, 400.0])


def test_gloss_is_matched_to_the_surface():
    """GGX finds the fold of the bare surface again: the physical index, and its width."""
    bins = Bins()
    lobe = surface_lobe(Tissue(), bins, rays=400_000)
    found = match(shader_named("ggx-lambert"), bins, np.tile(lobe, (1, 3, 1)))
    assert found.shape[0] == pytest.approx(0.35, abs=0.03)
    assert found.reflectance[0] == pytest.approx(0.0465, abs=0.035)


def test_a_look_up_is_what_walks_of_light_give():
    """Base colours of five biologies between the nodes, each walked for itself under light at 8 degrees.

    The match weighs directions by how they face, so that colour is what is seen from the front: 1.5 % more than the
    walk, give or take 3 % and the noise of the walk.
    """
    tissue, count, nm = Tissue(), 3000, np.arange(400, 701, 10.0)
    for k, draw in enumerate(stream(31, "biology").uniform(5, 6)):
        biology = {}
        for share, (name, each) in zip(draw, PARAMETERS.items(), strict=True):
            low, high = straightened(name, [each.low, each.high])
            value = low + share * (high - low)
            biology[name] = float(value if each.even else np.exp(value))
        walked, square = np.zeros(3), np.zeros(3)
        for wave, weights in zip(nm, rgb_weights(nm), strict=True):
            paths = volume_paths(
                tissue, wave, count, stratum_corneum_cm=biology["stratum_corneum_cm"],
                epidermis_cm=biology["epidermis_cm"], seed=50 + k, cosine=float(np.cos(np.radians(8))),
            )  # fmt: skip
            light = paths.weight * np.exp(-paths.lengths @ absorption(tissue, [wave], biology)[:, 0])
            walked += weights * light.mean()
            square += weights**2 * light.var() / count
        seen = lookup(biology).base_color[0]
        assert (np.abs(seen / walked - 1.015) < 0.03 + 3 * np.sqrt(square) / walked).all()


@pytest.mark.parametrize(
    "biology",
    [{"melanin": 0.45, "epidermis_cm": 0.02, "stratum_corneum_cm": 0.004}, {"melanin": 0.002, "blood": 0.15}],
)
def test_where_blue_outshines_green_the_walk_says_so_too(biology):
    """Two extremes: what a thick stratum corneum scatters before any melanin, and what much blood leaves.

    Blue over green is above 1 in walks under light at 8 degrees, and in the look-up the same within 0.1.
    """
    tissue, count, nm = Tissue(), 10_000, np.arange(400, 701, 20.0)
    whole = {name: each.usual for name, each in PARAMETERS.items()} | biology
    walked, square = np.zeros(3), np.zeros(3)
    for wave, weights in zip(nm, rgb_weights(nm), strict=True):
        paths = volume_paths(
            tissue, wave, count, stratum_corneum_cm=whole["stratum_corneum_cm"],
            epidermis_cm=whole["epidermis_cm"], seed=3, cosine=float(np.cos(np.radians(8))),
        )  # fmt: skip
        light = paths.weight * np.exp(-paths.lengths @ absorption(tissue, [wave], whole)[:, 0])
        walked += weights * light.mean()
        square += weights**2 * light.var() / count
    bluer, error = walked[2] / walked[1], np.hypot(*(np.sqrt(square) / walked)[1:])
    assert bluer > 1 + 3 * error
    seen = lookup(whole).base_color[0]
    assert seen[2] / seen[1] == pytest.approx(bluer, abs=0.1)
