"""Light in skin, in figures: truth of the walks, time of the thesis' precalculation, noise, matching, tables, look-up.

Run ``python -m benchmarks.optics [--quick]``. CPU-s is process time; wall time depends on who else is there.
"""

import argparse
import time
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
from scipy.interpolate import interpn

from surftex.optics import lookup, skin_types, slab
from surftex.optics.brdf import Absorbers, Bins, surface_lobe
from surftex.optics.colour import difference, lab
from surftex.optics.making import NODES, Making, make_table
from surftex.optics.matching import bin_geometry, bin_parts, match
from surftex.optics.nodes import nodes, straightened
from surftex.optics.paths import crossing_paths
from surftex.optics.shaders import SHADERS
from surftex.optics.spectra import rgb_weights
from surftex.optics.table import SkinTable
from surftex.optics.tissue import PARAMETERS, Tissue, absorption
from surftex.randomness import stream

THESIS = dict.fromkeys(PARAMETERS, 3)
WHITE = Tissue(base_albedo=1.0)
NM = np.arange(400, 701, 10.0)
SHINE = 0.045


class Clock:
    def __init__(self):
        self.wall, self.cpu = time.perf_counter(), time.process_time()

    def stop(self):
        self.wall, self.cpu = time.perf_counter() - self.wall, time.process_time() - self.cpu


@contextmanager
def clock():
    one = Clock()
    yield one
    one.stop()


def slabs(paths):
    print(f"slabs, {paths} photons: published, found, standard errors off")
    for name, medium, exact in (
        ("van de Hulst, Rd", (1.0, 10.0, 90.0, 0.75, 0.02), 0.09739),
        ("van de Hulst, Tt", (1.0, 10.0, 90.0, 0.75, 0.02), 0.66096),
        ("Giovanelli, R", (1.5, 10.0, 90.0, 0.0, np.inf), 0.2600),
        ("Chandrasekhar 0.9, R", (1.0, 1 / 9, 1.0, 0.0, np.inf), 0.414947),
    ):
        found = slab(*medium, paths)[name.endswith("Tt")]
        print(
            f"  {name:22} {exact:.5f} {found:.5f} {(found - exact) / np.sqrt(exact * (1 - exact) / paths):+.1f}"
        )


def biologies(count):
    """Random biology, even in what tables are even in, each (count,); the ranges of the design."""
    ranges = {
        "pheomelanin": (0, 0.5), "melanin": (0.005, 0.3), "epidermis_cm": (0.006, 0.02),
        "stratum_corneum_cm": (0.001, 0.004), "blood": (0.002, 0.05), "oxygenation": (0.3, 1),
    }  # fmt: skip
    numbers, result = stream(1, "held out").uniform(count, 6).T, {}
    for share, (name, ends) in zip(numbers, ranges.items(), strict=True):
        low, high = straightened(name, np.array(ends))
        value = low + share * (high - low)
        result[name] = value if PARAMETERS[name].even else np.exp(value)
    return result


def precalculation(paths):
    making = Making(
        engine="biospec", nodes=THESIS, crowded=False, paths=paths, beam_paths=0, tissue=WHITE, lock_surface=False
    )  # fmt: skip
    with clock() as whole:
        table = make_table(making)
    print(
        f"thesis' precalculation: 3^6 = 729 entries, BRDF of {making.bins.count} bins, fits, 31 x {paths} paths"
    )
    print(
        f"  {whole.cpu:.1f} CPU-s, {whole.wall:.1f} s (goal: 20 CPU-s, 120 s; the thesis: 22 h on two machines)"
    )
    biology = {name: each.usual for name, each in PARAMETERS.items()}
    with clock() as one:
        for nm in NM:
            thick = [biology["stratum_corneum_cm"], biology["epidermis_cm"], 0.02, 0.18]
            crossing_paths(WHITE, nm, paths, depth=absorption(WHITE, [nm], biology)[:, 0] * thick)
    print(
        f"  walked entry by entry: {one.cpu:.2f} CPU-s each, {729 * one.cpu / whole.cpu:.0f} times as long in all"
    )
    other = make_table(replace(making, seed=1))
    noise = (table.values - other.values)[..., :3].reshape(-1, 3) / np.sqrt(2)
    print(
        f"  noise of colour, two seeds: rms {np.sqrt((noise**2).mean(0)).round(5)}, most {np.abs(noise).max():.4f} "
        "(goal: rms 0.001)"
    )


