"""Tangent spaces at vertices, how directions are carried between them, and the equations of smooth fields.

Around an inner vertex the angles are stretched to a full turn. A direction with `symmetry` equal arms is one
complex number, its angle times `symmetry`. Carried from a vertex straight to a point of a face, it depends on
the way the line leaves the vertex, so that a field interpolated from the corners is continuous across edges.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from surftex.geodesics.factors import Factors, solved_by_steps
from surftex.geodesics.modes import lowest_mode
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

FACTORED_VERTICES = 400_000
"""Vertices up to which the equations of a field are factored; beyond it factors take 4 kB a vertex and more."""

_LEAST_WEIGHT, _MOST_WEIGHT = 1e-2, 1e2
"""Bounds of an edge's weight: 0.58 between equilateral triangles, negative or huge between slivers."""


@dataclass(frozen=True, eq=False)
class Connection:
    """Directions at the vertices of a surface.

    Attributes
    ----------
    surface : Surface
        m faces, n vertices.
    symmetry : int
        Equal arms of a direction.
    """

    surface: Surface
    symmetry: int

    @cached_property
    def edge_angle(self) -> NDArray[np.float64]:
        """(m, 3) direction of edge i in the frame of its face."""
        along = np.roll(self.surface.flat, -1, axis=1) - self.surface.flat
        return np.arctan2(along[..., 1], along[..., 0])

    @cached_property
    def stretch(self) -> NDArray[np.float64]:
        """(m, 3) full turn by the sum of angles at each corner's vertex; 1 on borders."""
        total = np.where(self.surface.vertex_angle > 0, self.surface.vertex_angle, 1.0)
        return np.where(self.surface.on_border, 1.0, 2 * np.pi / total)[self.surface.faces]

    @cached_property
    def before(self) -> NDArray[np.float64]:
        """(m, 3) angle walked around the corner's vertex, before the corner."""
        _, corner, angle = self.surface.fans
        result = np.zeros(3 * len(self.surface.faces))
        result[corner] = angle
        return result.reshape(-1, 3)

    @cached_property
    def mass(self) -> NDArray[np.float64]:
        """(n,) mm^2: a third of the faces around a vertex."""
        share = np.repeat(self.surface.face_area_mm2 / 3, 3)
        count = len(self.surface.vertices)
        return np.bincount(self.surface.faces.ravel(), share, minlength=count).astype(np.float64)

    @cached_property
    def component(self) -> NDArray[np.int64]:
        """(n,) component of each vertex; 0 where no face uses it."""
        result = np.zeros(len(self.surface.vertices), np.int64)
        result[self.surface.faces.ravel()] = np.repeat(self.surface.component, 3)
        return result

    @cached_property
    def edge_turn(self) -> NDArray[np.float64]:
        """(m, 3) added to an angle carried along edge i from its start's tangent space to its end's."""
        leaving = self.stretch * self.before
        arriving = self.stretch * (self.before + self.surface.corner_angle)
        return np.roll(arriving, -1, axis=1) + np.pi - leaving

    def corner_turn(
        self, face: NDArray[np.int32], away: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]:
        """Angles that carry directions from the corners of faces into their frames.

        Parameters
        ----------
        face : (k,) int32
            Faces.
        away : (k, 3) float64, optional
            Angle between edge i and the way from corner i to the place; the middle of the corner without it.

        Returns
        -------
        turn : (k, 3) float64
            Add it to a vertex' angle to get the face's.
        """
        if away is None:
            away = 0.5 * self.surface.corner_angle[face]
        return self.edge_angle[face] + away - self.stretch[face] * (self.before[face] + away)

    def away(self, points: SurfacePoints) -> NDArray[np.float64]:
        """Angles between the edges at the corners and the ways from there to points.

        Parameters
        ----------
        points : SurfacePoints
            k points.

        Returns
        -------
        away : (k, 3) float64
            From 0 to the angle of the corner.
        """
        corner = self.surface.flat[points.face]
        weights = np.maximum(points.barycentric, 0.0)
        onward, back = np.roll(weights, -1, axis=1), np.roll(weights, -2, axis=1)
        edge = np.roll(corner, -1, axis=1) - corner
        other = np.roll(corner, -2, axis=1) - corner
        way = onward[..., None] * edge + back[..., None] * other
        across = edge[..., 0] * way[..., 1] - edge[..., 1] * way[..., 0]
        angle = np.arctan2(np.maximum(across, 0.0), (edge * way).sum(axis=2))
        whole = self.surface.corner_angle[points.face]
        return np.where(onward + back > 0, np.minimum(angle, whole), 0.5 * whole)

    def interpolated(self, value: NDArray[np.complex128], points: SurfacePoints) -> NDArray[np.complex128]:
        """Directions at points, from directions at vertices.

        Parameters
        ----------
        value : (n,) complex128
            At the vertices.
        points : SurfacePoints
            k points.

        Returns
        -------
        value : (k,) complex128
            In the frames of the points' faces; continuous across edges.
        """
        turn = np.exp(1j * self.symmetry * self.corner_turn(points.face, self.away(points)))
        return (points.barycentric * turn * value[self.surface.faces[points.face]]).sum(axis=1)

    def gathered(self, value: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Means at vertices, weighted by corner angle, of directions given in the frames of faces.

        Parameters
        ----------
        value : (m,) complex128
            One per face.

        Returns
        -------
        value : (n,) complex128
            At the vertices; 0 where no face is.
        """
        from surftex.kernels.connection import gather_directions

        first, corner, walked = self.surface.fans
        result = np.zeros(len(self.surface.vertices), np.complex128)
        gather_directions(
            first, corner, walked, self.surface.corner_angle, self.edge_angle, self.stretch,
            self.symmetry, np.asarray(value, np.complex128), result,
        )  # fmt: skip
        return result

    def index(self, value: NDArray[np.complex128]) -> NDArray[np.int64]:
        """Count a field's turns around each face, in steps of 1 / symmetry: 0 but at singularities.

        Parameters
        ----------
        value : (n,) complex128
            At the vertices.

        Returns
        -------
        index : (m,) int64
            They add up to symmetry times the Euler number on a closed surface.
        """
        here = value[self.surface.faces] * np.exp(1j * self.symmetry * self.edge_turn)
        change = np.angle(np.roll(value[self.surface.faces], -1, axis=1) * here.conj())
        curvature = ((self.stretch - 1) * self.surface.corner_angle).sum(axis=1)
        return np.rint((change.sum(axis=1) + self.symmetry * curvature) / (2 * np.pi)).astype(np.int64)

    @cached_property
    def laplacian(self) -> csr_array:
        """(n, n) Hermitian, not negative: how much a field changes along edges."""
        from surftex.kernels.connection import edge_entries, laplacian_rows

        surface = self.surface
        first, corner, _ = surface.fans
        weight, entry = np.zeros(surface.faces.shape), np.zeros(surface.faces.shape, np.complex128)
        edge_entries(
            surface.neighbor, surface.neighbor_edge, surface.corner_angle, self.edge_turn, self.symmetry,
            1e-9, _LEAST_WEIGHT, _MOST_WEIGHT, weight, entry,
        )  # fmt: skip
        count = len(surface.vertices)
        size = count + entry.size + int((surface.neighbor < 0).sum())
        start, column = np.zeros(count + 1, np.int32), np.zeros(size, np.int32)
        value = np.zeros(size, np.complex128)
        laplacian_rows(surface.faces, surface.neighbor, first, corner, weight, entry, start, column, value)
        result = csr_array((value, column, start), shape=(count, count))
        result.sum_duplicates()
        return result

    def smoothed(self, value: NDArray[np.complex128], pull: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Field that changes little and is pulled towards given directions.

        Parameters
        ----------
        value : (n,) complex128
            Directions wanted.
        pull : (n,) float64
            How strongly, beside edge weights of about 1; 0 leaves a vertex free. Components without any pull
            come back as 0.

        Returns
        -------
        value : (n,) complex128
            Of any length.
        """
        floor = 1e-9 * self.mass / self.surface.area_mm2
        matrix = self.laplacian + diags_array(pull + floor)
        if len(value) > FACTORED_VERTICES:
            return solved_by_steps(matrix, pull * value, np.where(pull > 0, value, 0.0))
        return Factors(matrix).solve(pull * value)

    def lowest(self, start: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Smoothest field on each component.

        Parameters
        ----------
        start : (n,) complex128
            Where several fields are equally smooth, one near to this is found.

        Returns
        -------
        value : (n,) complex128
            Of unit mean square on each component.
        """
        return lowest_mode(self.laplacian, self.mass, self.component, start)
