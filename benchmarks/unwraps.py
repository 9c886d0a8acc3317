"""The same leather under two unwraps: ``python -m benchmarks.unwraps MESH [--size 4096] [--cells 5000]``.

Height is looked up bilinearly at 100,000 places of the surface in two bakes, one unwrapped by xatlas, one by uvunwrap.
Printed are quantiles of the difference as shares of the relief's rms, what bilinear lookup alone gets wrong in each (the
pattern itself says what is right), and how much the pattern differs when asked with the texels of one unwrap and the other.
"""

import argparse

import numpy as np

import surftex as sx
from benchmarks.leather import sized
from surftex.bake.bake import run
from surftex.charts.lookup import bilinear
from surftex.features.uniform import scatter
from surftex.randomness import stream
from surftex.recipe.model import Recipe
from surftex.surface.points import Samples

PLACES = 100_000


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("mesh")
    parser.add_argument("--size", type=int, default=4096)
    parser.add_argument("--cells", type=int, default=5000)
    options = parser.parse_args()
    surface = sx.load(options.mesh, size="300 mm")
    leather = sized(surface, options.cells)
    places = scatter(surface, stream(0, "benchmark"), count=PLACES)
    heights, patterns = [], []
    for unwrapper in ("xatlas", "uvunwrap"):
        recipe = Recipe.of(
            leather, resolution=options.size, maps=("height",), uv="unwrap", unwrapper=unwrapper
        )
        baked = run(recipe, surface)
        atlas = baked.maps.atlas
        uv = np.einsum("pk,pkc->pc", places.barycentric, atlas.corner_uv[places.face])
        heights.append(bilinear(baked.maps["height"], uv))
        jacobian = atlas.jacobian_mm(surface, options.size)
        side = np.sqrt(np.abs(np.linalg.det(jacobian)))[places.face]
        right = baked.stack.at(Samples(places, side.astype(np.float32)), ("height_mm",))["height_mm"]
        patterns.append(right)
        relief = float(right.std())
        report("bilinear error, " + unwrapper, heights[-1] - right, relief)
        print(f"  {len(baked.maps.features['cell'])} cells, {1 / np.median(side):.2f} texels per mm, "
              f"{atlas.chart_count} charts, relief {relief:.5f} mm rms")  # fmt: skip
        del baked
    report("difference of the maps", heights[0] - heights[1], relief)
    report("difference of the pattern", patterns[0] - patterns[1], relief)


def report(name, difference, relief):
    """Print quantiles as shares of the relief."""
    shares = np.quantile(np.abs(difference), (0.5, 0.9, 0.99, 0.999)) / relief
    within = float((np.abs(difference) <= 0.01 * relief).mean())
    print(f"{name:<28}" + "  ".join(f"{share:.4%}" for share in shares)
          + f"  (at 50, 90, 99, 99.9 %); within 1 %: {within:.2%}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
