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
    jacobian = atlas.jacobian_mm(surface, width, height)
    flip = np.where(np.linalg.det(jacobian) < 0, -1.0, 1.0)
    cosine = jacobian[:, 0, 0] + jacobian[:, 1, 1] * flip
    sine = jacobian[:, 1, 0] - jacobian[:, 0, 1] * flip
    length = np.hypot(cosine, sine)
    turned = length > 0
    cosine = np.divide(cosine, length, out=np.ones_like(length), where=turned)
    sine = np.divide(sine, length, out=np.zeros_like(length), where=turned)
    axes = np.stack([cosine, -sine * flip, sine, cosine * flip], axis=1).reshape(-1, 2, 2)
    stretch = axes.transpose(0, 2, 1) @ jacobian
    return PageMetric(
        stretch=frozen(np.stack([stretch[:, 0, 0], stretch[:, 0, 1], stretch[:, 1, 1]], axis=1)),
        axes=frozen(axes),
        weight=frozen(_weights(atlas.corner_px(width, height))),
    )


def _weights(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    """Barycentric coordinates as affine functions of column and row; thirds where a face has no area."""
    onward, far = np.roll(corner, -1, axis=1), np.roll(corner, -2, axis=1)
    weight = np.stack(
        [
            onward[..., 0] * far[..., 1] - onward[..., 1] * far[..., 0],
            onward[..., 1] - far[..., 1],
            far[..., 0] - onward[..., 0],
        ],
        axis=2,
    )
    doubled = weight[:, :, 0].sum(axis=1)[:, None, None]
    middle = np.broadcast_to([1 / 3, 0.0, 0.0], weight.shape).copy()
    return np.divide(weight, doubled, out=middle, where=np.abs(doubled) > 1e-12)


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
    first, last = texels.rows
    index = np.full((last - first) * texels.width, -1, np.int32)
    index[texels.texel - first * texels.width] = np.where(without, -1, np.arange(len(texels), dtype=np.int32))
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
