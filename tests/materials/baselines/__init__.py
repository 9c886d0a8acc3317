"""Baselines: small pictures that an eye approved. `python -m tests.materials.baselines` makes them anew.

A picture that comes out otherwise is a change of looks: look at it, tell it in CHANGELOG.md under *Looks*, commit it.
"""

from pathlib import Path

import numpy as np
from PIL import Image

import surftex as sx
from surftex.surface.shapes import sphere

HERE = Path(__file__).parent


def path(name):
    """Where the picture of a baseline lies."""
    return HERE / f"{name}.png"


def composite():
    """Gravel and gingham of the shelf on a ball of 24 mm, colour above height; (192, 192, 3) uint8.

    Gravel: grey stones of 3 to 6 texels with dark gaps, high where they are light. Gingham: red and white bands, in
    places checks, that run together where the smoothest direction of a ball has its two poles.
    """
    ball, columns = sphere(12.0, subdivisions=3), []
    for name, pixel, relief in (("gravel", 0.5, 3.0), ("gingham", 0.25, 0.2)):
        maps = sx.bake(
            ball,
            sx.Composite.preset(name, pixel_size=pixel, relief=relief),
            resolution=96,
            seed=5,
            unwrapper="uvunwrap",
        )
        color = np.clip(maps["base_color"], 0, 1) ** (1 / 2.2)
        height = np.clip(maps["height"] / relief + 0.5, 0, 1)
        columns.append(np.concatenate([color, np.repeat(height[..., None], 3, axis=2)]))
    return np.rint(255 * np.concatenate(columns, axis=1)).astype(np.uint8)


PICTURES = {"composite": composite}


def main():
    """Make all baselines anew."""
    for name, picture in PICTURES.items():
        Image.fromarray(picture()).save(path(name), optimize=True)
