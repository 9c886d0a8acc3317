"""Learnt textures: `python -m benchmarks.composite [pictures|speed|surface|choices|seams|angles|specks]`; all without a name.

Pictures: metrics of what was drawn, as multiples of those between two halves of the exemplar; all methods learn from the
left half alone. Beside them own quilting, which copies, and Portilla and Simoncelli's statistics where `SURFTEX_PLENOPTIC`
names a Python that has plenoptic (`benchmarks/portilla_simoncelli.py`). Coherence is told against more halves of the
exemplar too: how much of a photograph looks copied from the rest of it. Speed: CPU seconds for a megapixel, learning and
drawing in all. Surface: a million pixels on a sphere. Choices: what selection against noise, forced near pairs, and layouts
from coarse to fine do. Seams: how much more pairs over seams differ from the others than pairs over borders of random cells
do; eight drawings, six sets of cells; by chance: the same of one set of cells against the others. Angles: whether pixels
that touch differ as much wherever the direction field turns against the lattice. Specks: how loosely
a composite's tints are tied to its light. Times are of this process, all threads, warm.

Goals: near <= 1.1, pattern1 <= 2.3 and pattern2 <= 1.3 (gravel), coherence <= 1.2, largest piece <= 64 pixels; pairs <= 20
and quads <= 100 CPU-s per megapixel in all; a million pixels on a surface, pairs, <= 120 s wall on two threads, 80 neighbours
of each found in 6 s; spread by angle <= 1.35.
"""

import os
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.ndimage import median_filter
from scipy.spatial import cKDTree

import surftex as sx
from benchmarks import portilla_simoncelli
from benchmarks.quilting import quilt
from docs.made_exemplars import breccia, ground
from surftex.charts.surface_lattice import SurfaceLattice
from surftex.exemplar import learn
from surftex.exemplar.lattice import Table
from surftex.exemplar.metrics import copying
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


