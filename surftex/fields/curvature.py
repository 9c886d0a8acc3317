"""Curvature as a mask: where a surface bulges (edges that wear) or folds in (creases that gather dirt)."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError
from surftex.fields.sources import SpannedField, corner_field
from surftex.kernels.pool import one_blas_thread
from surftex.surface.surface import Surface


def curvature_field(surface: Surface, kind: Literal["convex", "concave"], radius_mm: float) -> SpannedField:
    """Give 1 where the surface bends as much as a ball, 0 where it is flat or bends the other way.

    The mean curvature is averaged over about `radius_mm` by diffusion before it is compared with 1/radius.

    Parameters
    ----------
    surface : Surface
        Where to measure; borders count as flat across.
    kind : str
        ``"convex"`` or ``"concave"``.
    radius_mm : float
        Of the ball, and of the average.

    Returns
    -------
    field : SpannedField
        0 to 1, linear in the curvature up to 1.

    Raises
    ------
    RecipeError
        If the kind is unknown or the radius not positive.
    """
    if kind not in ("convex", "concave"):
        raise RecipeError(f"curvature = {kind!r}; it takes 'convex' or 'concave'")
    if not 0 < radius_mm < np.inf:
        raise RecipeError(f"a curvature radius of {radius_mm} mm; it takes a length above 0")
    curvature = mean_curvature(surface, radius_mm)
    value = np.clip((curvature if kind == "convex" else -curvature) * radius_mm, 0.0, 1.0)
    return corner_field(value[surface.faces])


def mean_curvature(surface: Surface, radius_mm: float) -> NDArray[np.float64]:
    """Mean curvature at the vertices, averaged over a neighbourhood.

    Parameters
    ----------
    surface : Surface
        n vertices.
    radius_mm : float
        Standard deviation of the average.

    Returns
    -------
    curvature : (n,) float64
        1/mm, positive where the surface bulges outward: 1/r on a ball of radius r.
    """
    return Bending.of(surface).mean_curvature(radius_mm)


@dataclass(frozen=True, eq=False)
class Bending:
    """How a surface bends at its vertices, ready to be averaged; make it with `Bending.of`."""

    stiffness: Any
    area: NDArray[np.float64]
    bend: NDArray[np.float64]

    @staticmethod
    def of(surface: Surface) -> "Bending":
        """Take the cotangent Laplacian of the places.

        Parameters
        ----------
        surface : Surface
            n vertices.

        Returns
        -------
        bending : Bending
            Borders and vertices of no face bend nowhere.
        """
        from scipy.sparse import coo_array, diags_array

        count = len(surface.vertices)
        cotangent = 1 / np.tan(np.clip(surface.corner_angle, 1e-3, np.pi - 1e-3))
        weight = 0.5 * np.maximum(np.roll(cotangent, 1, axis=1), 0).ravel()  # edge i lies opposite corner i+2
        start, end = surface.faces.ravel(), np.roll(surface.faces, -1, axis=1).ravel()
        link = coo_array(
            (np.concatenate([weight, weight]), (np.r_[start, end], np.r_[end, start])), (count, count)
        ).tocsr()
        stiffness = diags_array(link.sum(axis=1)) - link
        area = np.bincount(surface.faces.ravel(), np.repeat(surface.face_area_mm2 / 3, 3), minlength=count)
        bend = 0.5 * np.einsum("vi,vi->v", stiffness @ surface.vertices, surface.vertex_normal)
        bend[surface.on_border | (area == 0)] = 0.0
        area[area == 0] = 1.0  # vertices of no face: they bend nowhere
        return Bending(stiffness, area.astype(np.float64), bend)

    def mean_curvature(self, radius_mm: float, *, tolerance: float = 1e-6) -> NDArray[np.float64]:
        """Average by diffusion, as `mean_curvature`.

        Parameters
        ----------
        radius_mm : float
            Standard deviation of the average.
        tolerance : float
            Residual that is left, as a share.

        Returns
        -------
        curvature : (n,) float64
            1/mm.
        """
        from scipy.sparse import diags_array
        from scipy.sparse.linalg import cg

        diffusion = (diags_array(self.area) + 0.5 * radius_mm**2 * self.stiffness).tocsr()
        inverse = diags_array(1 / diffusion.diagonal())
        with one_blas_thread():
            return cg(diffusion, self.bend, rtol=tolerance, atol=0.0, maxiter=2000, M=inverse)[0]
