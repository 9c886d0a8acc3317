"""A structured handbag: tapered body with a flap, two straps on rings, a clasp and feet."""

import numpy as np

from meshes.implicit import box, ellipsoid, intersection, ring, union
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


def flap():
    """A sheet over the top and the upper front, cut straight behind and round in front, its rim rounded."""
    wide, thick, step, corner = 118.0, 3.3, 5.5, 26.0
    rim = thick * np.array([0.0, 0.3, 1.0])
    x = spread(2 * wide, rim, step) - wide
    bend = np.clip((np.abs(x) - wide + corner) / corner, 0, 0.96)
    lowest = -8 - 34 * np.sqrt(1 - (x / 152) ** 2) + corner * (1 - np.sqrt(1 - bend**2))
    angle = np.linspace(np.radians(-45), np.radians(166), 600)
    rays = np.stack([np.zeros(600), np.cos(angle), np.sin(angle)], 1)
    lines = []
    for place, low in zip(x, lowest, strict=True):
        middle = np.array([place, 60.0, 0.0])
        near, far = np.zeros(600), np.full(600, 130.0)
        for _ in range(40):
            half = 0.5 * (near + far)
            inside = shape(middle + half[:, None] * rays) < 3.0
            near, far = np.where(inside, half, near), np.where(inside, far, half)
        line = middle + near[:, None] * rays
        kept = np.where(line[:, 2] < 0, line[:, 1] > 76, line[:, 1] > low)
        line = line[kept]
        arc = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        lines.append((line, arc))
    rows = spread(max(arc[-1] for _, arc in lines), rim, step)
    middle = np.empty((len(x), len(rows), 3))
    for points, (line, arc) in zip(middle, lines, strict=True):
        inner = np.linspace(rim[-1], arc[-1] - rim[-1], len(rows) - 4)
        places = np.concatenate([rim[:2], inner, arc[-1] - rim[1::-1]])
        points[:] = np.stack([np.interp(places, arc, line[:, i]) for i in range(3)], 1)
    flat = middle.reshape(-1, 3)
    normal = np.stack([shape(flat + 0.1 * axis) - shape(flat - 0.1 * axis) for axis in np.eye(3)], 1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    inward = np.minimum(np.arange(len(x)), np.arange(len(x))[::-1])[:, None]
    inward = np.minimum(inward, np.minimum(np.arange(len(rows)), np.arange(len(rows))[::-1])[None]).ravel()
    high = thick * np.sqrt(1 - (1 - rim[np.minimum(inward, 2)] / thick) ** 2)
    under = np.flatnonzero(inward > 0)
    twin = np.arange(len(flat))
    twin[under] = len(flat) + np.arange(len(under))
    faces = grid_faces(len(x), len(rows))
    vertices = np.concatenate([flat + high[:, None] * normal, (flat - high[:, None] * normal)[under]])
    return outward(vertices, np.concatenate([faces, twin[faces][:, ::-1]]))


def spread(length, rim, step):
    """Places from 0 to a length: those of a rim at either end, even ones between; an odd number of them.

    With odd numbers, `grid_faces` cuts no corner of a grid off with a triangle that lies on the rim alone.
    """
    count = 2 * round(0.5 * (length - 2 * rim[-1]) / step) + 1
    return np.concatenate([rim[:-1], np.linspace(rim[-1], length - rim[-1], count), length - rim[-2::-1]])


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
    parts = [Part("body", *body), Part("body", *flap())]
    for z, lean in ((40.0, 22.0), (-40.0, -22.0)):
        side = 1 if z > 0 else -1
        parts.append(Part("straps", *strap(z, lean)))
        for x in (-82.0, 82.0):
            parts.append(Part("straps", *tab(x, z, side)))
            parts.append(Part("metal", *hoop([x, 122.0, z], 11.0, 2.0)))
    step = 2.1
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
