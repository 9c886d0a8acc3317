"""Growing particles: who is near whom, which of them are on top, and the forces between them in the plane.

A particle is an ellipsoid that floats at `height` over its `foot`. Semi-axes: r sqrt(e) along its axis, r / sqrt(e) across,
r upright. Every kernel gathers: it reads the state of all particles and writes the rows [begin, end) of its own.

`law` holds damping, share of the pull, rise and ceiling, the last two per unit of `scale`, the size of particles thereabouts.
"""

import math

import numpy as np

from surftex.kernels.jit import kernel, part

WALL = 4.0
"""Stiffness of floor and ceiling; that between particles is 1."""


@part
def bubble(w, pull):
    """Force over rest length at w = distance / rest length, positive where it pushes: the cubic of the bubble mesh.

    1.125 at 0 with slope 0, 0 at 1 with slope -1, 0 from 1.5 on; between 1 and 1.5 it pulls, times `pull`.
    """
    if w >= 1.5:
        return 0.0
    f = (1.25 * w - 2.375) * w * w + 1.125
    return f if w < 1.0 else pull * f


@part
def reach(r, e, along, up):
    """Radius of an ellipsoid in the direction of a unit vector, of which `along` is the part along its axis."""
    if e == 1.0:
        return r
    across = max(1.0 - along * along - up * up, 0.0)
    return r / math.sqrt(along * along / e + across * e + up * up)


@part
def upright(height, r, scale, law):
    """Force of floor, ceiling and rise."""
    force = law[2] * scale
    if height < 0.5 * r:
        force += WALL * (0.5 * r - height)
    over = height - law[3] * scale + 0.5 * r
    if over > 0:
        force -= WALL * over
    return force


@kernel
def near_particles(
    begin, end, position, size, factor, skin, cell, key, order, owner, stride, count, neighbor
):
    """List the particles j within factor (size_i + size_j) + skin of particles [begin, end).

    position (a, 3): the particles, then their copies across the borders of a tile; size (a,); owner (a,) int64: whose copy;
    cell (n,) int64; key (a,) int64: sorted numbers of grid cells no smaller than any reach, order (a,) of whom; stride (2,):
    neighbours in z differ by 1, in y by stride[1], in x by stride[0] -> count (n,) int64, neighbor (n, room) int32: as
    many as find room, in the order of the grid.
    """
    room = neighbor.shape[1]
    for i in range(begin, end):
        found = 0
        for column in range(9):
            corner = cell[i] + (column // 3 - 1) * stride[0] + (column % 3 - 1) * stride[1] - 1
            for k in range(np.searchsorted(key, corner), len(key)):
                if key[k] > corner + 2:
                    break
                j = order[k]
                if j == i:
                    continue
                x, y = position[i, 0] - position[j, 0], position[i, 1] - position[j, 1]
                z = position[i, 2] - position[j, 2]
                limit = factor * (size[i] + size[j]) + skin
                if x * x + y * y + z * z < limit * limit:
                    if found < room:
                        neighbor[i, found] = owner[j]
                    found += 1
        count[i] = found


@kernel
def plane_forces(
    begin, end, place, velocity, radius, aspect, axis, scale, push, neighbor, count, side, law, acceleration
):
    """Acceleration of particles [begin, end) over a tile that repeats every `side`; their mass is 1.

    place, velocity (n, 3): x, y, height; radius, aspect, scale (n,); axis (n, 2): unit; push (n, 3): force of the field;
    neighbor (n, room) int32, count (n,) int64; law (4,) -> acceleration (n, 3).
    """
    half = 0.5 * side
    reaching = 1.5 if law[1] > 0 else 1.0
    for i in range(begin, end):
        x, y, z = place[i, 0], place[i, 1], place[i, 2]
        fx, fy = push[i, 0], push[i, 1]
        fz = upright(z, radius[i], scale[i], law)
        for k in range(count[i]):
            j = neighbor[i, k]
            dx, dy, dz = x - place[j, 0], y - place[j, 1], z - place[j, 2]
            dx -= side * math.floor((dx + half) / side)
            dy -= side * math.floor((dy + half) / side)
            square = dx * dx + dy * dy + dz * dz
            rest = radius[i] + radius[j]
            if aspect[i] == 1.0 and aspect[j] == 1.0 and square >= reaching * reaching * rest * rest:
                continue
            distance = math.sqrt(square) + 1e-300
            if aspect[i] != 1.0 or aspect[j] != 1.0:
                up = dz / distance
                rest = reach(radius[i], aspect[i], (dx * axis[i, 0] + dy * axis[i, 1]) / distance, up)
                rest += reach(radius[j], aspect[j], (dx * axis[j, 0] + dy * axis[j, 1]) / distance, up)
            force = rest * bubble(distance / rest, law[1]) / distance
            fx += force * dx
            fy += force * dy
            fz += force * dz
        acceleration[i, 0] = fx - law[0] * velocity[i, 0]
        acceleration[i, 1] = fy - law[0] * velocity[i, 1]
        acceleration[i, 2] = fz - law[0] * velocity[i, 2]


@kernel
def visible_share(begin, end, foot, normal, axis, height, radius, aspect, side, neighbor, count, share):
    """Share of the upper cap of particles [begin, end) that is under no other's cap, at 37 points of its disc.

    foot, normal, axis (n, 3); height, radius, aspect (n,); side: of a tile, inf for none -> share (n,).
    """
    for i in range(begin, end):
        seen = 0
        ax, ay, az = axis[i, 0], axis[i, 1], axis[i, 2]
        bx = normal[i, 1] * az - normal[i, 2] * ay
        by = normal[i, 2] * ax - normal[i, 0] * az
        bz = normal[i, 0] * ay - normal[i, 1] * ax
        stretch = math.sqrt(aspect[i])
        for ring in range(4):
            points = max(6 * ring, 1)
            for q in range(points):
                across = ring / 3.6
                u = across * math.cos(2 * math.pi * q / points) * radius[i] * stretch
                v = across * math.sin(2 * math.pi * q / points) * radius[i] / stretch
                top = height[i] + radius[i] * math.sqrt(1 - across * across)
                free = 1
                for k in range(count[i]):
                    j = neighbor[i, k]
                    if (
                        normal[i, 0] * normal[j, 0]
                        + normal[i, 1] * normal[j, 1]
                        + normal[i, 2] * normal[j, 2]
                        < 0.3
                    ):
                        continue
                    x = foot[i, 0] - foot[j, 0] + u * ax + v * bx
                    y = foot[i, 1] - foot[j, 1] + u * ay + v * by
                    z = foot[i, 2] - foot[j, 2] + u * az + v * bz
                    if side < math.inf:
                        x -= side * math.floor(x / side + 0.5)
                        y -= side * math.floor(y / side + 0.5)
                    cx = normal[j, 1] * axis[j, 2] - normal[j, 2] * axis[j, 1]
                    cy = normal[j, 2] * axis[j, 0] - normal[j, 0] * axis[j, 2]
                    cz = normal[j, 0] * axis[j, 1] - normal[j, 1] * axis[j, 0]
                    along = x * axis[j, 0] + y * axis[j, 1] + z * axis[j, 2]
                    wide = x * cx + y * cy + z * cz
                    room = radius[j] * radius[j] - along * along / aspect[j] - wide * wide * aspect[j]
                    if room > 0 and height[j] + math.sqrt(room) > top:
                        free = 0
                        break
                seen += free
        share[i] = seen / 37
