"""Poisson-disk sites against other libraries: process CPU at the same spacing, and what each leaves behind.

Run ``python benchmarks/sampling.py [--peers FOLDER]``; FOLDER holds site-packages of pymeshlab and
point-cloud-utils, which surftex does not depend on. Spacing and gaps are measured for all by exact distances.
"""

import argparse
import importlib
import sys
import time

import numpy as np

from surftex.features.poisson import poisson_disk
from surftex.features.uniform import scatter
from surftex.geodesics.windows import flood_points, nearest
from surftex.randomness import stream
from surftex.surface.points import SurfacePoints
from surftex.surface.shapes import sphere


def places_on(surface, xyz):
    """Nearest surface points of places in space."""
    import igl

    _, face, nearest_place = igl.point_mesh_squared_distance(xyz, surface.vertices, surface.faces)[:3]
    corners = surface.vertices[surface.faces[face]]
    weights = igl.barycentric_coordinates(
        nearest_place, *[np.ascontiguousarray(corners[:, i]) for i in range(3)]
    )
    weights = np.clip(weights, 0, None)
    return SurfacePoints(face, weights / weights.sum(axis=1, keepdims=True))


def ours(surface, spacing, threads=1):
    return poisson_disk(surface, spacing, stream(1, "benchmark"), threads=threads).points


def libigl(surface, spacing):
    import igl

    face = np.asarray(surface.faces, np.int64)
    weights, index, _ = igl.blue_noise(np.array(surface.vertices), face, spacing)
    return SurfacePoints(index, np.clip(weights, 0, 1) / np.clip(weights, 0, 1).sum(axis=1, keepdims=True))


def meshlab(surface, spacing):
    pymeshlab = importlib.import_module("pymeshlab")
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.array(surface.vertices), np.array(surface.faces)))
    meshes.generate_sampling_poisson_disk(radius=pymeshlab.PureValue(spacing), exactnumflag=False)
    return meshes.current_mesh().vertex_matrix()


def clouds(surface, spacing):
    library = importlib.import_module("point_cloud_utils")
    index, weights = library.sample_mesh_poisson_disk(
        np.array(surface.vertices), np.array(surface.faces), -1, radius=spacing, use_geodesic_distance=True
    )
    return SurfacePoints(index, np.clip(weights, 0, 1) / np.clip(weights, 0, 1).sum(axis=1, keepdims=True))


def measured(surface, spacing, points):
    """Least distance of two sites and largest of any probe to its site, in spacings."""
    records = flood_points(surface, points, 2 * spacing)
    apart = nearest(records, points, 2)[1][:, 1].min()
    far = nearest(records, scatter(surface, stream(2, "probes"), count=200_000), 1)[1].max()
    return apart / spacing, far / spacing


def main():
    options = argparse.ArgumentParser()
    options.add_argument("--peers")
    options.add_argument("--sites", type=int, nargs="+", default=[500, 5000, 50000])
    options = options.parse_args()
    if options.peers:
        sys.path.append(options.peers)
    surface = sphere(40.0, subdivisions=6)
    print(
        f"{len(surface.faces)} faces; CPU of one thread unless said; spacing and gap in units of the asked spacing"
    )
    ours(surface, 8.0)
    for sites in options.sites:
        spacing = float(np.sqrt(0.697 * surface.area_mm2 / sites))
        for name, make in (
            ("surftex", ours),
            ("igl.blue_noise", libigl),
            ("pymeshlab", meshlab),
            ("point-cloud-utils", clouds),
        ):
            try:
                start = time.process_time()
                points = make(surface, spacing)
                spent = time.process_time() - start
            except ImportError:
                print(f"{sites:6d} {name:18s} not installed")
                continue
            points = points if isinstance(points, SurfacePoints) else places_on(surface, points)
            apart, far = measured(surface, spacing, points)
            print(
                f"{sites:6d} {name:18s} {len(points):6d} sites {spent:7.2f} s  least {apart:.3f}  gap {far:.3f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
