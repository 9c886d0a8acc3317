"""Fields of a recipe on a tile: they are asked on a square sheet that lies where the tile lies, and repeat with it."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError
from surftex.features.growth_plane import Direction, Push
from surftex.fields.fieldset import FieldSet
from surftex.geodesics.directions import DirectionField
from surftex.materials.cells.model import Cells
from surftex.surface.closest import closest_points
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

GRID = 512
"""Places along a side at which a potential is read."""

_JUMP, _ROOM = 0.05, GRID // 16
"""Difference of a potential over the tile's border that may pass for rounding and dither, and over how many places."""


def sheet_points(sheet: Surface, place: NDArray[np.float64]) -> SurfacePoints:
    """Find places of a tile on its sheet.

    Parameters
    ----------
    sheet : Surface
        A square in the xy plane whose lower left corner is the tile's.
    place : (n, 2) float64
        In the tile, mm.

    Returns
    -------
    points : SurfacePoints
        n points.
    """
    where = np.column_stack([place, np.zeros(len(place))]) - sheet.origin_mm
    return closest_points(sheet, where)[0]


def tile_direction(sheet: Surface, direction: DirectionField) -> Direction:
    """Read a direction of a sheet as one of its tile.

    Parameters
    ----------
    sheet : Surface
        As for `sheet_points`.
    direction : DirectionField
        On it.

    Returns
    -------
    angle : callable
        ``angle(place) -> (n,)`` radians from the x axis.
    """

    def angle(place: NDArray[np.float64]) -> NDArray[np.float64]:
        points = sheet_points(sheet, place)
        own = direction.at(points)
        along = np.cos(own)[:, None] * sheet.frame[points.face, 0]
        along += np.sin(own)[:, None] * sheet.frame[points.face, 1]
        return np.arctan2(along[:, 1], along[:, 0])

    return angle


def tile_push(cells: Cells, names: FieldSet, side_mm: float) -> tuple[Push | None, tuple[str, ...]]:
    """Make the force of a potential and a drift.

    Parameters
    ----------
    cells : Cells
        With the names of both.
    names : FieldSet
        On the sheet.
    side_mm : float
        Of the tile.

    Returns
    -------
    push : callable or None
        ``push(place) -> (n, 3)``; a potential that does not repeat is steep where the tile ends.
    warnings : tuple of str
        Whether it does not repeat.

    Raises
    ------
    RecipeError
        If there is no such field.
    """
    size, step = float(cells.cell_size), side_mm / GRID
    line = (np.arange(GRID) + 0.5) * step
    place: NDArray[np.float64] = np.stack(np.meshgrid(line, line), axis=2, dtype=np.float64).reshape(-1, 2)
    force = np.zeros((GRID, GRID, 2))
    found, warnings = False, ()
    if cells.potential is not None and cells.potential_force > 0:
        found = True
        try:
            grey = names.scalar(cells.potential)(sheet_points(names.surface, place)).reshape(GRID, GRID)
        except RecipeError as problem:
            raise RecipeError(f"cells.potential: {problem}") from None
        warnings = _unlike_borders(grey, str(cells.potential))
        slope = np.stack([np.roll(grey, -1, k) - np.roll(grey, 1, k) for k in (1, 0)], axis=2) / (2 * step)
        slope *= cells.potential_height * size
        steep = np.sqrt(1 + (slope**2).sum(axis=2, keepdims=True))
        force -= cells.potential_force * size * slope / steep
    if cells.drift is not None and cells.drift_force > 0:
        found = True
        angle = tile_direction(names.surface, names.direction(cells.drift))(place).reshape(GRID, GRID)
        force += cells.drift_force * size * np.stack([np.cos(angle), np.sin(angle)], axis=2)
    return (_between(force, step) if found else None), warnings


def _unlike_borders(grey: NDArray[np.floating], potential: str) -> tuple[str, ...]:
    """Warn of a potential that jumps from one side of the tile to the other more than anywhere inside."""
    found = []
    for axis, sides in ((1, "left and right"), (0, "top and bottom")):
        # a picture is blended over its borders, so the jump takes some room
        step = np.abs(np.roll(grey, -_ROOM, axis) - grey)
        jump = np.take(step, GRID - _ROOM // 2, axis).max()
        inside = np.take(step, np.arange(GRID - _ROOM), axis).max()
        if jump > _JUMP + 2 * inside:
            found.append(f"{sides} by {jump:.2g}")
    if not found:
        return ()
    return (
        f"cells.potential: {potential!r} does not repeat: it differs at {' and at '.join(found)}, so cells crowd along that "
        "border of the tile; take a field or a picture whose opposite borders match",
    )


def _between(force: NDArray[np.float64], step: float) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """Blend the four nearest places of a grid that repeats."""
    count = len(force)

    def push(place: NDArray[np.float64]) -> NDArray[np.float64]:
        share = place / step - 0.5
        low = np.floor(share).astype(np.int64)
        share = share - low
        result = np.zeros((len(place), 3))
        for x in (0, 1):
            for y in (0, 1):
                weight = np.abs(1 - x - share[:, 0]) * np.abs(1 - y - share[:, 1])
                result[:, :2] += weight[:, None] * force[(low[:, 1] + y) % count, (low[:, 0] + x) % count]
        return result

    return push
