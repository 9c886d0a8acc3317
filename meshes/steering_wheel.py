"""A sports steering wheel: padded rim with thumb rests, three spokes, hub with a horn pad."""

import numpy as np

from meshes.implicit import box, ellipsoid, intersection, rod, smoothstep, subtraction, union
from meshes.model import Part
from meshes.nets import solid
from meshes.sweep import grid_faces, outward

RIM = 178.0


def rim():
    """A ring of oval section, fuller at ten and two o'clock, flattened a little at the foot."""
    around, columns = 220, 22
    turn = np.arange(around) * 2 * np.pi / around
    angle = np.degrees(turn)
    rest = sum(np.exp(-((((angle - at + 180) % 360 - 180) / 9.0) ** 2)) for at in (22, 158))
    notch = sum(np.exp(-((((angle - at + 180) % 360 - 180) / 3.0) ** 2)) for at in (40, 140))
    radius = RIM - 10 * smoothstep(-0.70, -1.0, np.sin(turn))
    tilt = np.arange(columns) * 2 * np.pi / columns
    thick, deep = 14.0 + 3.4 * rest - 1.8 * notch, 16.5 + 2.4 * rest - 1.8 * notch
    grip = 1 - 0.05 * np.cos(3 * tilt)
    away = radius[:, None] + thick[:, None] * np.cos(tilt) * grip
    points = np.stack(
        [away * np.cos(turn)[:, None], away * np.sin(turn)[:, None], deep[:, None] * np.sin(tilt) * grip], -1
    )
    return outward(points.reshape(-1, 3), grid_faces(around, columns, True, True))


def spokes(p):
    """Two spokes to the sides and one below with an opening; broad at the hub, slim at the rim, sunk towards the hub."""
    x, y, z = p.T
    away = np.sqrt(x * x + y * y)
    deep = z + 26 * smoothstep(165, 60, away)
    half = 13.5 + 13 * smoothstep(150, 50, np.abs(x)) + 4 * smoothstep(150, 172, np.abs(x))
    sides = box(np.stack([x, (y - 6) / half * 20, deep], 1), (0, 0, 0), (RIM, 20, 7.0), 6.5)
    wide = 21 + 17 * smoothstep(-150, -50, y) + 7 * smoothstep(-150, -172, y)
    foot = box(np.stack([x / wide * 30, y, deep], 1), (0, -90, 0), (30, 90, 6.5), 6.0)
    flat = np.stack([x, y, 0 * z], 1)
    opening = rod(flat, (0, -92, 0), (0, -142, 0), 13, 9)
    body = union(sides, subtraction(foot, opening, 7), 18)
    return intersection(body, away - RIM + 3, 2)


def hub(p):
    """A round boss, on it the horn pad: a shield with full cheeks, parted by a groove, and a badge in a shallow dish."""
    x, y, z = p.T
    q = p.copy()
    q[:, 2] = z + 24
    bowl = intersection(ellipsoid(q, (0, -2, 0), (72, 64, 26)), q[:, 2] - 15, 9)
    front = 0.0016 * x * x + 0.0022 * (y + 2) ** 2
    shield = np.stack([x / (1 + 0.0032 * (y + 2)), y, q[:, 2] + front], 1)
    pad = box(shield, (0, -2, 15), (50, 43, 14), 13.0)
    dish = ellipsoid(q, (0, -2, 33), (22, 22, 7))
    badge = ellipsoid(q, (0, -2, 26), (13, 13, 4.5))
    return union(union(bowl, subtraction(pad, dish, 3), 2), badge, 1.5)


def build():
    h = 4.6
    arms = solid(
        spokes,
        np.arange(-190, 190, h),
        np.arange(-190, 60, h),
        np.arange(-50, 24, h * 0.75),
        rounds=5,
        fair=8,
    )
    middle = solid(hub, np.arange(-84, 84, h), np.arange(-78, 74, h), np.arange(-62, 24, h), rounds=5, fair=6)
    return [Part("rim", *rim()), Part("spokes", *arms), Part("hub", *middle)]
