"""A padded watch strap in two halves on a wrist, with holes, keepers and a buckle; its UV are millimetres unrolled."""

import numpy as np

from meshes.implicit import intersection, smoothstep, subtraction
from meshes.model import Part
from meshes.nets import solid
from meshes.sweep import band_section, grid_faces, outward, resampled, round_section, tube

LUG, TIP, HOLES = 20.0, 16.0, np.arange(7)
PAGE = 150.0


def half_width(s, long):
    return 0.5 * (LUG + (TIP - LUG) * np.clip(s / long, 0, 1))


def thickness(s, long):
    """Padded near the case, thin at the end."""
    return 2.4 + 2.2 * smoothstep(0.75 * long, 0.08 * long, s)


def long_half(p):
    s, t, n = p.T
    body = flat_body(p, 118.0)
    body = intersection(body, -rounded_tip(s, t, 118.0), 1.0)
    for hole in HOLES:
        at = 55 + 7.0 * hole
        body = subtraction(body, np.sqrt((s - at) ** 2 + t**2) - 1.25, 0.5)
    return body


def rounded_tip(s, t, long):
    return -(np.sqrt(np.maximum(s - (long - 12), 0) ** 2 + (1.45 * t) ** 2) - 12) * (s > long - 12) + 3.0 * (
        s <= long - 12
    )


def flat_body(p, long):
    s, t, n = p.T
    wide, high = half_width(s, long), thickness(s, long)
    crown = 0.5 * high * np.sqrt(np.clip(1 - 0.35 * (t / wide) ** 4, 0.1, 1))
    side = np.abs(t) - wide
    top, bottom = n - crown, -n - 0.5 * 2.2
    body = intersection(intersection(side, top, 1.8), bottom, 1.2)
    return intersection(body, np.maximum(-s, s - long), 1.0)


def short_half(p):
    return flat_body(p, 74.0)


def unrolled(p, long):
    """UV in millimetres: the top as it lies, the walls folded outward, holes drawn in."""
    s, t, n = p.T
    crown = 0.5 * thickness(s, long)
    depth = np.clip(crown - n, 0, 4)
    wall = smoothstep(0.75, 1.0, np.abs(t) / half_width(s, long))
    return np.stack([s, t + np.sign(t) * depth * wall], 1)


def bent(p, start, sign):
    """Lay the flat strap around a wrist: an oval, from the case downward."""
    turn = np.linspace(0, 2 * np.pi, 4000)
    oval = np.stack([31.0 * np.cos(turn), 25.0 * np.sin(turn)], 1)
    arc = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(oval, axis=0), axis=1))])
    place = (np.interp(0.5 * np.pi, turn, arc) + sign * (start + p[:, 0])) % arc[-1]
    x, y = (np.interp(place, arc, oval[:, i]) for i in (0, 1))
    out = np.stack([x / 31.0**2, y / 25.0**2], 1)
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    lift = p[:, 2] + 2.4 + (4.6 * smoothstep(38, 62, p[:, 0]) if sign < 0 else 0.0)
    return np.stack([x + out[:, 0] * lift, y + out[:, 1] * lift, sign * -p[:, 1]], 1)


def half(function, long, sign, uv_row):
    h = 1.25
    points, faces = solid(
        function,
        np.arange(-3, long + 3.5, h),
        np.arange(-13.2, 13.3, h),
        np.arange(-3.1, 4.4, 0.72),
        rounds=5,
        fair=4,
    )
    a, b, c = (points[faces[:, i]] for i in range(3))
    below = np.cross(b - a, c - a)[:, 2] < 0
    middle = points[faces].mean(axis=1)
    below &= middle[:, 2] < 0
    flat = unrolled(points, long)
    under = np.stack([points[:, 0], points[:, 1]], 1)
    used = [np.unique(faces[~below]), np.unique(faces[below])]
    vertices = np.concatenate([points[u] for u in used])
    uv = np.concatenate([flat[used[0]] + [5, uv_row], under[used[1]] + [5, uv_row + 32]]) / PAGE
    number = np.zeros(len(points), int)
    pieces = []
    for u, chosen, base in ((used[0], ~below, 0), (used[1], below, len(used[0]))):
        number[u] = np.arange(len(u)) + base
        pieces.append(number[faces[chosen]])
    return Part("leather", *outward(bent(vertices, 16.0, sign), np.concatenate(pieces)), uv)


def loop(name, line, section, up, corner):
    """A closed tube laid around the wrist; rows and columns are there twice at the seams, for UV of its own."""
    body, _ = tube(line, section, closed=True, up=up)
    rows, columns = len(line), len(section)
    grid = bent(body, 16.0, 1).reshape(rows, columns, 3)
    grid = np.concatenate([grid, grid[:1]])
    grid = np.concatenate([grid, grid[:, :1]], axis=1)
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(grid[:, 0], axis=0), axis=1))])
    around = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(grid[0], axis=0), axis=1))])
    uv = np.stack(np.meshgrid(along, around, indexing="ij"), -1).reshape(-1, 2)
    return Part(name, *outward(grid.reshape(-1, 3), grid_faces(rows + 1, columns + 1)), (uv + corner) / PAGE)


def keeper(at, corner):
    """A loop of leather across both halves."""
    corners = [
        [10.9, -1.4],
        [11.3, 2.6],
        [10.6, 6.9],
        [0, 7.9],
        [-10.6, 6.9],
        [-11.3, 2.6],
        [-10.9, -1.4],
        [0, -2.6],
    ]
    line = resampled(np.column_stack([np.full(8, at), np.array(corners, float)]), 1.3, closed=True)
    return loop("leather", line, band_section(4.6, 1.4, 5), line - [at, 0, 2.6], corner)


def buckle():
    """A metal frame in front of the short half."""
    corners = [
        [71, 10.6, 0.6],
        [77, 11.4, 1.4],
        [83, 10.8, 2.2],
        [84.4, 0, 2.4],
        [83, -10.8, 2.2],
        [77, -11.4, 1.4],
        [71, -10.6, 0.6],
        [70, 0, 0.4],
    ]
    return loop(
        "metal", resampled(corners, 1.2, closed=True), round_section(1.35, 10), (0.0, 0.0, 1.0), [5, 127]
    )


def build():
    return [
        half(long_half, 118.0, -1, 16.0), half(short_half, 74.0, 1, 80.0),
        keeper(61.0, [82, 68]), keeper(40.0, [82, 84]), buckle(),
    ]  # fmt: skip
