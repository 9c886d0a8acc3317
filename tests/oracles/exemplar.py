"""Slow twins of the clique kernels: every neighbour is looked up by its coordinates."""

import numpy as np

from surftex.randomness import Stream


def pair_counts(picture, pair_type, *, wrap, joint=False, label=None):
    """(groups + 1, k, 64) counts; picture (c, h, w) with 255 for missing levels."""
    _, height, width = picture.shape
    groups = 1 if label is None else int(label.max()) + 1
    count = np.zeros((groups + 1, len(pair_type), 64), int)
    for k, (head, tail, right, down) in enumerate(pair_type):
        for y in range(height):
            for x in range(width):
                there = place(x + right, y + down, width, height, wrap=wrap)
                if there is None:
                    continue
                a, b = int(picture[head, y, x]), int(picture[tail, there[1], there[0]])
                if 255 in (a, b):
                    continue
                which = 0
                if label is not None:
                    same = label[y, x] == label[there[1], there[0]]
                    which = label[y, x] if same else groups
                count[which, k, 8 * a + b if joint else b - a + 31] += 1
    return count


def quad_counts(picture, band, shape, quarter, *, wrap):
    """(j, 256) counts of one group; quarter (c, 256)."""
    _, height, width = picture.shape
    count = np.zeros((len(band), 256), int)
    for j, corners in enumerate(shape):
        for y in range(height):
            for x in range(width):
                places = [place(x + right, y + down, width, height, wrap=wrap) for right, down in corners]
                if None in places:
                    continue
                levels = [picture[band[j], v, u] for u, v in places]
                if 255 not in levels:
                    a, b, c, d = (int(quarter[band[j], each]) for each in levels)
                    count[j, 64 * a + 16 * b + 4 * c + d] += 1
    return count


def place(x, y, width, height, *, wrap):
    """Where a step leads: None beyond a picture that ends."""
    if wrap:
        return x % width, y % height
    return (x, y) if 0 <= x < width and 0 <= y < height else None


def drawn(number, total, exponential):
    """The level that a random number chooses, by summed potentials (levels,)."""
    share = exponential[np.minimum(total - total.min(), len(exponential) - 1)].astype(np.float32)
    summed = np.cumsum(share, dtype=np.float32)
    return int((summed[:-1] <= np.float32(number) * summed[-1]).sum())


def sweep(relaxation, picture):
    """What one sweep of a `Relaxation` makes of picture (c, h, w) on a torus, one band of one group."""
    target, lattice = relaxation.target, relaxation.lattice
    table, single, _, exponential = relaxation._tables()
    table = table.reshape(-1, 64)
    width, height = lattice.width, lattice.height
    step, shift = target.code
    count = len(relaxation.classes)
    random = Stream(relaxation.random.key)
    start = int(random.at(np.array([relaxation.turn]))[0] * count)
    result = picture.copy()
    for number in range(count):
        before = result.copy()
        for p in relaxation.classes[(start + number) % count]:
            y, x = (each - lattice.margin for each in divmod(int(p), width + 2 * lattice.margin))
            total = single[0, 0, : target.levels].astype(int)
            for k, (_, _, right, down) in enumerate(target.pair_type):
                for turn, row in ((-1, 2 * k), (1, 2 * k + 1)):
                    s = int(before[0, (y + turn * down) % height, (x + turn * right) % width])
                    begin = shift + step * s
                    total = total + table[row, begin : begin + target.levels]
            for j, shape in enumerate(target.quad_shape):
                for corner in range(4):
                    places = shape - shape[corner]
                    near = [before[0, (y + v) % height, (x + u) % width] for u, v in places]
                    fours = [
                        np.ravel_multi_index(
                            [q if i == corner else target.quarter[0, 0, near[i]] for i in range(4)], [4] * 4
                        )
                        for q in range(4)
                    ]
                    potential = relaxation.quad[0, j]
                    codes = [i for i in range(4) if i != corner]
                    assert len(codes) == 3
                    lift = potential[fours] - potential[fours].min()
                    whole = np.rint(relaxation.scale * lift).astype(int)
                    total = total + whole[target.quarter[0, 0, : target.levels]]
            counter = relaxation.turn * lattice.places + int(p)
            result[0, y, x] = drawn(random.at(np.array([counter]))[0], total, exponential)
    return result
