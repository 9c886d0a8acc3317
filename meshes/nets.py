"""Polygons from functions: surface nets on a grid, evened out along the surface and pulled onto the zero set."""

import numpy as np
from scipy.sparse import coo_array


def axis(*stops):
    """Grid lines with the spacing changing from stop to stop: (place, spacing) pairs, ascending."""
    lines = [stops[0][0]]
    places = np.array([place for place, _ in stops], float)
    spacings = np.array([spacing for _, spacing in stops], float)
    while lines[-1] < places[-1]:
        lines.append(lines[-1] + np.interp(lines[-1], places, spacings))
    return np.array(lines)


def evaluate(function, points, block=200_000):
    return np.concatenate([function(points[i : i + block]) for i in range(0, len(points), block)])


def without_checkers(value):
    """Fill grid squares whose corners alternate in sign, which would join four sheets in one edge."""
    for _ in range(20):
        found = 0
        for u, v in ((0, 1), (1, 2), (2, 0)):
            corners = []
            for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                cut = [slice(None)] * 3
                cut[u] = slice(du, value.shape[u] - 1 + du)
                cut[v] = slice(dv, value.shape[v] - 1 + dv)
                corners.append(value[tuple(cut)])
            signs = [corner < 0 for corner in corners]
            checker = (signs[0] == signs[2]) & (signs[1] == signs[3]) & (signs[0] != signs[1])
            for where in np.argwhere(checker):
                nodes = []
                for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    node = where.copy()
                    node[u] += du
                    node[v] += dv
                    nodes.append(tuple(node))
                outer = [node for node in nodes if value[node] >= 0]
                if len(outer) == 2:
                    value[min(outer, key=lambda node: value[node])] = -1e-3
                    found += 1
        found += _without_opposites(value)
        if not found:
            break
    return value


def _without_opposites(value):
    """Drop one of two inner corners that face each other across a cell, or of two outer ones."""
    corners = {
        (i, j, k): value[tuple(slice(d, n - 1 + d) for d, n in zip((i, j, k), value.shape, strict=True))] < 0
        for i in (0, 1)
        for j in (0, 1)
        for k in (0, 1)
    }
    count = sum(corner.astype(int) for corner in corners.values())
    found = 0
    for a in ((0, 0, 0), (0, 0, 1), (0, 1, 0), (1, 0, 0)):
        b = tuple(1 - d for d in a)
        for inside, wanted in ((True, 2), (False, 6)):
            for where in np.argwhere((count == wanted) & (corners[a] == inside) & (corners[b] == inside)):
                nodes = [tuple(where + np.array(d)) for d in (a, b)]
                node = min(nodes, key=lambda node: abs(value[node]))
                value[node] = 1e-3 if inside else -1e-3
                found += 1
    return found


def surface_nets(function, xs, ys, zs):
    """Quads, outward, around the solid where `function` is negative; one vertex per mixed cell."""
    shape = (len(xs), len(ys), len(zs))
    grid = np.stack(np.meshgrid(xs, ys, zs, indexing="ij"), axis=-1).reshape(-1, 3)
    value = without_checkers(evaluate(function, grid).reshape(shape))
    grid = grid.reshape(*shape, 3)
    inside = value < 0
    cells = tuple(n - 1 for n in shape)
    total, count = np.zeros((*cells, 3)), np.zeros(cells)
    quads = []
    for along in range(3):
        low = [slice(None)] * 3
        high = [slice(None)] * 3
        low[along], high[along] = slice(None, -1), slice(1, None)
        a, b = value[tuple(low)], value[tuple(high)]
        mixed = (a < 0) != (b < 0)
        t = np.where(mixed, a / np.where(mixed, a - b, 1.0), 0.0)[..., None]
        crossing = grid[tuple(low)] * (1 - t) + grid[tuple(high)] * t
        u, v = (along + 1) % 3, (along + 2) % 3
        for du in (0, 1):
            for dv in (0, 1):
                # The cell at (i - du, j - dv) has the grid edge (i, j) as one of its twelve.
                source, target = [slice(None)] * 3, [slice(None)] * 3
                source[u] = slice(1, None) if du else slice(None, -1)
                source[v] = slice(1, None) if dv else slice(None, -1)
                target[along] = slice(None)
                total[tuple(target)] += (crossing * mixed[..., None])[tuple(source)]
                count[tuple(target)] += mixed[tuple(source)]
        where = np.argwhere(mixed)
        keep = (where[:, u] > 0) & (where[:, u] < cells[u]) & (where[:, v] > 0) & (where[:, v] < cells[v])
        if not keep.all():
            raise ValueError("the solid touches the border of its grid")
        corner = []
        for du, dv in ((1, 1), (0, 1), (0, 0), (1, 0)):
            cell = where.copy()
            cell[:, u] -= du
            cell[:, v] -= dv
            corner.append(np.ravel_multi_index(cell.T, cells))
        quad = np.stack(corner, axis=1)
        outward = inside[tuple(low)][mixed]
        quads.append(np.where(outward[:, None], quad, quad[:, ::-1]))
    quads = np.concatenate(quads)
    used, index = np.unique(quads, return_inverse=True)
    points = (total.reshape(-1, 3)[used]) / count.reshape(-1)[used, None]
    return points, index.reshape(-1, 4)


