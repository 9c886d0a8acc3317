"""`VectorField`: a direction and a length everywhere on a surface, such as wrinkles grow along.

From a picture (red and green the direction in the mesh's own UV, blue the length), from an attribute, or from a
`DirectionField` and a length.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError
from surftex.fields.attributes import attribute_values
from surftex.fields.sources import Field, image_field
from surftex.geodesics.directions import DirectionField
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface


@dataclass(frozen=True, eq=False)
class VectorField:
    """Vectors on a surface.

    Attributes
    ----------
    surface : Surface
        m faces.
    at : callable
        ``at(points) -> (n, 2) float64``: millimetres in the frame of each point's face.
    """

    surface: Surface
    at: Callable[[SurfacePoints], NDArray[np.float64]]

    def directions(self, symmetry: int = 1) -> DirectionField:
        """Take the directions alone, smooth and filled where the vectors are 0.

        Parameters
        ----------
        symmetry : int
            1 for arrows, 2 for lines.

        Returns
        -------
        directions : DirectionField
            Through the vectors at the middles of the faces.

        Raises
        ------
        RecipeError
            If every vector is 0.
        """
        count = len(self.surface.faces)
        middle = SurfacePoints.trusted(np.arange(count, dtype=np.int32), np.full((count, 3), 1 / 3))
        vector = self.at(middle)
        size = np.hypot(vector[:, 0], vector[:, 1])
        some = size > 1e-6 * max(float(size.max()), 1e-300)
        if not some.any():
            raise RecipeError("the vectors are 0 everywhere, which is no direction")
        chosen = SurfacePoints.trusted(middle.face[some], middle.barycentric[some])
        angle = np.arctan2(vector[some, 1], vector[some, 0])
        return DirectionField.from_strokes(self.surface, chosen, angle, symmetry)

    @staticmethod
    def along(directions: DirectionField, length_mm: Field | float = 1.0) -> "VectorField":
        """Give a direction field lengths.

        Parameters
        ----------
        directions : DirectionField
            Where to.
        length_mm : Field or float
            How far.

        Returns
        -------
        vectors : VectorField
            As long as asked.
        """

        def at(points: SurfacePoints) -> NDArray[np.float64]:
            angle = directions.at(points)
            size = length_mm(points) if callable(length_mm) else length_mm
            return np.stack([np.cos(angle), np.sin(angle)], axis=1) * np.reshape(size, (-1, 1))

        return VectorField(directions.surface, at)

    @staticmethod
    def from_image(
        surface: Surface, picture: NDArray[np.floating], longest_mm: float, name: str = "image"
    ) -> "VectorField":
        """Read directions and lengths from a picture through the mesh's own UVs.

        Parameters
        ----------
        surface : Surface
            With UVs of its own.
        picture : (h, w, 3 or more) float
            Red and green, 0 to 1, stand for -1 to 1 along u and v; blue, 0 to 1, for the length.
        longest_mm : float
            What blue of 1 means.
        name : str
            What messages call the picture.

        Returns
        -------
        vectors : VectorField
            Of no length where red and green are both one half.

        Raises
        ------
        RecipeError
            If the mesh has no UVs, or the picture has fewer than three channels or values that are not finite.
        """
        pixels = np.asarray(picture, np.float64)
        if pixels.ndim != 3 or pixels.shape[2] < 3:
            raise RecipeError(
                f"{name} has shape {pixels.shape}; vectors take red and green for the direction and blue for the length"
            )
        red, green, blue = (image_field(surface, pixels[..., k], name) for k in range(3))
        to_plane = _plane_of_uv(surface)

        def at(points: SurfacePoints) -> NDArray[np.float64]:
            uv = 2 * np.stack([red(points), green(points)], axis=1) - 1
            uv[np.hypot(uv[:, 0], uv[:, 1]) < 1 / 100] = 0.0
            vector = np.einsum("pij,pj->pi", to_plane[points.face], uv)
            size = np.hypot(vector[:, 0], vector[:, 1])
            unit = np.divide(vector, size[:, None], out=np.zeros_like(vector), where=size[:, None] > 0)
            return unit * (longest_mm * blue(points))[:, None]

        return VectorField(surface, at)

    @staticmethod
    def from_attribute(surface: Surface, name: str, longest_mm: float | None = None) -> "VectorField":
        """Read vectors in space from an attribute, laid onto the surface.

        Parameters
        ----------
        surface : Surface
            With an attribute of three numbers, along the file's axes.
        name : str
            Of the attribute.
        longest_mm : float, optional
            What the longest of them is scaled to; without it they are millimetres.

        Returns
        -------
        vectors : VectorField
            Linear between the corners of a face before they are laid.

        Raises
        ------
        RecipeError
            If there is no such attribute, or it is not three finite numbers, or all are 0.
        """
        values = attribute_values(surface, name)
        if values.ndim != 3 or values.shape[2] != 3:
            count = 1 if values.ndim == 2 else values.shape[2]
            raise RecipeError(f"attribute {name!r} has {count} numbers at a corner; vectors take 3")
        size = float(np.linalg.norm(values, axis=2).max())
        if size == 0:
            raise RecipeError(f"attribute {name!r} is 0 everywhere, which is no direction")
        scaled = values * (1.0 if longest_mm is None else longest_mm / size)

        def at(points: SurfacePoints) -> NDArray[np.float64]:
            vector = np.einsum("pk,pki->pi", points.barycentric, scaled[points.face])
            return np.einsum("pki,pi->pk", surface.frame[points.face, :2], vector)

        return VectorField(surface, at)


def _plane_of_uv(surface: Surface) -> NDArray[np.float64]:
    """(m, 2, 2) what a step in u and v is in the frame of each face; 0 where the unwrap has no area."""
    if surface.corner_uv is None:
        return np.zeros((len(surface.faces), 2, 2))
    uv = np.moveaxis(surface.corner_uv[:, 1:] - surface.corner_uv[:, :1], 1, 2)
    flat = np.moveaxis(surface.flat[:, 1:] - surface.flat[:, :1], 1, 2)
    area = uv[:, 0, 0] * uv[:, 1, 1] - uv[:, 0, 1] * uv[:, 1, 0]
    cofactor = np.stack([uv[:, 1, 1], -uv[:, 0, 1], -uv[:, 1, 0], uv[:, 0, 0]], axis=1).reshape(-1, 2, 2)
    sound = np.abs(area) > 1e-30
    inverse = cofactor / np.where(sound, area, 1.0)[:, None, None] * sound[:, None, None]
    return flat @ inverse
