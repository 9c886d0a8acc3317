"""The walk over the page: tiles of rows, in each the texels, the layers at them, and the maps of them.

What is kept grows with the page, what passes through does not: a tile holds at most `TILE_TEXELS` texels, and
layers are evaluated in slices of it. A tile reads a margin of rows beyond its own where a map looks at its
neighbours. Neither tiles nor slices change a byte.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surftex.arrays import read_only_view
from surftex.bake.stack import Stack
from surftex.charts.atlas import Atlas
from surftex.charts.fill import fill_nearest
from surftex.charts.texels import EXACT_PX, TexelPage, Texels, default_gutter_px
from surftex.errors import InputError
from surftex.kernels.pool import Tick, slices
from surftex.materials.layers import CHANNELS, RAW
from surftex.optics import RangeTally
from surftex.paged import let_go, page
from surftex.surface.surface import Surface

if TYPE_CHECKING:
    from surftex.maps.page import PageMetric

TILE_TEXELS = 1 << 21
"""Most texels of a tile where none is asked for; half of them, in 512 rows or more, where it needs next to no margin."""

_TILE_ROWS = 512

_SLICE = 1 << 15
_FROM_HEIGHT = ("normal", "ambient_occlusion")
_CHANNEL_OF = {"height": "height_mm", **dict.fromkeys(_FROM_HEIGHT, "height_mm")}


@dataclass(frozen=True, eq=False)
class Pages:
    """Maps as pictures without holes.

    Attributes
    ----------
    images : dict of str to (h, w) or (h, w, 3) array
        By name, and by the UDIM number of the page where there may be several (``height.1002``).
        float32, ``region`` int32; ``height`` in mm, ``base_color`` linear, ``normal`` unit vectors.
    core : int
        Texels whose centre shows the surface.
    mapped : int
        Texels of core and gutter.
    tangents : (m, 3, 4) float64
        That the normals are told in.
    mean : dict of str to float or (3,) float64
        Of what each map of a channel shows of the surface; none of ids.
    clamped : dict of str to int
        Texels that show the surface and whose channel left its range, by channel; only those that did.
    """

    images: dict[str, NDArray[Any]]
    core: int
    mapped: int
    tangents: NDArray[np.float64]
    mean: dict[str, Any]
    clamped: dict[str, int]


def chosen_maps(stack: Stack, asked: tuple[str, ...] | None) -> tuple[str, ...]:
    """Choose the maps of a bake.

    Parameters
    ----------
    stack : Stack
        What the layers write.
    asked : tuple of str or None
        None means what the layers make: colours and shares, normal and height.

    Returns
    -------
    maps : tuple of str
        In the order asked for.

    Raises
    ------
    InputError
        If no layer writes what a map needs.
    """
    channels = stack.channels
    made = [channel for channel in channels if channel != "height_mm" and channel not in RAW]
    made += ["normal", "height"] if "height_mm" in channels else []
    if asked is None:
        return tuple(made)
    for name in asked:
        if _CHANNEL_OF.get(name, name) not in channels:
            extra = ["ambient_occlusion"] * ("height_mm" in channels) + [
                name for name in RAW if name in channels
            ]
            raise InputError(f"no layer makes the map {name!r}; these layers make {', '.join(made + extra)}")
    return asked


def bake_pages(
    surface: Surface,
    atlas: Atlas,
    stack: Stack,
    resolution: int,
    maps: tuple[str, ...],
    *,
    gutter_px: int | None = None,
    tile_rows: int | None = None,
    udim: bool = False,
    threads: int | None = None,
    tick: Tick | None = None,
) -> Pages:
    """Evaluate a stack at every texel of every page.

    Parameters
    ----------
    surface : Surface
        What is baked.
    atlas : Atlas
        Its unwrap.
    stack : Stack
        What lies on it.
    resolution : int
        Side of the page in texels.
    maps : tuple of str
        From `chosen_maps`.
    gutter_px : int, optional
        Width of the gutter; the atlas' own without it.
    tile_rows : int, optional
        Rows of a tile; cannot change a byte.
    udim : bool
        Whether names carry the number of the page.
    threads : int, optional
        None means every core; cannot change a byte.
    tick : callable, optional
        Told the finished share; may raise to cancel.

    Returns
    -------
    pages : Pages
        Every texel filled.
    """
    gutter = default_gutter_px(atlas, resolution) if gutter_px is None else gutter_px
    tools = _Tools(surface, atlas, maps, threads)
    images, baked, clamped = {}, [], Counter[str]()
    for i, tile in enumerate(atlas.tiles):
        share = None if tick is None else lambda done, i=i: tick((i + done) / len(atlas.tiles))
        tools.turn_to(atlas.page(tile))
        one = _bake_page(stack, tools, resolution, maps, gutter, tile_rows, share)
        images |= {f"{name}.{tile}" if udim else name: image for name, image in one.images.items()}
        clamped.update(one.clamped)
        baked.append(one)
    core = sum(one.core for one in baked)
    mean = {
        name: sum(np.asarray(one.mean[name]) * one.core for one in baked) / max(core, 1)
        for name in baked[0].mean
    }
    return Pages(images, core, sum(one.mapped for one in baked), tools.tangents, mean, dict(clamped))


def _bake_page(
    stack: Stack,
    tools: "_Tools",
    resolution: int,
    maps: tuple[str, ...],
    gutter: int,
    tile_rows: int | None,
    tick: Tick | None,
) -> Pages:
    """Evaluate a stack at every texel of one page."""
    from surftex.kernels.rows import sum_rows

    surface, atlas, threads = tools.surface, tools.atlas, tools.threads
    images = {name: _page(name, resolution) for name in maps}
    mapped = np.zeros((resolution, resolution), bool)
    core, tally = 0, RangeTally()
    total = {
        name: np.zeros(_table(image).shape[1])
        for name, image in images.items()
        if name not in (*_FROM_HEIGHT, "region")
    }
    ground, beyond = TexelPage.of(surface, atlas, resolution, gutter), tools.margin_px(gutter)
    for first, last in _tiles(resolution, tile_rows, beyond):
        margin = beyond if last - first < resolution else 0
        rows = (max(0, first - margin), min(resolution, last + margin))
        tile = ground.texels(rows, exact_px=EXACT_PX, threads=threads)
        share = (
            None if tick is None else lambda done, a=first, b=last: tick((a + (b - a) * done) / resolution)
        )
        height = _evaluated(surface, stack, tile, (first, last), images, tally, threads, share)
        own = slice(*np.searchsorted(tile.texel, [first * resolution, last * resolution]))
        place = tile.texel[own]
        mapped.ravel()[place] = True
        core += int(np.count_nonzero(tile.core[own]))
        shown = read_only_view(place[tile.core[own]], np.int64)
        for name, sums in total.items():
            sum_rows(shown, _table(images[name]), sums)
        for name, image in images.items():
            if name in _FROM_HEIGHT:
                result = tools.map(name, tile, height)
                _put(tile.texel, (first, last), resolution, result, _table(image))
                del result
            let_go(image)
        del tile, height, place, shown  # or the next tile would be made beside this one
    count = int(np.count_nonzero(mapped))
    if count == 0:
        raise InputError(f"no texel of {resolution} x {resolution} shows the surface; raise the resolution")
    if count < mapped.size:
        fill_nearest(images.values(), mapped, threads=threads)
    mean = {name: np.squeeze(value / max(core, 1)) for name, value in total.items()}
    return Pages(images, core, count, tools.tangents, mean, tally.counts())


def equalise_pages(
    surface: Surface, atlas: Atlas, pages: Pages, *, tick: Tick | None = None
) -> dict[str, dict[str, float]]:
    """Even out what is left of seams, in place; ids are left alone, and normals, whose frames differ across seams.

    Parameters
    ----------
    surface : Surface
        What was baked.
    atlas : Atlas
        Its unwrap.
    pages : Pages
        The maps.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    moved : dict of str to dict
        For each map how many ``texels`` moved, and by how much: ``rms`` and ``max``, in its own unit.
    """
    from surftex.charts.equalise import equalise
    from surftex.charts.seams import seam_samples

    moved = {}
    names = [name for name in pages.images if name not in ("normal", "region")]
    for i, name in enumerate(names):
        image = pages.images[name]
        result = equalise(seam_samples(surface, atlas, image.shape[0]), image)
        low, high = (0.0, np.inf) if name == "base_color" or name.endswith("_mm") else (0.0, 1.0)
        image[...] = result.image if name == "height" else np.clip(result.image, low, high)
        moved[name] = {
            "texels": result.moved_texels,
            "rms": result.moved_rms,
            "max": result.moved_max,
        }
        if tick:
            tick((i + 1) / len(names))
    return moved


def _page(name: str, resolution: int) -> NDArray[Any]:
    count = 3 if name == "normal" else 1 if name in _CHANNEL_OF else CHANNELS[name]
    shape = (resolution, resolution) if count == 1 else (resolution, resolution, count)
    return page(shape, np.int32 if name == "region" else np.float32)


def _table(page: NDArray[Any]) -> NDArray[Any]:
    """See a page as rows of 1 or 3 numbers, one row for each texel."""
    return page.reshape(-1, 1 if page.ndim == 2 else page.shape[2])


def _put(
    texel: NDArray[np.int64], rows: tuple[int, int], width: int, values: NDArray[Any], table: NDArray[Any]
) -> None:
    """Write values of texels into the table of a page, where they lie in the range of its rows."""
    from surftex.kernels.rows import put_rows

    value = read_only_view(values, table.dtype).reshape(len(texel), table.shape[1])
    put_rows(read_only_view(texel, np.int64), rows[0] * width, rows[1] * width, value, table)


def _tiles(resolution: int, rows: int | None, margin: int) -> Iterator[tuple[int, int]]:
    if rows is None:
        most = TILE_TEXELS // resolution
        rows = max(1, most if margin > 1 else min(most, max(most // 2, _TILE_ROWS)))
    for first in range(0, resolution, rows):
        yield first, min(resolution, first + rows)


def _evaluated(
    surface: Surface,
    stack: Stack,
    tile: Texels,
    rows: tuple[int, int],
    images: dict[str, NDArray[Any]],
    tally: RangeTally,
    threads: int | None,
    tick: Tick | None,
) -> NDArray[np.float32]:
    """Write what the layers say of the texels in `rows` into the images; the height of all texels of the tile.

    Samples are asked in slices, and face by face; those that share the place of another get its values.
    """
    from surftex.kernels.ordering import order_by_face
    from surftex.kernels.rows import repeat_rows

    samples, width = tile.samples, tile.width
    own = tile.source == np.arange(len(tile), dtype=np.int32)
    asked_alone, follower = np.flatnonzero(own).astype(np.int32), np.flatnonzero(~own)
    order = np.zeros(len(asked_alone), np.int32)
    place = np.zeros(len(surface.faces) + 1, np.int64)
    order_by_face(read_only_view(samples.points.face[asked_alone], np.int32), place, order)
    order = asked_alone[order]
    tables = {name: _table(page) for name, page in images.items() if name not in _FROM_HEIGHT}
    looked_around = len(tables) < len(images)
    height = np.zeros(len(samples) if looked_around else 0, np.float32)
    channels = {_CHANNEL_OF.get(name, name) for name in images}
    asked = tuple(name for name in CHANNELS if name in channels)

    def work(first: int, last: int) -> None:
        chosen = order[first:last]
        texel = tile.texel[chosen]

        def told(outside: Mapping[str, NDArray[np.bool_]]) -> None:
            shown = tile.core[chosen] & (texel >= rows[0] * width) & (texel < rows[1] * width)
            tally.add({name: int(np.count_nonzero(at & shown)) for name, at in outside.items()})

        values = stack.at(samples.taken(chosen), asked, told=told)
        if looked_around:
            height[chosen] = values["height_mm"]
        for name, table in tables.items():
            _put(texel, rows, width, values[_CHANNEL_OF.get(name, name)], table)

    slices(work, len(order), size=_SLICE, threads=threads, tick=tick)
    source = tile.source[follower]
    if looked_around:
        height[follower] = height[source]
    texel = tile.texel[follower]
    kept = (texel >= rows[0] * width) & (texel < rows[1] * width)
    to, of = texel[kept], tile.texel[source[kept]]
    for table in tables.values():
        repeat_rows(read_only_view(to, np.int64), read_only_view(of, np.int64), table)
    return height


class _Tools:
    """What turns the layers of a tile into its maps."""

    def __init__(self, surface: Surface, atlas: Atlas, maps: tuple[str, ...], threads: int | None) -> None:
        self.surface, self.atlas, self.threads = surface, atlas, threads
        self.maps = set(maps)
        from surftex.maps.normal import surface_tangents

        self.tangents = surface_tangents(surface, atlas)
        self.metric: PageMetric | None = None

    def turn_to(self, page: Atlas) -> None:
        """Make the maps of another page of the atlas from here on."""
        self.atlas, self.metric = page, None

    def margin_px(self, gutter: int) -> int:
        """Rows beyond a tile that its maps depend on."""
        if "ambient_occlusion" in self.maps or ("normal" in self.maps and self.surface.on_border.any()):
            return 2 * max(gutter, 16) + 8
        return 1 if "normal" in self.maps else 0

    def map(self, name: str, tile: Texels, height_mm: NDArray[np.float32]) -> NDArray[Any]:
        """Make one of the maps that look around, at the texels of a tile."""
        from surftex.maps.page import page_metric

        if self.metric is None:
            self.metric = page_metric(self.surface, self.atlas, tile.width, tile.height)
        if name == "normal":
            from surftex.maps.normal import normal_map

            return normal_map(
                self.surface, self.atlas, tile, height_mm,
                tangents=self.tangents, metric=self.metric, threads=self.threads,
            )  # fmt: skip
        from surftex.maps.occlusion import ambient_occlusion

        return ambient_occlusion(
            self.surface, self.atlas, tile, height_mm, metric=self.metric, threads=self.threads
        )
