"""The page face by face: where charts end, and what a step across it is on the surface."""

import math

from surftex.kernels.jit import kernel, part

_FLAT = 1e-12
"""Twice the area on the page, in square texels, up to which a face has none."""


@kernel
def find_seams(corner, neighbor, neighbor_edge, same, seam):
    """Find the edges without a neighbour, or whose two sides lie farther apart on the page than `same`, or are folded over.

    corner (m, 3, 2) float64; neighbor, neighbor_edge (m, 3) int32 -> seam (m, 3) bool.
    """
    for f in range(len(corner)):
        for i in range(3):
            g, j = neighbor[f, i], neighbor_edge[f, i]
            seam[f, i] = g < 0 or _side(corner, f) != _side(corner, g)
            if not seam[f, i]:
                for k in range(2):
                    start = abs(corner[f, i, k] - corner[g, (j + 1) % 3, k])
                    end = abs(corner[f, (i + 1) % 3, k] - corner[g, j, k])
                    seam[f, i] |= max(start, end) > same


@part
def _side(corner, f):
    """Whether a face lies face up on the page, 1, or is mirrored, -1; 0 without area."""
    a, b = corner[f, 1, 0] - corner[f, 0, 0], corner[f, 1, 1] - corner[f, 0, 1]
    c, d = corner[f, 2, 0] - corner[f, 0, 0], corner[f, 2, 1] - corner[f, 0, 1]
    twice = a * d - b * c
    return (twice > 0.0) - (twice < 0.0)


@kernel
def measure_steps(corner, flat, steps):
    """Measure steps of a texel to the right and up in the frame of each face, in millimetres.

    corner (m, 3, 2) float64 in texels, rows run down; flat (m, 3, 2) float64 -> steps (m, 2, 2) float64, a column each;
    zero where a face has no area on the page.
    """
    for f in range(len(corner)):
        a, b = corner[f, 1, 0] - corner[f, 0, 0], corner[f, 2, 0] - corner[f, 0, 0]
        c, d = corner[f, 0, 1] - corner[f, 1, 1], corner[f, 0, 1] - corner[f, 2, 1]
        twice = a * d - b * c
        if abs(twice) > _FLAT:
            a, b, c, d = d / twice, -b / twice, -c / twice, a / twice
            for i in range(2):
                side, far = flat[f, 1, i] - flat[f, 0, i], flat[f, 2, i] - flat[f, 0, i]
                steps[f, i, 0], steps[f, i, 1] = side * a + far * c, side * b + far * d
        else:
            steps[f] = 0.0


@kernel
def take_apart(steps, corner, stretch, axes, weight):
    """Take the steps of each face apart, and find its barycentric coordinates on the page.

    steps (m, 2, 2) from `measure_steps`, corner (m, 3, 2) float64 -> axes (m, 2, 2): orthogonal, and stretch (m, 3): entries
    xx, xy, yy of a symmetric matrix, with steps = axes stretch; weight (m, 3, 3): corner i has weight row i times
    (1, column, row), a third where the face has no area.
    """
    for f in range(len(steps)):
        p, q, r, s = steps[f, 0, 0], steps[f, 0, 1], steps[f, 1, 0], steps[f, 1, 1]
        flip = -1.0 if p * s - q * r < 0.0 else 1.0
        cosine, sine = p + s * flip, r - q * flip
        length = math.hypot(cosine, sine)
        cosine, sine = (cosine / length, sine / length) if length > 0.0 else (1.0, 0.0)
        axes[f, 0, 0], axes[f, 0, 1], axes[f, 1, 0], axes[f, 1, 1] = cosine, -sine * flip, sine, cosine * flip
        stretch[f, 0], stretch[f, 1] = cosine * p + sine * r, cosine * q + sine * s
        stretch[f, 2] = flip * (cosine * s - sine * q)
        twice = 0.0
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            weight[f, i, 0] = corner[f, j, 0] * corner[f, k, 1] - corner[f, j, 1] * corner[f, k, 0]
            weight[f, i, 1], weight[f, i, 2] = (
                corner[f, j, 1] - corner[f, k, 1],
                corner[f, k, 0] - corner[f, j, 0],
            )
            twice += weight[f, i, 0]
        for i in range(3):
            for k in range(3):
                thirds = 1 / 3 if k == 0 else 0.0
                weight[f, i, k] = weight[f, i, k] / twice if abs(twice) > _FLAT else thirds
