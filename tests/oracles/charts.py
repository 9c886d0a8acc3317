"""Slow, obvious twins of the charts room."""

import numpy as np


def owners(corner, width, height):
    """Lowest face around each texel's centre, and its weights, by solving for the weights."""
    face, weight = np.full((height, width), -1), np.zeros((height, width, 3))
    for r in range(height):
        for c in range(width):
            for f in range(len(corner)):
                system = np.vstack([corner[f].T, np.ones(3)])
                if abs(np.linalg.det(system)) < 1e-12:
                    continue
                solved = np.linalg.solve(system, [c + 0.5, r + 0.5, 1])
                if solved.min() >= -1e-9:
                    face[r, c], weight[r, c] = f, np.maximum(solved, 0) / np.maximum(solved, 0).sum()
                    break
    return face, weight


def holders(corner, width, height, margin):
    """Number of faces that each texel's centre lies inside of, by more than a margin in texels."""
    count = np.zeros((height, width), int)
    for triangle in corner:
        if np.linalg.det(np.vstack([triangle.T, np.ones(3)])) < 0:
            triangle = triangle[::-1]
        for r in range(height):
            for c in range(width):
                inside = []
                for i in range(3):
                    a, b = triangle[i], triangle[(i + 1) % 3]
                    d = b - a
                    inside.append((d[0] * (r + 0.5 - a[1]) - d[1] * (c + 0.5 - a[0])) / np.linalg.norm(d))
                count[r, c] += min(inside) > margin
    return count


def nearest_edges(corner, edges, radius, face):
    """Nearest edge of each free texel: distance, then how squarely outside, then order."""
    owner = np.full(face.shape, -1)
    for r, c in np.argwhere(face < 0):
        best = None
        for e, (f, i) in enumerate(edges):
            a, b, o = corner[f, i], corner[f, (i + 1) % 3], corner[f, (i + 2) % 3]
            p, d = np.array([c + 0.5, r + 0.5]), b - a
            foot = a + d * np.clip((p - a) @ d / (d @ d), 0, 1)
            away = (p - foot) @ (p - foot)
            normal = np.array([d[1], -d[0]]) / np.linalg.norm(d)
            outside = (p - a) @ (normal if (o - a) @ normal < 0 else -normal)
            if away > radius**2:
                continue
            if best is None or away < best[0] - 1e-5 or (away <= best[0] + 1e-5 and outside > best[1]):
                best = (away, outside)
                owner[r, c] = e
    return owner


def straight_walk(surface, face, start, target):
    """Lay triangles out flat along a straight line, by their edge lengths in space alone.

    From `start` to `target`, both in the frame of `face`; goes on along borders, and ends on them.
    Returns the face, the weights there, and the turn from the first frame into the last.
    """
    laid = {int(surface.faces[face, i]): complex(*surface.flat[face, i]) for i in range(3)}
    here, there = complex(*start), complex(*target)
    came, slides, stop = -1, 0, None
    while True:
        names = [int(v) for v in surface.faces[face]]
        corner = np.array([laid[v] for v in names])
        system = np.vstack([corner.real, corner.imag, np.ones(3)])
        weight = np.linalg.solve(system, [there.real, there.imag, 1])
        from_weight = np.linalg.solve(system, [here.real, here.imag, 1])
        crossings = []
        for i in range(3):
            edge = (i + 1) % 3
            if edge != came and weight[i] < -1e-12:
                inside = max(from_weight[i], 0)
                crossings.append((inside / (inside - weight[i]), weight[i], edge))
        x_axis = corner[1] - corner[0]
        if not crossings:
            borders = [i for i in range(3) if surface.neighbor[face, (i + 1) % 3] < 0 and weight[i] < 1e-9]
            if slides and not borders:
                return stop
            weight[borders] = 0
            weight = np.maximum(weight, 0)
            return face, weight / weight.sum(), -np.angle(x_axis)
        edge = min(crossings)[2]
        other = int(surface.neighbor[face, edge])
        a, b = names[edge], names[(edge + 1) % 3]
        if other < 0:
            d = laid[b] - laid[a]
            along = ((there - laid[a]) * d.conjugate()).real / abs(d) ** 2
            there = laid[a] + along * d
            here = laid[a] + np.clip(along, 0, 1) * d
            came = edge
            weight = np.zeros(3)
            weight[edge], weight[(edge + 1) % 3] = 1 - np.clip(along, 0, 1), np.clip(along, 0, 1)
            stop = face, weight, -np.angle(x_axis)
            slides += 1
            if slides == 8:
                return stop
            continue
        came = int(surface.neighbor_edge[face, edge])
        apex = int(next(v for v in surface.faces[other] if v not in (a, b)))
        space = surface.vertices
        ab, side_a, side_b = (np.linalg.norm(space[p] - space[q]) for p, q in ((a, b), (a, apex), (b, apex)))
        along = (ab**2 + side_a**2 - side_b**2) / (2 * ab)
        up = np.sqrt(max(side_a**2 - along**2, 0))
        direction = (laid[b] - laid[a]) / abs(laid[b] - laid[a])
        laid = {a: laid[a], b: laid[b], apex: laid[a] + direction * complex(along, -up)}
        face = other


