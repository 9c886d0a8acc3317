"""Growing particles on a surface: forces between tangent planes, and steps that walk over edges.

State of a particle: face int32, place (2,) in the frame of its face, height over it, velocity (3,): two numbers in
that frame and one upright, angle of its axis in that frame. From these `settle` derives foot, normal and axis in space,
which the forces of all others read.
"""

import math

from surftex.kernels.jit import kernel, part
from surftex.kernels.particles import bubble, reach, upright
from surftex.kernels.trace import exit_edge

SAME_SIDE = 0.2
"""Cosine between the normals of two particles below which they lie on opposite sides of a thin part."""

STEEP = 0.7
"""A particle that lies higher over another's tangent plane than this share of their distance is on another sheet."""

DOUBTFUL, ASTRAY = 0.25, 0.25
"""Pairs as steep as the first are walked: who ends farther off than the second, per distance, cannot walk over."""

MOST_FACES = 200
"""Edges that one step may cross."""


@part
def arc_over_chord(cosine):
    """Length of a circle's arc over that of its chord, from the cosine of the angle between its end normals."""
    s = max(0.5 * (1.0 - cosine), 0.0)
    return 1.0 + s * (1 / 6 + s * (3 / 40 + s * (15 / 336 + s * (105 / 3456 + s * 945 / 42240))))


@kernel
def walk(flat, neighbor, neighbor_edge, transport, face, x, y, dx, dy, length):
    """Walk straight on from (x, y); along borders where one is met -> face, x, y, and what turns vectors along.

    The turn is (c, s), and a third number: the angle of the border walked along in the last face, or 9 for none.
    """
    entry, turn_c, turn_s, border = -1, 1.0, 0.0, 9.0
    for _ in range(MOST_FACES):
        edge, share = exit_edge(flat, face, entry, x, y, dx, dy)
        onward = (edge + 1) % 3
        to_x = flat[face, edge, 0] + share * (flat[face, onward, 0] - flat[face, edge, 0])
        to_y = flat[face, edge, 1] + share * (flat[face, onward, 1] - flat[face, edge, 1])
        step = max((to_x - x) * dx + (to_y - y) * dy, 0.0)
        if step >= length:
            x += length * dx
            y += length * dy
            break
        length -= step
        x, y = to_x, to_y
        other = neighbor[face, edge]
        if other < 0:
            ex, ey = flat[face, onward, 0] - flat[face, edge, 0], flat[face, onward, 1] - flat[face, edge, 1]
            size = math.sqrt(ex * ex + ey * ey)
            along = (dx * ex + dy * ey) / size
            sign = 1.0 if along > 0 else -1.0
            dx, dy = sign * ex / size, sign * ey / size
            length *= abs(along)
            border = math.atan2(dy, dx)
            x += 1e-7 * ((flat[face, 0, 0] + flat[face, 1, 0] + flat[face, 2, 0]) / 3 - x)
            y += 1e-7 * ((flat[face, 0, 1] + flat[face, 1, 1] + flat[face, 2, 1]) / 3 - y)
            entry = -1
            continue
        c, s = transport[face, edge, 0], transport[face, edge, 1]
        dx, dy = c * dx - s * dy, s * dx + c * dy
        turn_c, turn_s = c * turn_c - s * turn_s, s * turn_c + c * turn_s
        if border < 9.0:
            border = math.atan2(dy, dx)
        entry = neighbor_edge[face, edge]
        face = other
        onward = (entry + 1) % 3
        x = flat[face, onward, 0] + share * (flat[face, entry, 0] - flat[face, onward, 0])
        y = flat[face, onward, 1] + share * (flat[face, entry, 1] - flat[face, onward, 1])
    return face, x, y, turn_c, turn_s, border


@kernel
def settle(begin, end, faces, vertices, vertex_normal, frame, flat, face, place, angle, foot, normal, axis):
    """Places in space of particles [begin, end) -> foot, normal, axis (n, 3); the normal is that of the smooth surface."""
    for i in range(begin, end):
        f = face[i]
        c = place[i, 1] / flat[f, 2, 1]
        b = (place[i, 0] - c * flat[f, 2, 0]) / flat[f, 1, 0]
        a = 1.0 - b - c
        square, along = 0.0, 0.0
        for k in range(3):
            p, q, r = faces[f, 0], faces[f, 1], faces[f, 2]
            foot[i, k] = a * vertices[p, k] + b * vertices[q, k] + c * vertices[r, k]
            normal[i, k] = a * vertex_normal[p, k] + b * vertex_normal[q, k] + c * vertex_normal[r, k]
            square += normal[i, k] * normal[i, k]
        size = math.sqrt(square)
        for k in range(3):
            normal[i, k] = normal[i, k] / size if size > 1e-9 else frame[f, 2, k]
            axis[i, k] = math.cos(angle[i]) * frame[f, 0, k] + math.sin(angle[i]) * frame[f, 1, k]
            along += axis[i, k] * normal[i, k]
        square = 0.0
        for k in range(3):
            axis[i, k] -= along * normal[i, k]
            square += axis[i, k] * axis[i, k]
        for k in range(3):
            axis[i, k] /= math.sqrt(square) + 1e-300


