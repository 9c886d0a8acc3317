"""Ambient occlusion of a relief: how open each place is to light from everywhere, in its own furrows only.

A place sees the sky down to the horizon in each of eight directions; its share of the light is 1 less the
mean of the squared sines of the horizons' heights, which is exact for flat ground (walls are looked for at
six distances and may be taken for up to 1.8 times as far). Distances are walked on the surface,
on into the gutters of the charts, so the map has no seams. What the mesh itself shades is left to renderers.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surftex.arrays import checked
from surftex.charts.atlas import Atlas
from surftex.charts.texels import Texels, default_gutter_px
from surftex.errors import InputError
from surftex.kernels.pool import slices
from surftex.maps.page import PageMetric, page_metric, read_only, stopped
from surftex.surface.surface import Surface

RADIUS_MM = 1.0
"""How far off relief still shades a place, if nobody says otherwise."""

_DIRECTIONS = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]])
_STEPS, _FARTHEST = 6, 16
_SLICE = 1 << 17


def ambient_occlusion(
    surface: Surface,
    atlas: Atlas,
    texels: Texels,
    height_mm: ArrayLike,
    *,
    radius_mm: float = RADIUS_MM,
    metric: PageMetric | None = None,
    threads: int | None = None,
) -> NDArray[np.float32]:
    """Measure how open a relief is to light, at every mapped texel.

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
    radius_mm : float
        Relief farther off does not shade; nearer relief fades towards it. At most 16 texels, and no more than
        the gutter has, are looked at; where the radius is less than a texel, everything is open.
    metric : PageMetric, optional
        From `surftex.maps.page.page_metric`, if it is known already.
    threads : int, optional
        None means every core; it cannot change a byte.

    Returns
    -------
    sky : (t,) float32
        1 on open ground, towards 0 in deep furrows.

    Raises
    ------
    InputError
        If the radius is no length.
    """
    from surftex.kernels.occlusion import open_sky

    if not (np.isfinite(radius_mm) and radius_mm > 0):
        raise InputError(f"radius_mm is {radius_mm}; it takes a length above 0")
    values = checked(height_mm, "height_mm", (len(texels),), np.float32)
    if metric is None:
        metric = page_metric(surface, atlas, texels.width, texels.height)
    step = _steps(surface, atlas, texels.width, radius_mm)
    rim = int(step[-1])
    width = texels.width + 2 * rim
    height = np.full((texels.rows[1] - texels.rows[0] + 2 * rim, width), np.nan, np.float32)
    row, column = texels.texel // texels.width - texels.rows[0] + rim, texels.texel % texels.width + rim
    place = row * width + column
    height.ravel()[place] = np.where(stopped(surface, texels), np.float32(np.nan), values)
    jump = np.outer(_DIRECTIONS @ [1, -width], step)
    axes, squared, share = _DIRECTIONS.astype(float), step.astype(float) ** 2, 1 / step
    arrays = (place, height.ravel(), texels.host, metric.stretch, axes, jump, squared, share)
    place, relief, host, stretch, axes, jump, squared, share = map(read_only, arrays)
    sky = np.ones(len(texels), np.float32)

    def work(first: int, last: int) -> None:
        open_sky(first, last, place, relief, host, stretch, axes, jump, squared, share, float(radius_mm), sky)

    slices(work, len(texels), size=_SLICE, threads=threads)
    return sky


def _steps(surface: Surface, atlas: Atlas, width: int, radius_mm: float) -> NDArray[np.int64]:
    """Choose at which distances, in texels, to look: denser near by. The same for all rows of a page."""
    reach = radius_mm * atlas.texels_per_mm(surface, width)
    farthest = min(_FARTHEST, max(1, default_gutter_px(atlas, width)), max(1.0, reach))
    return np.unique(np.rint(np.geomspace(1, farthest, _STEPS)).astype(np.int64))
