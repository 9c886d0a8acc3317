"""Slow, obvious twin of the forces between round particles on a tile."""

import numpy as np


def accelerations(place, velocity, radius, scale, push, side, law):
    """Every pair, the short way around the tile; `law`: damping, share of the pull, rise, ceiling."""
    damping, pull, rise, ceiling = law
    result = np.zeros_like(place)
    for i in range(len(place)):
        force = np.array([push[i, 0], push[i, 1], rise * scale[i]])
        force[2] += 4.0 * max(0.5 * radius[i] - place[i, 2], 0)
        force[2] -= 4.0 * max(place[i, 2] - ceiling * scale[i] + 0.5 * radius[i], 0)
        for j in range(len(place)):
            if i == j:
                continue
            step = place[i] - place[j]
            step[:2] -= side * np.round(step[:2] / side)
            distance, rest = np.linalg.norm(step), radius[i] + radius[j]
            w = distance / rest
            strength = 1.25 * w**3 - 2.375 * w**2 + 1.125
            if w >= 1.5:
                strength = 0.0
            elif w >= 1:
                strength *= pull
            force += rest * strength * step / distance
        result[i] = force - damping * velocity[i]
    return result