def weave():
    """A quarter of the size of a photograph of gingham, (256, 256, 3)."""
    picture = Image.open(SHARED / "fabric_pattern_07_col.jpg").convert("RGB")
    small = picture.resize((picture.width // 4, picture.height // 4), Image.Resampling.BOX)
    return np.ascontiguousarray(np.asarray(small)[:256, :256])


def timed(work):
    """What a call gives, its CPU seconds and its wall seconds."""
    cpu, wall = time.process_time(), time.perf_counter()
    result = work()
    return result, time.process_time() - cpu, time.perf_counter() - wall


def pictures():
    if portilla_simoncelli.peer() is None:
        print("Portilla and Simoncelli: left out; SURFTEX_PLENOPTIC names a Python that has plenoptic")
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
        if portilla_simoncelli.peer() is not None:
            ways["Portilla-Simoncelli"] = lambda left=left: portilla_simoncelli.draw(left, 1)
        for way, work in ways.items():
            drawn, cpu, _ = timed(work)
            if isinstance(drawn, tuple):
                drawn, cpu = drawn
            found = sx.metrics(drawn, left)
            ratio = [found[key] / natural[key] for key in METRICS[:-1]]
            row = "".join(f"{each:>12.2f}" for each in ratio) + f"{found['largest_px']:>12.0f}"
            unseen = copying(drawn, right)[0] / natural["coherence"]
            print(
                f"{'  ' + way:<26}{row}{1e6 * cpu / drawn.size:>10.1f}  coherence with the half not learnt from {unseen:.2f}",
                flush=True,
            )
        print_halves(whole, natural["coherence"])


def print_halves(whole, natural):
    """Coherence of halves of an exemplar with each other, in multiples of that of its right half with its left."""
    found = []
    for turned in (whole, np.roll(whole, 64, axis=1), whole.T):
        one, other = (np.ascontiguousarray(each) for each in (turned[:, :128], turned[:, 128:]))
        found += [copying(one, other)[0] / natural, copying(other, one)[0] / natural]
    print("  coherence of other halves of it: " + " ".join(f"{each:.2f}" for each in found), flush=True)


def speed():
    print("a megapixel from 256 x 256, learning and drawing in all")
    for name, order, whole in (
        ("gravel, pairs", "pair", exemplar("gravel_skimage.png")), ("gravel, fours", "quad", exemplar("gravel_skimage.png")),
        ("gingham in colour, pairs", "pair", weave()), ("gingham in colour, fours", "quad", weave()),
    ):  # fmt: skip
        sx.learn_texture(whole[:64, :64], order=order).synthesize(64, 64, sweeps=2)
        model, learnt, _ = timed(lambda whole=whole, order=order: sx.learn_texture(whole, order=order))
        _, drawn, wall = timed(lambda model=model: model.synthesize(1000, 1000, 1))
        print(
            f"  {name:<26}{model.nbytes:>8} bytes  learn {learnt:6.2f}  draw {drawn:6.2f}  in all {learnt + drawn:6.2f} CPU-s"
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
    lattice = SurfaceLattice.of(ball, DirectionField.smoothest(ball), pitch, threads=2)
    square = np.array(
        [(x, y) for y in range(-24, 25) for x in range(-24, 25) if 0 < np.hypot(x, y) <= 24], np.int32
    )
    offset = square[np.random.default_rng(0).choice(len(square), 80, replace=False)]
    _, walked, wall = timed(lambda: lattice.table(offset, stream(0, "steps"), threads=2))
    print(
        f"{len(lattice)} pixels x {len(offset)} offsets: walks {walked:.1f} CPU-s, {wall:.1f} s (goal 6)",
        flush=True,
    )


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
        for name, turn, change in (
            ("charts along the field", 0.0, np.copy), ("charts at 45 degrees", np.pi / 4, np.copy),
            ("steps that lead back", 0.0, lambda table: leading_back(offset, table)),
        ):  # fmt: skip
            lattice = SurfaceLattice.of(body, up.turned(turn), 0.4)
            lattice = replace(lattice, angle_rad=lattice.angle_rad - turn)
            table = Table(offset, change(lattice.table(offset, stream(0, "steps"))))
            crossing = crossings(lattice, table)
            found = [seam_ratio(crossing, model.levels_on(table, seed)[0]) for seed in range(1, 9)]
            ratio, chance = np.array([each[0] for each in found]), np.concatenate([each[1] for each in found])
            print(
                f"{body.name:<8}{name:<26}{len(lattice):>8} pixels  seam ratio {ratio.mean():.2f} +- "
                f"{ratio.std() / np.sqrt(len(ratio)):.2f}, from {ratio.min():.2f} to {ratio.max():.2f}; by chance from "
                f"{chance.min():.2f} to {chance.max():.2f}", flush=True,
            )  # fmt: skip


def angles():
    model = sx.learn_texture(exemplar("gravel_skimage.png"), order="pair")
    offset = asked_offsets(model.target)
    for body in (sphere(40.0, subdivisions=4), torus(28.0, 12.0)):
        up = DirectionField.smoothest(body)
        for name, turn in (("charts along the field", 0.0), ("charts at 45 degrees", np.pi / 4)):
            lattice = SurfaceLattice.of(body, up.turned(turn), 0.2)
            lattice = replace(lattice, angle_rad=lattice.angle_rad - turn)
            table = Table(offset, lattice.table(offset, stream(0, "steps")))
            level = model.levels_on(table, 1)[0][:-1].astype(float)
            place = lattice.points.positions(body)
            there = cKDTree(place).query(place, k=3)[1][:, 1:]
            softness = np.abs(level[:, None] - level[there]).mean(axis=1)
            part = np.degrees(lattice.angle_rad) % 90 // 10
            mean = [softness[part == each].mean() for each in range(9) if (part == each).sum() > 300]
            print(
                f"{body.name:<8}{name:<26}{len(lattice):>8} pixels  next pixels by the angle of the frame, from "
                f"{min(mean):.2f} to {max(mean):.2f}: spread {max(mean) / min(mean):.2f}", flush=True,
            )  # fmt: skip


def specks():
    picture, label = ground()
    painted = np.ascontiguousarray(label[:224, :224])
    for order in ("pair", "quad"):
        model = sx.learn_composite(picture, label, order=order)
        low, high = np.percentile(picture @ model.bands.axes, (0.5, 99.5), axis=(0, 1))
        drawn = {f"{order}, {sweeps} sweeps": model.synthesize(224, 224, 1, labels=painted, sweeps=sweeps)
                 for sweeps in (model.sweeps, 4 * model.sweeps)[: 2 if order == "pair" else 1]}  # fmt: skip
        for name, shown in {"exemplar": picture[:224, :224], **drawn}.items():
            level = np.clip(32 * (shown @ model.bands.axes - low) / (high - low), 0, 31).astype(int)
            level = np.moveaxis(level, -1, 0)
            light, *tints = (each[painted == 2] for each in level)
            common = np.flatnonzero(np.bincount(light) > 20)
            stray = [np.sqrt(np.mean([tint[light == each].var() for each in common])) for tint in tints]
            alone = np.abs(level[1] - median_filter(level[1], 3))[painted == 2] >= 3
            print(
                f"stones of the ground, {name:<18} a tint strays {stray[0]:.2f} and {stray[1]:.2f} levels around what its "
                f"light says; alone {100 * alone.mean():.2f} %", flush=True,
            )  # fmt: skip


def leading_back(offset, table):
    """A table whose steps back are those forth, the other way round, wherever some step forth led to a site."""
    table, count = table.copy(), len(table) - 1
    column = {tuple(map(int, each)): at for at, each in enumerate(offset)}
    for (right, down), at in column.items():
        back = column.get((-right, -down))
        if (down, right) <= (0, 0) or back is None:
            continue
        come = np.full(count + 1, -1)
        come[table[:-1, at]] = np.arange(count)
        table[:-1, back] = np.where(come[:-1] >= 0, come[:-1], table[:-1, back])
    return table


def crossings(lattice, table):
    """For short steps: sites, where they lead, whether over a seam, and whether over borders of each set of cells."""
    chart = lattice.atlas.chart[lattice.points.face]
    place, random = lattice.points.positions(lattice.surface), np.random.default_rng(0)
    middle = [place[random.choice(len(place), 30, replace=False)] for _ in range(6)]
    cells = [np.linalg.norm(place[:, None] - each, axis=2).argmin(axis=1) for each in middle]
    found = []
    for step in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (-1, 1)):
        for column in np.flatnonzero((table.offset == step).all(axis=1)):
            there = table.table[:-1, column]
            site = np.flatnonzero(there < len(lattice))
            there = there[site]
            found.append(
                (site, there, chart[site] != chart[there], [each[site] != each[there] for each in cells])
            )
    return found


def seam_ratio(crossing, level):
    """Mean distance of pairs over seams by that over borders of cells, and such ratios of one set of cells each."""
    seam, border = [], []
    for site, there, over, pretended in crossing:
        difference = level[there].astype(int) - level[site] + 31
        known = np.bincount(difference[~over], minlength=63) / (~over).sum()
        count = min(2000, over.sum(), *((each & ~over).sum() for each in pretended))
        some = [np.flatnonzero(each) for each in (over, *(each & ~over for each in pretended))]
        some = [difference[each[np.arange(count) * len(each) // count]] for each in some]
        far = [np.linalg.norm(np.bincount(each, minlength=63) / count - known) for each in some]
        seam.append(far[0])
        border.append(far[1:])
    border = np.mean(border, axis=0)
    others = (border.sum() - border) / (len(border) - 1)
    return float(np.mean(seam) / border.mean()), border / others


if __name__ == "__main__":
    chosen = sys.argv[1:] or ["pictures", "speed", "surface", "choices", "seams", "angles", "specks"]
    print("load of the machine", *(f"{each:.1f}" for each in os.getloadavg()))
    for name in chosen:
        {
            "pictures": pictures,
            "speed": speed,
            "surface": surface,
            "choices": choices,
            "seams": seams,
            "angles": angles,
            "specks": specks,
        }[name]()
