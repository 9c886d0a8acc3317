"""Makes surftex/fields/data/face.json: `python -m docs.make_face canonical_face_model.obj`.

The face is MediaPipe's canonical face model (The MediaPipe Authors, Apache License 2.0), in centimetres: x to the viewer's
right, y up, z towards the viewer. Kept of it are the places of a few landmarks; masks and lines are drawn here, by x and
y, for the subject's left half or the middle, and get their z from the model.
"""

import json
import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

import surftex as sx

OUT = Path(__file__).resolve().parent.parent / "surftex" / "fields" / "data" / "face.json"
STEP_CM = 0.35
"""Between the controls of a line."""

LANDMARKS = {
    "right_eye_outer": 33, "right_eye_inner": 133, "left_eye_inner": 362, "left_eye_outer": 263, "nose_tip": 1,
    "nose_right": 129, "nose_left": 358, "mouth_right": 61, "mouth_left": 291, "lip_top": 0, "lip_bottom": 17,
    "chin": 199, "brow_middle": 9, "hairline": 10, "right_cheek": 50, "left_cheek": 280, "jaw_right": 172, "jaw_left": 397,
}  # fmt: skip
LIPS = [61, 185, 40, 39, 37, 0, 267, 269, 270, 409, 291, 375, 321, 405, 314, 17, 84, 181, 91, 146]

# Group: width and depth in mm, whether mirrored, and lines by x and y.
LINES = {
    "crows_feet": (1.0, 0.16, True, [
        [(4.75, 3.05), (5.35, 3.5), (6.0, 4.05)], [(4.9, 2.75), (5.6, 2.85), (6.35, 3.1)],
        [(4.85, 2.35), (5.5, 2.1), (6.25, 1.85)], [(4.65, 1.95), (5.2, 1.5), (5.85, 1.0)],
    ]),
    "under_eye": (1.2, 0.13, True, [
        [(1.75, 1.75), (2.5, 1.15), (3.5, 1.05), (4.4, 1.5)], [(2.0, 1.2), (2.8, 0.65), (3.8, 0.6)],
    ]),
    "forehead": (1.8, 0.28, False, [
        [(-4.3, 5.3), (-2.4, 5.75), (0.0, 5.55), (2.4, 5.75), (4.3, 5.3)],
        [(-4.0, 6.1), (-2.0, 6.5), (0.0, 6.3), (2.0, 6.5), (4.0, 6.1)],
        [(-3.0, 7.0), (-1.0, 7.2), (1.2, 7.15), (3.2, 6.95)],
    ]),
    "glabella": (1.3, 0.25, True, [[(0.6, 3.0), (0.75, 3.7), (0.65, 4.5)]]),
    "smile": (2.8, 0.6, True, [[(1.75, -0.75), (2.5, -1.8), (3.0, -3.1), (3.35, -4.3)]]),
    "mouth_corner": (1.7, 0.25, True, [[(2.75, -4.55), (3.0, -5.3), (3.0, -6.3)]]),
    "lips": (0.6, 0.08, True, [
        [(0.35, -3.35), (0.4, -2.9), (0.42, -2.55)], [(0.95, -3.4), (1.05, -2.95), (1.1, -2.6)],
        [(1.5, -3.65), (1.7, -3.2), (1.8, -2.85)], [(0.8, -5.0), (0.9, -5.4), (0.9, -5.7)],
        [(1.5, -4.9), (1.7, -5.3), (1.8, -5.6)],
    ]),
    "chin": (2.4, 0.35, False, [[(-1.6, -6.05), (-0.7, -5.75), (0.7, -5.75), (1.6, -6.05)]]),
}  # fmt: skip

# Ellipses: middle and half axes by x and y, softness; mirrored where the middle is not at 0.
MASKS = {
    "eyelids": ((3.0, 2.55), (2.1, 1.3), 0.35),
    "cheeks": ((4.3, -0.6), (2.3, 2.1), 0.55),
    "nose": ((0.0, 0.3), (1.75, 2.7), 0.35),
    "nose_tip": ((0.0, -0.7), (1.75, 1.35), 0.4),
    "forehead": ((0.0, 6.0), (5.6, 2.3), 0.4),
    "chin": ((0.0, -7.3), (2.5, 1.7), 0.45),
    "under_eyes": ((3.1, 1.05), (1.7, 0.75), 0.45),
    "brows": ((3.1, 4.3), (2.1, 0.5), 0.35),
    "moustache": ((0.0, -2.7), (2.7, 0.75), 0.4),
    "jaw": ((4.6, -5.6), (2.4, 2.8), 0.5),
    "temples": ((6.4, 4.2), (1.3, 2.2), 0.5),
}  # fmt: skip


