"""Tangent spaces at vertices, how directions are carried between them, and the equations of smooth fields.

Around an inner vertex the angles are stretched to a full turn. A direction with `symmetry` equal arms is one
complex number, its angle times `symmetry`. Carried from a vertex straight to a point of a face, it depends on
the way the line leaves the vertex, so that a field interpolated from the corners is continuous across edges.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, diags_array

from surftex.geodesics.factors import Factors, solved_by_steps
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

FACTORED_VERTICES = 400_000
"""Vertices up to which the equations of a field are factored; beyond it factors take 4 kB a vertex and more."""

_LEAST_WEIGHT, _MOST_WEIGHT = 1e-2, 1e2
"""Bounds of an edge's weight: 0.58 between equilateral triangles, negative or huge between slivers."""

_KRYLOV = 20
"""Fields kept beside one another while the smoothest is sought."""

_SETTLED = 1e-6
"""Share of itself by which one more step would change the smoothest field."""


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
        every = np.arange(len(self.surface.faces), dtype=np.int32)
        weight = self.surface.corner_angle
        there = weight * value[:, None] * np.exp(-1j * self.symmetry * self.corner_turn(every))
        index, count = self.surface.faces.ravel(), len(self.surface.vertices)
        total = np.bincount(index, there.real.ravel(), count) + 1j * np.bincount(
            index, there.imag.ravel(), count
        )
        return total / np.maximum(np.bincount(index, weight.ravel(), count), np.finfo(float).tiny)

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
    def laplacian(self) -> csc_array:
        """(n, n) Hermitian, not negative: how much a field changes along edges."""
        angle = np.roll(self.surface.corner_angle, -2, axis=1)
        half = 0.5 / np.tan(np.clip(angle, 1e-9, np.pi - 1e-9))
        glued = self.surface.neighbor >= 0
        other = half[np.maximum(self.surface.neighbor, 0), self.surface.neighbor_edge]
        weight = np.clip(half + np.where(glued, other, 0.0), _LEAST_WEIGHT, _MOST_WEIGHT)
        weight = (weight * np.where(glued, 0.5, 1.0)).ravel()
        start, end = self.surface.faces.ravel(), np.roll(self.surface.faces, -1, axis=1).ravel()
        carried = -weight * np.exp(1j * self.symmetry * self.edge_turn.ravel())
        count = len(self.surface.vertices)
        diagonal = np.bincount(start, weight, count) + np.bincount(end, weight, count)
        rows, columns = np.concatenate([end, start]), np.concatenate([start, end])
        entries = np.concatenate([carried, carried.conj()])
        off = coo_array((entries, (rows, columns)), shape=(count, count))
        return csc_array(off + diags_array(np.where(diagonal > 0, diagonal, 1.0)))

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

    def lowest(self, start: NDArray[np.complex128], *, most: int = 60) -> NDArray[np.complex128]:
        """Smoothest field on each component, by inverse iteration in Krylov spaces (Lanczos [1]_).

        Parameters
        ----------
        start : (n,) complex128
            Where several fields are equally smooth, the nearest to this one is found.
        most : int
            Solves at most.

        Returns
        -------
        value : (n,) complex128
            Of unit mean square on each component.

        References
        ----------
        .. [1] Lanczos. An Iteration Method for the Solution of the Eigenvalue Problem. J. Res. NBS 45 (1950).
        """
        mass = np.where(self.mass > 0, self.mass, 1.0)
        area = np.bincount(self.component, mass)
        solver = Factors(self.laplacian + diags_array(1e-6 * mass / area[self.component]))
        share = mass / area[self.component]
        value, moving = self._scaled(start, share), True
        while moving and most > 0:
            value, moving = self._ritz(solver, mass, share, value, min(most, _KRYLOV))
            most -= _KRYLOV
        return value

    def _ritz(
        self, solver: Factors, mass: NDArray[np.float64], share: NDArray[np.float64],
        start: NDArray[np.complex128], steps: int,
    ) -> tuple[NDArray[np.complex128], bool]:  # fmt: skip
        """Field of the Krylov space of `start` that changes least, and whether more steps would better it.

        Components do not mix: each has its own space, which no longer grows once its field stands.
        """
        count = len(np.bincount(self.component))
        basis, before = [start], np.zeros(count)
        band = np.zeros((count, steps, steps))
        moving, lead = np.ones(count, bool), np.ones((count, 1))
        for step in range(steps):
            here = basis[-1]
            onward = solver.solve(mass * here)
            level = self._sums(share * (here.conj() * onward).real)
            onward -= level[self.component] * here
            if step:
                onward -= before[self.component] * basis[-2]
            band[:, step, step] = level
            numbers, vectors = np.linalg.eigh(band[:, : step + 1, : step + 1])
            lead = np.where(vectors[:, :1, -1] < 0, -1.0, 1.0) * vectors[:, :, -1]
            before = np.sqrt(self._sums(share * np.abs(onward) ** 2))
            moving &= before * np.abs(lead[:, -1]) > _SETTLED * numbers[:, -1]
            if step + 1 == steps or not moving.any():
                break
            before = np.where(moving, before, 0.0)
            band[:, step, step + 1] = band[:, step + 1, step] = before
            basis.append(
                onward * np.where(moving, 1 / np.where(before > 0, before, 1.0), 0.0)[self.component]
            )
        value = np.zeros_like(start)
        for column, vector in zip(lead.T, basis, strict=True):
            value += column[self.component] * vector
        return self._scaled(value, share), bool(moving.any())

    def _sums(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sum over the vertices of each component."""
        return np.bincount(self.component, value).astype(np.float64, copy=False)

    def _scaled(self, value: NDArray[np.complex128], share: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Scale to a unit mean square on each component; `share` of each vertex in its area."""
        square = self._sums(share * np.abs(value) ** 2)
        return value / np.sqrt(np.maximum(square, np.finfo(float).tiny))[self.component]
