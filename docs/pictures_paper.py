"""Figures of Sakurai et al., made again: `python -m docs.pictures_paper [NAME ...]`, beside docs/make_pictures.py."""

import sys
import time

import numpy as np
from scipy.ndimage import binary_dilation, maximum_filter

import surftex as sx
from docs.make_pictures import save
from surftex.features.poisson import poisson_disk
from surftex.geodesics.directions import DirectionField
from surftex.preview.analyse import drawn
from surftex.preview.render import render
from surftex.preview.section import flat_section
from surftex.preview.sheet import contact_sheet
from surftex.preview.spectrum import fitted_ring, height_spectrum
from surftex.randomness import stream
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import plane


def greyed(height, low, high):
    """Height as grey."""
    return (255 * np.clip((height - low) / (high - low), 0, 1)).astype(np.uint8)


def disk_shape(side, across, up):
    """White on black, the region that a site keeps to itself; half axes in pixels."""
    row, column = np.mgrid[:side, :side] - (side - 1) / 2
    return (255.0 * (np.hypot(column / across, row / up) < 1)).astype(np.uint8)


def borders(region):
    """Where a pixel has another region to its right or below it."""
    edge = np.zeros(region.shape, bool)
    edge[:, :-1] |= region[:, 1:] != region[:, :-1]
    edge[:-1] |= region[1:] != region[:-1]
    return edge


def pixels_of(table, weights, surface, resolution):
    """Row and column at which features of a flat sheet lie on its maps."""
    points = SurfacePoints.trusted(np.ascontiguousarray(table["face"]), np.ascontiguousarray(table[weights]))
    low, high = surface.vertices.min(axis=0)[:2], surface.vertices.max(axis=0)[:2]
    place = (points.positions(surface)[:, :2] - low) / (high - low)
    column, row = np.clip((place * [1, -1] + [0, 1]) * resolution, 0, resolution - 1).astype(int).T
    return row, column


def figure_4():
    """Fig. 4: height cut at one depth. Wrinkles stay below it as solid lines, furrows between plates as broken ones.

    The paper does this by hand to a scanned hide; here it is a leather of ours whose furrows differ in depth.
    """
    surface, resolution = plane(12.0, cells=24), 1000
    layer = {
        "material": "leather", "preset": "calf", "wrinkle_density": 0, "wrinkle_count": 10, "wrinkle_length": "12 mm",
        "wrinkle_taper": "0 mm", "wrinkle_depth": "0.07 mm", "wrinkle_width": "0.22 mm", "wrinkle_angle": 80,
        "sulcus_depth": "0.055 mm", "waviness": 0.03,
        "pore_density": 0, "pocket_depth": "0 mm", "stress": "up",
    }  # fmt: skip
    recipe = {"surftex": 1, "fields": {"up": {"axis": [0.0, 1.0, 0.0]}}, "layer": [layer]}
    shown = ("height", "region")
    maps = sx.bake(surface, sx.Recipe.model_validate(recipe), resolution=resolution, seed=7, maps=shown)
    height, table = maps["height"], maps.features["wrinkle"]
    lines = np.zeros(height.shape, bool)
    first, last = (
        np.stack(pixels_of(table, end, surface, resolution), axis=1)
        for end in ("barycentric", "end_barycentric")
    )
    for share in np.linspace(0, 1, 60):
        row, column = np.rint(first + share * (last - first)).astype(int).T
        lines[row, column] = True
    near = binary_dilation(lines, iterations=12)
    furrows = borders(maps["region"]) & ~near
    depth = np.percentile(height[lines], 98)
    dark = height < depth
    placed = np.full((*height.shape, 3), 255, np.uint8)
    placed[borders(maps["region"])] = 150
    placed[binary_dilation(lines, iterations=2)] = (200, 40, 30)
    low, high = np.percentile(height, (0.5, 99.5))
    middle = slice(150, 850)
    pictures = [
        greyed(height, low, high)[middle, middle],
        (255 * ~dark).astype(np.uint8)[middle, middle],
        placed[middle, middle],
    ]
    print(
        f"below {depth:.3f} mm: {dark[lines].mean():.0%} of the wrinkles, {dark[furrows].mean():.0%} of the furrows"
    )
    labels = [
        "height, 8.4 mm",
        f"darker: below {depth:.3f} mm: {dark[lines].mean():.0%} of wrinkles, {dark[furrows].mean():.0%} of furrows",
        "placed: wrinkles red",
    ]
    save(contact_sheet(pictures, labels, columns=3), "figure-4")


