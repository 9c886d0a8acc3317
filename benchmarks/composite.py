"""Learnt textures: `python -m benchmarks.composite [pictures|speed|surface|choices|seams]`; all of them without a name.

Pictures: metrics of what was drawn, as multiples of those between two halves of the exemplar; all methods learn from the
left half alone. Beside them own quilting, which copies. Speed: CPU seconds for a megapixel, learning and drawing in all.
Surface: a million pixels on a sphere. Choices: what selection against noise, forced near pairs, and layouts from coarse
to fine do. Seams: how much more pairs over seams differ from the others than pairs over borders of random cells do.
Times are of this process, all threads, warm.

Goals: near <= 1.1, pattern1 <= 2.3 and pattern2 <= 1.3 (gravel), coherence <= 1.2, largest piece <= 64 pixels; pairs <= 20
and quads <= 100 CPU-s per megapixel in all; a million pixels on a surface, pairs, <= 120 s wall on two threads.
"""

import os
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

import surftex as sx
from benchmarks.quilting import quilt
from docs.made_exemplars import breccia
from surftex.charts.surface_lattice import SurfaceLattice
from surftex.exemplar import learn
from surftex.exemplar.lattice import Table
from surftex.exemplar.relaxation import asked_offsets
from surftex.geodesics.directions import DirectionField
from surftex.randomness import stream
from surftex.surface.shapes import sphere, torus

SHARED = Path(os.environ.get("SURFTEX_SHARED", Path(__file__).resolve().parents[2] / "shared")) / "exemplars"
METRICS = ("near", "pattern1", "pattern2", "gabor", "coherence", "largest_px")


def exemplar(name):
    """Half the size of a grey exemplar of 512 x 512."""
    picture = np.asarray(Image.open(SHARED / name).convert("L"), np.float64)
    return picture.reshape(256, 2, 256, 2).mean(axis=(1, 3)).round().astype(np.uint8)


def timed(work):
    """What a call gives, its CPU seconds and its wall seconds."""
    cpu, wall = time.process_time(), time.perf_counter()
    result = work()
    return result, time.process_time() - cpu, time.perf_counter() - wall


def pictures():
    print(f"{'':<26}" + "".join(f"{name:>12}" for name in METRICS) + f"{'CPU-s/MP':>10}")
    for name in ("gravel_skimage.png", "brick_skimage.png"):
        if not (SHARED / name).exists():
            print(f"{name}: not in {SHARED}; SURFTEX_SHARED names the folder above it")
            continue
        whole = exemplar(name)
        left, right = np.ascontiguousarray(whole[:, :128]), np.ascontiguousarray(whole[:, 128:])
        natural = sx.metrics(right, left)
        ways = {"quilting": lambda left=left: quilt(left, 128, 256, 1)}
        for order in ("pair", "quad"):
            ways[order] = lambda left=left, order=order: sx.learn_texture(left, order=order).synthesize(
                128, 256, 1
            )
        print(
            f"{name.split('_')[0] + ', right half':<26}"
            + "".join(f"{natural[key]:>12.4f}" for key in METRICS)
        )
        for way, work in ways.items():
            drawn, cpu, _ = timed(work)
            found = sx.metrics(drawn, left)
            ratio = [found[key] / natural[key] for key in METRICS[:-1]]
            row = "".join(f"{each:>12.2f}" for each in ratio) + f"{found['largest_px']:>12.0f}"
            print(f"{'  ' + way:<26}{row}{1e6 * cpu / drawn.size:>10.1f}", flush=True)


def speed():
    print("a megapixel of gravel from 256 x 256, learning and drawing in all")
    whole = exemplar("gravel_skimage.png")
    for order in ("pair", "quad"):
        sx.learn_texture(whole, order=order).synthesize(64, 64, sweeps=2)
        model, learnt, _ = timed(lambda order=order: sx.learn_texture(whole, order=order))
        _, drawn, wall = timed(lambda model=model: model.synthesize(1000, 1000, 1))
        print(
            f"  {order:<8}{model.nbytes:>8} bytes  learn {learnt:6.2f}  draw {drawn:6.2f}  in all {learnt + drawn:6.2f} CPU-s"
            f"  ({wall:.1f} s wall)", flush=True,
        )  # fmt: skip


def surface():
    ball = sphere(100.0, subdivisions=5)
    pitch = float(np.sqrt(ball.area_mm2 / 1e6))
    whole = exemplar("gravel_skimage.png")
    for order in ("pair", "quad"):
        model = sx.learn_texture(whole, order=order)
        offset = asked_offsets(model.target)

        def lay(pitch=pitch, offset=offset):
            lattice = SurfaceLattice.of(ball, DirectionField.smoothest(ball), pitch, threads=2)
            return Table(offset, lattice.table(offset, stream(0, "steps"), threads=2))

        lay(20 * pitch)
        table, laid, wall = timed(lay)
        print(
            f"{order}: {len(table.site)} pixels, {len(offset)} offsets; lattice and walks {laid:.1f} CPU-s, {wall:.1f} s",
            flush=True,
        )
        _, drawn, wall = timed(lambda model=model, table=table: model.levels_on(table, 0, threads=2))
        print(f"  {model.sweeps} sweeps {drawn:.1f} CPU-s, {wall:.1f} s wall on two threads", flush=True)