def lived(line, random):
    """A line as skin wears it: it wanders a little, and finer and shorter ones run beside it. -> points and scales."""
    knot = np.r_[0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    smooth, length = CubicSpline(knot, line), knot[-1]

    def strand(begin, end, aside, wander):
        at = np.linspace(begin, end, max(3, round((end - begin) / STEP_CM) + 1))
        ahead = smooth(at, 1)
        left = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) / np.linalg.norm(ahead, axis=1)[:, None]
        away = aside * np.interp(at, [begin, (begin + end) / 2, end], [0.4, 1, 0.7])
        return smooth(at) + left * (away + wander * random.standard_normal(len(at)))[:, None]

    strands = [(strand(0, length, 0, min(0.012 * length, 0.03)), 1.0)]
    for side in (-1, 1):
        if length > 1.5 and random.random() < 0.75:
            begin = length * random.uniform(0.05, 0.45)
            end = begin + length * random.uniform(0.3, 0.5)
            aside = side * random.uniform(0.13, 0.24)
            strands.append((strand(begin, min(end, length), aside, 0.02), random.uniform(0.35, 0.55)))
    return strands


def main():
    face = sx.load(sys.argv[1], units="cm")
    corner = face.vertices[face.faces] / 10 + face.origin_mm / 10
    rows = [line.split()[1:] for line in Path(sys.argv[1]).read_text().splitlines() if line.startswith("v ")]
    vertex = np.array(rows, float)

    def place(x, y):
        """The frontmost point of the model over x and y; beyond its rim that of the nearest point within."""
        for inward in np.linspace(1, 0.8, 41):
            at = np.array([x * inward, y * inward])
            a, b, c = corner[:, 0, :2], corner[:, 1, :2], corner[:, 2, :2]
            area = np.cross(b - a, c - a)
            v, w = np.cross(at - a, c - a) / area, np.cross(b - a, at - a) / area
            hit = (v >= -1e-9) & (w >= -1e-9) & (v + w <= 1 + 1e-9)
            if hit.any():
                z = (corner[:, 0, 2] * (1 - v - w) + corner[:, 1, 2] * v + corner[:, 2, 2] * w)[hit].max()
                return [round(float(number), 3) for number in (x, y, z)]
        raise SystemExit(f"({x}, {y}) lies far beside the face")

    lines = {}
    for name, (width, depth, both, drawn) in LINES.items():
        random = np.random.default_rng(sum(map(ord, name)))
        mains = [np.array(line) for line in drawn]
        mains += [line * [-1, 1] for line in mains if both]
        strands = [strand for line in mains for strand in lived(line, random)]
        lines[name] = {
            "width_mm": width,
            "depth_mm": depth,
            "scales": [round(scale, 2) for _, scale in strands],
            "curves": [[place(*point) for point in line] for line, _ in strands],
        }
    masks = {"lips": {"outline": np.round(vertex[LIPS][:, :2], 3).tolist(), "soft": 0.14}}
    for name, (middle, half, soft) in MASKS.items():
        both = [list(middle)] + ([[-middle[0], middle[1]]] if middle[0] else [])
        masks[name] = {"ellipses": [[*each, *half] for each in both], "soft": soft}
    masks["ears"] = {"balls": [[side * 8.3, 0.9, -5.6, 2.6, 3.9, 3.6] for side in (1, -1)], "soft": 0.3}
    content = {
        "source": "Landmarks: canonical face model of MediaPipe, The MediaPipe Authors, Apache License 2.0; centimetres.",
        "landmarks": {name: np.round(vertex[index], 3).tolist() for name, index in LANDMARKS.items()},
        "masks": masks,
        "lines": lines,
    }
    OUT.parent.mkdir(exist_ok=True)
    OUT.write_text(json.dumps(content, separators=(",", ":")) + "\n", "utf-8")
    print(f"{OUT}: {OUT.stat().st_size} bytes")


if __name__ == "__main__":
    main()
