"""Where a picture is taken from: named views, framing around what is seen, and the way from space to pixels."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.errors import RecipeError

VIEWS = {
    "front": (0.0, 5.0),
    "back": (180.0, 5.0),
    "left": (-90.0, 5.0),
    "right": (90.0, 5.0),
    "top": (0.0, 89.0),
    "bottom": (0.0, -89.0),
    "three-quarter": (38.0, 22.0),
    "three-quarter-left": (-38.0, 22.0),
    "three-quarter-back": (142.0, 22.0),
}
"""Azimuth from the front and elevation, degrees."""

UPS = {"x": np.array([1.0, 0, 0]), "y": np.array([0, 1.0, 0]), "z": np.array([0, 0, 1.0])}
_FRONTS = {"x": np.array([0, 0, 1.0]), "y": np.array([0, 0, 1.0]), "z": np.array([0, -1.0, 0])}


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole.

    Attributes
    ----------
    place : (3,) float64
        Millimetres.
    axes : (3, 3) float64
        Right, up and backward, as rows.
    focal_px : float
        Pixels for a tangent of 1.
    middle : (2,) float64
        Column and row of the axis.
    """

    place: NDArray[np.float64]
    axes: NDArray[np.float64]
    focal_px: float
    middle: NDArray[np.float64]

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Put points on the picture.

        Parameters
        ----------
        points : (..., 3) float
            Millimetres, in front of the camera.

        Returns
        -------
        pixels : (..., 3) float64
            Column, row, and 1 / depth.
        """
        seen = (points - self.place) @ self.axes.T
        near = -1 / seen[..., 2]
        column = self.middle[0] + self.focal_px * seen[..., 0] * near
        return np.stack([column, self.middle[1] - self.focal_px * seen[..., 1] * near, near], axis=-1)

    def rays(self, column: NDArray[np.float64], row: NDArray[np.float64]) -> NDArray[np.float64]:
        """Directions through pixels.

        Parameters
        ----------
        column : (n,) float
            Of the pixels.
        row : (n,) float
            Of the pixels.

        Returns
        -------
        direction : (n, 3) float64
            One unit along the camera's axis.
        """
        x, y = (column - self.middle[0]) / self.focal_px, (self.middle[1] - row) / self.focal_px
        return x[:, None] * self.axes[0] + y[:, None] * self.axes[1] - self.axes[2]


def camera_for(
    points: NDArray[np.float64],
    size: tuple[int, int],
    *,
    view: str | tuple[float, float] = "three-quarter",
    zoom: float = 1.0,
    target: ArrayLike | None = None,
    up: str = "y",
) -> Camera:
    """Frame points.

    Parameters
    ----------
    points : (n, 3) float
        What should be in the picture.
    size : (2,) int
        Width and height in pixels.
    view : str or (2,) float
        Name in `VIEWS`, or azimuth from the front and elevation in degrees.
    zoom : float
        1 shows everything, 10 a tenth of it.
    target : (3,) float, optional
        Place in millimetres to have in the middle.
    up : str
        Axis that points up: x, y or z.

    Returns
    -------
    camera : Camera
        Far enough not to distort.

    Raises
    ------
    RecipeError
        If the view, the axis or the zoom are none.
    """
    if up not in UPS:
        raise RecipeError(f"up is {up!r}; it takes x, y or z")
    if isinstance(view, str) and view not in VIEWS:
        raise RecipeError(f"no view {view!r}; known are {', '.join(VIEWS)}, or azimuth and elevation")
    if not 0 < zoom < 1e6:
        raise RecipeError(f"zoom is {zoom}; it takes a number above 0, where 1 shows everything")
    degrees = VIEWS[view] if isinstance(view, str) else view
    if not (np.isfinite(degrees[0]) and -90 <= degrees[1] <= 90):
        raise RecipeError(
            f"view is {degrees[0]:g},{degrees[1]:g}; elevation takes -90 to 90 degrees, azimuth any"
        )
    azimuth, elevation = np.radians(degrees)
    upward, front = UPS[up], _FRONTS[up]
    side = np.cross(upward, front)
    away = np.cos(elevation) * (np.cos(azimuth) * front + np.sin(azimuth) * side) + np.sin(elevation) * upward
    right = np.cross(upward, away)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(away, right), away])
    low, high = points.min(axis=0), points.max(axis=0)
    middle = 0.5 * (low + high)
    radius = max(0.5 * float(np.linalg.norm(high - low)), 1e-6)
    camera = Camera(middle + 5 * radius * away, axes, 1.0, np.zeros(2))
    seen = camera.project(points)[:, :2]
    width, height = size
    span = np.maximum(np.ptp(seen, axis=0), 1e-9)
    focal = 0.84 * zoom * min(width / span[0], height / span[1])
    if target is None:
        centre = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
    else:
        goal = np.asarray(target, float)
        if goal.shape != (3,) or not np.isfinite(goal).all():
            raise RecipeError(f"target is {target!r}; it takes three numbers, millimetres")
        centre = camera.project(goal)[:2]
    return Camera(camera.place, axes, focal, np.array([width, height]) / 2 - focal * centre)