def nearest_mapped_distance(mapped):
    """Distance to the nearest mapped texel, over all of them."""
    places = np.argwhere(mapped)
    return np.array(
        [
            [np.sqrt(((places - (r, c)) ** 2).sum(axis=1).min()) for c in range(mapped.shape[1])]
            for r in range(mapped.shape[0])
        ]
    )


def bilinear(image, uv):
    """Mix the four texels around each place by their shares; u right, v up; beyond the page those at its edge."""
    height, width = image.shape[:2]
    mixed = []
    for u, v in uv:
        column, row = u * width - 0.5, (1 - v) * height - 0.5
        total = 0.0
        for r in (np.floor(row), np.floor(row) + 1):
            for c in (np.floor(column), np.floor(column) + 1):
                share = (1 - abs(row - r)) * (1 - abs(column - c))
                texel = image[int(np.clip(r, 0, height - 1)), int(np.clip(c, 0, width - 1))]
                total = total + share * texel.astype(float)
        mixed.append(total)
    return np.array(mixed)


def seams(faces, corner_uv, same):
    """Edges that no other face runs back along at the same places of the page and with the same side up."""
    seam = np.ones(faces.shape, bool)
    (a, b), (c, d) = (corner_uv[:, 1:] - corner_uv[:, :1]).transpose(1, 2, 0)
    side = np.sign(a * d - b * c)
    for f, i in np.ndindex(seam.shape):
        for g, j in np.ndindex(seam.shape):
            if faces[f, i] == faces[g, (j + 1) % 3] and faces[f, (i + 1) % 3] == faces[g, j]:
                apart = corner_uv[f, [i, (i + 1) % 3]] - corner_uv[g, [(j + 1) % 3, j]]
                seam[f, i] = np.abs(apart).max() > same or side[f] != side[g]
    return seam


def parts(neighbor, apart):
    """Numbers of faces, each again and again the lowest across its edges; counted off at the end."""
    number = np.arange(len(neighbor))
    for _ in number:
        number = np.where(apart | (neighbor < 0), number[:, None], number[neighbor]).min(
            axis=1, initial=len(number)
        )
        number = np.minimum(number, np.arange(len(neighbor)))
    return np.unique(number, return_inverse=True)[1]


def notches(page, place, face, chart, area, near, apart):
    """Smaller faces of each two samples of a chart that are near on the page and far apart in space."""
    marked = np.zeros(len(chart), bool)
    for i in range(len(page)):
        for j in range(i):
            f, g = face[i], face[j]
            close = np.linalg.norm(page[i] - page[j]) <= near and chart[f] == chart[g]
            if close and np.linalg.norm(place[i] - place[j]) > apart:
                marked[g if area[g] < area[f] else f] = True
    return marked
