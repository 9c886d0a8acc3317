"""A growth as frames: one picture of its particles for each state that was remembered on the way."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.bake.growing import GROWS, Growth
from surftex.bake.pages import bake_pages
from surftex.bake.saving import More
from surftex.bake.stack import Stack
from surftex.bake.stages import Progress, Stages
from surftex.bake.tiling import tile_normals
from surftex.files.images import png_bytes
from surftex.kernels.pool import Tick
from surftex.maps.mapset import MapSet
from surftex.materials.cells.growing import GrowthPattern, tile_growth
from surftex.materials.cells.model import Cells
from surftex.preview.render import Shot
from surftex.recipe.model import Recipe

SIZE = (800, 600)
"""Pixels of a frame."""

SAMPLES = 1
"""Along each side of a pixel: what is seen small and moving needs no more."""

RESOLUTION = 768
"""Side of the page in which the particles of a frame are drawn."""

Seen = Sequence[tuple[int, Mapping[str, NDArray]]]
"""Generations, and the features that there were: `surftex.bake.growing.Growth.states`."""


def frame_names(stem: str, count: int) -> list[str]:
    """Name the frames.

    Parameters
    ----------
    stem : str
        Start of the names.
    count : int
        How many.

    Returns
    -------
    names : list of str
        ``<stem>_growth_0001.png`` and so on, in order.
    """
    return [f"{stem}_growth_{number:04d}.png" for number in range(1, count + 1)]


def growth_frames(
    maps: MapSet,
    cells: Cells,
    seen: Seen,
    *,
    resolution: int | None = None,
    threads: int | None = None,
    tick: Tick | None = None,
    **view: Any,
) -> Iterator[NDArray[np.uint8]]:
    """Draw a growth, state by state, from one point of view.

    Parameters
    ----------
    maps : MapSet
        What was baked in the end, on a mesh or a tile.
    cells : Cells
        The material.
    seen : sequence of (int, mapping)
        Features of one layer: ``particle``.
    resolution : int, optional
        Of the page in which the particles are drawn; `RESOLUTION` without it.
    threads : int, optional
        None means every core; cannot change a byte.
    tick : callable, optional
        Told the finished share.
    **view : Any
        As for `surftex.preview.render.render`; camera and lamps are set up once.

    Yields
    ------
    picture : (h, w, 3) uint8
        Young particles are pale, what lies deep is dark.
    """
    tile, side = maps.report.get("tile"), resolution or RESOLUTION
    shot: Shot | None = None
    for number, (_, features) in enumerate(seen):
        if tile is not None:
            images = dict(tile_growth(features["particle"], cells.law, tile["side_mm"], side))
            images["height"] = images.pop("height_mm")
            images["normal"] = tile_normals(images["height"], tile["side_mm"])
        else:
            pattern = GrowthPattern.of(maps.surface, features["particle"], cells.law, threads)
            images = bake_pages(
                maps.surface, maps.atlas, Stack((pattern,), (None,)), side,
                ("base_color", "roughness", "normal"), threads=threads,
            ).images  # fmt: skip
        subject = MapSet(images, maps.surface, maps.atlas, maps.tangents, stem=maps.stem)
        shot = shot or Shot.of(subject, **view)
        yield shot.drawn(subject)
        if tick is not None:
            tick((number + 1) / len(seen))


def frames_to_write(
    maps: MapSet,
    recipe: Recipe,
    growth: Growth,
    *,
    threads: int | None = None,
    progress: Progress | None = None,
) -> More | None:
    """Prepare the frames of a growth for `surftex.bake.saving.save`.

    Parameters
    ----------
    maps : MapSet
        What was baked in the end.
    recipe : Recipe
        Of the bake.
    growth : Growth
        That remembered states on its way.
    threads : int, optional
        None means every core; cannot change a byte.
    progress : callable, optional
        Told of the stage ``frames``; may raise to cancel.

    Returns
    -------
    more : (names, write), or None
        None where there is no state to be seen.
    """
    states = growth.states
    if not states:
        return None
    material: Any = next(layer.material for layer in recipe.layer if layer.kind in GROWS)
    view: dict[str, Any] = {"size": SIZE, "samples": SAMPLES}
    if "tile" in maps.report:
        view |= {"size": (SIZE[1], SIZE[1]), "view": "front", "light": "raking", "zoom": 1.06, "floor": False}
    names = frame_names(maps.stem, len(states))

    def write(workplace: Path) -> None:
        stages = Stages(progress)
        with stages.stage("frames") as tick:
            pictures = growth_frames(maps, material, states, threads=threads, tick=tick, **view)
            for name, picture in zip(names, pictures, strict=True):
                (workplace / name).write_bytes(png_bytes(picture))
        maps.report["stages"].extend(stages.done)

    return names, write
