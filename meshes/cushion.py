"""A Chesterfield seat cushion: deep buttons in a diamond net, pleats between them, piping around."""

import numpy as np

from meshes.implicit import box, smoothstep
from meshes.model import Part
from meshes.nets import pulled, solid
from meshes.sweep import grid_faces, outward, resampled, round_section, tube

HALF, HIGH, PITCH = 180.0, 42.0, 90.0
SUNK = 26.0


def buttons():
    """Middles of the buttons in the plane: a net of diamonds, rows offset by half a pitch."""
    places = []
    for row in range(-3, 4):
        for column in range(-3, 4):
            x, z = (column + 0.5 * (row % 2)) * PITCH, row * PITCH * 0.5
            if max(abs(x), abs(z)) < HALF - 30:
                places.append((x, z))
    return np.array(places)


def tuft(x, z):
    """How far the top sinks below its full height: pleats between buttons, pits at them."""
    u, v = x / PITCH + z / PITCH, x / PITCH - z / PITCH
    # Distance to the two families of pleats, in pitches; the pleats die out towards the rim.
    pleat_u, pleat_v = np.abs(u - np.round(u)), np.abs(v - np.round(v))
    puff = (1 - np.exp(-((pleat_u / 0.2) ** 1.6))) * (1 - np.exp(-((pleat_v / 0.2) ** 1.6)))
    places = buttons()
    near2 = ((x[:, None] - places[:, 0]) ** 2 + (z[:, None] - places[:, 1]) ** 2).min(axis=1)
    pit = np.exp(-near2 / (2 * 15.0**2))
    rim = 1 - smoothstep(HALF - 62, HALF - 16, np.maximum(np.abs(x), np.abs(z)))
    return SUNK * (0.5 * (1 - puff) * (0.2 + 0.8 * rim) + 0.7 * pit * rim) - 6 * rim


def body(p):
    crown = (
        7
        * np.cos(np.clip(p[:, 0] / HALF, -1, 1) * np.pi / 2)
        * np.cos(np.clip(p[:, 2] / HALF, -1, 1) * np.pi / 2)
    )
    top = smoothstep(-30, 20, p[:, 1])
    q = p.copy()
    q[:, 1] += top * (tuft(p[:, 0], p[:, 2]) - crown)
    bulge = 5 * np.clip(1 - (p[:, 1] / HIGH) ** 2, 0, 1)
    return box(q, (0, 0, 0), (HALF, HIGH, HALF), 22.0) - bulge


def piping(level):
    """A cord around the side at one level, pulled onto the body."""
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    c, s = np.cos(angle), np.sin(angle)
    power = 0.28
    line = np.stack(
        [HALF * np.sign(c) * np.abs(c) ** power, np.full(400, level), HALF * np.sign(s) * np.abs(s) ** power],
        1,
    )
    for _ in range(6):
        moved, _ = pulled(body, line, 8.0)
        line = np.stack([moved[:, 0], np.full(400, level), moved[:, 2]], 1)
    line = resampled(line[::4], 7.0, closed=True)
    return tube(line, round_section(4.2, 8), closed=True)


def button(x, z):
    """A covered button, sitting in its pit."""
    rings, sides = 5, 14
    tilt = np.linspace(0, np.pi, rings + 2)[1:-1]
    angle = np.arange(sides) * 2 * np.pi / sides
    points = np.stack(
        [
            np.outer(np.sin(tilt), np.cos(angle)),
            np.broadcast_to(np.cos(tilt)[:, None], (rings, sides)),
            np.outer(np.sin(tilt), np.sin(angle)),
        ],
        -1,
    )
    points = np.concatenate([points.reshape(-1, 3), [[0, 1, 0], [0, -1, 0]]]) * [11.0, 5.0, 11.0]

    ring = np.arange(sides)
    onward, last = (ring + 1) % sides, (rings - 1) * sides
    faces = np.concatenate(
        [
            grid_faces(rings, sides, False, True)[:, ::-1],
            np.stack([np.full(sides, rings * sides), onward, ring], 1),
            np.stack([np.full(sides, rings * sides + 1), last + ring, last + onward], 1),
        ]
    )
    seat = np.array([[x, HIGH + 10.0, z]])
    for _ in range(30):
        value = body(seat)
        seat[:, 1] -= 0.7 * value
    return outward(points + [x, seat[0, 1] + 2.0, z], faces)


def build():
    lines = np.arange(-HALF - 21, HALF + 22, 7.0)
    level = np.arange(-HIGH - 21, HIGH + 29, 6.5)
    vertices, faces = solid(body, lines, level, lines, rounds=14)
    cover = Part("leather", vertices, faces)
    cords = [Part("piping", *piping(level)) for level in (22.0, -24.0)]
    studs = [Part("buttons", *button(x, z)) for x, z in buttons()]
    return [cover, *cords, *studs]
