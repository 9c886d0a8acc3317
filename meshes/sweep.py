"""Grids rolled into bands, tubes, caps and revolved bodies."""

import numpy as np


def grid_faces(rows, columns, close_rows=False, close_columns=False):
    """Triangles of a (rows, columns) grid of vertices; outward is row direction x column direction."""
    r, c = np.meshgrid(
        np.arange(rows if close_rows else rows - 1),
        np.arange(columns if close_columns else columns - 1),
        indexing="ij",
    )
    r, c = r.ravel(), c.ravel()
    down, right = (r + 1) % rows, (c + 1) % columns
    a, b, d, e = r * columns + c, down * columns + c, down * columns + right, r * columns + right
    even = ((r + c) % 2 == 0)[:, None]
    cut = np.where(even, np.stack([a, b, d, a, d, e], 1), np.stack([a, b, e, b, d, e], 1))
    return cut.reshape(-1, 3)


def frames(points, closed=False, up=(0.0, 1.0, 0.0)):
    """Unit tangents, sides and uppers along a polyline; `up` is kept as far as it can be."""
    around = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    tangent = around if closed else np.gradient(points, axis=0)
    tangent = tangent / np.linalg.norm(tangent, axis=1, keepdims=True)
    up = np.broadcast_to(np.asarray(up, float), points.shape)
    side = np.cross(tangent, up)
    side = side / np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-9)
    return tangent, side, np.cross(side, tangent)


def tube(points, section, closed=False, up=(0.0, 1.0, 0.0)):
    """Carry a closed section (k, 2), or one per point (n, k, 2), along a polyline; open ends get a rounded lid.

    The section runs counter-clockwise in (side, upper).
    """
    _, side, upper = frames(points, closed, up)
    section = np.broadcast_to(section, (len(points), *np.asarray(section).shape[-2:]))
    body = points[:, None] + section[..., :1] * side[:, None] + section[..., 1:] * upper[:, None]
    rows, columns = body.shape[:2]
    vertices, faces = body.reshape(-1, 3), grid_faces(rows, columns, closed, True)[:, ::-1]
    if not closed:
        start, end = len(vertices), len(vertices) + 1
        ring = np.arange(columns)
        onward = (ring + 1) % columns
        last = (rows - 1) * columns
        vertices = np.concatenate([vertices, points[:1], points[-1:]])
        faces = np.concatenate(
            [
                faces,
                np.stack([np.full(columns, start), onward, ring], 1),
                np.stack([np.full(columns, end), last + ring, last + onward], 1),
            ]
        )
    return outward(vertices, faces)


def outward(vertices, faces):
    """Turn a closed body so that its volume is positive."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    volume = (a * np.cross(b, c)).sum()
    return vertices, faces if volume > 0 else faces[:, ::-1]


def round_section(radius, sides, flatten=1.0):
    angle = np.arange(sides) * 2 * np.pi / sides
    return np.stack([radius * np.cos(angle), radius * flatten * np.sin(angle)], axis=1)


def band_section(width, thickness, across, rounding=1.0):
    """Rounded rectangle: `across` points over the width, as even as the thickness allows."""
    half, high = width / 2, thickness / 2
    corner = np.linspace(0, np.pi / 2, 4)
    radius = high * rounding
    top = np.linspace(half - radius, -(half - radius), across)[1:-1]
    parts = []
    for centre, turn in (
        ((half - radius, high - radius), 0.0),
        ((-(half - radius), high - radius), np.pi / 2),
    ):
        parts.append(
            np.stack(
                [centre[0] + radius * np.cos(corner + turn), centre[1] + radius * np.sin(corner + turn)], 1
            )
        )
        if turn == 0.0:
            parts.append(np.stack([top, np.full(len(top), high)], 1))
    upper = np.concatenate(parts)
    loop = np.concatenate([upper, -upper])
    keep = np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1) > 1e-9
    return loop[keep]


def resampled(points, step, closed=False):
    """A polyline with even steps, through a smooth curve."""
    from scipy.interpolate import CubicSpline

    points = np.asarray(points, float)
    if closed:
        points = np.concatenate([points, points[:1]])
    chord = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    curve = CubicSpline(chord, points, bc_type="periodic" if closed else "natural")
    fine = curve(np.linspace(0, chord[-1], 2000))
    arc = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1))])
    count = max(2, round(arc[-1] / step) + (0 if closed else 1))
    places = np.linspace(0, arc[-1], count + 1)[:-1] if closed else np.linspace(0, arc[-1], count)
    return np.stack([np.interp(places, arc, fine[:, i]) for i in range(3)], axis=1)
