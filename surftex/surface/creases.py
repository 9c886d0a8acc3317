"""Hard edges by angle: shading normals for meshes whose file has none, or the wrong ones."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from surftex.arrays import checked_number, frozen
from surftex.surface.surface import Surface

SHARP_DEGREES = 60.0
"""Bend of an edge that is hardly meant to be round."""

_MANY = 0.05
"""Share of the length of all edges from which on sharp ones are spoken of: more than ears and lips of a face have."""


def creased(surface: Surface, degrees: float) -> Surface:
    """Give a surface shading normals that are smooth but for hard edges.

    Parameters
    ----------
    surface : Surface
        m faces; its own normals, if it has any, are dropped.
    degrees : float
        Edges that bend by more are hard: 0 is flat shading, 180 smooth.

    Returns
    -------
    surface : Surface
        The same places, with `corner_normal`.

    Raises
    ------
    InputError
        If the angle is not between 0 and 180.

    Examples
    --------
    >>> from surftex.surface.shapes import cylinder
    >>> creased(cylinder(), 30).corner_normal.shape[1:]
    (3, 3)
    """
    degrees = checked_number(degrees, "crease", 0, 180)
    face, edge = np.nonzero(surface.neighbor >= 0)
    soft = edge_bend(surface)[face, edge] <= np.radians(degrees)
    face, edge = face[soft], edge[soft]
    other, other_edge = surface.neighbor[face, edge], surface.neighbor_edge[face, edge]
    here = np.concatenate([3 * face + edge, 3 * face + (edge + 1) % 3])
    there = np.concatenate([3 * other + (other_edge + 1) % 3, 3 * other + other_edge])
    count = 3 * len(surface.faces)
    graph = coo_array((np.ones(len(here), np.int8), (here, there)), shape=(count, count))
    group = connected_components(graph, directed=False)[1]
    weighted = (surface.frame[:, None, 2] * surface.corner_angle[..., None]).reshape(-1, 3)
    total = np.stack([np.bincount(group, weighted[:, k]) for k in range(3)], axis=1)[group]
    length = np.linalg.norm(total, axis=1, keepdims=True)
    flat = np.repeat(surface.frame[:, 2], 3, axis=0)
    normal = np.where(length > 1e-12, total / np.maximum(length, 1e-12), flat)
    return replace(surface, corner_normal=frozen(normal.reshape(-1, 3, 3)))


def edge_bend(surface: Surface) -> NDArray[np.float64]:
    """Measure how much the surface bends at its edges.

    Parameters
    ----------
    surface : Surface
        m faces.

    Returns
    -------
    angle : (m, 3) float64
        Between the normals of the faces on both sides of edge i, in radians; 0 on borders.
    """
    normal = surface.frame[:, 2]
    cosine = np.einsum("fi,fki->fk", normal, normal[np.maximum(surface.neighbor, 0)])
    return np.where(surface.neighbor >= 0, np.arccos(np.clip(cosine, -1.0, 1.0)), 0.0)


def crease_notes(surface: Surface) -> tuple[str, ...]:
    """Say where smooth shading is hardly what a mesh without normals wants.

    Parameters
    ----------
    surface : Surface
        Any.

    Returns
    -------
    notes : tuple of str
        A line, or none.
    """
    if surface.corner_normal is not None:
        return ()
    length = surface.edge_length
    sharp = float(length[edge_bend(surface) > np.radians(SHARP_DEGREES)].sum() / length.sum())
    if sharp < _MANY:
        return ()
    return (
        f"the mesh has no normals of its own, and {100 * sharp:.0f} % of its edges bend by more than "
        f"{SHARP_DEGREES:g} degrees: they are shaded round; crease = 40 (--crease 40) "
        "makes edges hard that bend by more than 40",
    )
