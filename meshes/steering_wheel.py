"""A sports steering wheel: padded rim with thumb rests, three spokes, hub with a horn pad."""

import numpy as np

from meshes.implicit import box, ellipsoid, intersection, rod, smoothstep, union
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
    thick, deep = 14.0 + 2.6 * rest - 1.3 * notch, 16.5 + 1.6 * rest - 1.3 * notch
    grip = 1 - 0.05 * np.cos(3 * tilt)
    away = radius[:, None] + thick[:, None] * np.cos(tilt) * grip
    points = np.stack(
        [away * np.cos(turn)[:, None], away * np.sin(turn)[:, None], deep[:, None] * np.sin(tilt) * grip], -1
    )
    return outward(points.reshape(-1, 3), grid_faces(around, columns, True, True))


def spokes(p):
    """Two spokes to the sides and a forked one below; they sink towards the hub and run into the rim."""
    x, y, z = p.T
    away = np.sqrt(x * x + y * y)
    q = p.copy()
    q[:, 2] = z + 26 * smoothstep(165, 60, away)
    sides = box(q, (0, 4, 0), (RIM, 17, 4.5), 4.0) - 3.0
    sides = union(sides, box(q, (0, 8, 0), (95, 24, 4.5), 4.0) - 2.0, 20)
    foot = np.minimum(
        rod(q * [1, 1, 1.9], (22, -20, 0), (30, -168, 0), 15, 11),
        rod(q * [1, 1, 1.9], (-22, -20, 0), (-30, -168, 0), 15, 11),
    )
    body = union(sides, foot, 16)
    return intersection(body, away - RIM + 3, 2)


def hub(p):
    x, y, z = p.T
    q = p.copy()
    q[:, 2] = z + 24
    bowl = ellipsoid(q, (0, -2, 0), (70, 62, 26))
    pad = box(q, (0, -2, 14), (50, 42, 12), 11.5)
    badge = ellipsoid(q, (0, -2, 25), (15, 15, 3.2))
    body = intersection(bowl, q[:, 2] - 19, 12)
    return union(union(body, pad, 5), badge, 2)


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
