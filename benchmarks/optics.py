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


def one_by_one(making, biology):
    """Fill a single entry without reuse: absorption ends paths by chance, then its BRDF and its fit."""
    bins, brdf = making.bins, np.zeros((3, making.bins.count))
    thick = [biology["stratum_corneum_cm"], biology["epidermis_cm"], 0.02, 0.18]
    for nm, weights in zip(NM, rgb_weights(NM), strict=True):
        depth = absorption(WHITE, [nm], biology)[:, 0] * thick
        walked = crossing_paths(WHITE, nm, making.paths, depth=depth)
        step = bins.incident(walked.cosine)
        weight = walked.weight / np.bincount(step, minlength=bins.zenith)[step] / bins.solid_angle
        seen = np.bincount(bins.of(walked.cosine, walked.leaving), weight, minlength=bins.count)
        brdf += weights[:, None] * seen
    return match(SHADERS[making.shader], bins, bins.symmetric(brdf)[None])


def noise_ratio(biology, paths):
    """Variance of a colour, all channels together: paths that absorption ends, over paths that serve every absorber."""
    thick, sums = [biology["stratum_corneum_cm"], biology["epidermis_cm"], 0.02, 0.18], np.zeros(2)
    for nm, weights in zip(NM, rgb_weights(NM), strict=True):
        depth = absorption(WHITE, [nm], biology)[:, 0] * thick
        whole = crossing_paths(WHITE, nm, paths)
        ended = crossing_paths(WHITE, nm, paths, seed=1, depth=depth)
        reused = whole.weight * np.exp(-whole.lengths @ depth)
        sums += (weights**2).sum() * np.array([ended.weight.var(), reused.var()])
    return sums[0] / sums[1]


def precalculation(paths):
    making = Making(
        engine="biospec", nodes=THESIS, crowded=False, paths=paths, beam_paths=0, tissue=WHITE, fit_reflectance=True, facing=0.0
    )  # fmt: skip
    with clock() as whole:
        table = make_table(making)
    print(
        f"thesis' precalculation: 3^6 = 729 entries, BRDF of {making.bins.count} bins, fits, 31 x {paths} paths"
    )
    print(
        f"  {whole.cpu:.1f} CPU-s, {whole.wall:.1f} s (goal: 20 CPU-s, 120 s; the thesis: 22 h on two machines)"
    )
    values = biologies(4)
    entries = [{name: float(value[i]) for name, value in values.items()} for i in range(4)]
    with clock() as one:
        for each in entries:
            one_by_one(making, each)
    times = 729 * one.cpu / 4 / whole.cpu
    noisier = [noise_ratio(each, paths // 4) for each in entries]
    print(
        f"  entry by entry (walk, BRDF, fit): {one.cpu / 4:.2f} CPU-s each, {times:.0f} times as long in all for as many "
        f"photons;\n  their variance is {min(noisier):.1f} to {max(noisier):.1f} times ours: "
        f"{times * np.mean(noisier):.0f} times as long for the same noise (goal: 200)"
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


def annealing(paths):
    """The thesis' search against variable projection: what it costs, and how much worse it ends."""
    from scipy.optimize import dual_annealing

    bins, count = Bins(), 3
    lobe, shares = surface_lobe(Tissue(), bins), stream(2, "annealing").uniform(count, 3)
    walked = crossing_paths(WHITE, 600.0, 31 * paths)
    step = bins.incident(walked.cosine)
    weight = walked.weight / np.bincount(step)[step] / bins.solid_angle
    total, zero = np.zeros((bins.count, 1, count, 1)), np.zeros(1)
    Absorbers(zero, np.sort(2 * shares[:, 0]), zero + 0.05, zero + 0.1).sums(
        walked, weight, bins.of(walked.cosine, walked.leaving), np.ones(1), total
    )
    brdf = (bins.symmetric(total[:, 0, :, 0].T) + lobe)[:, None] * np.array([1, 0.9, 0.8])[None, :, None]
    print(f"annealing {count} of these, 3001 evaluations each: squares left over ours, ms")
    for name, shader in SHADERS.items():
        parts, places = bin_parts(name, bins), np.arange(len(shader.shapes))
        found, ratios = match(shader, bins, brdf), []
        with clock() as one:
            for n in range(count):

                def left(x, n=n, parts=parts, places=places):
                    low = min(int(x[0]), len(places) - 2)
                    part = parts[:, :, low] * (1 - x[0] + low) + parts[:, :, low + 1] * (x[0] - low)
                    model = x[2:, None] * part[:, 0] + part[:, 1] + x[1] * part[:, 2]
                    return ((model - brdf[n]) ** 2).sum()

                best = dual_annealing(
                    left, [(0, 95), (0, 1), (0, 1), (0, 1), (0, 1)], maxfun=3001, no_local_search=True, seed=n
                ).fun  # fmt: skip
                ratios.append(best / (found.residual[n] ** 2 * (brdf[n] ** 2).sum()))
        print(f"  {name:18} {min(ratios):.2f} to {max(ratios):.2f}, {1e3 * one.cpu / count:.0f} ms")


def folds(rays):
    """How well each model takes the bare surface, over facets of GGX and over those of the thesis."""
    bins = Bins()
    print("the bare surface alone, residual over facets of GGX, and of the thesis (cubed denominator)")
    lobes = [surface_lobe(Tissue(facets=facets), bins, rays=rays) for facets in ("ggx", "biospec")]
    for name, shader in SHADERS.items():
        left = match(shader, bins, np.array(lobes)[:, None].repeat(3, 1)).residual
        print(f"  {name:18} {left[0]:.3f}  {left[1]:.3f}")


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
    annealing(int(20_000 * small))
    folds(int(2_000_000 * small))
    tables(int(8000 * small), 200)
    look_ups(int(3_000_000 * small))
    types()


if __name__ == "__main__":
    main()
