"""One winding for a component: spread over glued edges, cut where it cannot agree, outward if closed."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from surftex.surface.glue import Glue
from surftex.words import by_count


def orient(
    vertices: NDArray[np.float64], faces: NDArray[np.int64], pairs: Glue
) -> tuple[NDArray[np.bool_], Glue, list[str]]:
    """Decide which faces to turn over.

    The winding of most of a component's area wins; a closed component whose volume is negative is
    turned inside out. A component with one side only (a Moebius strip) is cut along edges until it has two.

    Parameters
    ----------
    vertices : (n, 3) float64
        Positions.
    faces : (m, 3) int64
        Triangles.
    pairs : Glue
        Half-edges that belong together.

    Returns
    -------
    turned : (m,) bool
        Faces to be wound the other way.
    pairs : Glue
        Without the edges that were cut.
    warnings : list of str
        What was done.
    """
    warnings: list[str] = []
    count = len(faces)
    start = faces.ravel()
    one, other = pairs.first // 3, pairs.second // 3
    against = start[pairs.first] == start[pairs.second]
    component = _components(count, one, other)
    corner = [vertices[faces[:, k]] for k in range(3)]
    area = np.linalg.norm(np.cross(corner[1] - corner[0], corner[2] - corner[0]), axis=1)
    turned = np.zeros(count, bool)
    if against.any():
        graph = coo_array(
            (
                np.ones(2 * len(one), np.int8),
                (
                    np.concatenate([one, one + count]),
                    np.concatenate([other + count * against, other + count * ~against]),
                ),
            ),
            shape=(2 * count,) * 2,
        )
        side = connected_components(graph, directed=False)[1]
        one_sided = np.unique(component[side[:count] == side[count:]])
        turned = side[:count] > side[count:]
        if len(one_sided):
            strip = np.isin(component, one_sided)
            turned[strip] = _spread(count, one, other, against, strip)[strip]
            cut = against ^ turned[one] ^ turned[other]
            warnings.append(
                by_count(len(one_sided), "{} component has", "{} components have")
                + " one side only (Moebius); "
                + by_count(int(cut.sum()), "{} edge was cut", "{} edges were cut")
            )
            half_edge = pairs.first[cut]
            ends = np.concatenate([start[half_edge], faces[half_edge // 3, (half_edge + 1) % 3]])
            ends = np.union1d(pairs.crowded_vertex, ends)
            pairs = Glue(pairs.first[~cut], pairs.second[~cut], pairs.crowded_edges, ends)
            one, other = one[~cut], other[~cut]
            component = _components(count, one, other)
        size = int(component.max()) + 1
        minority = np.bincount(component, np.where(turned, area, -area), minlength=size) > 0
        turned ^= minority[component]
        if turned.any():
            warnings.append(
                by_count(
                    int(turned.sum()),
                    "{} face was wound against its neighbours and was turned",
                    "{} faces were wound against their neighbours and were turned",
                )
            )
    inside_out = _inside_out(vertices, faces, turned, component, one, area)
    if inside_out.any():
        warnings.append(
            by_count(
                int(inside_out.sum()),
                "{} closed component was inside out and was turned to face outward",
                "{} closed components were inside out and were turned to face outward",
            )
        )
        turned ^= inside_out[component]
    return turned, pairs, warnings


def _components(count: int, one: NDArray[np.int64], other: NDArray[np.int64]) -> NDArray[np.int64]:
    graph = coo_array((np.ones(len(one), np.int8), (one, other)), shape=(count,) * 2)
    return connected_components(graph, directed=False)[1].astype(np.int64)


def _spread(
    count: int,
    one: NDArray[np.int64],
    other: NDArray[np.int64],
    against: NDArray[np.bool_],
    strip: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """Turn faces along a tree of neighbours, over the marked components."""
    inside = strip[one]
    one, other, against = one[inside], other[inside], against[inside]
    label = _components(count, one, other)
    roots = np.flatnonzero(strip)[np.unique(label[strip], return_index=True)[1]]
    rows, columns = np.concatenate([one, np.full(len(roots), count)]), np.concatenate([other, roots])
    graph = coo_array((np.ones(len(rows), np.int8), (rows, columns)), shape=(count + 1,) * 2).tocsr()
    parent = breadth_first_order(graph, count, directed=False)[1].astype(np.int64)
    key = np.minimum(one, other) * count + np.maximum(one, other)
    order = np.argsort(key, kind="stable")
    face = np.flatnonzero((parent >= 0) & (parent != count))
    wanted = np.minimum(face, parent[face]) * count + np.maximum(face, parent[face])
    turned = np.zeros(count + 1, bool)
    turned[face] = against[order[np.searchsorted(key[order], wanted)]]
    above = np.full(count + 1, count)
    above[face] = parent[face]
    while (above != count).any():
        turned, above = turned ^ turned[above], above[above]
    return turned[:count]


def _inside_out(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    turned: NDArray[np.bool_],
    component: NDArray[np.int64],
    one: NDArray[np.int64],
    area: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """(components,) closed, with a volume below zero that is more than rounding."""
    size = int(component.max()) + 1
    closed = 2 * np.bincount(component[one], minlength=size) == 3 * np.bincount(component, minlength=size)
    anchor = np.zeros((size, 3))
    anchor[component[::-1]] = vertices[faces[::-1, 0]]
    a, b, c = (vertices[faces[:, k]] - anchor[component] for k in range(3))
    volume = np.einsum("fi,fi->f", a, np.cross(b, c)) * np.where(turned, -1.0, 1.0)
    total = np.bincount(component, volume, minlength=size)
    return closed & (total < -1e-9 * np.bincount(component, area, minlength=size) ** 1.5)
