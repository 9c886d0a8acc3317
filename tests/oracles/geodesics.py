"""Slow, obvious twins of the geodesic kernels: exact distances from libigl, and brute force."""

import numpy as np
from numpy.typing import NDArray

from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface


def exact_distance(surface: Surface, source: SurfacePoints, targets: SurfacePoints) -> NDArray[np.float64]:
    """(t,) mm from one source to targets by igl.exact_geodesic, all of them inserted as vertices.

    Weights must stay off the edges by 1e-6 or so; faces with several points are cut again and again.
    """
    import igl

    vertices = surface.vertices.tolist()
    faces = surface.faces.tolist()
    pieces: dict[int, list[int]] = {}

    def insert(face: int, place: NDArray[np.float64]) -> int:
        new = len(vertices)
        vertices.append(place.tolist())
        candidates = pieces.setdefault(face, [face])
        best, least = candidates[0], -np.inf
        for piece in candidates:
            corners = np.array([vertices[v] for v in faces[piece]])
            weights = np.linalg.lstsq(np.vstack([corners.T, np.ones(3)]), np.append(place, 1.0), rcond=None)[
                0
            ]
            if weights.min() > least:
                best, least = piece, weights.min()
        a, b, c = faces[best]
        faces[best] = [a, b, new]
        candidates += [len(faces), len(faces) + 1]
        faces.extend([[b, c, new], [c, a, new]])
        return new

    start = insert(int(source.face[0]), source.positions(surface)[0])
    ends = [insert(int(f), p) for f, p in zip(targets.face, targets.positions(surface), strict=True)]
    none = np.zeros(0, np.int64)
    result = igl.exact_geodesic(
        np.array(vertices),
        np.array(faces, np.int64),
        np.array([start], np.int64),
        none,
        np.array(ends, np.int64),
        none,
    )
    return np.asarray(result, np.float64).ravel()


def random_points(surface: Surface, count: int, seed: int = 0, *, margin: float = 1e-3) -> SurfacePoints:
    """Area-uniform points that keep off the edges."""
    rng = np.random.default_rng(seed)
    face = rng.choice(len(surface.faces), count, p=surface.face_area_mm2 / surface.face_area_mm2.sum())
    weights = np.clip(rng.dirichlet([1, 1, 1], count), margin, None)
    return SurfacePoints(face, weights / weights.sum(axis=1, keepdims=True))


def at_most(points: SurfacePoints, row: int) -> SurfacePoints:
    """One of some points."""
    return SurfacePoints(points.face[row : row + 1], points.barycentric[row : row + 1])
