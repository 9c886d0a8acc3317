"""What the tests ask of every mesh, and the table prints."""

import numpy as np


def welded(parts):
    """All parts as one body: equal points once."""
    points, faces, base = [], [], 0
    for part in parts:
        points.append(part.vertices)
        faces.append(part.faces + base)
        base += len(part.vertices)
    unique, index = np.unique(np.round(np.concatenate(points), 3), axis=0, return_inverse=True)
    return unique, index.ravel()[np.concatenate(faces)]


def report(parts):
    """Faces, size, borders, faults: edges shared by other than two opposite faces, vertices with several fans, slivers."""
    points, faces = welded(parts)
    a, b, c = (points[faces[:, i]] for i in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    edge = np.stack(
        [np.linalg.norm(b - a, axis=1), np.linalg.norm(c - b, axis=1), np.linalg.norm(a - c, axis=1)], 1
    )
    start, end = faces.ravel().astype(np.int64), np.roll(faces, -1, axis=1).ravel().astype(np.int64)
    key, back = start * len(points) + end, end * len(points) + start
    # A vertex has one fan where its corners, linked across edges, are one cycle: corners = fans, counted by walking.
    twice = len(key) - len(np.unique(key))
    border = int((~np.isin(key, back)).sum())
    degree = np.bincount(faces.ravel(), minlength=len(points))
    follow = dict(
        zip(
            key.tolist(),
            (start[np.arange(len(key)) // 3 * 3 + (np.arange(len(key)) + 2) % 3]).tolist(),
            strict=True,
        )
    )
    fans = 0
    first = {}
    for s, e in zip(start.tolist(), end.tolist(), strict=True):
        first.setdefault(s, e)
    for vertex, onward in first.items():
        seen, at = 0, onward
        while True:
            following = follow.get(vertex * len(points) + at)
            if following is None:
                break
            seen, at = seen + 1, following
            if at == onward:
                break
        fans += seen != degree[vertex]
    quality = 4 * np.sqrt(3) * area / np.maximum((edge**2).sum(axis=1), 1e-12)
    volume = float((a * np.cross(b, c)).sum() / 6)
    return {
        "faces": len(faces),
        "vertices": len(points),
        "size_mm": np.ptp(points, axis=0).round(1).tolist(),
        "area_mm2": round(float(area.sum())),
        "volume_cm3": round(volume / 1000, 1),
        "doubled_edges": int(twice),
        "border_edges": border,
        "fan_faults": int(fans),
        "least_area_mm2": float(area.min()),
        "edge_mm": [round(float(np.percentile(edge, q)), 2) for q in (0, 5, 50, 95, 100)],
        "quality_low": [round(float(np.percentile(quality, q)), 2) for q in (0, 1, 5)],
    }
