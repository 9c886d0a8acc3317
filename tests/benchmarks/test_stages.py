"""Every stage of a bake at three sizes; timed with `--benchmark-enable`, else each runs once. Few growths are asserted."""

from types import MappingProxyType

import numpy as np
import pytest

from surftex.charts.atlas import Atlas
from surftex.charts.seams import seam_report
from surftex.charts.texels import texels
from surftex.charts.unwrap import unwrap
from surftex.features.poisson import poisson_disk
from surftex.features.relax import relaxed
from surftex.features.voronoi_graph import VoronoiGraph
from surftex.files.meshes import load
from surftex.maps.mapset import MapSet
from surftex.maps.normal import normal_map, surface_tangents
from surftex.maps.occlusion import ambient_occlusion
from surftex.randomness import stream
from surftex.surface.shapes import sphere
from tests.benchmarks.growth import exponent

pytestmark = pytest.mark.slow

RADIUS_MM = 40.0
SITES = (500, 2000, 8000)
WIDTHS = (256, 512, 1024)


@pytest.fixture(scope="module")
def ball():
    return sphere(RADIUS_MM, subdivisions=5)


@pytest.fixture(scope="module")
def atlas(ball):
    return unwrap(ball, method="uvunwrap", resolution=512)


def sites_of(surface, count):
    spacing = float(np.sqrt(0.697 * surface.area_mm2 / count))
    return poisson_disk(surface, spacing, stream(0, "benchmark"), threads=1)


def page_of(surface, atlas, width):
    """Texels of a page, and a height at each."""
    mapped = texels(surface, atlas, width, gutter_px=4, threads=1)
    return mapped, np.sin(mapped.points.positions(surface)[:, 0]).astype(np.float32)


@pytest.mark.parametrize("subdivisions", [4, 5, 6])
def test_load(benchmark, tmp_path, subdivisions):
    surface = sphere(RADIUS_MM, subdivisions=subdivisions)
    path = tmp_path / "ball.obj"
    rows = ["v {:.6f} {:.6f} {:.6f}".format(*place) for place in surface.vertices]
    rows += ["f {} {} {}".format(*(face + 1)) for face in surface.faces]
    path.write_text("\n".join(rows))
    assert len(benchmark(load, path, units="mm").faces) == len(surface.faces)


@pytest.mark.parametrize("count", SITES)
def test_sites(benchmark, ball, count):
    assert len(benchmark(sites_of, ball, count)) == pytest.approx(count, rel=0.1)


@pytest.mark.parametrize("count", SITES)
def test_relax(benchmark, ball, count):
    sites = sites_of(ball, count)
    benchmark(relaxed, ball, sites, stream(0, "evening out"), rounds=1, threads=1)


@pytest.mark.parametrize("count", SITES)
def test_voronoi_graph(benchmark, ball, count):
    graph = benchmark(VoronoiGraph.of, ball, sites_of(ball, count), threads=1)
    assert len(graph.vertices) > count


@pytest.mark.parametrize("width", WIDTHS)
def test_texels(benchmark, ball, atlas, width):
    assert len(benchmark(texels, ball, atlas, width, gutter_px=4, threads=1)) > 0.4 * width**2


@pytest.mark.parametrize("subdivisions", [4, 5, 6])
def test_tangents(benchmark, subdivisions):
    surface = sphere(RADIUS_MM, subdivisions=subdivisions)
    whole = Atlas.of(surface, np.abs(surface.shading_normal[..., :2]) / 2)
    assert benchmark(surface_tangents, surface, whole).shape == (len(surface.faces), 3, 4)


@pytest.mark.parametrize("width", WIDTHS)
def test_seams(benchmark, ball, atlas, width):
    page, height = page_of(ball, atlas, width)
    report = benchmark(seam_report, ball, atlas, {"height": page.image(height)})
    assert report["samples"] > width


@pytest.mark.parametrize("width", WIDTHS)
def test_normals(benchmark, ball, atlas, width):
    page, height = page_of(ball, atlas, width)
    tangents = surface_tangents(ball, atlas)
    benchmark(normal_map, ball, atlas, page, height, tangents=tangents, threads=1)


@pytest.mark.parametrize("width", WIDTHS)
def test_occlusion(benchmark, ball, atlas, width):
    page, height = page_of(ball, atlas, width)
    benchmark(ambient_occlusion, ball, atlas, page, height, threads=1)


@pytest.mark.parametrize("width", WIDTHS)
def test_write(benchmark, ball, atlas, tmp_path, width):
    page, height = page_of(ball, atlas, width)
    tangents = surface_tangents(ball, atlas)
    maps = {
        "height": page.image(height),
        "normal": page.image(normal_map(ball, atlas, page, height, tangents=tangents, threads=1)),
    }
    result = MapSet(MappingProxyType(maps), ball, atlas, tangents, stem="ball")
    files = benchmark(result.save, tmp_path, overwrite=True, threads=1)
    assert all(path.stat().st_size > 0 for path in files)


def test_sites_and_their_graph_grow_with_the_count(ball):
    assert exponent(lambda count: VoronoiGraph.of(ball, sites_of(ball, count), threads=1), SITES) < 1.2


def test_texels_and_normals_grow_with_the_area_of_the_page(ball, atlas):
    tangents = surface_tangents(ball, atlas)

    def work(width):
        page, height = page_of(ball, atlas, width)
        normal_map(ball, atlas, page, height, tangents=tangents, threads=1)

    assert exponent(work, WIDTHS) < 2.4
