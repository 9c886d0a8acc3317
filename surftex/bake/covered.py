"""Where a layer can be seen: it is placed on the bodies of the mesh that its mask covers, and on no others.

Which bodies those are follows from the spans of the mask alone: one is left out where interval arithmetic proves the
mask to be 0 on every face of it, whatever is asked there later.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surftex.fields.fieldset import FieldSet
from surftex.fields.sources import Field, carried
from surftex.geodesics.directions import DirectionField
from surftex.kernels.pool import PartTick, Tick
from surftex.materials.layers import CHANNELS, Layers, Pattern, Reshaping
from surftex.surface.bodies import Bodies
from surftex.surface.points import Samples, SurfacePoints
from surftex.surface.surface import Surface
from surftex.words import by_count

Features = Mapping[str, NDArray]


def covered_bodies(surface: Surface, fields: FieldSet, mask: str | float) -> NDArray[np.bool_]:
    """Tell which bodies a mask may cover.

    Parameters
    ----------
    surface : Surface
        With c components.
    fields : FieldSet
        What the mask names.
    mask : str or float
        Of a layer.

    Returns
    -------
    covered : (c,) bool
        False where the mask is 0 or less at every point of the body, and at every footprint.

    Raises
    ------
    RecipeError
        If the mask is no expression over the fields.
    """
    count = int(surface.component.max()) + 1
    if mask == 1:
        return np.ones(count, bool)
    field, covered, surely = fields.scalar(mask), np.zeros(count, bool), np.zeros(count, bool)
    low, high = field.span()
    covered[surface.component[high > 0]] = True
    surely[surface.component[low > 0]] = True
    if field.narrow is not None and (covered & ~surely).any():
        covered[:] = False
        covered[surface.component[field.narrow()[1] > 0]] = True
    return covered


def holding(surface: Surface, features: Features) -> NDArray[np.bool_]:
    """Tell which bodies hold features.

    Parameters
    ----------
    surface : Surface
        With c components.
    features : mapping of str to structured array
        By kind, with faces of the surface.

    Returns
    -------
    holding : (c,) bool
        Whether any row lies on it.
    """
    result = np.zeros(int(surface.component.max()) + 1, bool)
    for table in features.values():
        result[surface.component[table["face"]]] = True
    return result


def fields_on(bodies: Bodies, fields: FieldSet) -> FieldSet:
    """Carry the fields of the whole over to some bodies; they have the values they have there.

    Parameters
    ----------
    bodies : Bodies
        Where to.
    fields : FieldSet
        Of the whole.

    Returns
    -------
    fields : FieldSet
        Of the same names, directions, curves and places; of the last two those on the bodies.
    """

    def direction(name: str) -> Any:
        from surftex.fields.vectors import VectorField

        found = fields.made_direction(name)
        if isinstance(found, VectorField):
            at = found.at
            return VectorField(bodies.surface, lambda points: at(bodies.points_there(points)))
        return DirectionField(bodies.surface, found.symmetry, found.vertex_value[bodies.vertex])

    def each(make: Callable[[str], Any], names: tuple[str, ...]) -> dict[str, Callable[[], Any]]:
        return {name: (lambda name=name: make(name)) for name in names}

    return FieldSet(
        bodies.surface,
        {name: carried(fields.scalar(name), bodies.face) for name in fields.names},
        each(direction, fields.direction_names),
        each(lambda name: bodies.curves_here(fields.curves(name)), fields.curve_names),
        each(lambda name: bodies.points_here(fields.points(name)), fields.point_names),
    )


def drawn_elsewhere(
    bodies: Bodies, fields: FieldSet, curves: Iterable[str], places: Iterable[str] = ()
) -> tuple[str, ...]:
    """Tell of what was drawn where a layer does not lie.

    Parameters
    ----------
    bodies : Bodies
        Where it lies.
    fields : FieldSet
        Of the whole.
    curves : iterable of str
        Names of those that the layer draws.
    places : iterable of str
        Names of those that it puts something at.

    Returns
    -------
    warnings : tuple of str
        A line for each name of which some are lost.
    """
    strokes = ((name, fields.curves(name)) for name in curves)
    spots = ((name, fields.points(name).face) for name in places)
    said = []
    for name, kind, face, own in (
        *((name, "stroke", table["face"], table["curve"]) for name, table in strokes),
        *((name, "place", face, np.arange(len(face))) for name, face in spots),
    ):
        every, lost = len(np.unique(own)), len(np.unique(own[bodies.own[face] < 0]))
        if lost:
            whole = by_count(every, f"{{}} {kind}", f"{{}} {kind}s")
            lie = "lies on a body" if lost == 1 else "lie on bodies"
            said.append(f"{lost} of {whole} of {name!r} {lie} that this layer does not cover")
    return tuple(said)


@dataclass(frozen=True, eq=False)
class OnBodies:
    """A pattern that lies on some bodies of a surface, and answers on all of it: 0 elsewhere, where nothing of it is seen.

    Attributes
    ----------
    bodies : Bodies
        Where it lies.
    pattern : Pattern
        Placed on ``bodies.surface``.
    features : mapping of str to structured array
        What was placed, by kind, with the faces of the whole.
    lost : tuple of str
        What was drawn for it on other bodies, a line each.
    """

    bodies: Bodies
    pattern: Pattern
    features: Features
    lost: tuple[str, ...] = ()

    @staticmethod
    def of(bodies: Bodies, pattern: Pattern, lost: tuple[str, ...] = ()) -> "OnBodies":
        """Make one that can be reshaped where the pattern can.

        Parameters
        ----------
        bodies : Bodies
            Where it lies.
        pattern : Pattern
            Placed on ``bodies.surface``.
        lost : tuple of str
            What was drawn for it on other bodies.

        Returns
        -------
        pattern : OnBodies
            On the whole.
        """
        kind = ReshapingOnBodies if isinstance(pattern, Reshaping) else OnBodies
        return kind(bodies, pattern, bodies.rows_there(pattern.features), lost)

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that `at` answers with."""
        return self.pattern.channels

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the pattern says of itself, and what of it is lost."""
        return self.lost + getattr(self.pattern, "warnings", ())

    @property
    def ranges(self) -> Mapping[str, tuple[float, float]]:
        """What looks are known for, by channel, where the pattern knows."""
        return getattr(self.pattern, "ranges", {})

    def at(self, samples: Samples) -> Layers:
        """Evaluate at samples.

        Parameters
        ----------
        samples : Samples
            n points of the whole.

        Returns
        -------
        layers : Layers
            Of the pattern.
        """
        here, rows = self.bodies.samples_here(samples)
        return _spread(self.pattern.at(here), rows, len(samples))


class ReshapingOnBodies(OnBodies):
    """One whose pattern answers in two steps; see `Reshaping`."""

    pattern: Any

    def gather(self, samples: Samples) -> Any:
        """Measure what takes time.

        Parameters
        ----------
        samples : Samples
            n points of the whole.

        Returns
        -------
        gathered : tuple
            For `shape`.
        """
        here, rows = self.bodies.samples_here(samples)
        return self.pattern.gather(here), rows

    def shape(self, gathered: Any, footprint_mm: NDArray[np.float32]) -> Layers:
        """Turn what was gathered into channels.

        Parameters
        ----------
        gathered : tuple
            From `gather`.
        footprint_mm : (n,) float32
            Side of each sample's patch.

        Returns
        -------
        layers : Layers
            Of the pattern.
        """
        measured, rows = gathered
        part = footprint_mm if rows is None else footprint_mm[rows]
        return _spread(self.pattern.shape(measured, part), rows, len(footprint_mm))

    def reshaped(self, material: Any) -> "ReshapingOnBodies | None":
        """Take over another material of the same kind.

        Parameters
        ----------
        material : Any
            Of the pattern's kind.

        Returns
        -------
        pattern : ReshapingOnBodies or None
            None where `gather` would answer otherwise.
        """
        pattern = self.pattern.reshaped(material)
        return None if pattern is None else replace(self, pattern=pattern)

    def keeps(self, material: Any) -> bool:
        """Tell whether another material of the same kind would place the same features.

        Parameters
        ----------
        material : Any
            Of the pattern's kind.

        Returns
        -------
        keeps : bool
            On the same bodies.
        """
        return self.pattern.keeps(material)


@dataclass(frozen=True, eq=False)
class Uncovered:
    """A layer whose mask covers nothing, of which nothing is placed.

    Attributes
    ----------
    channels : tuple of str
        That it would write.
    """

    channels: tuple[str, ...]
    warnings = ("its mask is 0 everywhere, so nothing of it is placed",)

    @property
    def features(self) -> Features:
        """Nothing."""
        return {}

    def at(self, samples: Samples) -> Layers:
        """Evaluate at samples.

        Parameters
        ----------
        samples : Samples
            n points.

        Returns
        -------
        layers : Layers
            Zeros, which the mask hides.
        """
        nowhere, count = np.zeros(0, np.int64), len(samples)
        empty = {
            name: np.zeros(
                (0, CHANNELS[name])[: 1 + (CHANNELS[name] > 1)], np.int32 if name == "region" else np.float32
            )
            for name in self.channels
        }
        return _spread(Layers(empty), nowhere, count)


def bodies_of(pattern: Any) -> tuple[int, ...] | None:
    """Tell on which bodies a pattern was placed.

    Parameters
    ----------
    pattern : Pattern
        Of a layer.

    Returns
    -------
    number : tuple of int or None
        Components, ascending; None for all.
    """
    if isinstance(pattern, Uncovered):
        return ()
    return pattern.bodies.number if isinstance(pattern, OnBodies) else None


def mask_on(pattern: Pattern, fields: FieldSet, mask: str | float) -> Field | None:
    """Read the mask of a layer that was placed.

    Parameters
    ----------
    pattern : Pattern
        Of the layer.
    fields : FieldSet
        Of the whole.
    mask : str or float
        Of the layer.

    Returns
    -------
    mask : Field or None
        None covers everything. Where a pattern does not lie it is 0 and no rounding of a comparison can make it more.
    """
    if mask == 1:
        return None
    field = fields.scalar(mask)
    if isinstance(pattern, Uncovered):
        return lambda points, footprint_mm=0.0: np.zeros(len(points))
    if not isinstance(pattern, OnBodies):
        return field
    own = pattern.bodies.own

    def on_bodies(points: SurfacePoints, footprint_mm: NDArray | float = 0.0) -> NDArray[np.float64]:
        return np.where(own[points.face] >= 0, field(points, footprint_mm), 0.0)

    return on_bodies


class BodiesTick(PartTick):
    """Tells of work on some bodies; what grows there is kept with the faces of the whole.

    Parameters
    ----------
    tick : callable or None
        Of the layer.
    bodies : Bodies
        Where it works.
    """

    def __init__(self, tick: Tick | None, bodies: Bodies) -> None:
        super().__init__(tick)
        self.bodies = bodies

    def keep(self, generation: int, last: int, make: Callable[[], Features]) -> None:
        """Hand on what has grown."""
        super().keep(generation, last, lambda: self.bodies.rows_there(make()))


def _spread(layers: Layers, rows: NDArray[np.int64] | None, count: int) -> Layers:
    """Put channels that were found for some rows among zeros; `rows` is None for all."""
    if rows is None:
        return layers

    def among(part: NDArray, fill: int) -> NDArray:
        whole = np.full((count, *part.shape[1:]), fill, part.dtype)
        whole[rows] = part
        return whole

    return Layers(
        {name: among(part, -1 if name == "region" else 0) for name, part in layers.channels.items()},
        {name: among(part, 0) for name, part in layers.clamped.items()},
    )
