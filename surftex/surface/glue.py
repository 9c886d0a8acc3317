"""Which faces run on into which: pairs of faces along edges, where more than two may claim one edge."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Glue:
    """Pairs of half-edges; half-edge 3 f + i runs from corner i of face f to corner i+1.

    Attributes
    ----------
    first, second : (g,) int64
        Half-edges that are glued.
    crowded_edges : int
        Edges with more than two faces.
    crowded_vertex : (k,) int64
        Their ends.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    crowded_edges: int
    crowded_vertex: NDArray[np.int64]


def glue(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    file_vertex: NDArray[np.int64],
    part: NDArray[np.int32],
) -> Glue:
    """Pair half-edges.

    Two faces at an edge are a pair, whatever their winding. Among more than two, those that share the file's
    own vertices go first; then, only where their windings agree, those of one part, and the pair that
    bends least. What is left over is a border.

    Parameters
    ----------
    vertices : (n, 3) float64
        Positions.
    faces : (m, 3) int64
        Welded triangles, without repeated corners.
    file_vertex : (m, 3) int64
        Vertices of the file, before welding.
    part : (m,) int32
        Part of each face.

    Returns
    -------
    glue : Glue
        The pairs.
    """
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    edge_key = np.minimum(start, end) * len(vertices) + np.maximum(start, end)
    order = np.argsort(edge_key, kind="stable")
    ordered = edge_key[order]
    fresh = np.concatenate([[True], ordered[1:] != ordered[:-1]])
    begin = np.flatnonzero(fresh)
    size = np.diff(np.append(begin, len(order)))
    two = begin[size == 2]
    first, second = [order[two]], [order[two + 1]]
    crowded = size > 2
    ends = np.zeros(0, np.int64)
    if crowded.any():
        member = order[np.repeat(crowded, size)]
        edge = np.repeat(np.arange(int(crowded.sum())), size[crowded])
        ends = np.unique(np.concatenate([start[member], end[member]]))
        a, b = file_vertex.ravel()[member], np.roll(file_vertex, -1, axis=1).ravel()[member]
        low, high = np.minimum(a, b), np.maximum(a, b)
        free = np.ones(len(member), bool)
        sense = start[member] < end[member]
        for keys, agreeing in (((edge, low, high), False), ((edge, part[member // 3]), True)):
            one, other = _exact_pairs(member, free, keys, sense if agreeing else None)
            first.append(one)
            second.append(other)
        one, other = _flattest_pairs(vertices, faces, member, edge, free)
        first.append(one)
        second.append(other)
    return Glue(np.concatenate(first), np.concatenate(second), int(crowded.sum()), ends)


def _exact_pairs(
    member: NDArray[np.int64],
    free: NDArray[np.bool_],
    keys: tuple[NDArray[np.integer], ...],
    sense: NDArray[np.bool_] | None,
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Glue members whose keys exactly two share, of opposite sense if given; they leave `free`."""
    here = np.flatnonzero(free)
    if len(here) == 0:
        return member[:0], member[:0]
    order = here[np.lexsort([key[here] for key in reversed(keys)])]
    differs = np.zeros(len(order) - 1, bool)
    for key in keys:
        differs |= key[order][1:] != key[order][:-1]
    begin = np.flatnonzero(np.concatenate([[True], differs]))
    size = np.diff(np.append(begin, len(order)))
    two = begin[size == 2]
    if sense is not None:
        two = two[sense[order[two]] != sense[order[two + 1]]]
    free[order[two]] = free[order[two + 1]] = False
    return member[order[two]], member[order[two + 1]]


def _flattest_pairs(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    member: NDArray[np.int64],
    edge: NDArray[np.int64],
    free: NDArray[np.bool_],
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Glue the free members of each edge that bend least and agree in winding, a few steps apart at most."""
    first, second = [member[:0]], [member[:0]]
    sense = faces.ravel()[member] < np.roll(faces, -1, axis=1).ravel()[member]
    while True:
        here = np.flatnonzero(free)
        if len(here) < 2:
            break
        angle = _angle_around(vertices, faces, member[here])
        order = here[np.lexsort([angle, edge[here]])]
        angle = angle[np.lexsort([angle, edge[here]])]
        begin = np.flatnonzero(np.concatenate([[True], edge[order][1:] != edge[order][:-1]]))
        size = np.diff(np.append(begin, len(order)))
        group = np.repeat(np.arange(len(begin)), size)
        bend, mate = np.full(len(order), np.inf), np.arange(len(order))
        for step in range(1, min(int(size.max()), 5)):
            place = np.arange(len(order)) - begin[group]
            other = begin[group] + (place + step) % size[group]
            gap = np.abs(np.mod(angle[other] - angle, 2 * np.pi) - np.pi)
            better = (gap < bend) & (size[group] > step) & (sense[order] != sense[order[other]])
            bend, mate = np.where(better, gap, bend), np.where(better, other, mate)
        rank = np.lexsort([np.arange(len(order)), bend, group])
        best = rank[begin]
        best = best[np.isfinite(bend[best])]
        if len(best) == 0:
            break
        first.append(member[order[best]])
        second.append(member[order[mate[best]]])
        free[order[best]] = free[order[mate[best]]] = False
        if len(first) > 4:
            break
    return np.concatenate(first), np.concatenate(second)


def _angle_around(
    vertices: NDArray[np.float64], faces: NDArray[np.int64], half_edge: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Direction of each half-edge's face around its edge, from an axis that depends on the edge only."""
    face, i = half_edge // 3, half_edge % 3
    a, b, tip = faces[face, i], faces[face, (i + 1) % 3], faces[face, (i + 2) % 3]
    low, high = np.minimum(a, b), np.maximum(a, b)
    along = vertices[high] - vertices[low]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), np.finfo(float).tiny)
    across = np.cross(along, np.eye(3)[np.argmin(np.abs(along), axis=1)])
    away = vertices[tip] - vertices[low]
    return np.arctan2(
        np.einsum("ki,ki->k", away, np.cross(along, across)), np.einsum("ki,ki->k", away, across)
    )
