"""Slow obvious twins of dart throwing and of Voronoi graphs in the plane."""

import numpy as np
from scipy.spatial import Voronoi


def regions_hit(darts, sites, axis, angle):
    """Which darts in the plane lie in the ellipse of some site."""
    away = darts[:, None] - sites[None]
    cosine, sine = np.cos(angle), np.sin(angle)
    x = (cosine * away[..., 0] + sine * away[..., 1]) / axis[:, 0]
    y = (cosine * away[..., 1] - sine * away[..., 0]) / axis[:, 1]
    return (np.hypot(x, y) < 1).any(axis=1)


def one_after_another(position, reach):
    """Darts that no earlier one may reach, pair by pair."""
    free = np.ones(len(position), bool)
    for i in range(len(position)):
        for j in range(i):
            if np.linalg.norm(position[i] - position[j]) <= reach[j]:
                free[i] = False
    return free


def corners_inside(places, width):
    """Voronoi vertices in the open square [0, width]^2."""
    corners = Voronoi(places).vertices
    return corners[((corners > 0) & (corners < width)).all(axis=1)]


def owners_slowly(records, samples, length, angle):
    """Whose each sample is by a length of tangent vectors at the six nearest sites, one sample after another."""
    from surftex.geodesics.windows import nearest

    owner = []
    for i in range(len(samples)):
        near, _, vector = nearest(records, samples.taken(np.array([i])), 6, vectors=True)
        found = near[0] >= 0
        measured = length(vector[0][found], near[0][found], angle)
        owner.append(near[0][found][np.argmin(measured)] if found.any() else -1)
    return np.array(owner)
