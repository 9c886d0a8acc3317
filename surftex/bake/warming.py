"""Compiling every kernel that a bake may need, by small bakes that use them all."""

from surftex.bake.bake import bake
from surftex.materials.cells.model import Cells
from surftex.materials.composite.model import Composite
from surftex.materials.leather.model import Leather
from surftex.surface.shapes import cylinder, sphere


def warm() -> None:
    """Run small bakes of every kind of element, on a closed surface and on one with borders."""
    tube, ball = cylinder(6.0, 12.0, columns=24, rows=12), sphere(6.0, subdivisions=2)
    everything = {
        "cell_size": 2.0,
        "wrinkle_count": 3,
        "pore_density": 1.0,
        "pocket_depth": 0.01,
        "crown_spacing": 5.0,
        "regularity": 1,
    }
    bake(tube, Leather.preset("calf", **everything), resolution=64, unwrapper="uvunwrap")
    bake(tube, Leather.preset("calf", invasion=0.3, **everything), resolution=64, unwrapper="uvunwrap")
    bake(
        ball,
        Leather.preset("crocodile", cell_size=4.0),
        resolution=64,
        unwrapper="uvunwrap",
        maps="height,region",
    )
    grown = Cells.preset("oriented", cell_size=2.0, generations=30, wrinkle_count=2, attraction=0.1)
    bake(tube, grown, resolution=64, unwrapper="uvunwrap")
    grown.tile(24.0).page(16)
    learnt = Composite.preset("gravel", pixel_size=1.5, sweeps=2)
    bake(ball, learnt, resolution=64, unwrapper="uvunwrap")
