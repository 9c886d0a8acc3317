"""What a bake would cost, told before it is done: density, seconds, memory, within a factor of two or so."""

from typing import Any

from surftex.kernels.pool import thread_count
from surftex.surface.surface import Surface

COVERAGE = 0.62
"""Share of a page that charts cover, as unwraps come out."""

_CELLS = 0.84
"""Cells per square of the cell size, as full Poisson-disk sets come out."""

_CPU_S_PER = {"face": 3.0e-5, "cell": 2.2e-4, "texel": 2.2e-6}
_START_S = 2.0
_BYTES_PER = {"face": 1500, "cell": 5200, "texel": 69, "tile texel": 66}
_START_MB = 300.0


def bake_cost(surface: Surface, material: str = "calf") -> dict[str, Any]:
    """Estimate the cost of a bake at several resolutions.

    Parameters
    ----------
    surface : Surface
        What would be baked.
    material : str
        Name of a leather preset with a plain cell size.

    Returns
    -------
    cost : dict
        ``material``, ``cells``, ``max_features``, ``threads``, and ``pages``: for each ``resolution``
        ``texels_per_mm``, ``texels_per_cell``, ``seconds`` of wall time, ``memory_mb``.
    """
    from surftex.bake.pages import TILE_TEXELS
    from surftex.materials.leather.model import Leather
    from surftex.recipe.model import BakeSettings

    size_mm = float(Leather.preset(material).cell_size)
    cells = max(1, round(_CELLS * surface.area_mm2 / size_mm**2))
    most = BakeSettings().max_features
    threads, faces = thread_count(None), len(surface.faces)
    pages = []
    for side in (1024, 2048, 4096, 8192):
        density = side * (COVERAGE / surface.area_mm2) ** 0.5
        texels = side * side
        work = {"face": faces, "cell": cells, "texel": texels}
        cpu_s = sum(_CPU_S_PER[key] * count for key, count in work.items())
        held = sum(_BYTES_PER[key] * count for key, count in work.items())
        held += _BYTES_PER["tile texel"] * min(texels, TILE_TEXELS)
        pages.append(
            {
                "resolution": side,
                "texels_per_mm": round(density, 4),
                "texels_per_cell": round(density * size_mm, 3),
                "seconds": round(_START_S + cpu_s / (0.8 * threads + 0.2), 1),
                "memory_mb": round(_START_MB + held / 1e6),
            }
        )
    return {"material": material, "cells": cells, "threads": threads, "max_features": most, "pages": pages}
