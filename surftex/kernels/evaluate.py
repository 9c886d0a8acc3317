"""Length of the path that one row promises to a place in its face, and how that path leaves the source.

Rows are described in `surftex.kernels.windows`. A place that the visible interval does not show is reached around the
interval's nearer end, so that no row ever promises too short a path.
"""

import math

from surftex.kernels.jit import part


@part
def distance_to(kind, row, r, x, y):
    """Millimetres from the source of row r to (x, y) in the frame of the row's face."""
    if kind == 2 or kind == 3 or kind == 6:
        Ax, Ay, nx, ny = row[r, 0], row[r, 1], row[r, 7], row[r, 8]
        u = x * ny - y * nx
        u0 = row[r, 2] * ny - row[r, 3] * nx
        u1 = row[r, 4] * ny - row[r, 5] * nx
        if u < min(u0, u1) or u > max(u0, u1):
            q = 2 if abs(u - u0) < abs(u - u1) else 4
            ex, ey = row[r, q], row[r, q + 1]
            return abs((ex - Ax) * nx + (ey - Ay) * ny) + math.sqrt((x - ex) ** 2 + (y - ey) ** 2)
        return abs((x - Ax) * nx + (y - Ay) * ny)
    Ix, Iy = row[r, 0], row[r, 1]
    dx, dy = x - Ix, y - Iy
    ux, uy = row[r, 2] - Ix, row[r, 3] - Iy
    if ux * dy - uy * dx > 0:
        return (
            row[r, 6] + math.sqrt(ux * ux + uy * uy) + math.sqrt((x - row[r, 2]) ** 2 + (y - row[r, 3]) ** 2)
        )
    ux, uy = row[r, 4] - Ix, row[r, 5] - Iy
    if ux * dy - uy * dx < 0:
        return (
            row[r, 6] + math.sqrt(ux * ux + uy * uy) + math.sqrt((x - row[r, 4]) ** 2 + (y - row[r, 5]) ** 2)
        )
    return row[r, 6] + math.sqrt(dx * dx + dy * dy)


@part
def leaving_direction(kind, row, r, x, y):
    """Find the unit direction, in the frame of the source's face, in which the path to (x, y) leaves a point source."""
    c, s = row[r, 7], row[r, 8]
    if kind == 1:
        return c, s
    Ix, Iy = row[r, 0], row[r, 1]
    dx, dy = x - Ix, y - Iy
    ux, uy = row[r, 2] - Ix, row[r, 3] - Iy
    wx, wy = row[r, 4] - Ix, row[r, 5] - Iy
    if ux * dy - uy * dx > 0:
        dx, dy = ux, uy
    elif wx * dy - wy * dx < 0:
        dx, dy = wx, wy
    norm = math.sqrt(dx * dx + dy * dy)
    if norm == 0:
        return 1.0, 0.0
    return (c * dx - s * dy) / norm, (s * dx + c * dy) / norm


@part
def place_on_curve(kind, row, r, tangent, q, x, y):
    """Find where on primitive q of a curve the path of row r to (x, y) leaves it: mm from its start; to its left or not.

    tangent (p, 2): direction of the curve at each cap.
    """
    if kind <= 1:
        c, s = leaving_direction(kind, row, r, x, y)
        return 0.0, tangent[q, 0] * s - tangent[q, 1] * c >= 0
    if kind == 4 or kind == 5:
        return max(row[r, 7], 0.0), kind == 4
    nx, ny = row[r, 7], row[r, 8]
    if kind == 3:
        nx, ny = -nx, -ny
    a = (row[r, 2] - row[r, 0]) * ny - (row[r, 3] - row[r, 1]) * nx
    b = (row[r, 4] - row[r, 0]) * ny - (row[r, 5] - row[r, 1]) * nx
    ahead = min(max((x - row[r, 0]) * ny - (y - row[r, 1]) * nx, min(a, b)), max(a, b))
    return max(ahead, 0.0), kind == 2 or (kind == 6 and (x - row[r, 0]) * nx + (y - row[r, 1]) * ny >= 0)
