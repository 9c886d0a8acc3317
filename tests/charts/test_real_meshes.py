"""Real meshes and awkward files: every unwrap passes the gate, and seams stay small."""

import pytest

from surftex.charts.equalise import equalise
from surftex.charts.gate import choose_atlas, gate
from surftex.charts.seams import probe, probe_seams, seam_jumps, seam_samples
from surftex.charts.texels import texels
from surftex.charts.unwrap import unwrap
from surftex.errors import InputError
from surftex.files.meshes import load

pytestmark = pytest.mark.slow

MESHES = [
    "spot_quads.obj",
    "shoe_variants.glb",
    "chair_sheen.glb",
    "bust_demosthenes.off",
    "head_lee_perry_smith.ply",
]
SIDE = 1024


@pytest.mark.parametrize("name", MESHES)
def test_unwraps_of_real_meshes_pass_and_their_seams_are_small(shared, name):
    surface = load(shared / "meshes" / name, size="300 mm")
    atlas = unwrap(surface, method="uvunwrap", resolution=SIDE)
    report = gate(surface, atlas, SIDE, gap_px=2 * atlas.gutter_px)
    assert report.passed, report.problems
    assert report.mirrored_faces == report.flat_faces == report.stretched_share == 0
    page = texels(surface, atlas, SIDE)
    levels = probe_seams(surface, atlas, page)
    assert all(level["ratio"] < 5 for level in levels)
    dilated = probe_seams(surface, atlas, texels(surface, atlas, SIDE, gutter_px=0), mips=1)
    assert dilated[0]["rms"] > 5 * levels[0]["rms"]
    image = page.image(probe(surface, page.points, 24 / atlas.texels_per_mm(surface, SIDE)))
    samples = seam_samples(surface, atlas, SIDE)
    jumps = seam_jumps(samples, equalise(samples, image).image)
    assert jumps[0].rms < 1.2 * levels[0]["interior"]


def test_awkward_files_get_an_atlas(shared):
    seen = 0
    for path in sorted((shared / "bad-inputs").glob("*.*")):
        if not path.is_file() or path.suffix == ".md":
            continue
        try:
            surface = load(path, size="300 mm")
        except InputError:
            continue
        atlas = choose_atlas(surface, method="uvunwrap", resolution=512)
        own = atlas.unwrapper == "own"
        report = gate(surface, atlas, 512, gap_px=3 if own else 2 * atlas.gutter_px)
        assert report.passed, (path.name, report.problems)
        assert len(texels(surface, atlas, 512)) > 0, path.name
        seen += 1
    assert seen > 20
