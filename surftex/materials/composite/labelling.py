"""Labels on a surface: by masks, or drawn from the model's own layout; and how far what lies over them has grown."""

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.charts.surface_lattice import SurfaceLattice
from surftex.errors import RecipeError
from surftex.exemplar.composite import CompositeModel
from surftex.exemplar.erosion import MOST_STEPS, worn_after
from surftex.exemplar.labels import LabelModel
from surftex.exemplar.lattice import Table
from surftex.exemplar.relaxation import asked_offsets
from surftex.exemplar.smoothing import NEXT
from surftex.materials.composite.model import Composite
from surftex.randomness import stream

LEAST_SITES = 1500
"""Sites of the coarsest lattice that a layout is drawn on."""


def site_labels(
    composite: Composite,
    model: CompositeModel,
    lattices: list[SurfaceLattice],
    seed: int,
    *,
    fields: Any = None,
    threads: int | None = None,
) -> NDArray[np.uint8]:
    """Label every site.

    Parameters
    ----------
    composite : Composite
        Its masks and its age.
    model : CompositeModel
        Its layout.
    lattices : list of SurfaceLattice
        The finest first, each twice as coarse as the one before; at least one.
    seed : int
        Of everything random.
    fields : FieldSet, optional
        The recipe's.
    threads : int, optional
        None means every core; cannot change a label.

    Returns
    -------
    label : (n,) uint8
        Of the sites of the finest lattice.

    Raises
    ------
    RecipeError
        If the masks are not as many as the labels that they choose from, or an age has nothing that grows.
    """
    fine = lattices[0]
    if composite.labels is None:
        models = model.layout.models()
        label = model.layout.joined(
            [
                _drawn(each, lattices, stream(seed, "composite", "layout", k).key, threads)
                for k, each in enumerate(models)
            ]
        )
    else:
        label = _masked(composite.labels, model, fine, fields)
    if model.over is None:
        if composite.age != 0:
            raise RecipeError("age needs a model that something lies over; learn it with over (--over)")
        return label
    worn = _drawn(model.over, lattices, stream(seed, "composite", "over").key, threads) > 0
    steps = _number(composite.age, fine, fields) / composite.pixel_size
    back, on = (int(min(MOST_STEPS, max(0.0, np.ceil(each)))) for each in (-steps.min(), steps.max()))
    around = Table(NEXT, fine.table(NEXT, stream(seed, "composite", "steps"), threads=threads))
    age = worn_after(around, np.append(worn, False), back=back, on=on)
    return np.where(age <= steps, model.labels - 1, label).astype(np.uint8)


def _drawn(
    model: LabelModel, lattices: list[SurfaceLattice], seed: int, threads: int | None
) -> NDArray[np.uint8]:
    """Draw a layout from coarse to fine; scales with too few sites are left out."""
    count = min(len(model.targets), len(lattices))
    while count > 1 and len(lattices[count - 1]) < LEAST_SITES:
        count -= 1
    used = lattices[:count][::-1]
    model = LabelModel(model.targets[len(model.targets) - count :])
    tables = []
    for number, (target, lattice) in enumerate(zip(model.targets, used, strict=True)):
        offset = asked_offsets(target)
        tables.append(
            Table(offset, lattice.table(offset, stream(seed, "composite", "steps", number), threads=threads))
        )
    onto = [coarse.nearest(finer.points) for coarse, finer in itertools.pairwise(used)]
    return model.levels_on(tables, onto, seed, threads=threads)[0, :-1]


def _masked(
    masks: tuple[str, ...], model: CompositeModel, lattice: SurfaceLattice, fields: Any
) -> NDArray[np.uint8]:
    wanted = model.layout.leaves
    if len(masks) not in (wanted - 1, wanted):
        raise RecipeError(
            f"labels has {len(masks)} masks; the model has {wanted} labels: give a mask for each, or for all but the first"
        )
    values = [_number(mask, lattice, fields) for mask in masks]
    if len(masks) < wanted:
        values.insert(0, 1.0 - np.max(values, axis=0))
    return np.argmax(values, axis=0).astype(np.uint8)


def _number(value: str | float, lattice: SurfaceLattice, fields: Any) -> NDArray[np.float64]:
    if not isinstance(value, str):
        return np.full(len(lattice), float(value))
    if fields is None:
        raise RecipeError(f"{value!r} needs the fields of a recipe")
    return np.asarray(fields.scalar(value)(lattice.points, lattice.pitch_mm), np.float64)
