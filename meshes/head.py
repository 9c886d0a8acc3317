"""A head with neck, an adult's size: built up from masses as a sculptor would, left and right alike.

x to the side, y up, z to the front; the eyes are at y = 0, the ears near z = -10.
"""

import numpy as np

from meshes.implicit import ball, ellipsoid, intersection, near, path, rod, subtraction, union
from meshes.model import Part
from meshes.nets import lens, solid

EYE = np.array([31.5, -1.0, 68.5])


def skull(p):
    cranium = ellipsoid(p, (0, 30, -14), (75, 86, 98))
    forehead = ellipsoid(p, (0, 42, 34), (58, 48, 50))
    face = ellipsoid(p, (0, -36, 25), (63, 76, 61))
    head = union(union(cranium, forehead, 30), face, 34)
    head = union(head, ellipsoid(p, (42, -30, 55), (22, 18, 20), yaw=35), 44)
    head = union(head, ellipsoid(p, (36, -62, 52), (24, 28, 22), yaw=30), 40)
    jaw = path(p, [(57, -30, -2), (54, -66, 6), (34, -94, 46), (12, -106, 70)], [14, 14, 13, 12], 10)
    head = union(head, jaw, 30)
    head = union(head, ellipsoid(p, (0, -104, 75), (19, 14, 14)), 20)
    # Temples and the hollow under the cheekbones.
    head = subtraction(head, ellipsoid(p, (90, 20, 48), (18, 30, 32)), 36)
    return subtraction(head, ellipsoid(p, (84, -64, 60), (14, 22, 20)), 36)


def neck(p):
    column = rod(p, (0, -56, -34), (0, -190, -36), 53, 56)
    muscle = path(p, [(62, -38, -24), (44, -110, -4), (14, -184, 24)], [8, 9, 9], 12)
    shoulder = rod(p, (10, -150, -56), (74, -214, -48), 30, 34)
    body = union(union(column, muscle, 34), shoulder, 60)
    return union(body, ellipsoid(p, (0, -138, 17), (10, 15, 9)), 30)


def brow(p):
    return path(p, [(4, 13, 83), (20, 17.5, 83), (38, 19.5, 76), (55, 10, 57)], [6, 6, 6, 5], 10)


def nose(p):
    bridge = path(p, [(0, 14, 82), (0, -6, 92), (0, -28, 102.5), (0, -38.5, 106.5)], [5.5, 5.6, 7.2, 8.4], 12)
    sides = rod(p, (3, 2, 82), (9.5, -42, 91), 5, 8.5)
    body = union(bridge, sides, 24)
    wing = ellipsoid(p, (12.8, -42, 95.5), (6.8, 7.2, 10), yaw=12)
    body = union(body, wing, 7)
    return union(body, ellipsoid(p, (0, -46.5, 101), (3.6, 4.5, 9)), 6)


def nostril(p):
    return ellipsoid(p, (6.8, -51.5, 99.5), (3.6, 6.0, 6.0), yaw=-18, pitch=0)


def lips(p):
    muzzle = ellipsoid(p, (0, -72, 72), (36, 27, 20))
    upper = path(
        p, [(0, -68.2, 96.0), (6, -67.0, 95.8), (16, -69.8, 93.2), (28, -73.8, 88.0)], [3.8, 4.3, 3.9, 2.0], 0
    )
    lower = path(
        p,
        [(0, -78.6, 94.0), (10, -78.2, 92.8), (19, -76.8, 90.5), (28, -74.6, 88.0)],
        [5.4, 5.2, 4.2, 2.0],
        0,
    )
    return muzzle, upper, lower


def eye(p):
    """Lids as a shell around the ball, parted by an almond."""
    q = p - EYE
    dx = np.where(q[:, 0] > -1, (q[:, 0] + 1) / 14.5, (q[:, 0] + 1) / 15.0)
    arch = np.clip(1 - dx * dx, -1, 1)
    tilt = 0.07 * q[:, 0]
    upper = 6.4 * arch * (1 + 0.12 * -dx) + tilt - 0.5
    lower = -4.6 * arch * (1 + 0.15 * dx) + tilt - 0.5
    opening = np.maximum(q[:, 1] - upper, lower - q[:, 1])
    opening = np.maximum(opening, 2 - q[:, 2]) * 0.8
    lid = ball(p, EYE, 14.8)
    lid = union(lid, ellipsoid(p, EYE + [-14.5, -1.6, 7.0], (4.5, 3.0, 4.0)), 5)
    lid = union(lid, ellipsoid(p, EYE + [13.5, -0.5, 4.0], (5, 4.0, 5)), 5)
    crease = path(
        p,
        [EYE + [-12, 7.5, 12], EYE + [-3, 12.2, 11.5], EYE + [8, 11.4, 10], EYE + [15, 6, 5]],
        [1.6, 1.9, 1.9, 1.6],
        0,
    )
    t = np.linspace(-0.98, 0.98, 6)
    x = np.where(t < 0, 15.0 * t, 14.5 * t) - 1
    rims = []
    for high, radius in (
        (6.6 * (1 - t * t) * (1 - 0.12 * t), 1.9),
        (-4.6 * (1 - t * t) * (1 + 0.15 * t), 1.6),
    ):
        y = high + 0.07 * x - 0.5
        z = np.sqrt(14.6**2 - np.minimum(x**2 + y**2, 190))
        rims.append(path(p, EYE + np.stack([x, y, z], 1), np.full(6, radius), 0, 2))
    pupil = ellipsoid(p, EYE + [-0.5, 0.4, 12.6], (4.2, 4.2, 1.7))
    return lid, opening, subtraction(ball(p, EYE, 12.5), pupil, 0.8), crease, np.minimum(*rims)


