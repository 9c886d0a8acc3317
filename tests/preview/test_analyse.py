"""Spectra and sections of reliefs whose truth is known."""

import json

import numpy as np
import pytest

from surftex.errors import InputError
from surftex.files.images import read_png, write_exr
from surftex.geodesics.pieces import CurvePieces
from surftex.preview.analyse import analyse_file
from surftex.preview.section import curve_points, flat_section, section
from surftex.preview.spectrum import fitted_ring, height_spectrum, statistics
from surftex.surface.shapes import plane


def waves(long, short, angle_deg, *, count=400, size=256, mm=0.05, spread=0.06):
    """Waves whose frequencies lie on an ellipse, in cycles per mm; rows run down, angles up."""
    random = np.random.Generator(np.random.PCG64(5))
    turn, phase = np.arange(count) * 2 * np.pi / count, random.uniform(0, 2 * np.pi, count)
    wide = 1 + spread * random.standard_normal(count)
    fx, fy = long * np.cos(turn) * wide, short * np.sin(turn) * wide
    spin = np.radians(angle_deg)
    fx, fy = fx * np.cos(spin) - fy * np.sin(spin), fx * np.sin(spin) + fy * np.cos(spin)
    x, y = np.arange(size) * mm, -np.arange(size) * mm
    across = np.exp(2j * np.pi * np.outer(fx, x)) * np.exp(1j * phase)[:, None]
    return np.real(np.exp(2j * np.pi * np.outer(y, fy)) @ across) * 0.01


@pytest.mark.parametrize(
    ("long", "short", "angle"), [(2.0, 2.0, 0), (2.5, 1.6, 0), (2.5, 1.6, 35), (3.0, 2.0, -60)]
)
def test_ring_of_known_waves_is_found(long, short, angle):
    ring = fitted_ring(height_spectrum(waves(long, short, angle), 0.05))
    assert ring.radius == pytest.approx(np.sqrt(long * short), rel=0.05)
    assert ring.ratio == pytest.approx(
        long / short, rel=0.10
    )  # speckle of 12.8 mm: measured 1.085 for a circle
    if long > short:
        assert abs((ring.angle_deg - angle + 90) % 180 - 90) < 4


def test_spectrum_integrates_to_the_variance_and_finds_a_sine():
    random = np.random.Generator(np.random.PCG64(1))
    noise = random.standard_normal((192, 256))
    spectrum = height_spectrum(noise, 0.1)
    cell = (spectrum.across[1] - spectrum.across[0]) * (spectrum.along[1] - spectrum.along[0])
    assert spectrum.density.sum() * cell == pytest.approx(noise.var(), rel=0.03)
    x = np.arange(128) * 0.1
    peak = height_spectrum(np.tile(np.sin(2 * np.pi * 1.25 * x), (64, 1)), 0.1)
    row, column = np.unravel_index(np.argmax(peak.density), peak.density.shape)
    assert abs(peak.across[column]) == pytest.approx(1.25, abs=0.04)
    assert peak.along[row] == 0
    assert peak.decibels.max() == 0


def test_statistics_of_known_numbers():
    values = statistics(np.array([[0.0, 0.0, 0.0, 4.0]]))
    assert values["mean"] == 1
    assert values["rms"] == pytest.approx(np.sqrt(3))
    assert values["skew"] == pytest.approx(2 / np.sqrt(3))
    assert (values["least"], values["most"]) == (0, 4)
    assert statistics(np.full((4, 4), 0.1))["skew"] == 0


def test_flat_section_follows_a_slope():
    row, column = np.mgrid[:20, :30]
    cut = flat_section(0.5 * (column + 0.5) - 0.25 * (row + 0.5), (2, 3), (22, 15), 0.1)
    assert cut.along_mm[-1] == pytest.approx(0.1 * np.hypot(20, 12))
    truth = np.linspace(0.5 * 2 - 0.25 * 3, 0.5 * 22 - 0.25 * 15, len(cut.along_mm))
    np.testing.assert_allclose(cut.height_mm, truth, atol=1e-9)
    with pytest.raises(InputError, match="leaves the map"):
        flat_section(np.zeros((20, 30)), (2, 3), (31, 3), 0.1)


class Slope:
    """A relief that rises with x and y."""

    def __init__(self, surface):
        self.surface = surface

    def at(self, samples):
        x, y, _ = samples.points.positions(self.surface).T
        return {"height_mm": (0.1 * x + 0.02 * y).astype(np.float32)}


def test_section_walks_along_a_curve_of_the_surface():
    surface = plane(10.0, cells=2)
    faces = np.arange(len(surface.faces))
    middle = surface.flat[faces].mean(axis=1)
    pieces = CurvePieces.of(faces[:1], middle[:1], surface.flat[faces[:1], 1], [0])
    points, along = curve_points(surface, pieces, 0.2)
    positions = points.positions(surface)
    np.testing.assert_allclose(np.linalg.norm(positions - positions[0], axis=1), along, atol=1e-9)
    np.testing.assert_allclose(positions[-1], surface.vertices[surface.faces[0, 1]], atol=1e-9)
    cut = section(Slope(surface), surface, pieces, step_mm=0.2)
    np.testing.assert_allclose(cut.height_mm, 0.1 * positions[:, 0] + 0.02 * positions[:, 1], atol=1e-6)


