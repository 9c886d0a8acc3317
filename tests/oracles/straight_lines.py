"""Slow, obvious twin of the traced line: walk in space, and fold the direction over each edge's hinge."""

import numpy as np


def walk_in_space(vertices, faces, neighbor, face, position, direction, length):
    """Face, position and direction after walking `length` straight on; stops at a border."""
    entry = None
    while True:
        corner = vertices[faces[face]]
        normal = np.cross(corner[1] - corner[0], corner[2] - corner[0])
        normal /= np.linalg.norm(normal)
        best, exit_edge = length, None
        for edge in range(3):
            if edge == entry:
                continue
            along = corner[(edge + 1) % 3] - corner[edge]
            inward = np.cross(normal, along)
            speed = -direction @ inward
            if speed > 1e-14:
                reach = max((position - corner[edge]) @ inward / speed, 0.0)
                if reach < best:
                    best, exit_edge = reach, edge
        position = position + best * direction
        length -= best
        if exit_edge is None or neighbor[face, exit_edge] < 0:
            return face, position, direction
        along = corner[(exit_edge + 1) % 3] - corner[exit_edge]
        along /= np.linalg.norm(along)
        other = neighbor[face, exit_edge]
        there = vertices[faces[other]]
        other_normal = np.cross(there[1] - there[0], there[2] - there[0])
        other_normal /= np.linalg.norm(other_normal)
        across = direction @ np.cross(along, normal)
        direction = (direction @ along) * along + across * np.cross(along, other_normal)
        twin = [(k, (k + 1) % 3) for k in range(3)]
        entry = next(
            k
            for k, (a, b) in enumerate(twin)
            if {faces[other][a], faces[other][b]}
            == {faces[face][exit_edge], faces[face][(exit_edge + 1) % 3]}
        )
        face = other
