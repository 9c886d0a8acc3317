"""A derby shoe, left foot, EU 42: upper with cap, facings and tongue; welted sole with heel; laces.

z runs from the heel (-) to the toe (+), x across (the inner side of this left shoe is -x), y up from the ground.
"""

from itertools import pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator

from meshes.implicit import intersection, length, rod, smoothstep, subtraction, union
from meshes.model import Part
from meshes.nets import axis, gradient, pulled, solid
from meshes.sweep import band_section, grid_faces, outward, resampled, round_section, tube

WALL = 6.6
BED = PchipInterpolator([-150, -100, -50, 0, 45, 80, 120, 160], [29, 28, 24, 15, 9, 9, 13, 20])
"""Height of the insole."""
TOP = PchipInterpolator([-150, -60, -20, 20, 50, 80, 105, 130, 160], [150, 150, 122, 96, 79, 66, 57, 48, 40])
"""Height of the ridge of the upper, before the collar cuts it."""
LEAN = PchipInterpolator([-150, -110, -60, -10, 40, 90, 150], [0.06, 0.08, 0.14, 0.24, 0.20, 0.10, 0.05])
"""How far the wall leans in for each millimetre of height."""
COLLAR = PchipInterpolator([-150, -122, -95, -65, -35, -5, 30], [90, 89, 79, 73, 79, 92, 112])
"""Height of the opening."""


def plan(p):
    """Distance to the outline of the foot, seen from above."""
    q = np.stack([p[:, 0], np.zeros(len(p)), p[:, 2]], 1)
    heel = rod(q, (1, 0, -107), (3, 0, -70), 29.5, 28.5)
    waist = rod(q, (3, 0, -70), (2, 0, 30), 28.5, 39)
    ball = rod(q, (2, 0, 30), (-4, 0, 66), 41, 42)
    toe = rod(q, (-4, 0, 66), (-9, 0, 104), 42, 30)
    return union(union(heel, waist, 14), union(ball, toe, 14), 14)


def cap(p):
    """The toe cap and the facings lie on top of the vamp, the counter on top of the heel: each with a clear edge."""
    z = p[:, 2]
    edge = 74 + 0.0015 * (p[:, 0] + 6) ** 2
    low = np.maximum(0, 72 - p[:, 1])
    facing, slope = 46 - 0.3 * low - 0.012 * low**2, 0.3 + 0.024 * low
    back = smoothstep(1.5, -1.5, (z - facing) / np.sqrt(1 + slope**2))
    counter = smoothstep(1.5, -1.5, z + 84 + 0.35 * np.maximum(p[:, 1] - 40, 0))
    return 2.2 * smoothstep(-1.4, 1.4, z - edge) + 2.4 * back + 1.8 * counter


def last(p):
    """The body that the upper clothes."""
    x, y, z = p.T
    bed, ridge = BED(z), TOP(z)
    rise = np.maximum(y - bed, 0)
    lean = LEAN(z) * np.maximum(rise - 14, 0) + 0.10 * np.maximum(16 - rise, 0) ** 2 / 16 * 2
    bulge = 2.5 * np.exp(-(((rise - 22) / 16) ** 2)) * smoothstep(-60, -110, z)
    side = (plan(p) + lean - bulge) * 0.95
    roof = (y - ridge) * 0.86
    body = intersection(side, roof, 44)
    return intersection(body, bed - y, 7)


def collar(p):
    return p[:, 1] - COLLAR(p[:, 2])


def slit(p):
    """The gap between the facings, under the laces."""
    half = 5.0 + 0.05 * np.clip(40 - p[:, 2], 0, 100)
    return np.maximum(np.abs(p[:, 0] + 2) - half, np.abs(p[:, 2]) - 36)


def upper(p):
    outer = last(p) - cap(p)
    inner = last(p) + WALL
    padded = inner + 1.6 * smoothstep(-26, -4, collar(p))
    shell = subtraction(outer, padded, 2.0)
    shell = intersection(shell, collar(p) * 0.9, 9.0)
    gap = intersection(slit(p), 48 - p[:, 1], 3.0)
    return subtraction(shell, gap, 4.0)


def instep(x, z, depth):
    """Height at which a place lies `depth` under the outside of the last."""
    low, high = np.full(np.broadcast(x, z).shape, 30.0), np.full(np.broadcast(x, z).shape, 160.0)
    for _ in range(40):
        half = 0.5 * (low + high)
        flat = np.stack([np.broadcast_to(x, half.shape), half, np.broadcast_to(z, half.shape)], -1)
        inside = last(flat.reshape(-1, 3)).reshape(half.shape) < -depth
        low, high = np.where(inside, half, low), np.where(inside, high, half)
    return low


