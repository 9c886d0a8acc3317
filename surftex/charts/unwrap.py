"""`unwrap`: cut a surface into charts and lay them on a square page, by one door to two libraries.

* ``"xatlas"``: the well-known one; slow on large meshes, so it runs in a child process with a budget of time.
* ``"uvunwrap"``: far faster, seams as short or shorter.
* ``"auto"``: xatlas up to 20,000 faces, uvunwrap above, and wherever xatlas fails or runs out of time.

Whoever cuts, faces that come out mirrored, folded or stretched are cut off into charts of their own, and
uvunwrap packs: the page is square, texels are as large everywhere, and charts keep 2 x `gutter_px` texels
between them.
"""

import time
from dataclasses import replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from surftex.charts.atlas import Atlas, tile_origin
from surftex.charts.mend import (
    bad_faces,
    notch_faces,
    overlap_faces,
    stand_ins,
    true_scale,
    true_to_shape,
)
from surftex.charts.xatlas_run import xatlas_charts
from surftex.errors import InputError, WorkError
from surftex.kernels.pool import Tick
from surftex.surface.surface import Surface
from surftex.words import by_count

Method = Literal["auto", "xatlas", "uvunwrap"]

XATLAS_FACES = 20_000
"""Faces up to which ``"auto"`` takes xatlas."""

LEAST_COVERAGE = 0.3
"""Share of the page that charts should cover; the default gutter shrinks for it."""

SPARSE_COVERAGE = LEAST_COVERAGE / 2
"""Share of the page below which a note says that gutters leave little of it to the surface."""

PACKED_SHARE = 0.85
"""Share of the page that charts and gutters cover together once they are packed."""

MOST_TILES = 100
"""Pages that a density may take: ten rows of ten."""

_PER_UNIT, _LEAST_BLOCK = 256.0, 0.05

MENDING_ROUNDS = 4
"""How often bad faces are cut off and all is packed again."""


def unwrap(
    surface: Surface,
    *,
    method: Method = "auto",
    resolution: int = 2048,
    gutter_px: int | None = None,
    texels_per_mm: float | None = None,
    budget_s: float = 30.0,
    tick: Tick | None = None,
) -> Atlas:
    """Unwrap a surface for baking.

    Parameters
    ----------
    surface : Surface
        m faces.
    method : {"auto", "xatlas", "uvunwrap"}
        Who cuts and flattens.
    resolution : int
        Side in texels of the page that the gaps are made for.
    gutter_px : int, optional
        Free texels around each chart. R texels keep k mip levels clean where R >= 1.5 * 2^k. Without it,
        1/128 of the page, between 2 and 16, less where many small charts would leave no room.
    texels_per_mm : float, optional
        Density, over as many pages as it takes, side by side; one page, filled, without it. uvunwrap cuts and packs.
    budget_s : float
        Seconds of wall time for xatlas; beyond it uvunwrap takes over, and a note says so.
    tick : callable, optional
        Told the finished share; may raise to cancel.

    Returns
    -------
    atlas : Atlas
        All faces upright, none stretched more than 4 times, no overlap. Same input, same bytes.

    Raises
    ------
    InputError
        If an option is out of range, or the density takes more than `MOST_TILES` pages.
    WorkError
        If the charts do not fit on the page even without gaps.
    """
    if method not in get_args(Method):
        raise InputError(f"unwrapper is {method!r}; it takes one of {', '.join(get_args(Method))}")
    if resolution < 16:
        raise InputError(f"resolution is {resolution}; an unwrap takes at least 16 texels")
    gutter = default_gutter(resolution) if gutter_px is None else int(gutter_px)
    if not 0 <= gutter < resolution // 4:
        raise InputError(f"gutter_px is {gutter}; at {resolution} texels it takes 0 to {resolution // 4 - 1}")
    wanted = ("xatlas" if len(surface.faces) <= XATLAS_FACES else "uvunwrap") if method == "auto" else method
    if texels_per_mm is not None:
        tiles_for(surface, texels_per_mm, resolution)
        if method == "xatlas":
            raise InputError(
                "xatlas packs one page; let texels_per_mm be done by uvunwrap (unwrapper, --unwrapper)"
            )
        wanted = "uvunwrap"
    notes: list[str] = []
    used = np.unique(surface.faces)
    vertices = np.zeros(surface.vertices.shape, np.float32)
    vertices[used] = unit_vertices(surface.vertices[used])
    charts = None
    if wanted == "xatlas":
        try:
            charts = xatlas_charts(vertices, surface.faces, budget_s=budget_s, tick=_part(tick, 0, 0.7))
            charts = _even_scale(surface, charts)
        except WorkError as problem:
            notes.append(f"{problem}; uvunwrap took over")
            wanted = "uvunwrap"
    if charts is None:
        charts = _generated(
            surface, vertices, _part(tick, 0, 0.7), _page_size(surface, resolution, gutter, texels_per_mm)
        )
    drawn = Atlas.of(surface, charts / max(1.0, np.abs(charts).max()))
    if gutter_px is None and texels_per_mm is None:
        gutter = _affordable(surface, drawn, resolution, gutter)
    sheet = true_scale(surface, charts, drawn.chart)
    cut = notch_faces(
        surface, sheet, drawn.chart, drawn.seam, bad_faces(surface, sheet), min(resolution, 4096)
    )
    single = np.bincount(drawn.chart)[drawn.chart] == 1
    packed, worse = charts, np.zeros(0, np.int32)
    for turn in range(MENDING_ROUNDS):
        packed, gutter = _packed(
            surface,
            sheet,
            drawn.chart,
            cut | single,
            resolution,
            gutter,
            texels_per_mm,
            notes,
            _part(tick, 0.7, 1),
        )
        atlas = Atlas.of(surface, packed)
        worse = np.unique(
            np.concatenate([overlap_faces(surface, atlas.page(tile), resolution) for tile in atlas.tiles])
        )
        worse = worse[~cut[worse]]
        if len(worse) == 0:
            break
        cut[worse] = True
        if turn == MENDING_ROUNDS - 2:
            cut |= np.isin(atlas.chart, atlas.chart[worse])
    else:
        raise WorkError(
            f"faces still overlap after packing {MENDING_ROUNDS} times; the first is {int(worse[0])}"
        )
    if cut.any():
        notes.append(
            f"{cut.sum()} of {len(surface.faces)} faces lie in charts of their own: "
            "they came out folded, stretched or beside a notch"
        )
    made = Atlas.of(surface, packed, unwrapper=wanted, resolution=resolution, gutter_px=gutter)
    if texels_per_mm is None:
        notes.extend(_sparse(surface, made))
    return replace(made, notes=tuple(notes))


