"""Shapes with known geometry: the truth that tests measure against, and small subjects for examples."""

import numpy as np

from surftex.surface.surface import Surface


def plane(width_mm: float = 10.0, height_mm: float | None = None, *, cells: int = 16) -> Surface:
    """Make a flat rectangle in the xy plane, facing +z, with its own unwrap.

    Parameters
    ----------
    width_mm : float
        Along x.
    height_mm : float, optional
        Along y; as `width_mm` without it.
    cells : int
        Squares along x, two triangles each, with diagonals that alternate.

    Returns
    -------
    surface : Surface
        Lower left corner at the origin.
    """
    height_mm = width_mm if height_mm is None else height_mm
    rows = max(1, round(cells * height_mm / width_mm))
    x, y = np.meshgrid(np.linspace(0, 1, cells + 1), np.linspace(0, 1, rows + 1))
    unit = np.stack([x.ravel(), y.ravel()], axis=1)
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(cells), np.arange(rows)))
    a = j * (cells + 1) + i
    b, c, d = a + 1, a + cells + 2, a + cells + 1
    even = ((i + j) % 2 == 0)[:, None]
    first = np.where(even, np.stack([a, b, c], axis=1), np.stack([a, b, d], axis=1))
    second = np.where(even, np.stack([a, c, d], axis=1), np.stack([b, c, d], axis=1))
    faces = np.stack([first, second], axis=1).reshape(-1, 3)
    scale = np.array([width_mm, height_mm])
    square = unit * scale / scale.max()
    return Surface.from_arrays(
        np.column_stack([unit * scale, np.zeros(len(unit))]), faces, corner_uv=square[faces], name="plane"
    )


def sphere(radius_mm: float = 40.0, *, subdivisions: int = 3) -> Surface:
    """Make a ball from a subdivided icosahedron.

    Parameters
    ----------
    radius_mm : float
        Of every vertex.
    subdivisions : int
        Each one quarters the faces: 20, 80, 320, ...

    Returns
    -------
    surface : Surface
        Closed, centred at the origin.
    """
    golden = (1 + 5**0.5) / 2
    points = np.array([
        [-1, golden, 0], [1, golden, 0], [-1, -golden, 0], [1, -golden, 0], [0, -1, golden], [0, 1, golden],
        [0, -1, -golden], [0, 1, -golden], [golden, 0, -1], [golden, 0, 1], [-golden, 0, -1], [-golden, 0, 1],
    ])  # fmt: skip
    faces = np.array([
        [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
        [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
    ])  # fmt: skip
    points = points / np.linalg.norm(points, axis=1, keepdims=True)
    for _ in range(subdivisions):
        points, faces = midpoint_subdivided(points, faces)
        points = points / np.linalg.norm(points, axis=1, keepdims=True)
    return Surface.from_arrays(points * radius_mm, faces, name="sphere")


def midpoint_subdivided(points: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cut every triangle into four at the middles of its edges.

    Parameters
    ----------
    points : (n, 3) float
        Vertices.
    faces : (m, 3) int
        Triangles; child faces 4 f to 4 f + 3 come from face f, the last one from its middle.

    Returns
    -------
    points : (k, 3) float
        The old vertices, then one for each edge.
    faces : (4 m, 3) int
        The children.
    """
    pairs = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    edges, index = np.unique(pairs, axis=0, return_inverse=True)
    middle = len(points) + index.reshape(-1, 3)
    a, b, c = faces.T
    ab, bc, ca = middle.T
    children = np.stack(
        [np.stack(f, axis=1) for f in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))], axis=1
    )
    return np.concatenate([points, points[edges].mean(axis=1)]), children.reshape(-1, 3)


def _revolved_grid(columns: int, rows: int, *, wrap_rows: bool) -> np.ndarray:
    """Faces of a grid that closes in its columns, and in its rows if told."""
    i, j = (
        grid.ravel() for grid in np.meshgrid(np.arange(columns), np.arange(rows if wrap_rows else rows - 1))
    )
    right, up = (i + 1) % columns, (j + 1) % rows
    a, b, c, d = j * columns + i, j * columns + right, up * columns + right, up * columns + i
    return np.stack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)], axis=1).reshape(-1, 3)


def cylinder(
    radius_mm: float = 20.0, height_mm: float = 60.0, *, columns: int = 48, rows: int = 24
) -> Surface:
    """Make an open tube around the z axis, facing outward.

    Parameters
    ----------
    radius_mm : float
        Of the vertices.
    height_mm : float
        Along z, from 0.
    columns : int
        Vertices around.
    rows : int
        Vertices along the height.

    Returns
    -------
    surface : Surface
        With two borders.
    """
    angle, z = np.meshgrid(np.arange(columns) * 2 * np.pi / columns, np.linspace(0, height_mm, rows))
    points = np.stack([radius_mm * np.cos(angle), radius_mm * np.sin(angle), z], axis=-1).reshape(-1, 3)
    return Surface.from_arrays(points, _revolved_grid(columns, rows, wrap_rows=False), name="cylinder")


def torus(ring_mm: float = 30.0, tube_mm: float = 12.0, *, columns: int = 72, rows: int = 36) -> Surface:
    """Make a ring around the z axis, facing outward.

    Parameters
    ----------
    ring_mm : float
        From the axis to the middle of the tube.
    tube_mm : float
        Radius of the tube.
    columns : int
        Vertices around the axis.
    rows : int
        Vertices around the tube.

    Returns
    -------
    surface : Surface
        Closed, genus 1.
    """
    angle, tilt = np.meshgrid(np.arange(columns) * 2 * np.pi / columns, np.arange(rows) * 2 * np.pi / rows)
    away = ring_mm + tube_mm * np.cos(tilt)
    points = np.stack([away * np.cos(angle), away * np.sin(angle), tube_mm * np.sin(tilt)], axis=-1).reshape(
        -1, 3
    )
    return Surface.from_arrays(points, _revolved_grid(columns, rows, wrap_rows=True), name="torus")
