"""Slow twin of the drawing kernel: every pixel asks every face."""

import numpy as np


def nearest_faces_slowly(corner, rows, width):
    face, weight = np.full((rows, width), -1, np.int32), np.zeros((rows, width, 3))
    for r in range(rows):
        for c in range(width):
            best = 0.0
            for f, triangle in enumerate(corner):
                system = np.vstack([triangle[:, :2].T, np.ones(3)])
                if abs(np.linalg.det(system)) < 1e-12:
                    continue
                screen = np.linalg.solve(system, [c + 0.5, r + 0.5, 1.0])
                near = screen @ triangle[:, 2]
                if (screen >= 0).all() and near > best:
                    best, face[r, c], weight[r, c] = near, f, screen * triangle[:, 2] / near
    return face, weight
