"""Distances beside their peers: ``python -m benchmarks.geodesics [MESH ...]``.

Meshes are files that surftex loads; the head of ``meshes/``, cut in four, without any. Seconds of processor time on one
thread, ours and the peers' in the same run. libigl's exact geodesics are the truth; every point is inserted as a vertex
for them. The goals are listed last, met or not. Paths and Bézier curves beside EdgeFlip are in ``benchmarks.paths``, the
jump of maps at seams in ``benchmarks.seams``, the heat method's order in ``tests/geodesics/test_heat.py``.
"""

import sys
import time
from pathlib import Path

import igl
import numpy as np
import potpourri3d

from surftex.features.poisson import poisson_disk
from surftex.files.meshes import load
from surftex.geodesics.bounds import nearest_bound
from surftex.geodesics.windows import flood_points, nearest, within
from surftex.randomness import stream
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import midpoint_subdivided
from surftex.surface.surface import Surface

NONE = np.zeros(0, np.int64)


def scattered(surface, count, seed):
    """Points, even by area, sorted by face."""
    random = np.random.default_rng(seed)
    face = np.sort(random.choice(len(surface.faces), count, p=surface.face_area_mm2 / surface.area_mm2))
    return SurfacePoints(face, random.dirichlet([1, 1, 1], count))


def picked(points, rows):
    """Some of the points."""
    return SurfacePoints(points.face[rows], points.barycentric[rows])


