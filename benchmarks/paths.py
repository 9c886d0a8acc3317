"""Paths, Bézier curves and heat beside their peers: ``python -m benchmarks.paths [MESH ...]``.

Meshes are files that surftex loads; a rough ball without any. Seconds of processor time on one thread, ours and
the peers' in the same run. A path is exact if it is within 1e-6 of the exact windows; potpourri3d's EdgeFlip
runs between the vertices next to our points, since it takes nothing else.
"""

import sys
import time

import igl
import numpy as np
import potpourri3d

from surftex.geodesics.bezier import bezier_points
from surftex.geodesics.directions import DirectionField
from surftex.geodesics.heat import HeatSolver
from surftex.geodesics.paths import shortest_path
from surftex.geodesics.tracing import trace
from surftex.geodesics.windows import flood_points, nearest
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import sphere
from surftex.surface.surface import Surface


def rough_ball():
    """A ball with swellings, and every vertex moved by a third of an edge."""
    ball = sphere(40.0, subdivisions=5)
    x, y, z = ball.vertices.T / 40
    swell = 1 + 0.2 * np.sin(3 * x + 1) + 0.15 * np.cos(2 * y - z) + 0.1 * z**3
    swell += 0.005 * np.random.default_rng(0).normal(size=len(x))
    return Surface.from_arrays(ball.vertices * swell[:, None], ball.faces, name="rough ball")


def scattered(surface, count, seed):
    """Points, even by area."""
    random = np.random.default_rng(seed)
    share = surface.face_area_mm2 / surface.area_mm2
    return SurfacePoints(random.choice(len(share), count, p=share), random.dirichlet([1, 1, 1], count))


def rows(points, chosen):
    """Some of the points."""
    return SurfacePoints(points.face[chosen], points.barycentric[chosen])


