"""A bottle with a wall: foot, panel, shoulder, neck with rings, lip, inside; its UV are angle and length along the profile."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from meshes.model import Part
from meshes.sweep import grid_faces

COLUMNS = 64
OUTSIDE = [
    (0, 5.5),
    (16, 4.6),
    (25, 2.4),
    (28.5, 0.4),
    (30.5, 0),
    (33, 0.8),
    (35.2, 3.5),
    (36.4, 8),
    (36.5, 22),
    (36.3, 26),
    (35.3, 29.5),
    (35.2, 32),
    (35.2, 118),
    (35.3, 121),
    (36.3, 124.5),
    (36.5, 128),
    (36, 137),
    (33.5, 147),
    (28, 158),
    (20.5, 169),
    (16, 177),
    (14.3, 184),
    (14, 190),
    (14.3, 192),
    (16.8, 193),
    (17.2, 195),
    (16.8, 197),
    (14.3, 198),
    (14, 199.5),
    (14.4, 201),
    (15.8, 202.2),
    (15.8, 203.6),
    (14.3, 205),
    (14.2, 206.2),
    (14.5, 207.4),
    (15.8, 208.4),
    (15.8, 209.8),
    (14.4, 211.2),
    (14.2, 213),
    (13.8, 214.4),
    (12.8, 215),
]
INSIDE = [
    (12.8, 215),
    (11.4, 214.2),
    (10.9, 211),
    (10.8, 200),
    (11.4, 190),
    (13, 181),
    (19, 170.5),
    (28, 156),
    (32.6, 141.5),
    (33.6, 128),
    (33.2, 110),
    (32.6, 75),
    (33.6, 40),
    (33.8, 12),
    (32, 7.5),
    (27, 5.6),
    (18, 6.6),
    (0, 7.4),
]


def profile(points, step):
    points = np.asarray(points, float)
    chord = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    curve = PchipInterpolator(chord, points)
    fine = curve(np.linspace(0, chord[-1], 4000))
    arc = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1))])
    places = np.linspace(0, arc[-1], round(arc[-1] / step) + 1)
    return np.stack([np.interp(places, arc, fine[:, i]) for i in (0, 1)], axis=1), places / arc[-1]


def revolved(points, step, strip):
    """Rows of the profile without its pole, then the pole; the seam column is there twice, for UV."""
    line, v = profile(points, step)
    pole_first = line[0, 0] == 0
    rows = line[1:] if pole_first else line[:-1]
    row_v = v[1:] if pole_first else v[:-1]
    angle = np.arange(COLUMNS + 1) * 2 * np.pi / COLUMNS
    angle[-1] = 0.0
    body = np.stack(
        [
            rows[:, :1] * np.cos(angle),
            np.broadcast_to(rows[:, 1:], (len(rows), COLUMNS + 1)),
            -rows[:, :1] * np.sin(angle),
        ],
        -1,
    )
    u = np.linspace(0, 1, COLUMNS + 1)
    low, high = strip
    uv = np.stack(np.broadcast_arrays(u[None], (low + (high - low) * row_v)[:, None]), -1)
    count = len(rows) * (COLUMNS + 1)
    pole = line[0] if pole_first else line[-1]
    pole_v = low + (high - low) * (v[0] if pole_first else v[-1])
    vertices = np.concatenate([body.reshape(-1, 3), np.tile([0.0, pole[1], 0.0], (COLUMNS, 1))])
    uvs = np.concatenate([uv.reshape(-1, 2), np.stack([(u[:-1] + u[1:]) / 2, np.full(COLUMNS, pole_v)], 1)])
    faces = grid_faces(len(rows), COLUMNS + 1)[:, ::-1]
    ring = np.arange(COLUMNS) + (0 if pole_first else count - COLUMNS - 1)
    tip = count + np.arange(COLUMNS)
    fan = np.stack([tip, ring + 1, ring], 1) if pole_first else np.stack([tip, ring, ring + 1], 1)
    return vertices, np.concatenate([faces, fan]), uvs


def build():
    inside, outside = revolved(INSIDE, 4.5, (0.505, 1.0)), revolved(OUTSIDE, 2.0, (0.0, 0.495))
    return [
        Part("outside", outside[0], outside[1], outside[2]),
        Part("inside", inside[0], inside[1], inside[2]),
    ]