def test_analyse_file_writes_picture_and_numbers(tmp_path):
    write_exr(tmp_path / "a_height.exr", waves(2.5, 1.6, 0, size=200).astype(np.float32))
    result = analyse_file(tmp_path / "a_height.exr", section=(10, 10, 190, 120), mm_per_texel=0.05)
    assert result["ring"]["axis_ratio"] == pytest.approx(2.5 / 1.6, rel=0.08)
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "a_height.exr",
        "a_height_analysis.json",
        "a_height_analysis.png",
    ]
    stored = json.loads((tmp_path / "a_height_analysis.json").read_text())
    assert stored["statistics"] == result["statistics"]
    assert len(stored["section"]["along_mm"]) == len(stored["section"]["height_mm"])
    assert read_png(tmp_path / "a_height_analysis.png").std() > 20


def test_where_an_analysis_cannot_go_is_told_before_the_map_is_read(tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "there.json").mkdir()
    for out, what in (
        ("file/x", "file is a file; name a folder"),
        ("there", "is a folder; name another stem"),
    ):
        with pytest.raises(InputError, match=what):
            analyse_file(tmp_path / "no map at all.exr", tmp_path / out)
    write_exr(tmp_path / "h.exr", waves(2, 2, 0, size=64).astype(np.float32))
    analyse_file(tmp_path / "h.exr", tmp_path / "new" / "x")
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == ["x.json", "x.png"]


def test_texel_size_comes_from_the_report_or_is_said_to_be_unknown(tmp_path, capsys):
    from surftex.cli import main

    write_exr(tmp_path / "h.exr", waves(2, 2, 0, size=64).astype(np.float32))
    assert "not known" in analyse_file(tmp_path / "h.exr")["warnings"][0]
    report = {"resolution": 64, "coverage": 0.5, "mesh": {"area_mm2": 0.5 * 64**2 * 0.3**2}}
    (tmp_path / "report.json").write_text(json.dumps(report))
    assert analyse_file(tmp_path / "h.exr", tmp_path / "x.png")["mm_per_texel"] == pytest.approx(0.3)
    assert analyse_file(tmp_path / "h.exr", tmp_path / "x.png", mm_per_texel=1.0)["coverage"] == 0.5
    assert main(["analyse", str(tmp_path / "h.exr")]) == 0
    said = capsys.readouterr().out
    assert "of 0.3 mm, all of which count; 50 % lie in gaps between charts, and repeat the nearest" in said
    with pytest.raises(InputError, match="no such file"):
        analyse_file(tmp_path / "none.exr")
    with pytest.raises(InputError, match="x0,y0"):
        analyse_file(tmp_path / "h.exr", section=(1, 2, 3))


def test_leather_of_long_sites_leaves_a_flattened_ring():
    from surftex.bake.bake import bake
    from surftex.recipe.model import Recipe
    from surftex.surface.shapes import plane

    layer = {"material": "leather", "preset": "sakurai-12a", "cell_ratio": 5 / 3, "direction": "across"}
    recipe = Recipe.model_validate({"fields": {"across": {"axis": [1.0, 0.0, 0.0]}}, "layer": [layer]})
    maps = bake(plane(24.0, cells=24), recipe, resolution=512, seed=7, maps="height", uv="keep")
    ring = fitted_ring(height_spectrum(maps["height"], 24.0 / 512))
    assert 1.2 < ring.ratio < 1.6  # measured 1.34; long sites make cells only half as long
    assert abs(abs(ring.angle_deg) - 90) < 10
    assert ring.spacing_mm == pytest.approx(0.52, rel=0.1)


def test_the_command_prints_the_main_numbers_after_the_files(tmp_path, capsys):
    from surftex.cli import main

    x = np.arange(200) * 0.05
    height = np.tile(0.02 * np.sin(2 * np.pi * x / 1.0), (200, 1)).astype(np.float32)
    write_exr(tmp_path / "h.exr", height)
    assert main(["analyse", str(tmp_path / "h.exr"), "--mm-per-texel", "0.05"]) == 0
    files, (size, relief, spectrum) = np.split(np.array(capsys.readouterr().out.splitlines()), [2])
    assert [name.rpartition("_")[2] for name in files] == ["analysis.png", "analysis.json"]
    assert size == "map: 200 x 200 texels of 0.05 mm, all of which count, gaps between charts too"
    assert relief.startswith("relief: rms 0.01414 mm about a mean of ")
    assert spectrum.startswith("spectrum: features repeat every ")
    write_exr(tmp_path / "flat.exr", np.zeros((64, 64), np.float32))
    assert main(["analyse", str(tmp_path / "flat.exr"), "--mm-per-texel", "0.05"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "spectrum: no wavelength stands out"


@pytest.mark.parametrize(("cells_mm", "told"), [(1.0, True), (0.1, False), ("no size", True), (None, True)])
def test_a_wavelength_far_beyond_the_features_of_the_report_is_none_of_theirs(
    tmp_path, cells_mm, told, capsys
):
    from surftex.cli import main

    write_exr(tmp_path / "h.exr", waves(2, 2, 0, size=128).astype(np.float32))
    spacing = analyse_file(tmp_path / "h.exr", mm_per_texel=0.05)["ring"]["spacing_mm"]
    assert 0.4 < spacing < 4.0
    report = {"scales": {"features_mm": {"pores": 0.01} | ({} if cells_mm is None else {"cells": cells_mm})}}
    (tmp_path / "report.json").write_text(json.dumps(report))
    result = analyse_file(tmp_path / "h.exr", mm_per_texel=0.05)
    assert result["ring"]["spacing_mm"] == (spacing if told else None)
    assert any("far beyond the cells of 0.1 mm" in each for each in result["warnings"]) != told
    assert main(["analyse", str(tmp_path / "h.exr"), "--mm-per-texel", "0.05"]) == 0
    assert ("features repeat every" in capsys.readouterr().out) == told