def timed(work):
    """Processor seconds of a call, and what it returned."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def point_to_point(surface, count=300):
    """Share of exact paths and time beside EdgeFlip, by span."""
    flips = potpourri3d.EdgeFlipGeodesicSolver(surface.vertices, surface.faces.astype(np.int64))
    print("point to point     exact   mean excess   worst    ours     EdgeFlip")
    for span in (1, 3, 5, 10):
        reach = span * surface.mean_edge_mm
        start = scattered(surface, count, span)
        walk = trace(surface, start, np.random.default_rng(span).random(count) * 2 * np.pi, reach)
        many = np.tile(np.arange(count), 8)
        ends = rows(start, many), rows(walk.end, many)
        ours, (_, length) = timed(lambda e=ends: shortest_path(surface, *e, threads=1))
        length = length[:count]
        truth = np.zeros(count)
        for i in range(count):
            records = flood_points(surface, rows(start, [i]), 1.01 * reach)
            truth[i] = nearest(records, rows(walk.end, [i]), 1)[1][0, 0]
        over = length / truth - 1
        corner = [surface.faces[p.face, p.barycentric.argmax(axis=1)] for p in (start, walk.end)]
        pairs = [(int(a), int(b)) for a, b in zip(*corner, strict=True) if a != b]
        theirs, _ = timed(lambda p=pairs: [flips.find_geodesic_path(a, b) for a, b in p])
        print(
            f"  span {span:3d} edges   {np.mean(over < 1e-6):6.3f}   {over.mean():10.1e}   {over.max():6.3f}   "
            f"{ours / len(many) * 1e6:5.0f} us   {theirs / len(pairs) * 1e6:6.0f} us"
        )


def curves(surface, count=300):
    """Bézier curves: time of each of their 90 paths, which halving makes ever shorter, beside an EdgeFlip path.

    EdgeFlip runs from control to control: the ratio of like with like is that of `point_to_point`.
    """
    flips = potpourri3d.EdgeFlipGeodesicSolver(surface.vertices, surface.faces.astype(np.int64))
    print("Bézier, depth 4    a curve    failed   each path   EdgeFlip   ratio")
    for span in (1, 3, 10):
        random = np.random.default_rng(span)
        points = [scattered(surface, count, 10 + span)]
        for _ in range(3):
            angle = random.random(count) * 2 * np.pi
            points.append(trace(surface, points[-1], angle, span * surface.mean_edge_mm).end)
        face = np.stack([p.face for p in points], axis=1)
        weights = np.stack([p.barycentric for p in points], axis=1)
        controls = SurfacePoints(face.ravel(), weights.reshape(-1, 3))
        bezier_points(surface, controls, threads=1)
        ours, (_, curve) = timed(lambda c=controls: bezier_points(surface, c, threads=1))
        corner = surface.faces[face, weights.argmax(axis=2)]
        legs = [
            (int(a), int(b))
            for a, b in zip(corner[:, :-1].ravel(), corner[:, 1:].ravel(), strict=True)
            if a != b
        ]
        theirs, _ = timed(lambda pairs=legs: [flips.find_geodesic_path(a, b) for a, b in pairs])
        one, other = ours / count / 90, theirs / len(legs)
        failed = count - len(np.unique(curve))
        print(
            f"  span {span:3d} edges   {ours / count * 1e3:6.3f} ms   {failed:4d}   {one * 1e6:7.2f} us   "
            f"{other * 1e6:6.1f} us   {other / one:6.1f}"
        )


def heat():
    """Error on a sphere, and time, beside igl's heat method and the library's own."""
    print("heat on a sphere   edge     ours: mean  worst    first    again     igl heat: mean  worst   solve")
    for subdivisions in (3, 4, 5):
        ball = sphere(40.0, subdivisions=subdivisions)
        source = SurfacePoints([7], [[0.0, 1.0, 0.0]])
        start = ball.vertices[ball.faces[7, 1]] / 40
        unit = ball.vertices / 40
        circle = 40 * np.arctan2(np.linalg.norm(np.cross(unit, start), axis=1), unit @ start)
        solver = HeatSolver(ball)
        first, _ = timed(lambda s=solver, p=source: s.vertex_distance(p))
        again, ours = timed(lambda s=solver, p=source: s.vertex_distance(p))
        data = igl.HeatGeodesicsData()
        igl.heat_geodesics_precompute(ball.vertices, ball.faces.astype(np.int64), data)
        corner = np.array([ball.faces[7, 1]], np.int64)
        solve, theirs = timed(lambda d=data, c=corner: igl.heat_geodesics_solve(d, c))
        error, peer = np.abs(ours - circle), np.abs(theirs - circle)
        print(
            f"  {len(ball.vertices):6d} vertices {ball.mean_edge_mm:5.2f} mm   {error.mean():5.2f} {error.max():6.2f} mm  "
            f"{first:6.3f} s {again:6.3f} s       {peer.mean():8.2f} {peer.max():6.2f} mm {solve:6.3f} s"
        )


def fields(surface):
    """Time of the smoothest fields, and their singularities."""
    for symmetry in (1, 2, 4):
        seconds, field = timed(lambda n=symmetry: DirectionField.smoothest(surface, n))
        print(
            f"smoothest field, {symmetry} arms: {seconds:6.2f} s, {np.count_nonzero(field.index)} singular faces"
        )


def main():
    if len(sys.argv) > 1:
        from surftex.files.meshes import load

        surfaces = [load(path, size="200 mm") for path in sys.argv[1:]]
    else:
        surfaces = [rough_ball()]
    shortest_path(surfaces[0], *(scattered(surfaces[0], 1, k) for k in (1, 2)))
    for surface in surfaces:
        print(f"\n{surface.name}: {len(surface.faces)} faces, mean edge {surface.mean_edge_mm:.2f} mm")
        point_to_point(surface)
        curves(surface)
        fields(surface)
    print()
    heat()


if __name__ == "__main__":
    main()