def choices():
    whole = exemplar("gravel_skimage.png")
    left, right = np.ascontiguousarray(whole[:, :128]), np.ascontiguousarray(whole[:, 128:])
    natural = sx.metrics(right, left)
    usual, first = learn._CERTAIN, learn.first_pairs
    near = np.array([(0, 0, 1, 1), (0, 0, -1, 1), (0, 0, 2, 0), (0, 0, 0, 2)], np.int32)
    print(
        f"{'gravel, 30 pairs, to natural':<34}{'pairs':>6}{'longest':>9}{'near':>8}{'pattern1':>10}{'pattern2':>10}"
    )
    for name, certain, forced in (
        ("farther off than twice the noise", usual, False), ("farthest off, whatever the noise", 0.0, False),
        ("twice the noise, near pairs forced", usual, True),
    ):  # fmt: skip
        learn._CERTAIN = certain
        learn.first_pairs = (lambda bands: np.concatenate([first(bands), near])) if forced else first
        model = sx.learn_texture(left, order="pair")
        found = [sx.metrics(model.synthesize(128, 256, seed), left) for seed in (1, 2)]
        ratio = [np.mean([each[key] for each in found]) / natural[key] for key in METRICS[:3]]
        longest = np.abs(model.target.pair_type[:, 2:]).max(axis=1).mean()
        print(
            f"{name:<34}{len(model.target.pair_type):>6}{longest:>9.1f}{ratio[0]:>8.2f}{ratio[1]:>10.2f}{ratio[2]:>10.2f}",
            flush=True,
        )
    learn._CERTAIN, learn.first_pairs = usual, first
    label = breccia()[1]
    label[label == 3] = 0
    model = sx.learn_labels(label)
    pieces = [
        count_pieces(label),
        *(
            np.mean([count_pieces(each.synthesize(320, 320, seed)) for seed in (1, 2)])
            for each in (model, sx.LabelModel(model.targets[-1:]))
        ),
    ]
    print(
        f"stones of a breccia in 320 x 320: exemplar {pieces[0]:.0f}, from coarse to fine {pieces[1]:.0f}, "
        f"at one scale {pieces[2]:.0f}"
    )  # fmt: skip


def count_pieces(label):
    """Connected pieces of any label but the first, of 30 pixels or more."""
    from scipy.ndimage import label as connected

    return sum(
        int((np.bincount(connected(label == each)[0].ravel())[1:] >= 30).sum())
        for each in range(1, label.max() + 1)
    )


def seams():
    model = sx.learn_texture(exemplar("gravel_skimage.png"), order="pair")
    offset = asked_offsets(model.target)
    for body in (sphere(40.0, subdivisions=4), torus(28.0, 12.0)):
        up = DirectionField.smoothest(body)
        for name, turn in (("charts along the field", 0.0), ("charts at 45 degrees", np.pi / 4)):
            lattice = SurfaceLattice.of(body, up.turned(turn), 0.4)
            lattice = replace(lattice, angle_rad=lattice.angle_rad - turn)
            table = Table(offset, lattice.table(offset, stream(0, "steps")))
            ratios = [seam_ratio(lattice, table, model.levels_on(table, seed)) for seed in (1, 2)]
            print(
                f"{body.name:<8}{name:<26}{len(lattice):>8} pixels  seam ratio "
                + " ".join(f"{each:.2f}" for each in ratios)
            )


def seam_ratio(lattice, table, level):
    """Mean over short pairs of the distance of those over seams, by that of those over borders of random cells."""
    chart = lattice.atlas.chart[lattice.points.face]
    place = lattice.points.positions(lattice.surface)
    cell = np.linalg.norm(place[:, None] - place[len(place) // 80 :: len(place) // 30], axis=2).argmin(axis=1)
    far = []
    for step in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (-1, 1)):
        column = np.flatnonzero((table.offset == step).all(axis=1))
        if len(column) == 0:
            continue
        there = table.table[:-1, column[0]]
        site = np.flatnonzero(there < len(lattice))
        difference = level[0, there[site]].astype(int) - level[0, site] + 31
        crossing, pretended = chart[site] != chart[there[site]], cell[site] != cell[there[site]]
        known = np.bincount(difference[~crossing & ~pretended], minlength=63)
        some = [difference[crossing], difference[~crossing & pretended]]
        count = min(map(len, some))
        some = [
            np.bincount(each[np.arange(count) * len(each) // count], minlength=63) / count for each in some
        ]
        far.append([np.linalg.norm(each - known / known.sum()) for each in some])
    return float(np.divide(*np.mean(far, axis=0)))


if __name__ == "__main__":
    chosen = sys.argv[1:] or ["pictures", "speed", "surface", "choices", "seams"]
    print("load of the machine", *(f"{each:.1f}" for each in os.getloadavg()))
    for name in chosen:
        {"pictures": pictures, "speed": speed, "surface": surface, "choices": choices, "seams": seams}[name]()
