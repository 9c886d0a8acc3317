"""What maps and files cost, on a ball with a cellular relief: ``python -m benchmarks.maps [RESOLUTION]``.

Seconds of processor time of this process, all threads; the file sizes; and how well maps agree along seams.
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from surftex.charts.texels import texels
from surftex.charts.unwrap import unwrap
from surftex.files.images import normal_codes, png_bytes, srgb_codes, unit_codes, write_exr
from surftex.maps.displace import displaced
from surftex.maps.mapset import MapSet
from surftex.maps.normal import normal_map, surface_tangents
from surftex.maps.occlusion import ambient_occlusion
from surftex.randomness import stream
from surftex.surface.shapes import sphere


def timed(label, work, repeat=1):
    """Print the least processor time of a few calls; the last result."""
    least = np.inf
    for _ in range(repeat):
        start = time.process_time()
        result = work()
        least = min(least, time.process_time() - start)
    size = f"  {len(result) / 1e6:6.1f} MB" if isinstance(result, bytes) else ""
    print(f"{label:<28}{least:8.3f} s{size}")
    return result


def relief(place, radius_mm):
    """Height of plates of about 1.3 mm, parted by furrows."""
    sites = stream(0, "benchmark").uniform(27_000, 3) - 0.5
    sites *= radius_mm / np.linalg.norm(sites, axis=1, keepdims=True)
    near = cKDTree(sites).query(place, k=2)[0]
    return (-0.25 * np.exp(-(((near[:, 1] - near[:, 0]) / 0.36) ** 2))).astype(np.float32)


def main(resolution=2048):
    ball = sphere(60.0, subdivisions=5)
    print(f"{len(ball.faces)} faces, {resolution}^2 texels")
    atlas = timed("unwrap", lambda: unwrap(ball, method="uvunwrap", resolution=resolution))
    page = timed("texels", lambda: texels(ball, atlas, resolution))
    place = page.points.positions(ball)
    height = relief(place, 60.0)
    print(f"{'mapped':<28}{len(page) / resolution**2:8.1%}")
    tangents = timed("tangents", lambda: surface_tangents(ball, atlas), 2)
    normal_map(ball, atlas, page, height, tangents=tangents)
    ambient_occlusion(ball, atlas, page, height)
    normal = timed("normals", lambda: normal_map(ball, atlas, page, height, tangents=tangents), 3)
    sky = timed("ambient occlusion", lambda: ambient_occlusion(ball, atlas, page, height), 3)
    color = np.array([0.30, 0.16, 0.09]) * (1 + 2 * height[:, None])
    channels = {
        "base_color": color.astype(np.float32),
        "roughness": 0.5 - height,
        "normal": normal,
        "height": height,
        "ambient_occlusion": sky,
    }
    images = {name: page.image(values) for name, values in channels.items()}
    timed("base colour, PNG 8", lambda: png_bytes(srgb_codes(images["base_color"])), 3)
    timed("roughness, PNG 8", lambda: png_bytes(unit_codes(images["roughness"])), 3)
    timed("normal, PNG 16", lambda: png_bytes(normal_codes(images["normal"])), 3)
    maps = MapSet(images, ball, atlas, tangents, features={}, stem="ball")
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "height.exr"

        def exr():
            write_exr(target, images["height"])
            return target.read_bytes()

        timed("height, EXR 32", exr, 3)
        timed("five maps, GLB, report", lambda: maps.save(Path(folder) / "out"))
        size = sum(path.stat().st_size for path in (Path(folder) / "out").iterdir())
        print(f"{'on disk':<28}{size / 1e6:8.1f} MB")
    mesh = timed("displaced, 0.5 mm", lambda: displaced(ball, lambda s: np.zeros(len(s)), edge_mm=0.5))
    print(f"{'displaced faces':<28}{len(mesh.faces):8d}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
