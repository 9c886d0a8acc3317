"""Slow, obvious twins of the geodesic kernels: exact distances from libigl, and brute force."""

import itertools

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


def pieces_of_plane_polyline(shape: Surface, turns: NDArray[np.float64]):
    """Cut a polyline in the xy plane at the edges of a flat mesh."""
    from surftex.geodesics.pieces import CurvePieces

    corners = shape.vertices[shape.faces][:, :, :2]
    edges = np.concatenate([np.stack([corners[:, i], corners[:, (i + 1) % 3]], axis=1) for i in range(3)])
    inverse = np.linalg.inv(
        np.concatenate([corners.transpose(0, 2, 1), np.ones((len(corners), 1, 3))], axis=1)
    )
    face, start, end = [], [], []
    for p, q in itertools.pairwise(turns):
        along, side = q - p, edges[:, 1] - edges[:, 0]
        offset = edges[:, 0] - p
        across = along[0] * side[:, 1] - along[1] * side[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (offset[:, 0] * side[:, 1] - offset[:, 1] * side[:, 0]) / across
            u = (offset[:, 0] * along[1] - offset[:, 1] * along[0]) / across
        cuts = t[(np.abs(across) > 1e-12) & (t > 0) & (t < 1) & (u > -1e-9) & (u < 1 + 1e-9)]
        cuts = np.unique(np.round(np.concatenate([[0.0, 1.0], cuts]), 13))
        for low, high in itertools.pairwise(cuts):
            middle = p + along * (low + high) / 2
            f = int(np.argmax((inverse @ np.append(middle, 1.0)).min(axis=1)))
            to_face, origin = shape.frame[f][:2, :2], corners[f, 0]
            face.append(f)
            start.append(to_face @ (p + along * low - origin))
            end.append(to_face @ (p + along * high - origin))
    return CurvePieces.of(face, start, end, np.zeros(len(face), int))


def distance_to_polyline(turns: NDArray[np.float64], places: NDArray[np.float64]):
    """Distance to the nearest place of a polyline in the plane, and the length before it."""
    best, along, length = np.full(len(places), np.inf), np.zeros(len(places)), 0.0
    for p, q in itertools.pairwise(turns):
        size = np.hypot(*(q - p))
        share = np.clip((places - p) @ (q - p) / size**2, 0, 1)
        distance = np.linalg.norm(places - (p + share[:, None] * (q - p)), axis=1)
        nearer = distance < best
        best[nearer], along[nearer] = distance[nearer], (length + share * size)[nearer]
        length += size
    return best, along


def walk_bound(surface: Surface, sources: SurfacePoints, k: int, steps: int = 4) -> NDArray[np.float64]:
    """(m,) bound of the distance to the k-th nearest source: Dijkstra along edges."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    vertices, faces = surface.vertices, surface.faces
    ways: dict[tuple[int, int], float] = {}
    for f, i in itertools.product(range(len(faces)), range(3)):
        a, b = faces[f, i], faces[f, (i + 1) % 3]
        length = float(np.linalg.norm(vertices[b] - vertices[a]))
        ways[a, b] = ways[b, a] = length
    places = sources.positions(surface)
    for s, (f, place) in enumerate(zip(sources.face, places, strict=True)):
        for i in range(3):
            ways[len(vertices) + s, faces[f, i]] = float(np.linalg.norm(place - vertices[faces[f, i]]))
    count = len(vertices) + len(places)
    graph = coo_array((list(ways.values()), np.transpose(list(ways))), shape=(count, count)).tocsr()
    walks = dijkstra(graph, indices=np.arange(len(vertices), count))[:, : len(vertices)]
    nearest = np.sort(np.vstack([walks, np.full((k, len(vertices)), np.inf)]), axis=0)[k - 1]
    bound = np.zeros(len(faces))
    grid = [(i, j) for i in range(steps) for j in range(steps - i)]
    small = [[(i, j), (i + 1, j), (i, j + 1)] for i, j in grid]
    small += [[(i + 1, j), (i, j + 1), (i + 1, j + 1)] for i, j in grid if i + j < steps - 1]
    for f, face in enumerate(faces):
        for triangle in small:
            weights = np.array([[steps - i - j, i, j] for i, j in triangle]) / steps
            far = np.linalg.norm((weights @ vertices[face])[:, None] - vertices[face], axis=2).max(axis=0)
            bound[f] = max(bound[f], np.min(nearest[face] + far))
    return bound
