"""Slow, obvious twins of the maps room."""

import numpy as np
from scipy.linalg import polar


def mikktspace(position, normal, uv):
    """MikkTSpace by its definition: flood from each corner over faces of one handedness, add up."""
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


def page_metric(corner, flat):
    """Stretch and axes of one face by its polar decomposition, and weights by the inverse of its corners."""
    page, side = ((part[1:] - part[0]).T for part in (corner * [1, -1], flat))
    if abs(np.linalg.det(page)) < 1e-12:
        return np.zeros((2, 2)), np.eye(2), np.outer(np.ones(3), [1 / 3, 0, 0])
    axes, stretch = polar(side @ np.linalg.inv(page))
    return stretch, axes, np.linalg.inv(np.column_stack([np.ones(3), corner])).T


def object_normals(surface, tangents, face, barycentric, encoded):
    """Normals told along tangent, bitangent and normal, in space."""
    normal = np.einsum("pk,pki->pi", barycentric, surface.shading_normal[face])
    tangent = np.einsum("pk,pki->pi", barycentric, tangents[face, :, :3])
    frame = np.stack([tangent, tangents[face, 0, 3:] * np.cross(normal, tangent), normal], axis=1)
    result = np.einsum("pk,pki->pi", encoded, frame)
    return result / np.linalg.norm(result, axis=1, keepdims=True)


def normals(surface, atlas, texels, height, tangents):
    """Tangent-space normals of a page of one flat chart, texel by texel, from matrices."""
    where = {int(place): i for i, place in enumerate(texels.texel)}
    steps = atlas.jacobian_mm(surface, texels.width)
    result = np.zeros((len(texels), 3))
    for i, place in enumerate(texels.texel):
        host = texels.host[i]
        rows, rises = [], []
        for axis, offset in ((0, 1), (1, -texels.width)):
            ahead, behind = where.get(int(place) + offset), where.get(int(place) - offset)
            ahead, behind = (i if j is None else j for j in (ahead, behind))
            count = (ahead != i) + (behind != i)
            rows.append(steps[host][:, axis] * max(count, 1))
            rises.append(float(height[ahead]) - float(height[behind]))
        slope = np.linalg.solve(np.array(rows), rises)
        column, row = int(place) % texels.width + 0.5, int(place) // texels.width + 0.5
        corner = np.column_stack([atlas.corner_px(texels.width)[host], np.ones(3)])
        weight = np.linalg.solve(corner.T, [column, row, 1])
        up, along = weight @ surface.shading_normal[host], weight @ tangents[host, :, :3]
        normal = up / np.linalg.norm(up) - slope @ surface.frame[host, :2]
        basis = np.stack([along, tangents[host, 0, 3] * np.cross(up, along), up], axis=1)
        code = np.linalg.solve(basis, normal)
        result[i] = code / np.linalg.norm(code)
    return result


def open_sky(surface, atlas, texels, height, step, radius_mm):
    """Openness of each texel: eight marches over the page, each step measured in millimetres."""
    image = np.full((texels.height, texels.width), np.nan)
    image.ravel()[texels.texel] = height
    jacobian = atlas.jacobian_mm(surface, texels.width)

    def value(row, column):
        inside = 0 <= row < texels.height and 0 <= column < texels.width
        return image[row, column] if inside else np.nan

    result = np.ones(len(texels))
    for i, place in enumerate(texels.texel):
        row, column = divmod(int(place), texels.width)
        here, shut, weights = image[row, column], [], []
        for right, up in ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)):
            length = np.linalg.norm(jacobian[texels.host[i]] @ [right, up])
            ahead, behind = value(row - up, column + right), value(row + up, column - right)
            slope = np.nanmean([ahead - here, here - behind]) / length if np.isfinite(ahead) else 0.0
            tangents = [0.0]
            for k in step:
                there = value(row - k * up, column + k * right)
                if not np.isfinite(there) or length * k >= radius_mm:
                    break
                tangents.append(((there - here) / (length * k) - slope) * (1 - (length * k / radius_mm) ** 4))
            shut.append(np.sin(np.arctan(max(tangents))) ** 2)
            weights.append((right**2 + up**2) / length**2)
        result[i] = 1 - np.average(shut, weights=weights)
    return result
