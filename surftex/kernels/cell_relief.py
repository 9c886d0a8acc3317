"""Where samples lie in cells: the gauge of their cell, and the height of the blobs on its top."""

import math

from surftex.kernels.cell_outlines import gauge
from surftex.kernels.jit import kernel, part


@part
def blended(blob, first, last, x, y, threshold):
    """Height z at which the sum of exp(-(d^2 + z^2) / R^2) over blobs has fallen to the threshold; 0 below it."""
    total, slope = 0.0, 0.0
    for b in range(first, last):
        dx, dy = x - blob[b, 0], y - blob[b, 1]
        square = blob[b, 2] * blob[b, 2]
        exponent = (dx * dx + dy * dy) / square
        if exponent < 12:
            term = math.exp(-exponent)
            total += term
            slope += term / square
    if total <= threshold:
        return 0.0
    # Newton on the logarithm as a function of z^2, which is nearly straight
    height = 0.0
    for _ in range(5):
        step = math.log(total / threshold) * total / slope
        height += step
        if abs(step) < 1e-4 * height:
            break
        total, slope = 0.0, 0.0
        for b in range(first, last):
            dx, dy = x - blob[b, 0], y - blob[b, 1]
            square = blob[b, 2] * blob[b, 2]
            exponent = (dx * dx + dy * dy + height) / square
            if exponent < 40:
                term = math.exp(-exponent)
                total += term
                slope += term / square
        if slope <= 0:
            break
    return math.sqrt(max(height, 0.0))


@kernel
def cells_at(
    begin, end, start, cell, vector, wave, frame, edge, edges, middle, blob_start, blob, threshold, owner, rho, border,
    swelling,
):  # fmt: skip
    """Locate samples [begin, end); sample i has the candidates start[i] to start[i + 1].

    cell (e,) int32, vector (e, 2): the sample in the plane of the cell; wave (n, 3): in space, added to it by frame (c, 2, 3)
    -> owner (n,) int32: the cell with the least rho, -1 for none; rho (n,) float32; border (n,) float32: distance
    to the outline on the ray from the middle, below 0 outside; swelling (n,) float32: height of the blobs.
    """
    for i in range(begin, end):
        best, who, px, py = math.inf, -1, 0.0, 0.0
        for e in range(start[i], start[i + 1]):
            c = cell[e]
            if edges[c] == 0:
                continue
            x, y = vector[e, 0] - middle[c, 0], vector[e, 1] - middle[c, 1]
            x += wave[i, 0] * frame[c, 0, 0] + wave[i, 1] * frame[c, 0, 1] + wave[i, 2] * frame[c, 0, 2]
            y += wave[i, 0] * frame[c, 1, 0] + wave[i, 1] * frame[c, 1, 1] + wave[i, 2] * frame[c, 1, 2]
            here = gauge(edge, edges, c, x, y)
            if here < best:
                best, who, px, py = here, c, x, y
        owner[i] = who
        rho[i] = min(best, 9.0)
        if who >= 0:
            far = math.sqrt(px * px + py * py)
            border[i] = far * (1 / max(best, 1e-3) - 1)
            if best < 1 and blob_start[who + 1] > blob_start[who]:
                swelling[i] = blended(blob, blob_start[who], blob_start[who + 1], px, py, threshold)