@kernel
def keep_walkable(
    begin, end, flat, adjacent, adjacent_edge, transport, frame, component, vertices, faces, face, place, foot, normal,
    count, neighbor,
):  # fmt: skip
    """Strike neighbours that particles [begin, end) cannot walk to: behind a thin part, on another sheet or component."""
    for i in range(begin, end):
        kept = 0
        f = face[i]
        for k in range(count[i]):
            j = neighbor[i, k]
            if component[f] != component[face[j]]:
                continue
            cosine = normal[i, 0] * normal[j, 0] + normal[i, 1] * normal[j, 1] + normal[i, 2] * normal[j, 2]
            if cosine < SAME_SIDE:
                continue
            x, y, z = foot[j, 0] - foot[i, 0], foot[j, 1] - foot[i, 1], foot[j, 2] - foot[i, 2]
            distance = math.sqrt(x * x + y * y + z * z)
            up = x * normal[i, 0] + y * normal[i, 1] + z * normal[i, 2]
            if abs(up) > STEEP * distance + 1e-12:
                continue
            if f != face[j] and abs(up) > DOUBTFUL * distance:
                dx = x * frame[f, 0, 0] + y * frame[f, 0, 1] + z * frame[f, 0, 2]
                dy = x * frame[f, 1, 0] + y * frame[f, 1, 1] + z * frame[f, 1, 2]
                size = math.sqrt(dx * dx + dy * dy) + 1e-300
                g, u, v, _, _, _ = walk(
                    flat, adjacent, adjacent_edge, transport, f, place[i, 0], place[i, 1], dx / size, dy / size,
                    distance * arc_over_chord(cosine),
                )  # fmt: skip
                c = v / flat[g, 2, 1]
                b = (u - c * flat[g, 2, 0]) / flat[g, 1, 0]
                square = 0.0
                for q in range(3):
                    there = (1 - b - c) * vertices[faces[g, 0], q] + b * vertices[faces[g, 1], q]
                    square += (there + c * vertices[faces[g, 2], q] - foot[j, q]) ** 2
                if math.sqrt(square) > ASTRAY * distance:
                    continue
            neighbor[i, kept] = j
            kept += 1
        count[i] = kept


@kernel
def surface_forces(
    begin, end, frame, face, foot, normal, axis, height, velocity, radius, aspect, scale, push, neighbor, count, law, step,
    onward,
):  # fmt: skip
    """Advance the velocity of particles [begin, end) by a step of semi-implicit Euler -> onward (n, 3).

    push (n, 3): force of the field, in space; the rest as `settle` and `surftex.kernels.particles` have it.
    """
    reaching = 1.5 if law[1] > 0 else 1.0
    for i in range(begin, end):
        f = face[i]
        fx, fy, fz = 0.0, 0.0, 0.0
        rise = upright(height[i], radius[i], scale[i], law)
        for k in range(count[i]):
            j = neighbor[i, k]
            x, y, z = foot[i, 0] - foot[j, 0], foot[i, 1] - foot[j, 1], foot[i, 2] - foot[j, 2]
            up = height[i] - height[j]
            cosine = normal[i, 0] * normal[j, 0] + normal[i, 1] * normal[j, 1] + normal[i, 2] * normal[j, 2]
            square = x * x + y * y + z * z
            stretch = arc_over_chord(cosine)
            far = square * stretch * stretch + up * up
            round_ones = aspect[i] == 1.0 and aspect[j] == 1.0
            rest = radius[i] + radius[j]
            if round_ones and far >= reaching * reaching * rest * rest:
                continue
            lift = x * normal[i, 0] + y * normal[i, 1] + z * normal[i, 2]
            tx, ty, tz = x - lift * normal[i, 0], y - lift * normal[i, 1], z - lift * normal[i, 2]
            size = math.sqrt(tx * tx + ty * ty + tz * tz) + 1e-300
            arc = math.sqrt(square) * stretch
            distance = math.sqrt(far) + 1e-300
            if not round_ones:
                flat_share, steep = arc / distance, up / distance
                mine = (tx * axis[i, 0] + ty * axis[i, 1] + tz * axis[i, 2]) / size
                theirs = (x * axis[j, 0] + y * axis[j, 1] + z * axis[j, 2]) / (math.sqrt(square) + 1e-300)
                rest = reach(radius[i], aspect[i], flat_share * mine, steep)
                rest += reach(radius[j], aspect[j], flat_share * theirs, steep)
            force = rest * bubble(distance / rest, law[1]) / distance
            tangent = force * arc / size
            fx += tangent * tx
            fy += tangent * ty
            fz += tangent * tz
            rise += force * up
        gain = 1.0 / (1.0 + step * law[0])
        fx, fy, fz = fx + push[i, 0], fy + push[i, 1], fz + push[i, 2]
        along = fx * frame[f, 0, 0] + fy * frame[f, 0, 1] + fz * frame[f, 0, 2]
        across = fx * frame[f, 1, 0] + fy * frame[f, 1, 1] + fz * frame[f, 1, 2]
        onward[i, 0] = gain * (velocity[i, 0] + step * along)
        onward[i, 1] = gain * (velocity[i, 1] + step * across)
        onward[i, 2] = gain * (velocity[i, 2] + step * rise)


@kernel
def move_particles(
    begin, end, flat, neighbor, neighbor_edge, transport, step, onward, face, place, height, velocity, angle
):
    """Walk particles [begin, end) for one step at the velocities `onward`; velocity and angle are carried along."""
    for i in range(begin, end):
        height[i] += step * onward[i, 2]
        velocity[i, 2] = onward[i, 2]
        vx, vy = onward[i, 0], onward[i, 1]
        speed = math.sqrt(vx * vx + vy * vy)
        if speed > 1e-150:
            face[i], place[i, 0], place[i, 1], c, s, border = walk(
                flat, neighbor, neighbor_edge, transport, face[i], place[i, 0], place[i, 1], vx / speed, vy / speed,
                step * speed,
            )  # fmt: skip
            vx, vy = c * vx - s * vy, s * vx + c * vy
            angle[i] += math.atan2(s, c)
            if border < 9.0:
                along = vx * math.cos(border) + vy * math.sin(border)
                vx, vy = along * math.cos(border), along * math.sin(border)
        velocity[i, 0], velocity[i, 1] = vx, vy
