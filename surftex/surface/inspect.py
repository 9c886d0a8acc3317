"""What a surface is: its size, its topology, the shape of its triangles, its own UVs."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.surface.surface import Surface

SLIVER_DEGREES = 5.0
"""Triangles with a smaller angle are called slivers."""


@dataclass(frozen=True)
class PartDescription:
    """One part of a surface.

    Attributes
    ----------
    name : str
        Material slot, group or node.
    faces : int
        Triangles.
    area_mm2 : float
        Their area.
    """

    name: str
    faces: int
    area_mm2: float


@dataclass(frozen=True)
class Description:
    """What `surftex inspect` prints.

    Attributes
    ----------
    name, sha256 : str
        Of the surface.
    faces, vertices, edges, components : int
        Counts.
    closed_components : int
        Components without a border.
    border_loops : int
        Closed borders.
    border_length_mm : float
        Length of them all.
    euler_characteristic : int
        Vertices less edges plus faces.
    genus : int
        Handles, summed over the components.
    area_mm2 : float
        Of all faces.
    volume_mm3 : float or None
        Enclosed, where every component is closed.
    size_mm : tuple of float
        Sides of the bounding box.
    span_mm : dict of str to (float, float)
        Least and greatest coordinate in the file, by axis: x, y, z.
    mm_per_unit : float
        Millimetres in a unit of the file.
    edge_length_mm : dict of str to float
        Least, 5 %, median, 95 % and longest.
    smallest_angle_degrees : float
        Of any corner.
    slivers : int
        Triangles with an angle below `SLIVER_DEGREES`.
    own_uv : dict of str to object
        ``state`` ("none", "inside 0..1" or "leaves 0..1"), and where there are any: ``range``,
        ``mirrored_faces``, ``flat_faces`` (no UV area), ``area`` (sum over the faces, 1 is the whole page).
    own_normals : bool
        Whether the file's shading normals are kept.
    parts : tuple of PartDescription
        In the order of the surface.
    warnings : tuple of str
        What loading mended.
    """

    name: str
    sha256: str
    faces: int
    vertices: int
    edges: int
    components: int
    closed_components: int
    border_loops: int
    border_length_mm: float
    euler_characteristic: int
    genus: int
    area_mm2: float
    volume_mm3: float | None
    size_mm: tuple[float, float, float]
    span_mm: dict[str, tuple[float, float]]
    mm_per_unit: float
    edge_length_mm: dict[str, float]
    smallest_angle_degrees: float
    slivers: int
    own_uv: dict[str, Any]
    own_normals: bool
    parts: tuple[PartDescription, ...]
    warnings: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Give plain values, ready for JSON.

        Returns
        -------
        values : dict
            Nested, of numbers, text, lists and dicts.
        """
        return asdict(self)


def euler_characteristics(surface: Surface) -> NDArray[np.int64]:
    """Count vertices less edges plus faces, component by component.

    Parameters
    ----------
    surface : Surface
        Any.

    Returns
    -------
    characteristic : (components,) int64
        2 for a ball, 1 for a disk, 0 for a ring or a torus.

    Examples
    --------
    >>> from surftex.surface.shapes import plane
    >>> euler_characteristics(plane())
    array([1])
    """
    count = int(surface.component.max()) + 1
    of_vertex = np.zeros(len(surface.vertices), np.int32)
    of_vertex[surface.faces] = surface.component[:, None]
    faces = np.bincount(surface.component, minlength=count)
    sides = np.bincount(surface.component, (surface.neighbor < 0).sum(axis=1), minlength=count)
    return np.bincount(of_vertex, minlength=count) - (3 * faces + sides.astype(np.int64)) // 2 + faces


