"""Normal maps from height: slopes are taken along the surface, and told in the frames that shaders use.

The slope comes from the steps between texels, measured in millimetres of surface, so that neither stretch nor
rotation of the unwrap changes a normal. A normal is the shading normal less the slope; on a faceted mesh the
slope is tilted with the shading normal, so that facets do not show in the relief. The map holds components along
the interpolated MikkTSpace tangent, bitangent and normal of the face that the texel lies in, or whose chart it
continues: +y is up (OpenGL). Where the height is flat it holds exactly (0, 0, 1), in charts and gutter, so that no
side of a hard edge takes on the other's normal.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked, frozen, read_only_view
from surftex.charts.atlas import Atlas
from surftex.charts.fill import nearest_mapped
from surftex.charts.texels import Texels
from surftex.kernels.pool import slices
from surftex.maps.page import PageMetric, page_metric, read_only, stopped, texel_index
from surftex.maps.tangents import corner_tangents
from surftex.surface.surface import Surface

_SLICE = 1 << 17


def surface_tangents(surface: Surface, atlas: Atlas) -> NDArray[np.float64]:
    """MikkTSpace tangents of a surface under an unwrap: those that the exported mesh carries.

    Parameters
    ----------
    surface : Surface
        m faces, with their shading normals.
    atlas : Atlas
        Its unwrap.

    Returns
    -------
    tangent : (m, 3, 4) float64
        Read-only; see `surftex.maps.tangents.corner_tangents`.
    """
    return frozen(corner_tangents(surface.vertices[surface.faces], surface.shading_normal, atlas.corner_uv))


def height_gradient(
    surface: Surface, atlas: Atlas, texels: Texels, height_mm: ArrayLike, *, threads: int | None = None
) -> NDArray[np.float32]:
    """Slope of the height along the surface, at every texel.

    Parameters
    ----------
    surface : Surface
        m faces.
    atlas : Atlas
        Its unwrap.
    texels : Texels
        t mapped texels.
    height_mm : (t,) float
        Height above the surface at each.
    threads : int, optional
        None means every core; it cannot change a byte.

    Returns
    -------
    gradient : (t, 2) float32
        mm per mm, in the frame of the face that each texel lies in, or whose chart it continues. Not to be
        trusted beyond a border of the mesh.
    """
    index = texel_index(texels, stopped(surface, texels))
    metric = page_metric(surface, atlas, texels.width, texels.height)
    return _gradient(atlas, texels, height_mm, index, metric, threads)


def _gradient(
    atlas: Atlas,
    texels: Texels,
    height_mm: ArrayLike,
    index: NDArray[np.int32],
    metric: PageMetric,
    threads: int | None,
) -> NDArray[np.float32]:
    """As `height_gradient`, by the texels of an index."""
    from surftex.kernels.normals import gradients

    count = len(texels)
    height = read_only(checked(height_mm, "height_mm", (count,), np.float32))
    texel = read_only(texels.texel - texels.rows[0] * texels.width)
    host, chart = read_only(texels.host), read_only(atlas.chart)
    gradient = np.zeros((count, 2), np.float32)

    def work(first: int, last: int) -> None:
        gradients(
            first,
            last,
            texels.width,
            texel,
            index,
            chart,
            host,
            height,
            metric.stretch,
            metric.axes,
            gradient,
        )

    slices(work, count, size=_SLICE, threads=threads)
    return gradient


def normal_map(
    surface: Surface,
    atlas: Atlas,
    texels: Texels,
    height_mm: ArrayLike,
    *,
    tangents: NDArray[np.float64] | None = None,
    metric: PageMetric | None = None,
    threads: int | None = None,
) -> NDArray[np.float32]:
    """Tangent-space normals of the surface raised by a height, at every mapped texel.

    Parameters
    ----------
    surface : Surface
        m faces.
    atlas : Atlas
        Its unwrap.
    texels : Texels
        t mapped texels.
    height_mm : (t,) float
        Height above the surface at each.
    tangents : (m, 3, 4) float64, optional
        From `surface_tangents`, if they are known already.
    metric : PageMetric, optional
        From `surftex.maps.page.page_metric`, if it is known already.
    threads : int, optional
        None means every core; it cannot change a byte.

    Returns
    -------
    encoded : (t, 3) float32
        Unit vectors along tangent, bitangent and normal; `texels.image` makes a picture of them.
    """
    page = NormalPage.of(surface, atlas, texels, tangents=tangents, metric=metric)
    return page.encoded(height_mm, threads=threads)


@dataclass(frozen=True, eq=False)
class NormalPage:
    """All of a normal map but the height, for a page that is drawn again and again; make it with `NormalPage.of`."""

    surface: Surface
    atlas: Atlas
    texels: Texels
    tangents: NDArray[np.float64]
    metric: PageMetric
    border: NDArray[np.bool_]
    index: NDArray[np.int32]

    @staticmethod
    def of(
        surface: Surface,
        atlas: Atlas,
        texels: Texels,
        *,
        tangents: NDArray[np.float64] | None = None,
        metric: PageMetric | None = None,
    ) -> "NormalPage":
        """Prepare a page.

        Parameters
        ----------
        surface : Surface
            m faces.
        atlas : Atlas
            Its unwrap.
        texels : Texels
            t mapped texels.
        tangents : (m, 3, 4) float64, optional
            From `surface_tangents`, if they are known already.
        metric : PageMetric, optional
            From `surftex.maps.page.page_metric`, if it is known already.

        Returns
        -------
        page : NormalPage
            Ready for heights.
        """
        border = stopped(surface, texels)
        return NormalPage(
            surface, atlas, texels,
            read_only(surface_tangents(surface, atlas) if tangents is None else tangents),
            page_metric(surface, atlas, texels.width, texels.height) if metric is None else metric,
            border, texel_index(texels, border),
        )  # fmt: skip

    def encoded(self, height_mm: ArrayLike, *, threads: int | None = None) -> NDArray[np.float32]:
        """Make the normals of a height.

        Parameters
        ----------
        height_mm : (t,) float
            Height above the surface at each mapped texel.
        threads : int, optional
            None means every core; it cannot change a byte.

        Returns
        -------
        encoded : (t, 3) float32
            As `normal_map`.
        """
        from surftex.kernels.normals import encode_slopes

        texels = self.texels
        gradient = read_only(_gradient(self.atlas, texels, height_mm, self.index, self.metric, threads))
        shading, frame = read_only(self.surface.shading_normal), self.surface.frame
        texel, host = read_only(texels.texel), read_only(texels.host)
        encoded = np.zeros((len(gradient), 3), np.float32)

        def work(first: int, last: int) -> None:
            encode_slopes(
                first, last, texels.width, texel, gradient, host, self.metric.weight, frame, shading, self.tangents,
                encoded,
            )  # fmt: skip

        slices(work, len(gradient), size=_SLICE, threads=threads)
        _mend_border(texels, self.border, self.index, encoded)
        return encoded


def _mend_border(
    texels: Texels, border: NDArray[np.bool_], index: NDArray[np.int32], encoded: NDArray[np.float32]
) -> None:
    """Give gutter texels at borders of the mesh the normal of the nearest other texel, in place."""
    if border.any() and not border.all():
        source = nearest_mapped((index >= 0).reshape(-1, texels.width)).ravel()
        place = texels.texel[border] - texels.rows[0] * texels.width
        encoded[border] = encoded[index[source[place]]]


def object_normals(
    surface: Surface,
    tangents: NDArray[np.float64],
    face: NDArray[np.int32],
    barycentric: NDArray[np.float64],
    encoded: NDArray[np.float32],
) -> NDArray[np.float64]:
    """Decode tangent-space normals as a shader does.

    Parameters
    ----------
    surface : Surface
        m faces.
    tangents : (m, 3, 4) float64
        From `surface_tangents`.
    face : (n,) int
        Face that is drawn.
    barycentric : (n, 3) float
        Place in it.
    encoded : (n, 3) float
        What the map holds there, -1 to 1; any length.

    Returns
    -------
    normal : (n, 3) float64
        Unit vectors in the frame of `Surface.vertices`.
    """
    from surftex.kernels.tangents import decode_normals

    normal = np.zeros((len(face), 3))
    numbers = (
        read_only_view(array, np.float64)
        for array in (barycentric, encoded, surface.shading_normal, tangents)
    )
    decode_normals(read_only_view(face, np.int32), *numbers, normal)
    return normal