def timed(work):
    """Processor seconds of a call, and what it returned."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def quickest(work):
    """Processor seconds of the quickest of three calls, and what it returned: what else runs only adds to them."""
    seconds, result = timed(work)
    for _ in range(2):
        del result
        again, result = timed(work)
        seconds = min(seconds, again)
    return seconds, result


def spaced(surface, count):
    """About `count` Poisson-disk sites, and their spacing."""
    spacing = float(np.sqrt(0.7 * surface.area_mm2 / count))
    return poisson_disk(surface, spacing, stream(0, "benchmark")).points, spacing


def exactly(surface, source, targets, radius):
    """Distance from one source to targets by igl.exact_geodesic, on the faces that paths within `radius` can touch."""
    place = source.positions(surface)[0]
    reach = radius + surface.edge_length.max(axis=1)
    keep = np.flatnonzero(
        np.linalg.norm(surface.vertices[surface.faces] - place, axis=2).min(axis=1) <= reach
    )
    used, faces = np.unique(surface.faces[keep], return_inverse=True)
    vertices, faces = [*surface.vertices[used]], [*faces.reshape(-1, 3).tolist()]
    where = {int(face): row for row, face in enumerate(keep)}
    index = []
    for face, position in zip(
        [source.face[0], *targets.face], [place, *targets.positions(surface)], strict=True
    ):
        row, new = where[int(face)], len(vertices)
        a, b, c = faces[row]
        faces[row] = [a, b, new]
        faces += [[b, c, new], [c, a, new]]
        vertices.append(position)
        index.append(new)
    arrays = np.array(vertices), np.array(faces), np.array(index[:1]), NONE, np.array(index[1:]), NONE
    seconds, distance = timed(lambda: igl.exact_geodesic(*arrays))
    return seconds, distance


def accuracy(surface):
    """Ours against the truth, source by source."""
    print(
        "one source    points  missed   error, share of the distance: highest  lowest    ours, a source    igl exact"
    )
    highest, lowest = 0.0, 0.0
    for edges in (0.5, 2, 5, 10, 20):
        radius, errors, missed, theirs = edges * surface.mean_edge_mm, [], 0, 0.0
        sources = scattered(surface, 8, int(edges * 10))
        records = flood_points(surface, sources, radius, threads=1)
        ours = timed(lambda s=sources, r=radius: flood_points(surface, s, r, threads=1))[0] / len(sources)
        for i in range(len(sources)):
            faces = np.unique(records.row_id[records.row_id[:, 1] == i, 0])
            faces = np.random.default_rng(i).permutation(faces[faces != sources.face[i]])[:40]
            if len(faces) == 0:
                continue
            targets = SurfacePoints(faces, np.random.default_rng(i).dirichlet([3, 3, 3], len(faces)))
            seconds, truth = exactly(surface, picked(sources, [i]), targets, radius)
            start, source, distance, _ = within(records, targets)
            found = np.full(len(targets), np.inf)
            mine = source == i
            found[np.repeat(np.arange(len(targets)), np.diff(start))[mine]] = distance[mine]
            inside = (truth < radius * (1 - 1e-9)) & (truth > 0)
            missed += int(np.isinf(found[inside]).sum())
            errors.append((found[inside] / truth[inside] - 1)[np.isfinite(found[inside])])
            theirs += seconds / len(sources)
        error = np.concatenate(errors)
        print(
            f"  {edges:4g} h {len(error):12d} {missed:7d} {error.max():40.1e} {error.min():8.1e}"
            f" {ours:14.5f} s {theirs:10.3f} s"
        )
        if edges <= 10:
            highest, lowest = max(highest, float(np.abs(error).max())), min(lowest, float(error.min()))
    return {
        "error within 10 h, share of the distance": (highest, 1e-5),
        "underestimate, share of the distance": (-lowest, 1e-6),
    }


def interpolated(surface):
    """What solvers that keep values at vertices make of many sites."""
    sites, spacing = spaced(surface, 4000)
    points = scattered(surface, 100_000, 1)
    truth = nearest(flood_points(surface, sites, 2 * spacing, threads=1), points, 1, threads=1)[1][:, 0]
    corner = np.argmax(sites.barycentric, axis=1)
    at_vertices = np.unique(surface.faces[sites.face, corner])
    moved = np.zeros((len(at_vertices), 3))
    face = np.zeros(len(surface.vertices), np.int64)
    order = np.zeros(len(surface.vertices), np.int64)
    face[surface.faces.ravel()] = np.repeat(np.arange(len(surface.faces)), 3)
    order[surface.faces.ravel()] = np.tile(np.arange(3), len(surface.faces))
    moved[np.arange(len(at_vertices)), order[at_vertices]] = 1.0
    corners = SurfacePoints(face[at_vertices], moved)
    snapped = nearest(flood_points(surface, corners, 3 * spacing, threads=1), points, 1, threads=1)[1][:, 0]
    everywhere = np.zeros((len(surface.vertices), 3))
    everywhere[np.arange(len(everywhere)), order] = 1.0
    exact = nearest(flood_points(surface, sites, 4 * spacing, threads=1), SurfacePoints(face, everywhere), 1)[
        1
    ][:, 0]
    faces = surface.faces.astype(np.int64)
    heat = potpourri3d.MeshHeatMethodDistanceSolver(surface.vertices, faces)
    marching = potpourri3d.MeshFastMarchingDistanceSolver(surface.vertices, faces)
    rows = {
        "exact at the vertices, interpolated": (0.0, exact, truth),
        "heat from the nearest vertices": (*timed(lambda: heat.compute_distance_multisource(at_vertices.tolist())), snapped),
        "fast marching, likewise": (
            *timed(lambda: marching.compute_distance([[(int(v), [])] for v in at_vertices])), snapped),
    }  # fmt: skip
    print(
        f"many sites, {spacing / surface.mean_edge_mm:.1f} h apart            error / spacing: mean     p99    seconds"
    )
    for name, (seconds, values, reference) in rows.items():
        value = (np.asarray(values)[surface.faces[points.face]] * points.barycentric).sum(axis=1)
        error = np.abs(value - reference)[np.isfinite(reference)] / spacing
        print(f"  {name:42s} {error.mean():16.3%} {np.quantile(error, 0.99):8.2%} {seconds:9.3f}")


def across_edges(surface):
    """F1 and F2 asked from both faces of an edge."""
    sites, spacing = spaced(surface, 4000)
    records = flood_points(surface, sites, 3 * spacing, threads=1)
    face, edge = (a[:20_000] for a in np.nonzero(surface.neighbor >= 0))
    share = np.random.default_rng(0).random(len(face))
    here, there = np.zeros((len(face), 3)), np.zeros((len(face), 3))
    row = np.arange(len(face))
    here[row, edge], here[row, (edge + 1) % 3] = 1 - share, share
    other, back = surface.neighbor[face, edge], surface.neighbor_edge[face, edge]
    there[row, (back + 1) % 3], there[row, back] = 1 - share, share
    one, two = (nearest(records, SurfacePoints(*p), 2)[1] for p in ((face, here), (other, there)))
    gap = np.abs(one - two)[np.isfinite(one)].max() / spacing
    print(
        f"F1, F2 at {len(face)} points of edges, asked from both faces: they differ by {gap:.1e} of the spacing at most"
    )
    return {"F1, F2 across edges, share of the spacing": (gap, 1e-6)}


def many(surface, texels=2_500_000):
    """F1 to Fk of many sites at many texels beside heat, and how the work grows."""
    faces = surface.faces.astype(np.int64)
    setup, heat = timed(lambda: potpourri3d.MeshHeatMethodDistanceSolver(surface.vertices, faces))
    solve = min(timed(lambda v=v: heat.compute_distance(v))[0] for v in (0, 10, 100))
    print(f"heat: {setup:.2f} s once, {solve:.3f} s a solve")
    points = scattered(surface, texels, 3)
    print(
        "sites     k    texels     bound    flood    gather    in all   rows     MB    a heat solve per site   ratio"
    )
    seconds = {}
    for count, k, share in ((5000, 2, 1), (5000, 2, 4), (50_000, 2, 1), (5000, 5, 1), (50_000, 5, 1)):
        sites, spacing = spaced(surface, count)
        asked = picked(points, slice(None, None, share))
        bounding, bound = quickest(lambda s=sites, k=k: nearest_bound(surface, s, k))
        reach = (2.0 if k == 2 else 2.6) * spacing
        flooding, records = quickest(
            lambda s=sites, r=reach, b=bound: flood_points(surface, s, r, bound_mm=b, threads=1)
        )
        gathering = quickest(lambda r=records, a=asked, k=k: nearest(r, a, k, threads=1))[0]
        total, peer = bounding + flooding + gathering, solve * len(sites)
        seconds[count, k, share] = total, peer / total, gathering
        print(
            f"{len(sites):7d} {k:3d} {len(asked):9d} {bounding:8.2f} {flooding:8.2f} {gathering:8.2f} {total:8.2f} s "
            f"{len(records.row) / 1e6:6.2f}M {records.nbytes / 1e6:6.0f} {peer:15.0f} s {peer / total:14.0f}"
        )
    dots = scattered(surface, 170_000, 4)
    texel = float(np.sqrt(surface.area_mm2 / texels))
    flooding, records = quickest(lambda: flood_points(surface, dots, 2 * texel, threads=1))
    gathering = quickest(lambda: nearest(records, points, 1, threads=1))[0]
    print(
        f"170,000 follicles of 2 texels: flood {flooding:.2f} s = {flooding / solve:.1f} heat solves, "
        f"gather at {texels} texels {gathering:.2f} s"
    )
    one, many_more, fewer = seconds[5000, 2, 1], seconds[50_000, 2, 1], seconds[5000, 2, 4]
    return {
        "F1, F2 of 5,000 sites over a heat solve per site": (1 / one[1], 1 / 20),
        "time of ten times the sites over one": (many_more[0] / one[0], 2.0),
        "gather of four times the texels over one": (one[2] / fewer[2], 4.4),
        "flood of 170,000 follicles, heat solves": (flooding / solve, 10.0),
    }


def speed(surface):
    """Sources a second, by radius."""
    print("radius        sources a second")
    for edges, count in ((0.05, 100_000), (0.2, 50_000), (2, 4000), (5, 800), (10, 200), (20, 30)):
        sources = scattered(surface, count, 5)
        seconds = timed(
            lambda s=sources, e=edges: flood_points(surface, s, e * surface.mean_edge_mm, threads=1)
        )[0]
        print(f"  {edges:5g} h {count / seconds:18.0f}")


def main():
    """Every table, for every mesh."""
    paths = [Path(p) for p in sys.argv[1:]] or [Path(__file__).parent.parent / "meshes" / "head.ply"]
    for path in paths:
        surface = load(path)
        if len(surface.faces) < 50_000:
            name = surface.name + ", faces cut in four"
            surface = Surface.from_arrays(*midpoint_subdivided(surface.vertices, surface.faces), name=name)
        warm = scattered(surface, 3, 0)
        nearest(
            flood_points(surface, warm, surface.mean_edge_mm, bound_mm=nearest_bound(surface, warm, 1)),
            warm,
            1,
        )
        within(flood_points(surface, warm, surface.mean_edge_mm), warm)
        print(f"\n{surface.name}: {len(surface.faces)} faces, mean edge {surface.mean_edge_mm:.2f} mm")
        goals = {}
        for table in (accuracy, interpolated, across_edges, many, speed):
            goals |= table(surface) or {}
        print("goals")
        for name, (value, most) in goals.items():
            print(f"  {name:52s} {value:10.2g}, at most {most:g}: {'met' if value <= most else 'NOT met'}")


if __name__ == "__main__":
    main()