def describe(surface: Surface) -> Description:
    """Measure a surface.

    Parameters
    ----------
    surface : Surface
        Any.

    Returns
    -------
    description : Description
        Counts, lengths in mm, and what loading mended.

    Examples
    --------
    >>> from surftex.surface.shapes import torus
    >>> description = describe(torus())
    >>> description.genus, description.euler_characteristic, description.border_loops
    (1, 0, 0)
    """
    border = surface.neighbor < 0
    length = surface.edge_length
    edges = (3 * len(surface.faces) + int(border.sum())) // 2
    component = surface.component
    components = int(component.max()) + 1
    open_ = np.zeros(components, bool)
    open_[component[border.any(axis=1)]] = True
    euler = int(euler_characteristics(surface).sum())
    loops = surface.border_loops
    a, b, c = (surface.vertices[surface.faces[:, k]] for k in range(3))
    volume = float(np.einsum("fi,fi->", a, np.cross(b, c))) / 6
    kept_once = np.where(border, 1.0, 0.5)
    shares = (0.0, 0.05, 0.5, 0.95, 1.0)
    names = ("least", "5 %", "median", "95 %", "longest")
    smallest = np.degrees(surface.corner_angle.min(axis=1))
    least, greatest = (
        surface.origin_mm + end for end in (surface.vertices.min(axis=0), surface.vertices.max(axis=0))
    )
    size = greatest - least
    faces_in = np.bincount(surface.part, minlength=len(surface.part_names))
    area_in = np.bincount(surface.part, surface.face_area_mm2, minlength=len(surface.part_names))
    return Description(
        name=surface.name,
        sha256=surface.sha256,
        faces=len(surface.faces),
        vertices=len(surface.vertices),
        edges=edges,
        components=components,
        closed_components=int((~open_).sum()),
        border_loops=loops,
        border_length_mm=float(length[border].sum()),
        euler_characteristic=euler,
        genus=(2 * components - loops - euler) // 2,
        area_mm2=surface.area_mm2,
        volume_mm3=None if open_.any() else volume,
        size_mm=(float(size[0]), float(size[1]), float(size[2])),
        span_mm={axis: (float(a), float(b)) for axis, a, b in zip("xyz", least, greatest, strict=True)},
        mm_per_unit=surface.mm_per_unit,
        edge_length_mm={
            name: _weighted_quantile(length.ravel(), kept_once.ravel(), share)
            for name, share in zip(names, shares, strict=True)
        },
        smallest_angle_degrees=float(smallest.min()),
        slivers=int((smallest < SLIVER_DEGREES).sum()),
        own_uv=_own_uv(surface),
        own_normals=surface.corner_normal is not None,
        parts=tuple(
            PartDescription(name, int(count), float(area))
            for name, count, area in zip(surface.part_names, faces_in, area_in, strict=True)
        ),
        warnings=surface.warnings,
    )


def _weighted_quantile(values: np.ndarray, weight: np.ndarray, share: float) -> float:
    """Smallest value with at least that share of the weight at or below it."""
    order = np.argsort(values)
    total = np.cumsum(weight[order])
    return float(values[order[min(int(np.searchsorted(total, share * total[-1])), len(order) - 1)]])


def _own_uv(surface: Surface) -> dict[str, Any]:
    uv = surface.corner_uv
    if uv is None:
        return {"state": "none"}
    side = uv[:, 1:] - uv[:, :1]
    signed = 0.5 * (side[:, 0, 0] * side[:, 1, 1] - side[:, 0, 1] * side[:, 1, 0])
    flat = np.abs(signed) <= 1e-12 * float(np.abs(signed).sum())
    low, high = uv.min(axis=(0, 1)), uv.max(axis=(0, 1))
    inside = bool((low >= 0).all() and (high <= 1).all())
    return {
        "state": "inside 0..1" if inside else "leaves 0..1",
        "range": [[float(low[0]), float(high[0])], [float(low[1]), float(high[1])]],
        "mirrored_faces": int(((signed < 0) & ~flat).sum()),
        "flat_faces": int(flat.sum()),
        "area": float(np.abs(signed).sum()),
    }
