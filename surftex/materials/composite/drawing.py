"""Drawing a learnt texture on a surface: lattice, walks, sweeps, and pictures for whoever reads it."""

from collections.abc import Callable, Mapping
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.charts.surface_lattice import SurfaceLattice
from surftex.errors import InputError, RecipeError
from surftex.exemplar.bands import Bands
from surftex.exemplar.lattice import MISSING, Table
from surftex.exemplar.model import TextureModel
from surftex.exemplar.relaxation import asked_offsets
from surftex.exemplar.smoothing import NEXT, within_levels
from surftex.exemplar.store import SUFFIXES, load_model
from surftex.geodesics.directions import DirectionField
from surftex.kernels.pool import PartTick
from surftex.materials.composite.model import Composite
from surftex.materials.composite.pattern import CompositePattern
from surftex.materials.parameters import linear_from_srgb
from surftex.materials.presets import shelved
from surftex.randomness import stream
from surftex.surface.surface import Surface

MOST_WALKS = 2**29
"""Most entries of the table of neighbours, 4 bytes each."""


def place(
    composite: Composite,
    surface: Surface,
    seed: int,
    *,
    fields: Any = None,
    features: Mapping[str, NDArray[Any]] | None = None,
    max_features: int = 5_000_000,
    threads: int | None = None,
    tick: Callable[..., None] | None = None,
) -> CompositePattern:
    """Draw the texture, or take an earlier drawing; the parameters are those of `Composite.place`.

    Parameters
    ----------
    composite : Composite
        What to draw.
    surface : Surface
        Where.
    seed : int
        Of everything random.
    fields : FieldSet, optional
        The recipe's.
    features : mapping of str to structured array, optional
        Of an earlier drawing.
    max_features : int
        Most pixels.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    pattern : CompositePattern
        Ready to answer.

    Raises
    ------
    InputError
        If the model cannot be read.
    RecipeError
        If there would be too many pixels, or a field does not fit.
    """
    model = named_model(composite.model)
    expected = int(surface.area_mm2 / composite.pixel_size**2)
    offset = asked_offsets(model.target)
    most = min(max_features, MOST_WALKS // len(offset))
    if expected > most:
        least = float(np.sqrt(surface.area_mm2 / most))
        raise RecipeError(
            f"pixels of {composite.pixel_size:.4g} mm on {surface.area_mm2:.4g} mm^2 are {expected}, more than {most}; "
            f"make pixel_size {1.02 * least:.3g} mm or more"
        )
    directions = _directions(composite, surface, fields)
    lattice = SurfaceLattice.of(surface, directions, composite.pixel_size, threads=threads)
    if features is not None:
        level = _given(features, lattice, model)
    else:
        near = lattice.table(
            offset, stream(seed, "composite", "steps"), threads=threads, tick=PartTick(tick, 0.05, 0.2)
        )
        level = model.levels_on(
            Table(offset, near),
            seed,
            sweeps=composite.sweeps,
            threads=threads,
            tick=PartTick(tick, 0.2, 0.95),
        )[:, :-1]
    around = Table(NEXT, lattice.table(NEXT, stream(seed, "composite", "steps"), threads=threads))
    held = np.pad(level, ((0, 0), (0, 1)), constant_values=MISSING)
    number = within_levels(around, held, stream(seed, "exemplar", "within"))
    value = _channels(composite, model.bands, model.bands.numbers_of(number) / 255)
    columns = np.column_stack([value[name] for name in value]).astype(np.float32)
    widths = {name: 1 if each.ndim == 1 else each.shape[1] for name, each in value.items()}
    table = np.zeros(
        len(lattice), [("face", np.int32), ("barycentric", np.float64, 3), ("level", np.uint8, len(level))]
    )
    table["face"], table["barycentric"], table["level"] = (
        lattice.points.face,
        lattice.points.barycentric,
        level.T,
    )
    return CompositePattern(composite, lattice.image(columns), widths, {"pixel": table})


def named_model(name: str) -> TextureModel:
    """Read the model that a recipe names.

    Parameters
    ----------
    name : str
        A file's path, or the name of one on the shelf.

    Returns
    -------
    model : TextureModel
        Checked.

    Raises
    ------
    InputError
        If there is none, or it is damaged.
    """
    if Path(name).suffix.lower() in SUFFIXES:
        return _texture(load_model(name), name)
    known = shelved("composite", SUFFIXES[0])
    if name not in known:
        raise InputError(
            f"there is no model {name!r} on the shelf, which holds {', '.join(known)}; a file's name ends in "
            f"{' or '.join(SUFFIXES)}"
        )
    with as_file(files("surftex.materials.presets").joinpath("composite", name + SUFFIXES[0])) as path:
        return _texture(load_model(path), name)


def _texture(model: object, name: str) -> TextureModel:
    if not isinstance(model, TextureModel):
        raise InputError(f"{name}: is no plain texture")
    return model


def _directions(composite: Composite, surface: Surface, fields: Any) -> DirectionField:
    if composite.direction is None:
        return DirectionField.smoothest(surface)
    if fields is None:
        raise RecipeError(f"the direction {composite.direction!r} needs the fields of a recipe")
    return fields.direction(composite.direction)


def _given(
    features: Mapping[str, NDArray[Any]], lattice: SurfaceLattice, model: TextureModel
) -> NDArray[np.uint8]:
    table = features.get("pixel")
    if table is None or len(table) != len(lattice) or table["level"].shape[1:] != (model.target.bands,):
        raise InputError(
            "the features hold no pixels of this texture on this surface; was it drawn from another recipe?"
        )
    level = np.ascontiguousarray(table["level"].T, np.uint8)
    if (level >= model.target.levels).any():
        raise InputError(
            f"the features hold levels beyond the {model.target.levels} of the model; draw it anew"
        )
    return level


def _channels(
    composite: Composite, bands: Bands, value: NDArray[np.float64]
) -> dict[str, NDArray[np.floating]]:
    """Turn numbers from 0 to 1 at the sites, (n, c), into the channels of a material."""
    shown = np.clip(value[:, : bands.shown], 0, 1)
    color = linear_from_srgb(shown if bands.colored else np.repeat(shown, 3, axis=1))
    names = bands.names[bands.shown :]
    result: dict[str, NDArray[np.floating]] = {"base_color": color}
    if composite.relief > 0:
        height = value[:, bands.shown + names.index("height")] if "height" in names else shown.mean(axis=1)
        low, high = np.percentile(height, [0.5, 99.5])
        share = np.clip((height - low) / max(float(high - low), 1e-9), 0, 1)
        result["height_mm"] = composite.relief * (share - 0.5)
    if "roughness" in names:
        result["roughness"] = np.clip(value[:, bands.shown + names.index("roughness")], 0, 1)
    return result
