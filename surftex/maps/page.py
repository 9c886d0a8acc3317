"""What a step across the page is on the surface: each face's 2x2 map from texels to millimetres, taken apart.

The map of face f is ``axes[f] @ stretch[f]``: a symmetric stretch along the page's own axes, then a rotation
into the frame of the face. Stretches of neighbouring faces can be averaged, rotations need not be.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import frozen
from surftex.charts.atlas import Atlas
from surftex.charts.texels import Texels
from surftex.surface.surface import Surface

_ON_BORDER = 1e-9
"""Weight of a corner below which a place lies on the edge across from it, after a walk along a border."""


@dataclass(frozen=True, eq=False)
class PageMetric:
    """The page seen from the surface, per face.

    Attributes
    ----------
    stretch : (m, 3) float64
        Entries xx, xy, yy of the symmetric stretch, mm per texel; x right, y up.
    axes : (m, 2, 2) float64
        Orthogonal: page directions to directions in the frame of the face. A reflection where UV are
        mirrored.
    weight : (m, 3, 3) float64
        Barycentric coordinates of a place on the page: row i is (constant, per column, per row).
    """

    stretch: NDArray[np.float64]
    axes: NDArray[np.float64]
    weight: NDArray[np.float64]


def page_metric(surface: Surface, atlas: Atlas, width: int, height: int | None = None) -> PageMetric:
    """Take apart the map from texels to millimetres of every face.

    Parameters
    ----------
    surface : Surface
        m faces.
    atlas : Atlas
        Its unwrap.
    width : int
        Columns of the page.
    height : int, optional
        Rows; as `width` without it.

    Returns
    -------
    metric : PageMetric
        Without stretch for faces that have no area on the page: no texel is theirs.
    """
    from surftex.kernels.page import take_apart

    count = len(atlas.corner_uv)
    stretch, axes, weight = np.zeros((count, 3)), np.zeros((count, 2, 2)), np.zeros((count, 3, 3))
    steps, corner = atlas.jacobian_mm(surface, width, height), atlas.corner_px(width, height)
    take_apart(steps, corner, stretch, axes, weight)
    return PageMetric(stretch=frozen(stretch), axes=frozen(axes), weight=frozen(weight))


def stopped(surface: Surface, texels: Texels) -> NDArray[np.bool_]:
    """Tell the gutter texels at borders of the mesh, where the surface does not go on.

    Parameters
    ----------
    surface : Surface
        What is baked.
    texels : Texels
        t mapped texels.

    Returns
    -------
    stopped : (t,) bool
        They show a place on the border, and no step to them is as long as the page says.
    """
    result = np.zeros(len(texels), bool)
    if not surface.on_border.any():
        return result
    gutter = np.flatnonzero(~texels.core)
    border = np.roll(surface.neighbor < 0, -1, axis=1)[texels.points.face[gutter]]
    result[gutter] = (border & (texels.points.barycentric[gutter] < _ON_BORDER)).any(axis=1)
    return result


def texel_index(texels: Texels, without: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Look up mapped texels by their place on the rows asked for.

    Parameters
    ----------
    texels : Texels
        t mapped texels.
    without : (t,) bool
        Texels to leave out.

    Returns
    -------
    index : (rows * width,) int32
        -1 where none is mapped. Read-only.
    """
    from surftex.kernels.rows import index_rows

    first, last = texels.rows
    index = np.full((last - first) * texels.width, -1, np.int32)
    index_rows(read_only(texels.texel), first * texels.width, read_only(without), index)
    return read_only(index)


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Look at an array without leave to write, so that kernels compile for one type only.

    Parameters
    ----------
    array : ndarray
        Stays as it is.

    Returns
    -------
    view : ndarray
        C-contiguous; shares memory where it can.
    """
    view = np.ascontiguousarray(array).view()
    view.flags.writeable = False
    return view
