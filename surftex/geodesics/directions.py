"""`DirectionField`: a direction everywhere on a surface, with 1, 2 or 4 equal arms.

* `smoothest`: turns as little as possible and has the fewest singular places; the default.
* `from_axis`: follows an axis in space; filled smoothly where the axis leaves the surface.
* `from_strokes`: passes smoothly through given directions.
* `from_curvature`: along or across the bend of the surface; filled smoothly where it bends alike all round.
* `constant`: one direction in the xy plane, for flat sheets.

Every component of the surface has its own solution, and every face and point has a finite angle.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, frozen
from surftex.errors import SurfaceError
from surftex.geodesics.connection import Connection
from surftex.geodesics.tracing import per_point
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

_TILTED_AXIS = np.array([0.3, 0.1, 1.0])
"""Where fields are equally smooth, the one nearest to this axis is taken: mostly z, and along no symmetry."""


@dataclass(frozen=True, eq=False)
class DirectionField:
    """A direction in each face, and smoothly between.

    Attributes
    ----------
    surface : Surface
        m faces, n vertices.
    symmetry : int
        1 for arrows, 2 for lines, 4 for crosses: turned by 2 pi / symmetry, a direction is the same.
    vertex_value : (n,) complex128
        Unit numbers: `symmetry` times the angle in the vertex' tangent space, see `Connection`.
    """

    surface: Surface
    symmetry: int
    vertex_value: NDArray[np.complex128]

    @cached_property
    def connection(self) -> Connection:
        """The tangent spaces that `vertex_value` lives in."""
        return Connection(self.surface, self.symmetry)

    @cached_property
    def angle_rad(self) -> NDArray[np.float64]:
        """(m,) one arm's angle at the middle of each face, in the frame of the face."""
        every = np.arange(len(self.surface.faces), dtype=np.int32)
        return frozen(self.at(SurfacePoints.trusted(every, np.full((len(every), 3), 1 / 3))))

    @cached_property
    def strength(self) -> NDArray[np.float64]:
        """(m,) 1, or 0 in the faces that hold a singularity."""
        return frozen(np.where(self.index == 0, 1.0, 0.0))

    @cached_property
    def index(self) -> NDArray[np.int64]:
        """(m,) turns around each face in steps of 1 / symmetry: not 0 at singularities."""
        return frozen(self.connection.index(self.vertex_value))

    def at(self, points: SurfacePoints) -> NDArray[np.float64]:
        """Angles at points; they change smoothly inside faces and across edges, except at singularities.

        Parameters
        ----------
        points : SurfacePoints
            k points.

        Returns
        -------
        angle_rad : (k,) float64
            One arm's angle in the frame of the point's face; all arms are ``2 pi / symmetry`` apart.
        """
        points.check_on(self.surface)
        return np.angle(self.connection.interpolated(self.vertex_value, points)) / self.symmetry

    def turned(self, by_rad: float) -> "DirectionField":
        """Turn all directions, counter-clockwise seen from outside.

        Parameters
        ----------
        by_rad : float
            The angle.

        Returns
        -------
        field : DirectionField
            Turned.
        """
        turn = np.exp(1j * self.symmetry * by_rad)
        return DirectionField(self.surface, self.symmetry, frozen(self.vertex_value * turn))

    @staticmethod
    def smoothest(surface: Surface, symmetry: int = 1) -> "DirectionField":
        """Field that turns least, with the fewest singularities [1]_.

        Parameters
        ----------
        surface : Surface
            Any.
        symmetry : int
            1, 2 or 4.

        Returns
        -------
        field : DirectionField
            Where several are equally smooth, one near the z axis.

        Raises
        ------
        SurfaceError
            If the symmetry is another.

        References
        ----------
        .. [1] Knöppel, Crane, Pinkall, Schröder. Globally Optimal Direction Fields. SIGGRAPH (2013).
        """
        connection = _connection(surface, symmetry)
        return _field(connection, _smoothest(connection))

    @staticmethod
    def from_axis(surface: Surface, axis: ArrayLike, symmetry: int = 1) -> "DirectionField":
        """Field along an axis in space, laid onto the surface.

        Parameters
        ----------
        surface : Surface
            Any.
        axis : (3,) float
            Of any length but 0.
        symmetry : int
            1, 2 or 4.

        Returns
        -------
        field : DirectionField
            Follows the axis, smoothed over about an edge's length, the more freely the steeper the axis
            stands on the surface.

        Raises
        ------
        SurfaceError
            If the axis has no length or the symmetry is none of these.
        """
        connection = _connection(surface, symmetry)
        vector = checked(axis, "axis", (3,), np.float64, error=SurfaceError)
        length = np.linalg.norm(vector)
        if not 0 < length < np.inf:
            raise SurfaceError(
                "axis has no length, or one beyond all numbers; give a direction such as [0, 0, 1]"
            )
        return _pulled(connection, *_laid(surface, vector / length, symmetry))

    @staticmethod
    def from_strokes(
        surface: Surface, points: SurfacePoints, angle_rad: ArrayLike, symmetry: int = 1
    ) -> "DirectionField":
        """Field through given directions, as smooth as can be between them.

        Parameters
        ----------
        surface : Surface
            Any.
        points : SurfacePoints
            k places, at least 1: such as the pieces of painted strokes.
        angle_rad : float or (k,) float
            Directions there, in the frames of the points' faces.
        symmetry : int
            1, 2 or 4.

        Returns
        -------
        field : DirectionField
            Components without any stroke have their smoothest field.

        Raises
        ------
        SurfaceError
            If there is no stroke, one lies on no face, or an angle is not finite.
        """
        connection = _connection(surface, symmetry)
        points.check_on(surface)
        if len(points) == 0:
            raise SurfaceError("no strokes were given; draw one, or take DirectionField.smoothest")
        wanted = np.exp(1j * symmetry * per_point(angle_rad, "angle_rad", len(points)))
        turn = np.exp(-1j * symmetry * connection.corner_turn(points.face, connection.away(points)))
        weight = np.maximum(points.barycentric, 0.0)
        index, count = surface.faces[points.face].ravel(), len(surface.vertices)
        there: NDArray[np.complex128] = (weight * turn * wanted[:, None]).ravel()
        total = np.bincount(index, there.real, count) + 1j * np.bincount(index, there.imag, count)
        pull = np.bincount(index, weight.ravel(), count).astype(np.float64)
        value = connection.smoothed(total / np.maximum(pull, np.finfo(float).tiny), 1e4 * pull)
        return _field(connection, _filled(connection, value))

    @staticmethod
    def from_curvature(
        surface: Surface, which: Literal["max", "min"] = "max", symmetry: int = 2
    ) -> "DirectionField":
        """Field along the direction in which the surface bends most, or least.

        Parameters
        ----------
        surface : Surface
            Any; bends are measured by the change of the vertex normals over each face [1]_.
        which : {"max", "min"}
            Most or least, inward and outward alike: around a tube or along it.
        symmetry : int
            2, or 4 for both.

        Returns
        -------
        field : DirectionField
            Filled smoothly where the surface is flat, round, or a saddle that bends alike both ways.

        Raises
        ------
        SurfaceError
            If `which` or `symmetry` is none of these.

        References
        ----------
        .. [1] Rusinkiewicz. Estimating Curvatures and Their Derivatives on Triangle Meshes. 3DPVT (2004).
        """
        if which not in ("max", "min"):
            raise SurfaceError(f"which is {which!r}; it takes 'max' or 'min'")
        if symmetry not in (2, 4):
            raise SurfaceError(f"symmetry is {symmetry!r}; bends have no sign: it takes 2 or 4")
        bend, certainty = _bend(surface)
        wanted = (bend if which == "max" else -bend) ** (symmetry // 2)
        return _pulled(_connection(surface, symmetry), wanted, certainty)

    @staticmethod
    def constant(surface: Surface, angle_rad: float = 0.0, symmetry: int = 1) -> "DirectionField":
        """One direction in the xy plane, for flat sheets.

        Parameters
        ----------
        surface : Surface
            A flat sheet, or nearly so.
        angle_rad : float
            From the x axis towards the y axis.
        symmetry : int
            1, 2 or 4.

        Returns
        -------
        field : DirectionField
            As `from_axis` with that direction.
        """
        return DirectionField.from_axis(surface, [np.cos(angle_rad), np.sin(angle_rad), 0.0], symmetry)


def _connection(surface: Surface, symmetry: int) -> Connection:
    """Tangent spaces for a symmetry that exists."""
    if symmetry not in (1, 2, 4):
        raise SurfaceError(f"symmetry is {symmetry!r}; it takes 1 (arrows), 2 (lines) or 4 (crosses)")
    return Connection(surface, int(symmetry))


def _field(connection: Connection, value: NDArray[np.complex128]) -> DirectionField:
    """Make a field of unit numbers, 1 where there is no direction."""
    length = np.abs(value)
    unit = np.where(length > 1e-300, value / np.maximum(length, 1e-300), 1.0)
    return DirectionField(connection.surface, connection.symmetry, frozen(unit))


def _laid(
    surface: Surface, axis: NDArray[np.float64], symmetry: int
) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
    """Direction of an axis laid onto each face, and the square of the share of it that lies in the face."""
    along = surface.frame[:, 0] @ axis + 1j * (surface.frame[:, 1] @ axis)
    length = np.abs(along)
    unit = np.where(length > 1e-9, 1 / np.maximum(length, 1e-9), 0.0) * along
    for _ in range(symmetry // 2):  # 1, 2 or 4
        unit = unit * unit
    return unit, length**2


def _smoothest(connection: Connection) -> NDArray[np.complex128]:
    """Lowest mode of every component, from a start that is along no symmetry."""
    axis = _TILTED_AXIS / np.linalg.norm(_TILTED_AXIS)
    wanted, share = _laid(connection.surface, axis, connection.symmetry)
    start = connection.gathered(wanted * share)
    index = np.arange(len(start))
    return connection.lowest(start + 1e-3 * np.exp(2j * np.pi * 0.6180339887498949 * index))


def _pulled(
    connection: Connection, wanted: NDArray[np.complex128], certainty: NDArray[np.float64]
) -> DirectionField:
    """Smooth field pulled to directions in faces, as far as they are certain."""
    total = connection.gathered(wanted * certainty)
    pull = np.abs(total)
    unit = total / np.maximum(pull, np.finfo(float).tiny)
    pull[pull < 1e-6] = 0.0
    value = connection.smoothed(unit, 10.0 * pull**2)
    return _field(connection, _filled(connection, value))


def _filled(connection: Connection, value: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Put the smoothest field on components that nothing pulled."""
    most = np.zeros(connection.component.max() + 1)
    np.maximum.at(most, connection.component, np.abs(value))
    free = (most < 1e-12)[connection.component]
    return np.where(free, _smoothest(connection), value) if free.any() else value


def _bend(surface: Surface) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
    """Twice the angle of the most bent direction of each face as a unit number, and how certain it is."""
    normal = surface.vertex_normal[surface.faces]
    flat_normal = np.einsum("fki,fji->fkj", normal, surface.frame[:, :2])
    along = np.roll(surface.flat, -1, axis=1) - surface.flat
    change = np.roll(flat_normal, -1, axis=1) - flat_normal
    rows = np.zeros((len(surface.faces), 3, 2, 3))
    rows[:, :, 0, 0], rows[:, :, 0, 1] = along[..., 0], along[..., 1]
    rows[:, :, 1, 1], rows[:, :, 1, 2] = along[..., 0], along[..., 1]
    rows = rows.reshape(-1, 6, 3)
    square = np.einsum("fri,frj->fij", rows, rows)
    square += 1e-9 * np.trace(square, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    right = np.einsum("fri,fr->fi", rows, change.reshape(-1, 6))
    xx, xy, yy = np.linalg.solve(square, right[..., None])[..., 0].T
    mean, uneven = 0.5 * (xx + yy), 0.5 * (xx - yy) + 1j * xy
    squared = mean * uneven
    size = np.abs(squared)
    floor = 4e-4 / surface.area_mm2
    unit = np.where(size > 0, squared / np.maximum(size, np.finfo(float).tiny), 0.0)
    return unit, size / (mean**2 + np.abs(uneven) ** 2 + floor)