def tiles_for(surface: Surface, texels_per_mm: float, resolution: int) -> int:
    """Estimate how many tiles a density takes.

    Parameters
    ----------
    surface : Surface
        What would be unwrapped.
    texels_per_mm : float
        The density.
    resolution : int
        Side of a tile in texels.

    Returns
    -------
    tiles : int
        About so many.

    Raises
    ------
    InputError
        If they are more than `MOST_TILES`.
    """
    pages = surface.area_mm2 * texels_per_mm**2 / (PACKED_SHARE * resolution**2)
    if pages > MOST_TILES:
        raise InputError(
            f"{texels_per_mm:g} texels per mm take about {pages:.0f} tiles of {resolution} x {resolution}; "
            f"at most {MOST_TILES} are made: raise the resolution, or lower the density"
        )
    return max(1, int(np.ceil(pages)))


def default_gutter(resolution: int) -> int:
    """Choose the free texels around each chart.

    Parameters
    ----------
    resolution : int
        Side of the page.

    Returns
    -------
    gutter_px : int
        1/128 of the page, between 2 and 16.
    """
    return min(16, max(2, resolution // 128))


def _affordable(surface: Surface, drawn: Atlas, resolution: int, gutter: int) -> int:
    """Halve the gutter while many small charts would leave less than `LEAST_COVERAGE` of the page for the surface.

    Charts of area A, border length P and number n at d texels per mm take about A d^2 + P R d + pi R^2 n
    texels.
    """
    border_mm = float(surface.edge_length[drawn.seam].sum())
    while gutter > 2:
        room = PACKED_SHARE * resolution**2 - np.pi * gutter**2 * drawn.chart_count
        if room > 0:
            density = np.sqrt((border_mm * gutter) ** 2 + 4 * surface.area_mm2 * room) - border_mm * gutter
            density /= 2 * surface.area_mm2
            if surface.area_mm2 * density**2 >= LEAST_COVERAGE * resolution**2:
                break
        gutter //= 2
    return gutter


def _sparse(surface: Surface, atlas: Atlas) -> list[str]:
    """Tell where gutters fill the page and leave little of it to the surface; long thin charts may do so without them."""
    density = atlas.texels_per_mm(surface, atlas.resolution)
    covered = surface.area_mm2 * density**2 / atlas.resolution**2
    border_px = float(surface.edge_length[atlas.seam].sum()) * density
    gutters = border_px * atlas.gutter_px + np.pi * atlas.gutter_px**2 * atlas.chart_count
    if covered >= SPARSE_COVERAGE or gutters < PACKED_SHARE / 2 * atlas.resolution**2:
        return []
    return [
        f"the surface covers {100 * covered:.2g} % of the page at {atlas.resolution}: the rest goes to gutters of "
        f"{by_count(atlas.gutter_px, '{} texel', '{} texels')} around {atlas.chart_count} charts; a larger resolution "
        "(--resolution) or a smaller gutter (bake.gutter) would do"
    ]


def unit_vertices(vertices: NDArray[np.float64]) -> NDArray[np.float32]:
    """Bring points to size one around the origin, where single precision serves any scale.

    Parameters
    ----------
    vertices : (n, 3) float64
        At any scale and place.

    Returns
    -------
    vertices : (n, 3) float32
        The longest side of their box is one.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    return np.ascontiguousarray((vertices - (low + high) / 2) / (high - low).max(), np.float32)


def _even_scale(surface: Surface, charts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Undo the separate stretch along u and v that xatlas gives each chart when it rounds them to texels."""
    chart = Atlas.of(surface, charts / max(1.0, np.abs(charts).max())).chart
    first, second = charts[:, 1] - charts[:, 0], charts[:, 2] - charts[:, 0]
    along = first / surface.flat[:, 1, :1]
    up = (second - along * surface.flat[:, 2, :1]) / surface.flat[:, 2, 1:]
    area = surface.face_area_mm2
    total = np.bincount(chart, area)
    scale = np.stack(
        [np.sqrt(np.bincount(chart, area * (along**2 + up**2)[:, k]) / total) for k in (0, 1)], axis=1
    )
    scale[~(scale > 0)] = 1
    return charts / scale[chart][:, None]


def _part(tick: Tick | None, start: float, end: float) -> Tick | None:
    """Give a stage its share of the progress."""
    return None if tick is None else lambda share: tick(start + (end - start) * min(1.0, max(0.0, share)))


def _page_size(surface: Surface, resolution: int, gutter: int, texels_per_mm: float | None) -> float:
    """Side of a page of that density inside its gutter, as a share of the mesh's longest; infinite without one."""
    if texels_per_mm is None:
        return np.inf
    return (resolution - 2 * gutter) / (texels_per_mm * float(np.ptp(surface.vertices, axis=0).max()))


def _generated(
    surface: Surface, vertices: NDArray[np.float32], tick: Tick | None, page: float
) -> NDArray[np.float64]:
    """Cut and flatten by uvunwrap, packed in haste; charts longer than a page are cut along cubes in space."""
    import uvunwrap

    cuts, block = surface.neighbor < 0, 0.9 * page
    middle = vertices[surface.faces].mean(axis=1)
    while True:
        mesh = uvunwrap.Mesh(
            vertices, surface.faces.astype(np.uint32), seams=np.ascontiguousarray(cuts, np.uint8)
        )
        job = uvunwrap.start([mesh], page_size=None, texels_per_unit=_PER_UNIT, padding=0, packing="fast")
        result = _finished(job, tick)
        corner, output = _corners(result), result.meshes[0]
        chart = _of_faces(output, output.chart)
        side = np.zeros(int(chart.max()) + 1)
        for axis in (0, 1):
            low, high = np.full(len(side), np.inf), np.full(len(side), -np.inf)
            np.minimum.at(low, chart, corner[..., axis].min(axis=1))
            np.maximum.at(high, chart, corner[..., axis].max(axis=1))
            side = np.maximum(side, high - low)
        large = (side > page * _PER_UNIT)[chart]
        if not large.any() or block < _LEAST_BLOCK * page:
            return corner
        cube = np.floor(middle / block).astype(np.int64)
        cuts = cuts | (
            (cube[:, None] != cube[surface.neighbor]).any(axis=2) & large[:, None] & large[surface.neighbor]
        )
        block *= 0.7


def _of_faces(output: Any, of_vertices: Any) -> NDArray[np.int32]:
    """Read what uvunwrap says of its vertices, by face."""
    first = np.frombuffer(output.indices, np.uint32).reshape(-1, 3)[:, 0]
    return np.frombuffer(of_vertices, np.int32)[first]


def _packed(
    surface: Surface,
    sheet: NDArray[np.float64],
    chart: NDArray[np.int32],
    alone: NDArray[np.bool_],
    resolution: int,
    gutter: int,
    texels_per_mm: float | None,
    notes: list[str],
    tick: Tick | None,
) -> tuple[NDArray[np.float64], int]:
    """Pack given charts by uvunwrap, which keeps their shapes."""
    import uvunwrap

    single = np.flatnonzero(alone)
    sheet, layers = sheet.copy(), chart.astype(np.int64)
    sheet[single] = stand_ins(surface, single)
    layers[single] = layers.max() + 1 + np.arange(len(single))
    flat = (sheet / sheet.max()).astype(np.float32).reshape(-1, 2)
    space = surface.vertices[surface.faces]
    space[single] = space[single, :1] + np.concatenate([sheet[single], np.zeros((len(single), 3, 1))], axis=2)
    place, layer = flat.view(np.int64)[:, 0], np.repeat(layers, 3)
    order = np.lexsort([place, surface.faces.ravel(), layer])
    new = np.zeros(len(order), bool)
    new[0] = True
    for key in (place, surface.faces.ravel(), layer):
        new[1:] |= np.diff(key[order]) != 0
    first, index = order[new], np.zeros(len(order), np.int64)
    index[order] = np.cumsum(new) - 1
    mesh = uvunwrap.Mesh(
        unit_vertices(space.reshape(-1, 3)[first]),
        np.ascontiguousarray(index.reshape(-1, 3), np.uint32),
        existing_uvs=np.ascontiguousarray(flat[first]),
    )
    if texels_per_mm is not None:
        units_mm = float(np.ptp(space.reshape(-1, 3)[first], axis=0).max())
        return true_to_shape(
            surface, _spread(mesh, resolution, gutter, texels_per_mm * units_mm, tick), single
        ), gutter
    page, gutter = _fitted(mesh, resolution, gutter, notes, tick)
    return true_to_shape(surface, page, single), gutter


def _fitted(
    mesh: Any, resolution: int, gutter: int, notes: list[str], tick: Tick | None
) -> tuple[NDArray[np.float64], int]:
    """Pack by uvunwrap; where the gaps leave no room for the charts, halve them."""
    import uvunwrap

    asked, reason = gutter, ""
    while True:
        try:
            result = _finished(uvunwrap.start([mesh], page_size=resolution, padding=gutter), tick)
        except uvunwrap.UnwrapError as problem:
            result, reason = None, str(problem)
        if result is not None and result.page_count == 1 and max(result.width, result.height) <= resolution:
            break
        if gutter == 0:
            raise WorkError(
                f"the charts do not fit on {resolution} x {resolution} texels: {reason or 'too many'}"
            )
        gutter //= 2
    if gutter != asked:
        notes.append(f"the page has no room for {asked} free texels around each chart; they have {gutter}")
    return _corners(result) / resolution, gutter


def _spread(
    mesh: Any, resolution: int, gutter: int, texels_per_unit: float, tick: Tick | None
) -> NDArray[np.float64]:
    """Pack by uvunwrap over as many pages as it takes, at a given density."""
    import uvunwrap

    try:
        result = _finished(
            uvunwrap.start([mesh], page_size=resolution, texels_per_unit=texels_per_unit, padding=gutter),
            tick,
        )
    except uvunwrap.UnwrapError as problem:
        raise WorkError(f"the charts do not fit on tiles of {resolution} x {resolution}: {problem}") from None
    if result.page_count > MOST_TILES:
        raise WorkError(f"the charts take {result.page_count} tiles; at most {MOST_TILES} are made")
    output = result.meshes[0]
    page = _of_faces(output, output.page)
    return _corners(result) / resolution + tile_origin(1001 + page)[:, None]


def _corners(result: Any) -> NDArray[np.float64]:
    """Read the corners out of uvunwrap's answer, in texels; it divides them by the two sides of what it filled."""
    share = np.frombuffer(result.meshes[0].corner_uvs, np.float32).reshape(-1, 3, 2).astype(np.float64)
    return share * [result.width, result.height]


def _finished(job: Any, tick: Tick | None) -> Any:
    """Wait for a job in the background, tell its progress, and stop it when interrupted."""
    try:
        while not job.done:
            time.sleep(0.005)
            if tick and job.progress is not None:
                tick(_stage_share(job.progress))
        return job.result()
    finally:
        if not job.done:
            job.cancel()


def _stage_share(progress: Any) -> float:
    """Turn a report of uvunwrap into a share of the whole."""
    start, length = {
        "segmenting": (0.0, 0.4),
        "parameterizing": (0.4, 0.3),
        "packing": (0.7, 0.25),
        "output": (0.95, 0.05),
    }.get(progress.stage, (0.0, 0.0))
    within = progress.done / progress.total if progress.total else 0.5
    return start + length * min(1.0, within)
