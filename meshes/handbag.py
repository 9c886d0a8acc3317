"""A structured handbag: tapered body with a flap, two straps on rings, a clasp and feet."""

import numpy as np

from meshes.implicit import box, ellipsoid, intersection, ring, smoothstep, union
from meshes.model import Part
from meshes.nets import solid
from meshes.sweep import band_section, grid_faces, outward, resampled, tube


def shape(p, grow=0.0):
    """The bag's body: wide below, narrow above, gussets drawn in, front and back softly full."""
    x, y, z = p.T
    share = np.clip((y + 105) / 210, 0, 1)
    q = p.copy()
    q[:, 0] = x / (1 - 0.12 * share)
    q[:, 2] = z / (1 - 0.42 * share**1.3)
    full = 5 * (1 - np.clip(x / 150, -1, 1) ** 2) * np.clip(1 - (y / 105) ** 2, 0, 1)
    body = box(q, (0, 0, 0), (150, 105, 58), 16) * 0.88 - full - grow
    gusset = ellipsoid(p, (176, 30, 0), (34, 95, 17))
    gusset = np.minimum(gusset, ellipsoid(p, (-176, 30, 0), (34, 95, 17)))
    return intersection(body, -gusset, 18)


def flap(p):
    """A sheet over the top and the upper front, with a rounded edge."""
    x, y, z = p.T
    sheet = np.abs(shape(p) - 3.2) - 3.4
    edge = -8 - 34 * np.sqrt(np.clip(1 - (x / 152) ** 2, 0, 1))
    front = intersection(edge - y, np.abs(x) - 124 + 0.10 * np.abs(y - 30), 24)
    behind = 74 - y
    back = np.maximum(behind, np.abs(x) - 124 + 0.10 * np.abs(y - 30))
    weight = smoothstep(-8, 8, z)
    cut = weight * front + (1 - weight) * back
    return intersection(sheet, cut * 0.8, 3.0)


def strap(z, lean):
    """An arch of flat, padded leather between two rings."""
    angle = np.linspace(-0.06, np.pi + 0.06, 60)
    high = np.maximum(np.sin(angle), -0.2)
    line = np.stack([82 * np.cos(angle), 128 + 122 * high, z + lean * np.maximum(high, 0)], 1)
    line = resampled(line, 5.5)
    to_middle = line - [0, 118, z]
    share = np.linspace(-1, 1, len(line))
    padded = 5.0 + 3.2 * np.cos(share * np.pi / 2) ** 0.5
    sections = np.stack([band_section(17.0, thick, 5) for thick in padded])
    return tube(line, sections, up=to_middle)


def tab(x, z, side):
    """A leather tab that holds a ring, sewn onto the body."""
    y = np.linspace(50, 118, 15)
    line = np.stack([np.full(15, x), y, np.full(15, z)], 1)
    for _ in range(25):
        value = shape(line)
        line[:, 2] -= side * np.where(y < 96, value - (9.0 if side > 0 else 5.0), 0) * 0.7
    line[y >= 96, 2] = np.linspace(line[y < 96][-1, 2], z, (y >= 96).sum())
    line = resampled(line, 5.0)
    return tube(line, band_section(21.0, 4.2, 5), up=(0.0, 0.0, float(side)))


def hoop(centre, radius, wire):
    turn, tilt = np.meshgrid(np.arange(28) * 2 * np.pi / 28, np.arange(8) * 2 * np.pi / 8, indexing="ij")
    away = radius + wire * np.cos(tilt)
    points = np.stack([away * np.cos(turn) * 1.15, away * np.sin(turn), wire * np.sin(tilt)], -1).reshape(
        -1, 3
    )
    return outward(points + centre, grid_faces(28, 8, True, True))


def clasp(p):
    plate = box(p, (0, -32, 58.0), (17, 11, 5), 4.0)
    return union(plate, ring(p, (0, -32, 63.5), 6.5, 2.6), 2.0)


def build():
    h = 8.2
    body = solid(shape, np.arange(-174, 174, h), np.arange(-124, 124, h), np.arange(-82, 82, h), rounds=8)
    h = 5.8
    cover = solid(
        flap,
        np.arange(-148, 148, h),
        np.arange(-64, 122, h * 0.9),
        np.arange(-76, 84, h * 0.85),
        rounds=4,
        fair=20,
    )
    parts = [Part("body", *body), Part("body", *cover)]
    for z, lean in ((40.0, 22.0), (-40.0, -22.0)):
        side = 1 if z > 0 else -1
        parts.append(Part("straps", *strap(z, lean)))
        for x in (-82.0, 82.0):
            parts.append(Part("straps", *tab(x, z, side)))
            parts.append(Part("metal", *hoop([x, 122.0, z], 11.0, 2.0)))
    step = 2.6
    parts.append(
        Part(
            "metal",
            *solid(
                clasp, np.arange(-24, 25, step), np.arange(-50, -14, step), np.arange(48, 74, step), rounds=4
            ),
        )
    )
    for x in (-118.0, 118.0):
        for z in (-38.0, 38.0):
            grid = np.arange(-14, 15, 2.9)
            foot = solid(
                lambda p, x=x, z=z: ellipsoid(p, (x, -107, z), (9, 6, 9)),
                x + grid,
                -107 + grid,
                z + grid,
                rounds=4,
            )
            parts.append(Part("metal", *foot))
    return parts
