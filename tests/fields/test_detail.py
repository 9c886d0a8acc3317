"""The finest detail of a mesh: none on a ball, the wavelength of waves that are laid on one."""

import numpy as np
import pytest

from surftex.bake.loading import load
from surftex.bake.scales import scale_report
from surftex.fields.detail import finest_detail_mm
from surftex.materials.skin.model import Skin
from surftex.recipe.model import Recipe
from surftex.surface.shapes import plane, sphere
from surftex.surface.surface import Surface


def wavy(wavelength, height, cells=160, side=80.0):
    flat = plane(side, cells=cells)
    place = np.array(flat.vertices)
    place[:, 2] += (
        height * np.sin(2 * np.pi * place[:, 0] / wavelength) * np.sin(2 * np.pi * place[:, 1] / wavelength)
    )
    return Surface.from_arrays(place, flat.faces)


def test_a_ball_and_a_plane_have_none():
    assert finest_detail_mm(sphere(50.0, subdivisions=4)) is None
    assert finest_detail_mm(plane(50.0, cells=30)) is None


@pytest.mark.parametrize("wavelength", [5.0, 10.0, 20.0])
def test_waves_are_found_within_an_octave_or_so(wavelength):
    found = finest_detail_mm(wavy(wavelength, 0.06 * wavelength))
    assert found is not None
    assert wavelength / 3.5 < found < wavelength * 1.5


def test_waves_too_flat_to_see_do_not_count():
    assert finest_detail_mm(wavy(10.0, 0.02)) is None


def test_a_gap_and_an_overlap_are_told():
    surface = wavy(20.0, 1.5)
    fine = scale_report(surface, Recipe.of(Skin(wrinkle_count=0)))
    assert "nothing has detail" in fine["note"]
    coarse = scale_report(surface, Recipe.of(Skin(scar_count=3, scar_radius=(15.0, 1.0))))
    assert "may double scars (30 mm)" in coarse["note"]
    assert coarse["features_mm"]["furrows"] == 0.85
    assert scale_report(sphere(30.0, subdivisions=3), Recipe.of(Skin()))["note"] is None


def test_curves_that_were_drawn_and_vessels_count_and_flat_freckles_do_not():
    skin = Skin(freckle_count=9, vessel_count=2, vessel_width=0.5)
    drawn = {"wrinkle": np.array([(1.5,), (4.0,)], [("width_mm", "f8")])}
    sizes = scale_report(sphere(30.0, subdivisions=3), Recipe.of(skin), features=drawn)["features_mm"]
    assert sizes["wrinkles"] == 8.0
    assert sizes["vessels"] == 1.0
    assert "freckles" not in sizes


@pytest.mark.parametrize(("along", "across"), [(24, 2), (120, 12)])
def test_the_bend_of_a_whole_shape_is_no_relief_of_it(along, across):
    """A band of Moebius, cut where its sides meet: no wave of more than half the mesh is found on it."""
    turn = 2 * np.pi * np.arange(along + 1)[:, None] / along
    aside = 40.0 * (np.arange(across + 1) / across - 0.5)
    reach = 100.0 + aside * np.cos(turn / 2)
    place = np.stack([reach * np.cos(turn), reach * np.sin(turn), aside * np.sin(turn / 2)], axis=2)
    number = np.arange((along + 1) * (across + 1)).reshape(along + 1, across + 1)
    number[-1] = number[0, ::-1]
    a, b, c, d = (
        each.ravel() for each in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    )
    faces = np.concatenate([np.stack(corners, axis=1) for corners in ((a, b, c), (a, c, d))])
    assert finest_detail_mm(load((place[:-1].reshape(-1, 3), faces))) is None