def figure_10():
    """Fig. 10 of Sakurai et al.: sites that keep a disk and an ellipse to themselves, and their spectra."""
    surface = plane(20.0, cells=24)
    upright = DirectionField.from_axis(surface, (0.0, 1.0, 0.0))
    pictures, labels = [], []
    for label, ratio in (("disk", 1.0), ("ellipse, 5 to 3", 5 / 3)):
        sets = [
            poisson_disk(surface, 0.5 * np.sqrt(ratio), stream(seed, "docs"), ratio=ratio, direction=upright)
            for seed in range(8)
        ]
        size = 512
        power = np.zeros((size, size))
        for sites in sets:
            place = sites.points.positions(surface)[:, :2]
            pixel = np.clip(
                ((place - surface.vertices[:, :2].min(axis=0)) / 20.0 * size).astype(int), 0, size - 1
            )
            dots = np.zeros((size, size))
            np.add.at(dots, (size - 1 - pixel[:, 1], pixel[:, 0]), 1)
            power += np.abs(np.fft.fftshift(np.fft.fft2(dots - dots.mean()))) ** 2 / dots.sum() / len(sets)
            corner = np.kron(np.minimum(dots, 1)[:160, :160], np.ones((3, 3)))
            dot = maximum_filter(corner, footprint=np.hypot(*np.mgrid[-4:5, -4:5]) < 4.3)
            picture = 255 * (1 - dot)
        middle = power[size // 2 - 120 : size // 2 + 120, size // 2 - 120 : size // 2 + 120]
        pictures += [
            disk_shape(480, 72 / ratio**0.5, 72 * ratio**0.5),
            picture.astype(np.uint8),
            np.kron(np.clip(middle * 90, 0, 255), np.ones((2, 2))).astype(np.uint8),
        ]
        labels += [f"{label}: what a site keeps", f"{label}: sites", f"{label}: spectrum of 8 sets"]
    save(contact_sheet(pictures, labels, columns=3), "figure-10")


def figure_11():
    """Fig. 11: two groups of sites, long across on the left and upright on the right, one Voronoi diagram, one leather."""
    surface, resolution, side = plane(20.0, cells=24), 1080, 540
    left = surface.vertices[surface.faces].mean(axis=1)[:, 0] < np.median(surface.vertices[:, 0])
    grain = np.where(left[:, None], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    surface = surface.with_attributes({"grain": grain}, at="faces")
    layer = {
        "material": "leather", "preset": "sakurai-12a", "cell_ratio": 2.2, "cell_shape": "ellipse", "direction": "grain",
    }  # fmt: skip
    recipe = sx.Recipe.model_validate(
        {"surftex": 1, "fields": {"grain": {"vector_attribute": "grain"}}, "layer": [layer]}
    )
    shown = ("base_color", "roughness", "specular", "normal", "height", "region")
    maps = sx.bake(surface, recipe, resolution=resolution, seed=7, maps=shown)
    middle = slice((resolution - side) // 2, (resolution + side) // 2)
    dots = np.zeros((resolution, resolution), bool)
    dots[pixels_of(maps.features["cell"], "barycentric", surface, resolution)] = True
    dots = binary_dilation(dots, iterations=3)
    edge = binary_dilation(borders(maps["region"]))
    major, minor = 0.5 * side * 0.3 * 2.2**0.5, 0.5 * side * 0.3 / 2.2**0.5
    pictures = [
        disk_shape(side, major, minor),
        disk_shape(side, minor, major),
        (255 * ~dots).astype(np.uint8)[middle, middle],
        (255 * ~edge).astype(np.uint8)[middle, middle],
        render(maps, size=(side, side), view="front", light="raking", zoom=2.1, floor=False),
    ]
    labels = ["(a) left", "(b) right", "(c) sites, 10 mm", "(d) Voronoi", "(e) leather"]
    save(contact_sheet(pictures, labels, columns=3), "figure-11")


def figure_12():
    """Fig. 12 and 16 of Sakurai et al.: the twelve settings of Table 1, 500 pixels of 0.02 mm, as height and lit.

    Below them cracks from near: without, of 10 pixels, of 20, and what these cut out of the plates.
    """
    surface = plane(10.0, cells=24)
    heights, lit, labels = [], [], []
    near = {}
    for letter in "abcdefghijkl":
        layer = {"material": "leather", "preset": f"sakurai-12{letter}", "stress": "up"}
        recipe = sx.Recipe.model_validate(
            {"surftex": 1, "fields": {"up": {"axis": [0.0, 1.0, 0.0]}}, "layer": [layer]}
        )
        maps = sx.bake(surface, recipe, resolution=500, seed=7)
        heights.append(greyed(maps["height"][:320, :320], -0.08, 0.08))
        lit.append(render(maps, size=(320, 320), view="front", light="raking", zoom=1.8, floor=False))
        labels.append(f"12 ({letter})")
        if letter in "ahi":
            closer = sx.bake(surface, recipe, resolution=1250, seed=7, maps=("height",))
            near[letter] = closer["height"][:320, :320]
    rows = [greyed(each, -0.08, 0.08) for each in near.values()] + [greyed(near["a"] - near["i"], 0, 0.03)]
    beside = [f"({letter}) 2.5 times nearer" for letter in near] + ["what the cracks of (i) cut"]
    save(contact_sheet(heights + rows, labels + beside, columns=4), "figure-12")
    save(contact_sheet(lit, labels, columns=4), "figure-16")


def figure_15():
    """Fig. 15 and 14: height, its spectrum with the ring, and a section through furrows; round and long cells."""
    surface = plane(20.0, cells=24)
    rows = []
    for ratio, shape in ((1.0, "round"), (5 / 3, "ellipse")):
        layer = {
            "material": "leather", "preset": "sakurai-12a", "cell_ratio": ratio, "cell_shape": shape, "direction": "up",
        }  # fmt: skip
        recipe = sx.Recipe.model_validate(
            {"surftex": 1, "fields": {"up": {"axis": [0.0, 1.0, 0.0]}}, "layer": [layer]}
        )
        height = sx.bake(surface, recipe, resolution=768, seed=7, maps=("height",))["height"].astype(float)
        texel = 20.0 / 768
        spectrum = height_spectrum(height, texel)
        line = (300.0, 384.0, 420.0, 384.0)
        cut = flat_section(height, line[:2], line[2:], texel)
        rows.append(drawn(height, spectrum, fitted_ring(spectrum), cut, line))
    save(np.concatenate(rows), "figure-15")


PICTURES = {
    made.__name__.replace("_", "-"): made for made in (figure_4, figure_10, figure_11, figure_12, figure_15)
}

if __name__ == "__main__":
    for name in sys.argv[1:] or PICTURES:
        began = time.perf_counter()
        PICTURES[name]()
        print(f"{name}: {time.perf_counter() - began:.0f} s", flush=True)
