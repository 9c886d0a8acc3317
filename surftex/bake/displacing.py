"""The displaced mesh of a bake: its relief as triangles, for printing, milling and close-ups."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surftex.bake.stack import Stack
from surftex.errors import InputError
from surftex.kernels.pool import Tick, slices
from surftex.recipe.model import Recipe
from surftex.surface.points import Samples

if TYPE_CHECKING:
    from surftex.maps.mapset import MapSet

_EDGE_TEXELS = 2.0
_USUAL_FACES = 4_000_000
_SLICE = 1 << 15


@dataclass(frozen=True, eq=False)
class Baked:
    """Maps, and the patterns that they were made from.

    Attributes
    ----------
    maps : MapSet
        The maps.
    stack : Stack
        The patterns, which can be asked again.
    recipe : Recipe
        What was baked.
    """

    maps: "MapSet"
    stack: Stack
    recipe: Recipe

    @property
    def displaced_name(self) -> str:
        """Name of the file of the displaced mesh."""
        return f"{self.maps.stem}_displaced.{self.recipe.bake.displaced_format}"


def write_displaced(
    baked: Baked, folder: Path, *, threads: int | None = None, tick: Tick | None = None
) -> Path:
    """Write the displaced mesh of a bake.

    Parameters
    ----------
    baked : Baked
        From `surftex.bake.bake.run`.
    folder : Path
        Where; a file of the same name is replaced.
    threads : int, optional
        None means every core; cannot change a byte.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    path : Path
        Of the file, in the file's own axes; millimetres, or metres for GLB, which names colour and roughness beside it.

    Raises
    ------
    InputError
        If the layers make no height, or the edges asked for take too many faces.
    """
    from surftex.files.meshout import write_mesh
    from surftex.maps.displace import displaced

    if "height_mm" not in baked.stack.channels:
        raise InputError("no layer makes a height, so there is nothing to displace")
    surface, atlas = baked.maps.surface, baked.maps.atlas

    def height_at(samples: Samples) -> NDArray[Any]:
        found = slices(
            lambda first, last: baked.stack.at(samples.part(first, last), ("height_mm",))["height_mm"],
            len(samples),
            size=_SLICE,
            threads=threads,
            tick=tick,
        )
        return np.concatenate(found)

    edge_mm = baked.recipe.bake.displaced_edge
    if edge_mm is None:
        texel_mm = 1 / atlas.texels_per_mm(surface, baked.recipe.bake.resolution)
        edge_mm = max(_EDGE_TEXELS * texel_mm, float(np.sqrt(surface.area_mm2 / (0.25 * _USUAL_FACES))))
    mesh = displaced(surface, height_at, edge_mm=edge_mm, corner_uv=atlas.corner_uv)
    path = folder / baked.displaced_name
    stem, beside = baked.maps.stem, set(baked.maps.file_names)
    pictures = {role: f"{stem}_{role}.png" for role in ("base_color", "roughness")}
    pictures = {role: file for role, file in pictures.items() if file in beside}
    write_mesh(path, mesh.vertices + surface.origin_mm, mesh.faces, mesh.uv, pictures)
    return path
