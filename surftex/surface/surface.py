"""`Surface`: triangles that can be walked on. Millimetres, consistently oriented, immutable.

Two faces are neighbours where they run along one edge in opposite senses; every other edge is a border. A
vertex has one fan of faces. `surftex.surface.repair` makes such meshes from whatever a file holds.

Each face has a frame of its own: corner 0 at the origin, corner 1 on the x axis, corner 2 above it. Edge i
runs from corner i to corner i+1. Tangent vectors and directions are two numbers in the frame of their face.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from surftex.arrays import checked, frozen, read_only_view
from surftex.errors import SurfaceError
from surftex.surface.parts import Labels


@dataclass(frozen=True, eq=False)
class Surface:
    """A triangle mesh to walk on; make one with `Surface.from_arrays` or `surftex.load`.

    Attributes
    ----------
    vertices : (n, 3) float64
        Millimetres from `origin_mm`.
    faces : (m, 3) int32
        Counter-clockwise seen from outside.
    corner_uv : (m, 3, 2) float64 or None
        The file's own unwrap, per corner.
    corner_normal : (m, 3, 3) float64 or None
        The file's own shading normals, per corner, unit length.
    part : (m,) int32
        Index into `part_names` for each face.
    part_names : tuple of str
        Material slots, groups or nodes of the file.
    labels : mapping of str to ((m,) int32, tuple of str)
        All names that the file has for its faces, by kind ("material", "group", "node"): an index for each face, and
        the names; `part` and `part_names` are one of them.
    selected : bool
        Whether it is a part of its file.
    origin_mm : (3,) float64
        Where the file has the point that `vertices` counts from.
    name : str
        Stem for file names.
    sha256 : str
        Of the file's bytes; of the arrays when there was no file.
    mm_per_unit : float
        Millimetres in a unit of the file.
    warnings : tuple of str
        What loading mended, a line each.
    attributes : mapping of str to (m, 3) or (m, 3, k) float64
        Painted or computed numbers by name, at the corners of each face; NaN where the file has none.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    corner_uv: NDArray[np.float64] | None
    corner_normal: NDArray[np.float64] | None
    part: NDArray[np.int32]
    part_names: tuple[str, ...]
    origin_mm: NDArray[np.float64]
    name: str
    sha256: str
    mm_per_unit: float
    warnings: tuple[str, ...]
    neighbor: NDArray[np.int32]
    neighbor_edge: NDArray[np.int32]
    attributes: Mapping[str, NDArray[np.float64]] = field(default_factory=lambda: MappingProxyType({}))
    labels: Labels = field(default_factory=lambda: MappingProxyType({}))
    selected: bool = False

    def __repr__(self) -> str:
        return (
            f"Surface({self.name!r}: {len(self.faces)} faces, {len(self.vertices)} vertices, "
            f"{self.area_mm2:.6g} mm^2, parts {', '.join(self.part_names)})"
        )

    @staticmethod
    def from_arrays(
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        corner_uv: ArrayLike | None = None,
        corner_normal: ArrayLike | None = None,
        part: ArrayLike | None = None,
        part_names: tuple[str, ...] = ("surface",),
        origin_mm: ArrayLike = (0.0, 0.0, 0.0),
        name: str = "surface",
        sha256: str = "",
        mm_per_unit: float = 1.0,
        warnings: tuple[str, ...] = (),
        attributes: Mapping[str, ArrayLike] | None = None,
        labels: Labels | None = None,
        selected: bool = False,
    ) -> "Surface":
        """Check the arrays, glue the faces, freeze all.

        Parameters
        ----------
        vertices : (n, 3) float
            Millimetres.
        faces : (m, 3) int
            Counter-clockwise seen from outside.
        corner_uv : (m, 3, 2) float, optional
            Own unwrap.
        corner_normal : (m, 3, 3) float, optional
            Own shading normals.
        part : (m,) int, optional
            Part of each face; one part without it.
        part_names : tuple of str
            Names of the parts.
        origin_mm : (3,) float
            Added again on export.
        name : str
            Stem for file names.
        sha256 : str
            Of the file's bytes.
        mm_per_unit : float
            Millimetres in a unit of the file.
        warnings : tuple of str
            What loading mended.
        attributes : mapping of str to (m, 3) or (m, 3, k) float, optional
            Numbers at the corners of the faces.
        labels : mapping of str to ((m,) int, tuple of str), optional
            All names of the faces, by kind; those of the parts without it.
        selected : bool
            Whether it is a part of its file.

        Returns
        -------
        surface : Surface
            Read-only copies of everything.

        Raises
        ------
        SurfaceError
            If a face points outside the vertices, has no area, runs along an edge in the same sense as
            another, or if a vertex has several fans: `surftex.surface.repair.repair` mends the last three.
        """
        points = checked(vertices, "vertices", (None, 3), np.float64, error=SurfaceError)
        triangles = checked(faces, "faces", (None, 3), np.int32, error=SurfaceError)
        if len(triangles) == 0:
            raise SurfaceError("the mesh has no faces; surftex textures surfaces, not points or lines")
        outside = np.flatnonzero(((triangles < 0) | (triangles >= len(points))).any(axis=1))
        if len(outside):
            first = int(outside[0])
            raise SurfaceError(
                f"{len(outside)} of {len(triangles)} faces point outside the {len(points)} vertices; "
                f"the first is face {first} = {triangles[first].tolist()}. Was the mesh cut without re-indexing?"
            )
        neighbor, neighbor_edge = _glue(triangles, len(points))
        count = len(triangles)
        surface = Surface(
            vertices=frozen(points.copy()),
            faces=frozen(triangles.copy()),
            corner_uv=None
            if corner_uv is None
            else frozen(
                checked(corner_uv, "corner_uv", (count, 3, 2), np.float64, error=SurfaceError).copy()
            ),
            corner_normal=None
            if corner_normal is None
            else frozen(
                checked(corner_normal, "corner_normal", (count, 3, 3), np.float64, error=SurfaceError).copy()
            ),
            part=frozen(
                np.zeros(count, np.int32)
                if part is None
                else checked(part, "part", (count,), np.int32, error=SurfaceError).copy()
            ),
            part_names=tuple(part_names),
            origin_mm=frozen(checked(origin_mm, "origin_mm", (3,), np.float64, error=SurfaceError).copy()),
            name=name,
            sha256=sha256,
            mm_per_unit=float(mm_per_unit),
            warnings=tuple(warnings),
            neighbor=frozen(neighbor),
            neighbor_edge=frozen(neighbor_edge),
            attributes=MappingProxyType(
                {name: _corner_numbers(name, value, count) for name, value in (attributes or {}).items()}
            ),
            selected=selected,
        )
        if surface.part.min() < 0 or surface.part.max() >= len(surface.part_names):
            raise SurfaceError(
                f"part runs from {surface.part.min()} to {surface.part.max()}, but there are "
                f"{len(surface.part_names)} part names"
            )
        named = {
            kind: (frozen(checked(index, kind, (count,), np.int32, error=SurfaceError).copy()), names)
            for kind, (index, names) in (labels or {"part": (surface.part, surface.part_names)}).items()
        }
        surface = replace(surface, labels=MappingProxyType(named))
        flat = np.flatnonzero(~(surface.face_area_mm2 > 0))
        if len(flat):
            raise SurfaceError(
                f"{len(flat)} of {count} faces have no area; the first is face {int(flat[0])}. "
                "Drop them with surftex.surface.repair.repair"
            )
        return surface

    def with_attributes(
        self, values: Mapping[str, ArrayLike], at: Literal["vertices", "faces", "corners"] = "vertices"
    ) -> "Surface":
        """Hang numbers on the surface, for fields to read.

        Parameters
        ----------
        values : mapping of str to array
            By name: (n,) or (n, k) for the vertices, (m,) or (m, k) for the faces, (m, 3) or (m, 3, k) for the
            corners. Names that are there already are replaced.
        at : str
            ``"vertices"``, ``"faces"`` or ``"corners"``.

        Returns
        -------
        surface : Surface
            The same, with the attributes.

        Raises
        ------
        SurfaceError
            If an array has another length, or `at` is none of these.
        """
        count = {"vertices": len(self.vertices), "faces": len(self.faces), "corners": len(self.faces)}
        if at not in count:
            raise SurfaceError(f"at = {at!r}; it takes {', '.join(map(repr, count))}")
        hung = dict(self.attributes)
        for name, value in values.items():
            array = np.asarray(value)
            if array.ndim == 0 or len(array) != count[at]:
                raise SurfaceError(
                    f"attribute {name!r} has shape {array.shape}; the surface has {count[at]} {at}"
                )
            if at == "vertices":
                array = array[self.faces]
            elif at == "faces":
                array = np.repeat(array[:, None], 3, axis=1)
            hung[name] = _corner_numbers(name, array, len(self.faces))
        return replace(self, attributes=MappingProxyType(hung))

    def slot_names(self, stem: str) -> dict[int, str]:
        """Name the materials of a result as the file does.

        Parameters
        ----------
        stem : str
            What the only one is called, where the surface is the whole file.

        Returns
        -------
        names : dict of int to str
            For each part that has faces, ascending.
        """
        used = np.unique(self.part).tolist()
        if len(used) == 1 and not self.selected:
            return {used[0]: stem}
        return {part: self.part_names[part] for part in used}

    @cached_property
    def edge_length(self) -> NDArray[np.float64]:
        """(m, 3) mm; edge i runs from corner i to corner i+1."""
        corners = self.vertices[self.faces]
        return frozen(np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2))

    @cached_property
    def frame(self) -> NDArray[np.float64]:
        """(m, 3, 3): rows are the face's x axis, y axis and outward unit normal."""
        a, b, c = np.moveaxis(self.vertices[self.faces], 1, 0)
        x = (b - a) / self.edge_length[:, :1]
        normal = np.cross(x, (c - a) / np.maximum(self.edge_length[:, 2:], np.finfo(float).tiny))
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
        return frozen(np.stack([x, np.cross(normal, x), normal], axis=1))

    @cached_property
    def flat(self) -> NDArray[np.float64]:
        """(m, 3, 2) mm: the corners in the frame of their face."""
        corners = np.zeros((len(self.faces), 3, 2))
        side = self.vertices[self.faces[:, 2]] - self.vertices[self.faces[:, 0]]
        corners[:, 1, 0] = self.edge_length[:, 0]
        corners[:, 2, 0] = np.einsum("fi,fi->f", side, self.frame[:, 0])
        corners[:, 2, 1] = np.einsum("fi,fi->f", side, self.frame[:, 1])
        return frozen(corners)

    @cached_property
    def face_area_mm2(self) -> NDArray[np.float64]:
        """(m,) mm^2."""
        return frozen(0.5 * self.flat[:, 1, 0] * self.flat[:, 2, 1])

    @cached_property
    def area_mm2(self) -> float:
        """Area of all faces."""
        return float(self.face_area_mm2.sum())

    @cached_property
    def longest_side_mm(self) -> float:
        """Of the bounding box: what ``--size`` sets."""
        return float(np.ptp(self.vertices, axis=0).max())

    @cached_property
    def mean_edge_mm(self) -> float:
        """Mean edge length: the h of error bounds and of the choice of solver."""
        return float(self.edge_length.mean())

    @cached_property
    def transport(self) -> NDArray[np.float64]:
        """(m, 3, 4): (c, s, x, y) that carry a point across edge i into the neighbour's frame.

        ``there = (c here_x - s here_y + x, s here_x + c here_y + y)``; the identity at a border.
        """
        face, edge = np.nonzero(self.neighbor >= 0)
        other, other_edge = self.neighbor[face, edge], self.neighbor_edge[face, edge]
        here_a, here_b = self.flat[face, edge], self.flat[face, (edge + 1) % 3]
        there_a, there_b = self.flat[other, (other_edge + 1) % 3], self.flat[other, other_edge]
        here = (here_b - here_a) @ np.array([1, 1j])
        there = (there_b - there_a) @ np.array([1, 1j])
        turn = there * here.conj()
        turn /= np.abs(turn)
        shift = there_a @ np.array([1, 1j]) - turn * (here_a @ np.array([1, 1j]))
        result = np.zeros((len(self.faces), 3, 4))
        result[..., 0] = 1
        result[face, edge] = np.stack([turn.real, turn.imag, shift.real, shift.imag], axis=1)
        return frozen(result)

    @cached_property
    def corner_angle(self) -> NDArray[np.float64]:
        """(m, 3) radians."""
        onward = np.roll(self.flat, -1, axis=1) - self.flat
        back = np.roll(self.flat, 1, axis=1) - self.flat
        cross = onward[..., 0] * back[..., 1] - onward[..., 1] * back[..., 0]
        return frozen(np.arctan2(np.abs(cross), (onward * back).sum(axis=2)))

    @cached_property
    def vertex_angle(self) -> NDArray[np.float64]:
        """(n,) radians: the sum of the corners at a vertex; 2 pi where it is flat and inside."""
        return frozen(
            np.bincount(self.faces.ravel(), self.corner_angle.ravel(), minlength=len(self.vertices))
        )

    @cached_property
    def on_border(self) -> NDArray[np.bool_]:
        """(n,) whether a vertex lies on a border."""
        face, edge = np.nonzero(self.neighbor < 0)
        result = np.zeros(len(self.vertices), bool)
        result[self.faces[face, edge]] = True
        result[self.faces[face, (edge + 1) % 3]] = True
        return frozen(result)

    @cached_property
    def fans(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
        """The corners around each vertex, counter-clockwise; a border vertex starts at its border.

        start (n+1,), corner (3m,) as 3 face + i, angle (3m,) walked before each corner.
        """
        from surftex.kernels.topology import vertex_fans

        order = np.argsort(self.faces.ravel(), kind="stable")
        counts = np.bincount(self.faces.ravel(), minlength=len(self.vertices))
        start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        corner, angle = np.zeros(len(order), np.int64), np.zeros(len(order))
        broken = vertex_fans(
            start, order, self.neighbor, self.neighbor_edge, self.corner_angle, corner, angle
        )
        if broken >= 0:
            raise SurfaceError(
                f"vertex {broken} joins several fans of faces; split it with surftex.surface.repair.repair"
            )
        return frozen(start), frozen(corner), frozen(angle)

    @cached_property
    def component(self) -> NDArray[np.int32]:
        """(m,) index of the connected component of each face."""
        return hanging_together(self, self.neighbor < 0)

    @cached_property
    def vertex_normal(self) -> NDArray[np.float64]:
        """(n, 3) unit normals, weighted by corner angle."""
        weighted = (self.frame[:, None, 2] * self.corner_angle[..., None]).reshape(-1, 3)
        index = self.faces.ravel()
        total = np.stack(
            [np.bincount(index, weighted[:, k], minlength=len(self.vertices)) for k in range(3)], axis=1
        )
        length = np.linalg.norm(total, axis=1, keepdims=True)
        return frozen(
            np.divide(total, length, out=np.tile([0.0, 0.0, 1.0], (len(total), 1)), where=length > 0)
        )

    @cached_property
    def shading_normal(self) -> NDArray[np.float64]:
        """(m, 3, 3) unit normals at the corners: the file's own where it has them, else smooth."""
        return (
            self.corner_normal if self.corner_normal is not None else frozen(self.vertex_normal[self.faces])
        )

    @cached_property
    def border_loops(self) -> int:
        """Number of closed borders."""
        face, edge = np.nonzero(self.neighbor < 0)
        if len(face) == 0:
            return 0
        a, b = self.faces[face, edge], self.faces[face, (edge + 1) % 3]
        used, compact = np.unique(np.concatenate([a, b]), return_inverse=True)
        graph = coo_array(
            (np.ones(len(a), np.int8), (compact[: len(a)], compact[len(a) :])), shape=(len(used),) * 2
        )
        return int(connected_components(graph, directed=False)[0])


def _corner_numbers(name: str, value: ArrayLike, count: int) -> NDArray[np.float64]:
    """(count, 3) or (count, 3, k) numbers; they may be missing, as NaN, where nobody asks for them."""
    array = np.asarray(value)
    if array.dtype.kind not in "biuf" or array.ndim not in (2, 3) or array.shape[:2] != (count, 3):
        raise SurfaceError(
            f"attribute {name!r} has shape {array.shape} of {array.dtype}; it takes numbers, ({count}, 3) or "
            f"({count}, 3, k)"
        )
    return frozen(np.array(array, np.float64))


def _glue(faces: NDArray[np.int32], vertex_count: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Neighbour face and its edge across each edge, -1 at borders."""
    start = faces.astype(np.int64).ravel()
    end = np.roll(faces, -1, axis=1).astype(np.int64).ravel()
    key = start * vertex_count + end
    order = np.argsort(key, kind="stable")
    ordered = key[order]
    repeated = np.flatnonzero(ordered[1:] == ordered[:-1])
    if len(repeated):
        first, second = np.sort(order[[repeated[0], repeated[0] + 1]]) // 3
        raise SurfaceError(
            f"{len(repeated)} edges are run along in the same sense by several faces; the first by faces "
            f"{first} and {second}. Mend the mesh with surftex.surface.repair.repair"
        )
    found = np.minimum(np.searchsorted(ordered, end * vertex_count + start), len(key) - 1)
    twin = np.where(ordered[found] == end * vertex_count + start, order[found], -1)
    neighbor = np.where(twin >= 0, twin // 3, -1).astype(np.int32).reshape(-1, 3)
    edge = np.where(twin >= 0, twin % 3, 0).astype(np.int32).reshape(-1, 3)
    return neighbor, edge


def hanging_together(surface: Surface, apart: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Give numbers to the parts of a surface that faces hang together in.

    Parameters
    ----------
    surface : Surface
        m faces.
    apart : (m, 3) bool
        Edges that part faces, on both sides; borders do so anyway.

    Returns
    -------
    part : (m,) int32
        Of each face, counted from 0 in the order of their first faces. Read-only.
    """
    from surftex.kernels.topology import label_parts

    part = np.zeros(len(surface.faces), np.int32)
    label_parts(surface.neighbor, read_only_view(apart, bool), np.zeros_like(part), part)
    return frozen(part)
