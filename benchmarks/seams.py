"""What is left of seams on real leather: ``python -m benchmarks.seams MESH ... [--size 1024] [--own]``.

Calf is baked at 24 texels a cell. Height in mm and normals as directions in space are looked up bilinearly from both
sides of every seam, and at places inside charts, where the pattern itself says what is right: at mip k the pattern as
seen by texels 2^k times as large. Printed are root mean squares at mips 0, 1 and 2, and their ratio; without
and with `equalise`. `--own` keeps the file's UVs.
"""

import argparse

import numpy as np
from scipy.ndimage import binary_erosion

import surftex as sx
from surftex.bake.bake import run
from surftex.charts.lookup import bilinear, half
from surftex.charts.seams import seam_samples
from surftex.charts.texels import texels
from surftex.features.uniform import scatter
from surftex.maps.normal import object_normals
from surftex.randomness import stream
from surftex.recipe.model import Recipe
from surftex.surface.points import Samples, SurfacePoints

TEXELS_A_CELL = 24
COVERED = 0.6
PLACES = 40_000


def sized(path, resolution):
    """Load a mesh at the size where a cell of calf takes `TEXELS_A_CELL` texels."""
    side = np.ptp(sx.load(path, size="300 mm").vertices, axis=0).max()
    density = resolution * np.sqrt(COVERED / sx.load(path, size="300 mm").area_mm2)
    return sx.load(path, size=float(side * density * 0.7 / TEXELS_A_CELL))


def slope(pattern, surface, points, footprint_mm):
    """Gradient of the height in the frame of each point's face, by steps within the face."""
    step = 0.02 * footprint_mm
    flat, frame = surface.flat[points.face], points.flat(surface)
    inverse = np.linalg.inv(np.stack([flat[:, 1], flat[:, 2]], axis=2))
    rise = []
    for axis in (0, 1):
        ends = []
        for sign in (-1.0, 1.0):
            place = frame.copy()
            place[:, axis] += sign * step
            weight = np.einsum("pij,pj->pi", inverse, place)
            weight = np.concatenate([1 - weight.sum(axis=1, keepdims=True), weight], axis=1)
            there = SurfacePoints.trusted(points.face, weight)
            ends.append(height_at(pattern, there, footprint_mm))
        rise.append((ends[1] - ends[0]) / (2 * step))
    return np.stack(rise, axis=1)


def height_at(stack, points, footprint_mm):
    return stack.at(Samples(points, footprint_mm.astype(np.float32)), ("height_mm",))["height_mm"].astype(
        float
    )


def bent(surface, points, gradient):
    """Shading normal bent by a gradient, as `surftex.maps.normal` defines it."""
    shading = np.einsum("pk,pki->pi", points.barycentric, surface.shading_normal[points.face])
    shading /= np.linalg.norm(shading, axis=1, keepdims=True)
    frame = surface.frame[points.face]
    tilted = np.einsum("pk,pki->pi", gradient, frame[:, :2])
    half_way = frame[:, 2] + shading
    share = (tilted * shading).sum(axis=1) / np.maximum((half_way * shading).sum(axis=1), 0.1)
    normal = shading - (tilted - share[:, None] * half_way)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def rms(difference):
    difference = difference if difference.ndim > 1 else difference[:, None]
    return float(np.sqrt((difference**2).sum(axis=1).mean()))


def measure(baked, resolution):
    """Jumps and errors per map and mip."""
    surface, atlas, stack = baked.maps.surface, baked.maps.atlas, baked.stack
    page = texels(surface, atlas, resolution)
    core = np.zeros((resolution, resolution), bool)
    core.ravel()[page.texel[page.core]] = True
    points = scatter(surface, stream(0, "benchmark"), count=PLACES)
    inside = points.barycentric.min(axis=1) > 0.03
    points = SurfacePoints.trusted(points.face[inside], points.barycentric[inside])
    uv = np.einsum("pk,pkc->pc", points.barycentric, atlas.corner_uv[points.face])
    side = np.bincount(page.host, page.footprint_mm, len(surface.faces)) / np.maximum(
        np.bincount(page.host, minlength=len(surface.faces)), 1
    )
    samples = seam_samples(surface, atlas, resolution)
    tangents = baked.maps.tangents

    def told(values, places):
        return object_normals(surface, tangents, places.face, places.barycentric, values)

    rows = {}
    for name in ("height", "normal"):
        image, row = baked.maps[name], []
        for level in range(3):
            if level:
                image = half(image)
            kept = binary_erosion(core, iterations=3 << level)
            column = np.clip((uv[:, 0] * resolution).astype(int), 0, resolution - 1)
            line = np.clip(((1 - uv[:, 1]) * resolution).astype(int), 0, resolution - 1)
            chosen = np.flatnonzero(kept[line, column] & (side[points.face] > 0))
            places = SurfacePoints.trusted(points.face[chosen], points.barycentric[chosen])
            footprint = side[places.face] * 2**level
            seen = bilinear(image, uv[chosen])
            if name == "height":
                here, there = bilinear(image, samples.here_uv), bilinear(image, samples.there_uv)
                right = height_at(stack, places, footprint)
            else:
                right = bent(surface, places, slope(stack, surface, places, footprint))
                seen = told(seen, places)
                soft = samples.soft()
                here = told(bilinear(image, soft.here_uv), soft.here)
                there = told(bilinear(image, soft.there_uv), soft.there)
            row.append((rms(here - there), rms(seen - right)))
        rows[name] = row
    return rows


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("mesh", nargs="+")
    parser.add_argument("--size", type=int, default=1024)
    parser.add_argument("--own", action="store_true")
    options = parser.parse_args()
    for path in options.mesh:
        surface = sized(path, options.size)
        for equalise in (False, True):
            recipe = Recipe.of(
                sx.Leather.preset("calf"),
                resolution=options.size,
                maps=("height", "normal"),
                uv="auto" if options.own else "unwrap",
                unwrapper="uvunwrap",
                equalise=equalise,
            )
            baked = run(recipe, surface)
            for name, row in measure(baked, options.size).items():
                numbers = "   ".join(f"{jump:.5f} / {error:.5f} = {jump / error:5.2f}" for jump, error in row)
                print(
                    f"{surface.name:<24}{name:<8}{'equalised' if equalise else '':<10}{numbers}", flush=True
                )
            if "equalised" in baked.maps.report:
                print(f"  {baked.maps.report['equalised']}")
                print([s for s in baked.maps.report["stages"] if s["name"] == "equalise"])


if __name__ == "__main__":
    main()
