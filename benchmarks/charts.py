"""What unwraps, texels and seams cost: ``python -m benchmarks.charts MESH [--subdivide] [--xatlas] [RESOLUTION ...]``.

Seconds of processor time of this process and its children, all threads. `--xatlas` also times xatlas alone, which
takes minutes on large meshes.
"""

import os
import sys
import time

import numpy as np

from surftex.charts.atlas import Atlas
from surftex.charts.equalise import equalise
from surftex.charts.gate import gate
from surftex.charts.seams import probe, probe_seams, seam_jumps, seam_samples
from surftex.charts.texels import texels
from surftex.charts.unwrap import unit_vertices, unwrap
from surftex.charts.xatlas_run import xatlas_charts
from surftex.files.meshes import load
from surftex.surface.shapes import midpoint_subdivided, sphere
from surftex.surface.surface import Surface


def timed(label, work):
    """Print the processor time of a call; its result."""
    before, start = sum(os.times()[:4]), time.perf_counter()
    result = work()
    print(f"{label:<34}{sum(os.times()[:4]) - before:8.2f} cpu s{time.perf_counter() - start:8.2f} wall s")
    return result


def page_by_rows(surface, atlas, resolution):
    """Map a page in tiles of four million texels, as a bake does; the number of mapped texels."""
    rows = max(64, 4_194_304 // resolution)
    return sum(
        len(texels(surface, atlas, resolution, gutter_px=16, rows=(first, min(resolution, first + rows))))
        for first in range(0, resolution, rows)
    )


def main(path, resolutions, subdivide, alone):
    surface = load(path, size="300 mm")
    if subdivide:
        surface = Surface.from_arrays(
            *midpoint_subdivided(surface.vertices, surface.faces), name=surface.name
        )
    small = sphere(subdivisions=2)
    texels(small, unwrap(small, method="uvunwrap", resolution=64), 64)
    print(f"{surface.name}: {len(surface.faces)} faces, {surface.area_mm2:.0f} mm^2")
    atlas = timed("unwrap, uvunwrap", lambda: unwrap(surface, method="uvunwrap", resolution=2048))
    report = timed("gate", lambda: gate(surface, atlas, 2048, gap_px=2 * atlas.gutter_px))
    print(
        f"  {atlas.chart_count} charts, {atlas.seam_length_mm(surface):.0f} mm of seams, gutter {atlas.gutter_px}"
    )
    print(f"  {report}")
    if alone:
        vertices = unit_vertices(surface.vertices)
        charts = timed("xatlas alone", lambda: xatlas_charts(vertices, surface.faces, budget_s=1e4))
        other = Atlas.of(surface, charts / np.abs(charts).max())
        print(f"  {other.chart_count} charts, {other.seam_length_mm(surface):.0f} mm of seams")
    for resolution in resolutions:
        before = time.process_time()
        mapped = timed(
            f"texels {resolution}^2, gutter 16", lambda side=resolution: page_by_rows(surface, atlas, side)
        )
        each = (time.process_time() - before) / resolution**2
        print(f"  {1e6 * each:.3f} us a texel, {mapped / resolution**2:.1%} mapped")
    page = texels(surface, atlas, 2048)
    for name, shown in (("continued", page), ("dilated", texels(surface, atlas, 2048, gutter_px=0))):
        levels = probe_seams(surface, atlas, shown)
        numbers = "   ".join(f"{level['rms']:.5f} ({level['ratio']:.2f} x interior)" for level in levels)
        print(f"jump rms at mips 0, 1, 2, {name:<10}{numbers}")
    samples = seam_samples(surface, atlas, 2048)
    image = page.image(
        probe(surface, page.points, 24 / atlas.texels_per_mm(surface, 2048)).astype(np.float32)
    )
    even = timed("equalise", lambda: equalise(samples, image))
    for name, shown in (("continued", image), ("equalised", even.image)):
        jumps = "   ".join(f"{jump.rms:.5f}" for jump in seam_jumps(samples, shown))
        print(f"one pattern at mips 0, 1, 2, {name:<10}{jumps}")
    print(f"  {even.moved_texels} texels moved by {even.moved_rms:.4f} rms, {even.moved_max:.3f} at most")


if __name__ == "__main__":
    words = sys.argv[1:]
    sizes = [int(word) for word in words if word.isdigit()] or [2048]
    main(words[0], sizes, "--subdivide" in words, "--xatlas" in words)
