"""Placing a skin: points by likelihood and area, vessels that fork, wrinkles along a direction; a stream for each."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from surftex.errors import RecipeError, naming
from surftex.features.uniform import scatter
from surftex.fields.fieldset import FieldSet
from surftex.fields.sources import Field, SpannedField
from surftex.fields.vectors import VectorField
from surftex.geodesics.directions import DirectionField
from surftex.kernels.pool import Tick
from surftex.materials.limits import Expected, refuse_more
from surftex.materials.skin.kinds import KINDS, setting
from surftex.materials.skin.lines import FORKS, drawn_lines, vessels, wrinkles
from surftex.materials.skin.model import Skin
from surftex.randomness import stream
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface


def place(
    skin: Skin,
    surface: Surface,
    seed: int,
    *,
    fields: FieldSet,
    max_features: int,
    threads: int | None,
    tick: Tick | None,
) -> dict[str, NDArray]:
    """Place every feature.

    Parameters
    ----------
    skin : Skin
        What to place.
    surface : Surface
        Where.
    seed : int
        Of all streams.
    fields : FieldSet
        Named numbers and directions.
    max_features : int
        Refuse beyond it.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    features : dict of str to structured array
        By kind; each row has `face` and `barycentric`.
    """
    _check_order(skin)
    refuse_more("skin", expected_features(skin, surface, fields), surface.area_mm2, max_features)
    told = tick or (lambda share: None)
    features: dict[str, NDArray] = {}
    for i, kind in enumerate(KINDS):
        features[kind] = _points(skin, surface, seed, fields, kind)
        told(0.8 * (i + 1) / len(KINDS))
    where = likelihood(skin, fields, "vessel")
    features["vessel"] = vessels(skin, surface, where, stream(seed, "skin", "vessel"), threads)
    where = likelihood(skin, fields, "wrinkle")
    along = _wrinkle_field(skin, fields)
    features["wrinkle"] = wrinkles(skin, surface, where, along, stream(seed, "skin", "wrinkle"), threads)
    if skin.wrinkle_curves is not None:
        drawn = drawn_lines(fields.curves(skin.wrinkle_curves), stream(seed, "skin", "drawn wrinkles"))
        drawn["curve"] += int(features["wrinkle"]["curve"].max(initial=-1)) + 1
        features["wrinkle"] = np.concatenate([features["wrinkle"], drawn])
    told(1.0)
    return {kind: table for kind, table in features.items() if len(table)}


def likelihood(skin: Skin, fields: FieldSet, kind: str) -> Field | None:
    """Read how likely features of a kind are.

    Parameters
    ----------
    skin : Skin
        The parameters.
    fields : FieldSet
        What expressions name.
    kind : str
        Such as ``freckle``.

    Returns
    -------
    field : Field or None
        Below 0 it counts as 0; None means 1 everywhere.

    Raises
    ------
    RecipeError
        If the expression is wrong; the message names the parameter.
    """
    value = setting(skin, kind, "where")
    return None if value == 1 else read(fields, value, f"{kind}_where")


def read(fields: FieldSet, value: float | str, key: str) -> Field:
    """Read a number or an expression.

    Parameters
    ----------
    fields : FieldSet
        What expressions name.
    value : float or str
        Of a parameter.
    key : str
        Its name, for the message.

    Returns
    -------
    field : Field
        Of points; where it has no finite value, its message names the parameter too.

    Raises
    ------
    RecipeError
        If the expression is wrong; the message names the parameter.
    """
    name = f"skin.{key}"
    with naming(name):
        field = fields.scalar(value)

    def at(points: SurfacePoints, footprint_mm: NDArray | float = 0.0) -> NDArray[np.float64]:
        with naming(name):
            return field(points, footprint_mm)

    return SpannedField(at, field.span)


def tension(skin: Skin, surface: Surface, fields: FieldSet) -> DirectionField:
    """Lines of tension of the skin: those asked for, or where the surface bends least.

    Parameters
    ----------
    skin : Skin
        The parameters.
    surface : Surface
        Where it lies.
    fields : FieldSet
        Named directions.

    Returns
    -------
    direction : DirectionField
        Only its line matters.
    """
    if skin.relief_direction is not None:
        return fields.direction(skin.relief_direction)
    return DirectionField.from_curvature(surface, "min")


def _wrinkle_field(skin: Skin, fields: FieldSet) -> Callable[[], DirectionField | VectorField]:
    if (vectors := skin.wrinkle_vectors) is not None:
        return lambda: fields.vectors(vectors)
    if (direction := skin.wrinkle_direction) is not None:
        return lambda: fields.direction(direction)
    return lambda: DirectionField.smoothest(fields.surface)


def _points(skin: Skin, surface: Surface, seed: int, fields: FieldSet, kind: str) -> NDArray:
    """Rows of one kind: a count and a density, thinned by its likelihood."""
    where = likelihood(skin, fields, kind)
    count, density = setting(skin, kind, "count"), setting(skin, kind, "density")
    power = skin.freckle_gather if kind == "freckle" else 1.0
    parts: list[SurfacePoints] = []
    with naming(f"skin.{kind}_where"):
        if count:
            random = stream(seed, "skin", kind, "count")
            parts.append(scatter(surface, random, count=count, weight=where, power=power))
        if density:
            random = stream(seed, "skin", kind, "density")
            parts.append(scatter(surface, random, density_per_mm2=density, weight=where, power=power))
    if kind == "mole" and skin.mole_points is not None:
        parts.append(fields.points(skin.mole_points))
    face = np.concatenate([np.zeros(0, np.int32), *[part.face for part in parts]])
    barycentric = np.concatenate([np.zeros((0, 3)), *[part.barycentric for part in parts]])
    columns = KINDS[kind].columns(skin, stream(seed, "skin", kind, "parameters"), len(face))
    if KINDS[kind].lean(skin) != 1 and len(face):
        points = SurfacePoints.trusted(face, barycentric)
        columns["angle_rad"] = _lean_angle(skin, surface, seed, fields, kind, points)
    names = [("face", "i4"), ("barycentric", "f8", 3), *[(name, "f4") for name in columns]]
    table = np.zeros(len(face), np.dtype(names))
    table["face"], table["barycentric"] = face, barycentric
    for name, column in columns.items():
        table[name] = column
    return table


def _lean_angle(
    skin: Skin, surface: Surface, seed: int, fields: FieldSet, kind: str, points: SurfacePoints
) -> NDArray[np.float64]:
    """Long axis of each feature: hair lies along its field, pores along the tension, scars as they fell."""
    if kind == "scar":
        return 2 * np.pi * stream(seed, "skin", "scar", "direction").uniform(len(points))[:, 0]
    if kind == "follicle":
        name = skin.follicle_direction
        field = fields.direction(name) if name else DirectionField.smoothest(surface)
    else:
        field = tension(skin, surface, fields)
    return field.angle_rad[points.face]


def _check_order(skin: Skin) -> None:
    if sorted(skin.order) != sorted(KINDS):
        raise RecipeError(
            f"skin.order: it lists {', '.join(skin.order)}; it takes each of {', '.join(KINDS)} once"
        )


def expected_features(skin: Skin, surface: Surface, fields: FieldSet) -> tuple[Expected, ...]:
    """Tell about how many features would be placed.

    Parameters
    ----------
    skin : Skin
        What would be placed.
    surface : Surface
        Where.
    fields : FieldSet
        With what is drawn and picked.

    Returns
    -------
    expected : tuple of Expected
        Of each kind; as many as there are where they are likely everywhere.

    Raises
    ------
    RecipeError
        If it names curves or places that there are not.
    """
    forks = sum((2 * FORKS) ** i for i in range(skin.vessel_branches + 1))
    each = {**dict.fromkeys(KINDS, (1.0, 1.0)), "vessel": (forks, forks / 1000), "wrinkle": (1.0, 1 / 1000)}
    expected = [
        Expected(kind, setting(skin, kind, key) * factor, f"{kind}_{key}", setting(skin, kind, key))
        for kind, (of_count, per_mm2) in each.items()
        for key, factor in (("count", of_count), ("density", per_mm2 * surface.area_mm2))
    ]
    if skin.mole_points is not None:
        picked = len(fields.points(skin.mole_points))
        expected.append(Expected("mole", picked, "mole_points", skin.mole_points))
    if skin.wrinkle_curves is not None:
        drawn = len(np.unique(fields.curves(skin.wrinkle_curves)["curve"]))
        expected.append(Expected("wrinkle", drawn, "wrinkle_curves", skin.wrinkle_curves))
    return tuple(expected)
