"""Solids as functions: negative inside, about the distance in millimetres near the surface.

A point array is (n, 3); each function returns (n,). `blend` lengths say over how many millimetres two solids flow together.
"""

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator


def length(p):
    return np.sqrt((p * p).sum(axis=-1))


def smoothstep(low, high, x):
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3 - 2 * t)


def union(a, b, blend=0.0):
    """Smooth minimum: the solids grow together over `blend` millimetres."""
    if blend <= 0:
        return np.minimum(a, b)
    h = np.maximum(blend - np.abs(a - b), 0.0) / blend
    return np.minimum(a, b) - h * h * h * blend / 6.0


def intersection(a, b, blend=0.0):
    return -union(-a, -b, blend)


def subtraction(a, b, blend=0.0):
    """a without b."""
    return intersection(a, -b, blend)


def turned(p, centre, yaw=0.0, pitch=0.0, roll=0.0):
    """Points in the frame of a part: moved to `centre`, turned about y, x, then z (degrees)."""
    q = p - np.asarray(centre, float)
    for angle, (i, j) in ((yaw, (2, 0)), (pitch, (1, 2)), (roll, (0, 1))):
        if angle:
            c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
            a, b = q[..., i] * c + q[..., j] * s, q[..., j] * c - q[..., i] * s
            q = q.copy()
            q[..., i], q[..., j] = a, b
    return q


def ellipsoid(p, centre, radii, **turn):
    q = turned(p, centre, **turn)
    radii = np.asarray(radii, float)
    k0, k1 = length(q / radii), length(q / radii**2)
    return k0 * (k0 - 1.0) / np.maximum(k1, 1e-9)


def ball(p, centre, radius):
    return length(p - np.asarray(centre, float)) - radius


def rod(p, a, b, radius_a, radius_b=None):
    """Round cone from a to b."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    radius_b = radius_a if radius_b is None else radius_b
    along = b - a
    t = np.clip(((p - a) * along).sum(axis=-1) / (along @ along), 0.0, 1.0)
    return length(p - a - t[..., None] * along) - (radius_a + (radius_b - radius_a) * t)


def path(p, points, radii, blend=0.0, smooth=3):
    """Round cones along a smooth curve through the points, `smooth` of them for each piece."""
    at = np.arange(len(points))
    fine = np.linspace(0, at[-1], smooth * at[-1] + 1)
    points = CubicSpline(at, np.asarray(points, float), bc_type="natural")(fine)
    radii = PchipInterpolator(at, radii)(fine)
    result = rod(p, points[0], points[1], radii[0], radii[1])
    for i in range(1, len(points) - 1):
        result = union(result, rod(p, points[i], points[i + 1], radii[i], radii[i + 1]), blend)
    return result


def near(p, centre, radius, function):
    """Values of a costly solid inside a ball that holds it; outside, the distance to half that ball."""
    centre = np.asarray(centre, float)
    away = length(p - centre)
    result = away - 0.5 * radius
    inside = np.flatnonzero(away < radius)
    if len(inside):
        result[inside] = function(p[inside])
    return result


def box(p, centre, half, rounding=0.0, **turn):
    q = np.abs(turned(p, centre, **turn)) - (np.asarray(half, float) - rounding)
    return length(np.maximum(q, 0.0)) + np.minimum(q.max(axis=-1), 0.0) - rounding


def ring(p, centre, radius, tube, **turn):
    """Torus around the part's own z axis."""
    q = turned(p, centre, **turn)
    away = np.sqrt(q[..., 0] ** 2 + q[..., 1] ** 2) - radius
    return np.sqrt(away**2 + q[..., 2] ** 2) - tube