def tongue():
    """A padded band under the slit, arched as the instep is, standing out at the ankle with a round end."""
    z = np.linspace(50, -36, 40)
    y = instep(-2.0, np.maximum(z, -12.0), WALL + 3.5)
    y = y + 0.85 * np.maximum(-12.0 - z, 0)
    line = resampled(np.stack([np.full(40, -2.0), y, z], 1), 3.4)
    arc = 3.4 * np.arange(len(line))
    ends = np.clip(np.minimum(arc, arc[::-1]) / 13.0, 0.06, 1)
    width = (30 + 3 * arc / arc[-1]) * np.sqrt(1 - (1 - ends) ** 2)
    sections = []
    for wide, end in zip(width, ends, strict=True):
        section = band_section(wide, 3.2 + 2.4 * end, 9)
        section[:, 1] -= 0.021 * section[:, 0] ** 2
        sections.append(section)
    return tube(line, np.stack(sections))


def outline(out, back, step):
    """Four sides (heel, outer, toe, inner) of the foot's outline, `out` mm wider, cut at `back` if given."""
    angle = np.linspace(0, 2 * np.pi, 240, endpoint=False)
    loop = np.stack([45 * np.sin(angle), 0 * angle, -135 * np.cos(angle)], 1)
    for _ in range(40):
        loop, _ = pulled(lambda q: plan(q) - out, loop, 4.0)
        loop = resampled(
            loop, np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1).sum() / 240, closed=True
        )
    if back is not None:
        loop = loop[np.lexsort((loop[:, 0], loop[:, 2]))]
        keep = loop[loop[:, 2] < back]
        right = keep[keep[:, 0] > 1][np.argsort(keep[keep[:, 0] > 1][:, 2])]
        left = keep[keep[:, 0] <= 1][np.argsort(keep[keep[:, 0] <= 1][:, 2])]
        breast = [
            [x, 0, back - 4 + 4 * (x / 30) ** 2] for x in np.linspace(right[-1, 0], left[-1, 0], 20)[1:-1]
        ]
        corners = [left[len(left) // 4], right[len(right) // 4], right[-1], left[-1]]
        loop = np.concatenate([right, breast, left[::-1]])
    else:
        corners = [[-24, 0, -131], [27, 0, -131], [14, 0, 126], [-32, 0, 126]]
    at = [int(np.argmin(length(loop - np.asarray(corner)))) for corner in corners]
    sides = []
    for first, last_one in zip(at, at[1:] + at[:1], strict=True):
        run = np.arange(first, last_one + 1 if last_one > first else last_one + len(loop) + 1) % len(loop)
        sides.append(loop[run])
    across = round(length(np.diff(sides[0], axis=0)).sum() / step * 1.4)
    along = round(length(np.diff(sides[1], axis=0)).sum() / step)
    return [evenly(side, count) for side, count in zip(sides, (across, along, across, along), strict=True)]


def evenly(line, count):
    arc = np.concatenate([[0], np.cumsum(length(np.diff(line, axis=0)))])
    return np.stack([np.interp(np.linspace(0, arc[-1], count + 1), arc, line[:, i]) for i in range(3)], 1)


def slab(sides, top, bottom, rounding, rows):
    """A body between two heights over an outline: two sheets of a Coons patch, and a rounded wall."""
    heel, outer, toe, inner = sides[0], sides[1], sides[2][::-1], sides[3][::-1]
    u, v = np.linspace(0, 1, len(heel))[None, :, None], np.linspace(0, 1, len(outer))[:, None, None]
    patch = (1 - v) * heel[None] + v * toe[None] + (1 - u) * inner[:, None] + u * outer[:, None]
    patch -= (1 - u) * (1 - v) * heel[0] + u * (1 - v) * heel[-1] + (1 - u) * v * toe[0] + u * v * toe[-1]
    links = patch.copy()
    for _ in range(60):
        links[1:-1, 1:-1] = 0.25 * (links[2:, 1:-1] + links[:-2, 1:-1] + links[1:-1, 2:] + links[1:-1, :-2])
    rim = np.concatenate([links[0, :-1], links[:-1, -1], links[-1, :0:-1], links[:0:-1, 0]])
    middle = np.stack(
        [
            0 * rim[:, 0],
            0 * rim[:, 0],
            np.clip(rim[:, 2], *(np.array([0.9, 0.9]) * [rim[:, 2].min(), rim[:, 2].max()])),
        ],
        1,
    )
    inward = middle - rim
    inward /= length(inward)[:, None]
    n, m = links.shape[:2]
    sheet = links.reshape(-1, 3)
    number = np.arange(n * m).reshape(n, m)
    edge = np.concatenate([number[0, :-1], number[:-1, -1], number[-1, :0:-1], number[:0:-1, 0]])
    grid = grid_faces(n, m)
    points, faces = [], []
    for height, flip in ((top, True), (bottom, False)):
        body = sheet.copy()
        body[edge] += rounding * inward
        body[:, 1] = height(body)
        faces.append((grid[:, ::-1] if flip else grid) + len(points) * n * m)
        points.append(body)
    count = len(rim)
    walls = []
    for turn in np.linspace(0, np.pi, rows + 2)[1:-1]:
        ring_ = rim + rounding * (1 - np.sin(turn) ** 0.6) * inward
        share = 0.5 + 0.5 * np.cos(turn)
        ring_[:, 1] = share * top(ring_) + (1 - share) * bottom(ring_)
        walls.append(2 * n * m + len(walls) * count + np.arange(count))
        points.append(ring_)
    walls = [edge, *walls, n * m + edge]
    for a, b in pairwise(walls):
        faces += [np.stack([a, b, np.roll(b, -1)], 1), np.stack([a, np.roll(b, -1), np.roll(a, -1)], 1)]
    return outward(np.concatenate(points), np.concatenate(faces))


def sole():
    tread = slab(outline(4.5, None, 5.0), lambda p: BED(p[:, 2]) + 2.8, lambda p: BED(p[:, 2]) - 6.5, 0.9, 3)
    lift = slab(outline(3.0, -56.0, 5.0), lambda p: BED(p[:, 2]) - 5.5, lambda p: 0.0 * p[:, 1], 0.8, 5)
    return tread, lift


def on_upper(points, lift):
    """Points pulled onto the outside of the upper, then lifted."""
    outer = lambda q: last(q) - cap(q) - lift  # noqa: E731
    for _ in range(12):
        points, _ = pulled(outer, points, 6.0)
    return points


def lace_bars():
    """Four bars across the slit, ends tucked into eyelets."""
    bars = []
    for z in (33.0, 27.0, 21.0, 15.0):
        half = 14.0 + 0.05 * (30 - z)
        x = np.linspace(-half, half, 13) - 2
        height = float(TOP(z)) + 10
        line = on_upper(np.stack([x, np.full(13, height), np.full(13, z)], 1), 1.3)
        middle = np.abs(x + 2) < half - 4
        chord = np.interp(x, x[[2, -3]], line[[2, -3], 1])
        line[:, 1] = np.where(middle, np.maximum(line[:, 1], chord), line[:, 1])
        line[[0, -1]] = on_upper(line[[0, -1]], -2.2)
        normal = gradient(last, line)
        line = resampled(line, 2.6)
        bars.append(tube(line, band_section(4.6, 2.0, 4), up=nearest(line, normal)))
    return bars


def nearest(line, normal):
    at = np.linspace(0, len(normal) - 1, len(line))
    return np.stack([np.interp(at, np.arange(len(normal)), normal[:, i]) for i in range(3)], 1)


def bow():
    """Knot, two loops and two ends."""
    knot = on_upper(np.array([[-2.0, 130.0, 15.0]]), 4.5)[0]
    parts = []
    for side in (-1, 1):
        loop = np.array(
            [
                [0, 0, 0],
                [9, 5, 5],
                [20, 4, 13],
                [29, -4, 17],
                [33, -11, 12],
                [28, -7, 5],
                [17, 1, 1],
                [7, 3, -2],
                [0, 0, -1],
            ],
            float,
        )
        end = np.array([[0, 0, 1], [7, 3, 9], [14, 0, 20], [20, -8, 30], [24, -17, 37]], float)
        for number, shape in enumerate((loop, end)):
            line = knot + shape * [side, 1, 1] + [0.3 * side, 0.2 * number, 0]
            line = resampled(line, 1.9)
            body = last(line) - cap(line) - 1.9
            slope = gradient(last, line)
            slope /= np.maximum(length(slope), 1e-9)[:, None]
            line = line - np.minimum(body, 0)[:, None] * slope
            parts.append(tube(resampled(line[::2], 3.0), round_section(1.9, 6, 0.8), up=(0.0, 1.0, 0.01)))
    x = np.linspace(-5, 5, 9)
    line = knot + np.stack([x, 1.0 + 0 * x, 0 * x], 1)
    radius = 3.9 * np.sqrt(np.maximum(1 - (x / 5.2) ** 2, 0.05))
    parts.append(tube(line, np.stack([round_section(r, 10) for r in radius])))
    return parts


def build():
    h = 4.4
    xs = np.arange(-58, 58, h)
    zs = axis((-152, 4.6), (58, 4.6), (70, 2.4), (79, 2.4), (92, 4.6), (152, 4.6))
    shell = solid(upper, xs, np.arange(2, 128, h), zs, rounds=3, fair=5)
    laces = [Part("laces", *body) for body in (*lace_bars(), *bow())]
    return [
        Part("upper", *shell),
        Part("upper", *tongue()),
        *(Part("sole", *body) for body in sole()),
        *laces,
    ]