def matching(paths):
    bins, count = Bins(), 243
    shares = stream(2, "depths").uniform(count, 3).T
    walked = crossing_paths(WHITE, 600.0, 31 * paths)
    step = bins.incident(walked.cosine)
    weight = walked.weight / np.bincount(step)[step] / bins.solid_angle
    total = np.zeros((bins.count, 1, count, 1))
    zero = np.zeros(1)
    Absorbers(zero, np.sort(3 * shares[0] ** 2), zero + 0.05, zero + 0.1).sums(
        walked, weight, bins.of(walked.cosine, walked.leaving), np.ones(1), total
    )
    brdf = bins.symmetric(total[:, 0, :, 0].T) + surface_lobe(Tissue(), bins)
    brdf = np.repeat(brdf[:, None], 3, axis=1) * np.array([1, 0.9, 0.8])[None, :, None]
    print(
        f"matching {count} sampled BRDFs of three channels: ms each, residual, albedo error rms and most, roughness, F0"
    )
    for name, shader in SHADERS.items():
        bin_parts(name, bins)
        with clock() as one:
            found = match(shader, bins, brdf)
        parts = [
            np.array(
                [part.reshape(bins.count, -1).mean(1) for part in shader.parts(shape, bin_geometry(bins))]
            )
            for shape in found.shape[:40]
        ]
        model = np.stack(
            [
                d[:, None] * part[0] + part[1] + level * part[2]
                for d, level, part in zip(found.diffuse, found.reflectance, parts, strict=False)
            ]
        )
        wrong = bins.albedo(model) - bins.albedo(brdf[:40])
        print(
            f"  {name:18} {1e3 * one.cpu / count:.3f} ms  {np.median(found.residual):.3f}  {np.sqrt((wrong**2).mean()):.4f} "
            f"{np.abs(wrong).max():.4f}  {np.median(shader.roughness(found.shape)):.3f}  {np.median(found.reflectance):.3f}"
        )


def colors(walked, biology):
    """Albedo of each biology (n, 3), straight from the paths."""
    result = np.zeros((len(biology["melanin"]), 3))
    for i in range(len(result)):
        one = {name: float(value[i]) for name, value in biology.items()}
        thick = np.array([one["stratum_corneum_cm"], one["epidermis_cm"], 0.02, 0.18])
        depth = absorption(WHITE, NM, one).T * thick
        albedo = [
            (paths.weight @ np.exp(-paths.lengths @ d)) / len(paths.kind)
            for paths, d in zip(walked, depth, strict=True)
        ]
        result[i] = np.array(albedo) @ rgb_weights(NM)
    return result


def tables(paths, held_out):
    """Reading between nodes against walking; same paths, so nothing here is noise."""
    from surftex.optics.tissue import corneum_absorption, dermis_absorption, epidermis_absorption

    walked = [crossing_paths(WHITE, nm, paths) for nm in NM]
    biology = biologies(held_out)
    exact = colors(walked, biology)
    print(f"tables against {held_out} held-out colours, same {paths} paths: entries, dE00 mean, 95 %, most")
    for title, counts, crowded in (
        ("3 even nodes, linear", THESIS, False),
        ("the package's nodes", NODES, True),
    ):
        axes = {name: nodes(name, counts[name], crowded=crowded) for name in PARAMETERS}
        p, m = np.meshgrid(axes["pheomelanin"], axes["melanin"], indexing="ij")
        b, o = np.meshgrid(axes["blood"], axes["oxygenation"], indexing="ij")
        e, s = axes["epidermis_cm"], axes["stratum_corneum_cm"]
        values = np.zeros((p.size * len(e), len(s), b.size, 3))
        for k, one in enumerate(walked):
            nm = NM[k : k + 1]
            pigment = epidermis_absorption(WHITE, nm, m, p).ravel()
            absorbers = Absorbers(
                corneum_absorption(WHITE, nm) * s,
                (pigment[:, None] * e).ravel(),
                dermis_absorption(WHITE, nm, b, o).ravel() * 0.02,
                dermis_absorption(WHITE, nm, 0.76 * b, o).ravel() * 0.18,
            )
            values += absorbers.albedo(one)[..., None] * rgb_weights(NM)[k]
        shape = (*p.shape, len(e), len(s), *b.shape)
        full = np.concatenate([values.reshape(*shape, 3), np.ones((*shape, 5))], axis=-1)
        table = SkinTable(full, {"nodes": counts, "crowded": crowded})
        if crowded:
            points = zip(*biology.values(), strict=True)
            read = np.array(
                [
                    table.at(dict(zip(biology, np.array(point)[:, None], strict=True))).ravel()[:3]
                    for point in points
                ]
            )
        else:
            read = interpn(tuple(axes.values()), full[..., :3], np.stack(list(biology.values()), axis=1))
        wrong = difference(lab(read + SHINE), lab(exact + SHINE))
        print(
            f"  {title:22} {np.prod(shape):6d}  {wrong.mean():.3f}  {np.quantile(wrong, 0.95):.3f}  {wrong.max():.3f}"
        )


def look_ups(count):
    biology = biologies(count)
    lookup({name: value[:1000] for name, value in biology.items()})
    with clock() as one:
        lookup(biology)
    print(f"look-up: {count / one.cpu / 1e6:.2f} million texels per CPU-s (goal: 3)")


def types():
    print("skin types: rms of the fit to the mean reflectance (goal: 0.010)")
    for name, each in skin_types().items():
        print(f"  {name:13} {each.rmse:.4f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer photons")
    small = 0.1 if parser.parse_args().quick else 1.0
    make_table(Making(nodes=dict.fromkeys(PARAMETERS, 1), paths=100, beam_paths=100))  # compile first
    crossing_paths(WHITE, 500.0, 10)
    slabs(int(1_000_000 * small))
    precalculation(int(100_000 * small))
    matching(int(64_000 * small))
    tables(int(8000 * small), 200)
    look_ups(int(3_000_000 * small))
    types()


if __name__ == "__main__":
    main()
