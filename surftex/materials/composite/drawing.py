"""Drawing a learnt texture on a surface: lattice, walks, sweeps, and pictures for whoever reads it."""

from collections.abc import Callable, Mapping
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.charts.surface_lattice import SurfaceLattice, lattice_atlas
from surftex.errors import InputError, RecipeError
from surftex.exemplar.bands import Bands
from surftex.exemplar.composite import CompositeModel
from surftex.exemplar.labels import LabelModel
from surftex.exemplar.lattice import MISSING, Table
from surftex.exemplar.model import TextureModel
from surftex.exemplar.relaxation import asked_offsets
from surftex.exemplar.smoothing import NEXT, within_levels
from surftex.exemplar.store import SUFFIXES, Model, load_model
from surftex.geodesics.directions import DirectionField
from surftex.kernels.pool import PartTick
from surftex.materials.composite.labelling import LEAST_SITES, site_labels
from surftex.materials.composite.model import Composite
from surftex.materials.composite.pattern import CompositePattern
from surftex.materials.limits import Expected, refuse_more
from surftex.materials.parameters import linear_from_srgb
from surftex.materials.presets import shelved
from surftex.randomness import stream
from surftex.surface.surface import Surface

Texture = TextureModel | CompositeModel

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
    if not isinstance(model, CompositeModel) and (composite.labels is not None or composite.age != 0):
        raise RecipeError("labels and age are for composites; this model is one texture")
    refuse_more("composite", expected_features(composite, model, surface), surface.area_mm2, max_features)
    offset = asked_offsets(model.target)
    lattices = _lattices(composite, surface, model, _directions(composite, surface, fields), threads)
    lattice = lattices[0]
    if features is not None:
        level, label = _given(features, lattice, model)
    else:
        label = np.zeros(len(lattice), np.uint8)
        if isinstance(model, CompositeModel):
            label = site_labels(composite, model, lattices, seed, fields=fields, threads=threads)
        steps = stream(seed, "composite", "steps")
        table = Table(offset, lattice.table(offset, steps, threads=threads, tick=PartTick(tick, 0.1, 0.25)))
        level = _levels(composite, model, table, label, seed, threads, PartTick(tick, 0.25, 0.95))
    around = Table(NEXT, lattice.table(NEXT, stream(seed, "composite", "steps"), threads=threads))
    held = np.pad(level, ((0, 0), (0, 1)), constant_values=MISSING)
    number = within_levels(around, held, stream(seed, "exemplar", "within"), np.append(label, np.uint8(0)))
    value = _channels(composite, model.bands, model.bands.numbers_of(number, label) / 255)
    columns = np.column_stack([value[name] for name in value]).astype(np.float32)
    widths = {name: 1 if each.ndim == 1 else each.shape[1] for name, each in value.items()}
    return CompositePattern(
        composite, lattice.image(columns), widths, {"pixel": _pixels(lattice, level, label)}, lattice,
        label if isinstance(model, CompositeModel) else None,
    )  # fmt: skip


def expected_features(composite: Composite, model: Texture, surface: Surface) -> tuple[Expected, ...]:
    """Tell about how many pixels would be drawn.

    Parameters
    ----------
    composite : Composite
        What would be drawn.
    model : TextureModel or CompositeModel
        From `named_model`.
    surface : Surface
        Where.

    Returns
    -------
    expected : tuple of Expected
        Pixels; what walks between them fill bounds them as well.
    """
    with np.errstate(divide="ignore", over="ignore"):
        count = float(surface.area_mm2 / np.square(composite.pixel_size))
    most = MOST_WALKS // len(asked_offsets(model.target))
    return (Expected("pixel", count, "pixel_size", composite.pixel_size, -2, most),)


def _lattices(
    composite: Composite, surface: Surface, model: Model, directions: DirectionField, threads: int | None
) -> list[SurfaceLattice]:
    """Lay out the lattice of the pixels, and coarser ones for a layout that is drawn."""
    atlas = lattice_atlas(surface)
    lattices = [SurfaceLattice.of(surface, directions, composite.pixel_size, atlas=atlas, threads=threads)]
    if isinstance(model, CompositeModel):
        drawn = [] if composite.labels is not None else model.layout.models()
        drawn += [] if model.over is None else [model.over]
        for scale in range(1, max([len(each.targets) for each in drawn], default=1)):
            pitch = composite.pixel_size * 2**scale
            if surface.area_mm2 < LEAST_SITES * pitch**2:
                break
            lattices.append(SurfaceLattice.of(surface, directions, pitch, atlas=atlas, threads=threads))
    return lattices


def _levels(
    composite: Composite, model: Texture, table: Table, label: NDArray[np.uint8], seed: int,
    threads: int | None, tick: PartTick,
) -> NDArray[np.uint8]:  # fmt: skip
    if isinstance(model, CompositeModel):
        group = np.append(label, np.uint8(0))
        level = model.levels_on(table, seed, group, sweeps=composite.sweeps, threads=threads, tick=tick)
    else:
        level = model.levels_on(table, seed, sweeps=composite.sweeps, threads=threads, tick=tick)
    return level[:, :-1]


def _pixels(lattice: SurfaceLattice, level: NDArray[np.uint8], label: NDArray[np.uint8]) -> NDArray[Any]:
    table = np.zeros(
        len(lattice),
        [
            ("face", np.int32),
            ("barycentric", np.float64, 3),
            ("level", np.uint8, len(level)),
            ("label", np.uint8),
        ],
    )
    table["face"], table["barycentric"] = lattice.points.face, lattice.points.barycentric
    table["level"], table["label"] = level.T, label
    return table


def named_model(name: str) -> Texture:
    """Read the model that a recipe names.

    Parameters
    ----------
    name : str
        A file's path, or the name of one on the shelf.

    Returns
    -------
    model : TextureModel or CompositeModel
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


def _texture(model: Model, name: str) -> Texture:
    if isinstance(model, LabelModel):
        raise InputError(f"{name}: is a layout without textures; learn a picture with it (--labels)")
    return model


def _directions(composite: Composite, surface: Surface, fields: Any) -> DirectionField:
    if composite.direction is None:
        return DirectionField.smoothest(surface)
    if fields is None:
        raise RecipeError(f"the direction {composite.direction!r} needs the fields of a recipe")
    return fields.direction(composite.direction)


def _given(
    features: Mapping[str, NDArray[Any]], lattice: SurfaceLattice, model: Texture
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
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
    return level, np.ascontiguousarray(table["label"], np.uint8)


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
