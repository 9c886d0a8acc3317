"""Slow, obvious twins of the maps room."""

import numpy as np


def mikktspace(position, normal, uv):
    """MikkTSpace of corners by its definition: flood from each corner over faces of one handedness, then add up."""
    count = len(position)
    key = [
        [(*map(float, position[f, i]), *map(float, normal[f, i]), *map(float, uv[f, i])) for i in range(3)]
        for f in range(count)
    ]
    doubled = [
        float(np.linalg.det(np.stack([uv[f, 1] - uv[f, 0], uv[f, 2] - uv[f, 0]]))) for f in range(count)
    ]
    result = np.zeros((count, 3, 4))
    for f in range(count):
        for i in range(3):
            group, queue = {f}, [f]
            while queue:
                g = queue.pop()
                for h in range(count):
                    if (
                        h not in group
                        and (doubled[h] > 0) == (doubled[g] > 0)
                        and _meet(key[g], key[h], key[f][i])
                    ):
                        group.add(h)
                        queue.append(h)
            total = np.zeros(3)
            n = normal[f, i]
            for g in sorted(group):
                k = key[g].index(key[f][i])
                along, up = uv[g, 1] - uv[g, 0], uv[g, 2] - uv[g, 0]
                to_uv = np.stack([along, up])
                sides = np.stack([position[g, 1] - position[g, 0], position[g, 2] - position[g, 0]])
                tangent = np.linalg.solve(to_uv, sides)[0]
                onward, back = (_flat(position[g, (k + j) % 3] - position[g, k], n) for j in (1, 2))
                total += _flat(tangent, n) * np.arccos(np.clip(onward @ back, -1, 1))
            result[f, i] = [*(total / np.linalg.norm(total)), 1 if doubled[f] > 0 else -1]
    return result


def _meet(one, other, corner):
    """Whether two faces run along an edge at `corner` in opposite senses."""
    edges = {(one[i], one[(i + 1) % 3]) for i in range(3)}
    return any(
        corner in (a, b) and (b, a) in edges for a, b in ((other[i], other[(i + 1) % 3]) for i in range(3))
    )


def _flat(vector, normal):
    vector = vector - normal * (vector @ normal)
    return vector / np.linalg.norm(vector)