def without_doublets(points, quads):
    """Melt two quads around a vertex that has no third into one."""
    while True:
        degree = np.bincount(quads.ravel(), minlength=len(points))
        gone = np.zeros(len(quads), bool)
        extra = []
        for vertex in np.flatnonzero(degree == 2):
            pair = np.flatnonzero((quads == vertex).any(axis=1))
            if len(pair) < 2 or gone[pair].any():
                continue
            first, second = (np.roll(quads[q], -int(np.argmax(quads[q] == vertex))) for q in pair)
            gone[pair] = True
            extra.append([first[1], first[2], first[3], second[2]])
        if not extra:
            used, index = np.unique(quads, return_inverse=True)
            return points[used], index.reshape(-1, 4)
        quads = np.concatenate([quads[~gone], np.array(extra)])


def gradient(function, points, step=0.05):
    result = np.zeros_like(points)
    for i in range(3):
        shift = np.zeros(3)
        shift[i] = step
        result[:, i] = (evaluate(function, points + shift) - evaluate(function, points - shift)) / (2 * step)
    return result


def pulled(function, points, most):
    """One Newton step onto the zero set, at most `most` millimetres; with the unit normals."""
    slope = gradient(function, points)
    size2 = np.maximum((slope**2).sum(axis=1), 1e-6)
    step = np.clip(evaluate(function, points) / np.sqrt(size2), -most, most)
    normal = slope / np.sqrt(size2)[:, None]
    return points - step[:, None] * normal, normal


def neighbours(quads, count):
    a = np.concatenate([quads.ravel(), np.roll(quads, -1, axis=1).ravel()])
    b = np.concatenate([np.roll(quads, -1, axis=1).ravel(), quads.ravel()])
    links = coo_array((np.ones(len(a)), (a, b)), shape=(count, count)).tocsr()
    links.data[:] = 1.0
    return links, links.sum(axis=1)[:, None]


def triangles(points, quads):
    """Cut each quad along its shorter diagonal, or along the other one where that edge is taken."""
    a, b, c, d = (points[quads[:, i]] for i in range(4))
    first = ((a - c) ** 2).sum(axis=1) <= ((b - d) ** 2).sum(axis=1)
    side = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2), axis=1) @ [
        len(points),
        1,
    ]
    for _ in range(4):
        cross = np.sort(np.where(first[:, None], quads[:, [0, 2]], quads[:, [1, 3]]), axis=1) @ [
            len(points),
            1,
        ]
        _, index, count = np.unique(cross, return_inverse=True, return_counts=True)
        taken = (count[index] > 1) | np.isin(cross, side)
        if not taken.any():
            break
        again = np.flatnonzero(taken)
        again = again[np.sort(np.unique(cross[again], return_index=True)[1])]
        first[again] = ~first[again]
    cut = np.where(first[:, None], quads[:, [0, 1, 2, 0, 2, 3]], quads[:, [1, 2, 3, 1, 3, 0]])
    return cut.reshape(-1, 3)


def lens(centres, powers, widths):
    """Space seen through lenses: a function from the places of an even grid to points, closer together near the centres."""

    def seen(points):
        result = points.copy()
        for centre, power, width in zip(centres, powers, widths, strict=True):
            away = points - np.asarray(centre, float)
            result += power * away / (1 + (away**2).sum(axis=1) / width**2)[:, None]
        return result

    def unseen(places):
        points = 0.8 * places
        for _ in range(60):
            points += 0.37 * (places - seen(points))
        return points

    return seen, unseen


def solid(function, xs, ys, zs, rounds=12, most=None, fair=10, unseen=None):
    """Triangles of the zero set: nets, rounds of evening out along it, each with a pull back; then `fair` of fairing."""
    if unseen is None:
        points, quads = without_doublets(*surface_nets(function, xs, ys, zs))
    else:
        points, quads = without_doublets(*surface_nets(lambda places: function(unseen(places)), xs, ys, zs))
        points = unseen(points)
    most = most or 0.5 * float(np.diff(xs).min())
    links, degree = neighbours(quads, len(points))
    points, normal = pulled(function, points, most)
    for _ in range(rounds):
        move = (links @ points) / degree - points
        move -= (move * normal).sum(axis=1, keepdims=True) * normal
        points, normal = pulled(function, points + 0.6 * move, most)
    points, _ = pulled(function, points, most)
    for weight in (0.5, -0.53) * fair:
        points = points + weight * ((links @ points) / degree - points)
    return points, triangles(points, quads)
