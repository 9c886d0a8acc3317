"""A ring, the smallest closed surface that is not a ball."""

import numpy as np

from meshes.model import Part
from meshes.sweep import grid_faces, outward


def build():
    columns, rows, ring, tube = 96, 40, 45.0, 18.0
    around, tilt = np.meshgrid(
        np.arange(columns) * 2 * np.pi / columns, np.arange(rows) * 2 * np.pi / rows, indexing="ij"
    )
    away = ring + tube * np.cos(tilt)
    points = np.stack([away * np.cos(around), tube * np.sin(tilt), away * np.sin(around)], axis=-1).reshape(
        -1, 3
    )
    return [Part("ring", *outward(points, grid_faces(columns, rows, True, True)))]
