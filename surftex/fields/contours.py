"""The border of a mask as curves on the surface: where a field crosses a level."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError
from surftex.fields.sources import Field
from surftex.geodesics.pieces import CurvePieces
from surftex.surface.points import SurfacePoints
from surftex.surface.subdivide import Subdivided, subdivided
from surftex.surface.surface import Surface

_INWARD = 1e-3
"""How far the corners of a triangle are moved towards its middle, so that they belong to it alone."""

_MOST_TRIANGLES = 2_000_000

_HALVINGS = 12
"""Of an edge that crosses the level, until the place is known; masks may be steps."""


def contour(
    surface: Surface, field: Field, *, level: float = 0.5, edge_mm: float | None = None
) -> CurvePieces:
    """Find where a field crosses a level, by pieces that are straight inside small triangles.

    Parameters
    ----------
    surface : Surface
        m faces.
    field : Field
        May jump across edges, as parts do: the edge is then a piece of the border.
    level : float
        What is above is inside.
    edge_mm : float, optional
        Longest edge of the triangles that the faces are cut into; a third of the mean edge without it.

    Returns
    -------
    pieces : CurvePieces
        Each is a curve of its own, with the inside on its left.

    Raises
    ------
    RecipeError
        If the field is on one side of the level everywhere.
    """
    fine = _cut(surface, surface.mean_edge_mm / 3 if edge_mm is None else edge_mm)
    inward = (1 - _INWARD) * fine.weight + _INWARD * fine.weight.mean(axis=1, keepdims=True)
    points = SurfacePoints.trusted(np.repeat(fine.parent, 3), inward.reshape(-1, 3))
    inside = (np.asarray(field(points), np.float64) > level).reshape(-1, 3)
    if inside.all() or not inside.any():
        side = "above" if inside.all() else "below"
        raise RecipeError(f"it has no border: it is {side} {level:g} everywhere")
    parts = [_crossings(fine, lambda points: field(points) > level, inside), _jumps(fine, inside)]
    face, start, end = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    corner = surface.flat[face]
    begin, finish = (np.einsum("pk,pki->pi", weights, corner) for weights in (start, end))
    return CurvePieces.of(face, begin, finish, np.arange(len(face)))


def _cut(surface: Surface, edge_mm: float) -> Subdivided:
    """Cut the faces, but not into more triangles than memory bears."""
    least = (2.3 * surface.area_mm2 / _MOST_TRIANGLES) ** 0.5
    longest = float(surface.edge_length.max())
    if len(surface.faces) * 2 > _MOST_TRIANGLES:
        return subdivided(surface, longest)
    return subdivided(surface, max(edge_mm, least), max_faces=8 * _MOST_TRIANGLES)


Parts = tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]


def _crossings(
    fine: Subdivided, within: Callable[[SurfacePoints], NDArray[np.bool_]], inside: NDArray[np.bool_]
) -> Parts:
    """Straight pieces inside the triangles that have both sides."""
    count = inside.sum(axis=1)
    mixed = np.flatnonzero((count == 1) | (count == 2))
    lone = np.where(count[mixed] == 1, inside[mixed].argmax(axis=1), (~inside[mixed]).argmax(axis=1))
    rows = np.arange(len(mixed))
    onward, back = (lone + 1) % 3, (lone + 2) % 3
    weight, parent, here = fine.weight[mixed], fine.parent[mixed], inside[mixed, lone]

    def crossing(other: NDArray[np.int64]) -> NDArray[np.float64]:
        start, end = weight[rows, lone], weight[rows, other]
        for _ in range(_HALVINGS):
            middle = (start + end) / 2
            alike = (within(SurfacePoints.trusted(parent, middle)) == here)[:, None]
            start, end = np.where(alike, middle, start), np.where(alike, end, middle)
        return (start + end) / 2

    first, second = crossing(onward), crossing(back)
    # around a lone corner that is inside, the inside is left of the way from the onward edge to the other
    turned = (count[mixed] == 2)[:, None]
    return parent, np.where(turned, second, first), np.where(turned, first, second)


def _jumps(fine: Subdivided, inside: NDArray[np.bool_]) -> Parts:
    """Edges with one side inside and the other outside."""
    start, end = fine.faces.ravel().astype(np.int64), np.roll(fine.faces, -1, axis=1).ravel().astype(np.int64)
    key = np.minimum(start, end) * (int(start.max()) + 1) + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    pair = np.flatnonzero(key[order][1:] == key[order][:-1])
    one, other = order[pair], order[pair + 1]
    both = np.stack([inside, np.roll(inside, -1, axis=1)], axis=2).all(axis=2).ravel()
    none = ~np.stack([inside, np.roll(inside, -1, axis=1)], axis=2).any(axis=2).ravel()
    jump = np.concatenate([one[both[one] & none[other]], other[both[other] & none[one]]])
    triangle, edge = jump // 3, jump % 3
    return fine.parent[triangle], fine.weight[triangle, edge], fine.weight[triangle, (edge + 1) % 3]
