"""What a growth has become: how many cells, how much their areas vary, and the share of triangles among them."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray


def cell_statistics(table: NDArray[Any]) -> dict[str, float]:
    """Count the cells of a growth.

    Parameters
    ----------
    table : (c,) structured array
        Features of the kind ``cell``.

    Returns
    -------
    statistics : dict of str to float
        ``count``, ``area_mm2`` (mean), ``area_cv`` (standard deviation over mean), ``triangles`` (share).
    """
    corner = table["corner_mm"]
    onward = np.roll(corner, -1, axis=1)
    area = 0.5 * (corner[..., 0] * onward[..., 1] - corner[..., 1] * onward[..., 0]).sum(axis=1)
    mean = float(area.mean()) if len(area) else 0.0
    return {
        "count": len(table),
        "area_mm2": round(mean, 6),
        "area_cv": round(float(area.std()) / mean, 4) if mean else 0.0,
        "triangles": round(float((table["sides"] == 3).mean()), 4) if len(table) else 0.0,
    }


def grown_cells(features: Mapping[str, NDArray[Any]]) -> dict[str, dict[str, float]]:
    """Count the cells of every layer that has grown.

    Parameters
    ----------
    features : mapping of str to structured array
        As `surftex.bake.stack.Stack.features`.

    Returns
    -------
    grown : dict of str to dict
        `cell_statistics` by kind of feature: ``cell``, ``layer2_cell`` and so on; empty where nothing grows.
    """
    return {
        kind: cell_statistics(table)
        for kind, table in features.items()
        if {"corner_mm", "sides"} <= set(table.dtype.names or ())
    }
