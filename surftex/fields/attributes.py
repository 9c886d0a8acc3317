"""Numbers that the mesh itself carries, and what its shape alone says: attributes, labels, slope, occlusion."""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.errors import RecipeError
from surftex.fields.sources import SpannedField, corner_field
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

Channel = Literal["luminance", "red", "green", "blue", "alpha", "x", "y", "z"]
"""One of several numbers: of a colour, or of a vector."""

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def attribute_values(surface: Surface, name: str) -> NDArray[np.float64]:
    """Look up an attribute.

    Parameters
    ----------
    surface : Surface
        m faces.
    name : str
        One of ``surface.attributes``.

    Returns
    -------
    values : (m, 3) or (m, 3, k) float64
        At the corners of the faces.

    Raises
    ------
    RecipeError
        If there is none of that name, or a number is not finite.
    """
    if name not in surface.attributes:
        from difflib import get_close_matches

        near = get_close_matches(name, list(surface.attributes), 1)
        known = ", ".join(map(repr, sorted(surface.attributes)))
        hint = f"did you mean {near[0]!r}?" if near else f"it has {known}" if known else "it has none"
        raise RecipeError(f"the mesh has no attribute {name!r}; {hint}")
    values = surface.attributes[name]
    wrong = ~np.isfinite(values).reshape(len(values), -1).all(axis=1)
    if wrong.any():
        raise RecipeError(
            f"attribute {name!r} is not finite on {int(wrong.sum())} of {len(values)} faces; the first is face "
            f"{int(np.argmax(wrong))}"
        )
    return values


def attribute_field(
    surface: Surface, name: str, channel: Channel = "luminance", label: int | None = None
) -> SpannedField:
    """Read an attribute, linearly inside faces.

    Parameters
    ----------
    surface : Surface
        With attributes of vertices, faces or corners.
    name : str
        One of them.
    channel : str
        Which number, where the attribute has several; a single number is taken whatever this says.
    label : int, optional
        Give 1 where the attribute is this whole number, and 0 elsewhere; inside a face the nearest corner's counts.

    Returns
    -------
    field : SpannedField
        The attribute's numbers.

    Raises
    ------
    RecipeError
        If there is no such attribute or channel, or it is not finite.
    """
    values = attribute_values(surface, name)
    if values.ndim == 3:
        values = _channel(values, name, channel)
    if label is None:
        return corner_field(values)
    alike = (np.rint(values) == label).astype(np.float64)
    if not alike.any():
        known = np.unique(np.rint(values))
        shown = ", ".join(f"{each:.0f}" for each in known[:12]) + (", ..." if len(known) > 12 else "")
        raise RecipeError(f"attribute {name!r} is {label} nowhere; it holds {shown}")

    def nearest(points: SurfacePoints, footprint_mm: NDArray | float = 0.0) -> NDArray[np.float64]:
        return alike[points.face, np.argmax(points.barycentric, axis=1)]

    return SpannedField(nearest, lambda: (alike.min(axis=1), alike.max(axis=1)))


def slope_field(surface: Surface, axis: ArrayLike) -> SpannedField:
    """Tell how much the surface faces a direction.

    Parameters
    ----------
    surface : Surface
        Its smooth normals count.
    axis : (3,) float
        Direction in the file's axes; any length but 0.

    Returns
    -------
    field : SpannedField
        1 where the surface faces along the axis, 0 where it stands at right angles, -1 where it faces away: the
        cosine.

    Raises
    ------
    RecipeError
        If the axis has no length.
    """
    along = np.asarray(axis, np.float64)
    length = float(np.linalg.norm(along))
    if along.shape != (3,) or not 0 < length < np.inf:
        raise RecipeError(f"slope = {axis} is no direction; write three numbers such as [0, 0, 1]")
    return corner_field((surface.vertex_normal @ (along / length))[surface.faces])


def occlusion_field(surface: Surface, reach_mm: float) -> SpannedField:
    """Tell how closed in by the surface itself each place is.

    Parameters
    ----------
    surface : Surface
        Measured at its vertices.
    reach_mm : float
        What is farther off does not count.

    Returns
    -------
    field : SpannedField
        0 in the open, towards 1 in folds and holes.
    """
    from surftex.surface.occlusion import vertex_occlusion

    return corner_field(vertex_occlusion(surface, reach_mm)[surface.faces])


def _channel(values: NDArray[np.float64], name: str, channel: str) -> NDArray[np.float64]:
    count = values.shape[2]
    if channel == "luminance":
        return values[..., :3] @ _LUMINANCE if count >= 3 else values[..., 0]
    index = {"red": 0, "x": 0, "green": 1, "y": 1, "blue": 2, "z": 2, "alpha": 3}[channel]
    if index >= count:
        raise RecipeError(f"attribute {name!r} has {count} numbers and no {channel}")
    return values[..., index]