def ear(p):
    shift = np.array([76.0, -12.0, -10.0])
    q = p - shift
    # The auricle leans back and stands off the head by some twenty-five degrees.
    c, s = np.cos(np.radians(24)), np.sin(np.radians(24))
    q = np.stack([q[:, 0] * c + q[:, 2] * s, q[:, 1], -q[:, 0] * s + q[:, 2] * c], 1)
    c, s = np.cos(np.radians(9)), np.sin(np.radians(9))
    q = np.stack([q[:, 0], q[:, 1] * c - q[:, 2] * s, q[:, 1] * s + q[:, 2] * c], 1)
    plate = ellipsoid(q, (1, 1, -5), (4.0, 28, 16.5))
    helix = path(
        q,
        [
            (1, -6, 8),
            (4, 6, 10),
            (5.5, 20, 6),
            (6.5, 27, -4),
            (7, 24, -14),
            (7, 12, -20),
            (6.5, -2, -20),
            (5, -14, -15),
            (3, -24, -7),
            (1.5, -29, -1),
        ],
        [2.6, 3.2, 3.6, 3.8, 3.8, 3.6, 3.4, 3.2, 3.6, 4.6],
        0,
        5,
    )
    anti = path(
        q,
        [(5.5, 16, -5), (6, 8, -9), (6, -4, -11), (4.5, -14, -7), (3.5, -18, 0)],
        [2.6, 3.0, 3.2, 3.0, 3.4],
        0,
        5,
    )
    root = ellipsoid(q, (-7, 0, 0), (8, 22, 11))
    lobe = ellipsoid(q, (2, -29, 0), (4.2, 7.5, 6.5))
    tragus = ellipsoid(q, (3.0, -6, 8.5), (4.0, 6.5, 4.2))
    body = union(union(plate, helix, 4), anti, 4)
    body = union(union(body, root, 9), lobe, 6)
    body = subtraction(body, ellipsoid(q, (6.5, -4, -0.5), (7.0, 12, 7.2)), 4)
    return union(body, tragus, 4)


def face(p):
    body = union(skull(p), neck(p), 40)
    body = union(body, brow(p), 24)
    body = subtraction(body, ellipsoid(p, (30, -1, 95), (20, 12.5, 16)), 28)
    body = subtraction(body, ellipsoid(p, (17, -3, 93), (6, 10, 9)), 16)
    muzzle, upper, lower = lips(p)
    body = union(body, muzzle, 22)
    body = union(body, nose(p), 14)
    body = subtraction(body, ellipsoid(p, (0, -88.5, 96), (17, 5, 7)), 9)
    body = subtraction(body, path(p, [(21, -50, 95), (30, -62, 88), (33, -76, 80)], [1.6, 2.0, 1.6]), 9)
    body = subtraction(body, rod(p, (0, -57, 98.5), (0, -63, 101), 1.6, 2.2), 4)
    body = union(union(body, upper, 4.5), lower, 4.5)
    parting = path(
        p, [(0, -73.2, 99.5), (6, -72.6, 98.5), (16, -73.8, 95.5), (30, -75.0, 89.5)], [1.7, 1.6, 1.5, 1.4], 0
    )
    body = subtraction(body, parting, 2.5)
    return eyed(body, p)


def eyed(body, p):
    """Lids and eyeball, near the eye only."""
    result = body.copy()
    here = np.flatnonzero(((p - EYE) ** 2).sum(axis=1) < 48**2)
    if len(here):
        p, body = p[here], body[here]
        lid, opening, white, crease, rims = eye(p)
        body = union(body, lid, 9)
        body = subtraction(body, crease, 3.5)
        body = subtraction(body, np.maximum(opening, ball(p, EYE, 21)), 1.2)
        body = union(body, rims, 1.5)
        result[here] = union(body, white, 0.5)
    return result


def head(p):
    p = p.copy()
    p[:, 0] = np.sqrt(p[:, 0] ** 2 + 0.04)
    body = face(p)
    body = subtraction(body, nostril(p), 2.5)
    body = union(body, near(p, (76, -12, -10), 62, ear), 4)
    base = -176 - p[:, 1]
    return intersection(body, base, 16)


def build():
    centres = [(0, -36, 92), (0, -73, 92), (31, -1, 80), (-31, -1, 80), (82, -10, -14), (-82, -10, -14)]
    seen, unseen = lens(centres, (0.9, 0.8, 1.8, 1.8, 1.2, 1.2), (42, 20, 15, 15, 22, 22))
    low, high = np.array([-125.0, -200.0, -130.0]), np.array([125.0, 128.0, 128.0])
    low, high = seen(np.stack([low, high]))
    h = 6.0
    xs = (np.arange(2 * int(190 // h)) - int(190 // h) + 0.5) * h
    vertices, faces = solid(
        head,
        xs,
        np.arange(low[1] - 20, high[1] + 40, h),
        np.arange(low[2] - 20, high[2] + 50, h),
        rounds=4,
        most=2.0,
        fair=6,
        unseen=unseen,
    )
    return [Part("head", vertices, faces)]
