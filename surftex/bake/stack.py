"""The stack: patterns laid over one another by their masks, evaluated at samples."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surftex.bake.covered import (
    BodiesTick,
    OnBodies,
    Uncovered,
    covered_bodies,
    drawn_elsewhere,
    fields_on,
    holding,
    mask_on,
)
from surftex.bake.locating import located
from surftex.errors import InputError, RecipeError
from surftex.fields.fieldset import FieldSet
from surftex.fields.sources import Field
from surftex.kernels.pool import PartTick, Tick
from surftex.materials.layers import CHANNELS, Pattern
from surftex.randomness import stream
from surftex.recipe.layer import drawn_names
from surftex.recipe.model import Recipe
from surftex.surface.bodies import Bodies
from surftex.surface.points import Samples
from surftex.surface.surface import Surface

if TYPE_CHECKING:
    from surftex.bake.limits import Foreseen

Features = Mapping[str, NDArray]

_OTHER_LAYER = re.compile(r"layer\d+_")

BARE: Mapping[str, float] = {
    "height_mm": 0.0, "base_color": 0.5, "roughness": 0.5, "specular": 0.5, "metallic": 0.0, "region": -1,
}  # fmt: skip
"""What shows where no layer covers; 0 for all other channels."""


@dataclass(frozen=True, eq=False)
class Stack:
    """Patterns from the lowest to the topmost, each with its mask.

    Attributes
    ----------
    patterns : tuple of Pattern
        Placed on one surface.
    masks : tuple of Field or None
        How much each covers, 0 to 1; None covers everything.
    recipe : Recipe, optional
        Whose layers they are, for messages.
    """

    patterns: tuple[Pattern, ...]
    masks: tuple[Field | None, ...]
    recipe: Recipe | None = None

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels that any layer writes."""
        written = {channel for pattern in self.patterns for channel in pattern.channels}
        return tuple(channel for channel in CHANNELS if channel in written)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the patterns have to say of themselves, each with the layer it is of."""
        return tuple(
            f"{layer_label(self.recipe, i)}: {text}"
            for i, pattern in enumerate(self.patterns)
            for text in getattr(pattern, "warnings", ())
        )

    @property
    def features(self) -> dict[str, NDArray]:
        """Everything placed, by kind; kinds of the second layer are called ``layer2_pore`` and so on."""
        return {
            f"{_prefix(i)}{kind}": table
            for i, pattern in enumerate(self.patterns)
            for kind, table in pattern.features.items()
        }

    def at(
        self,
        samples: Samples,
        channels: tuple[str, ...],
        *,
        told: Callable[[Mapping[str, NDArray[np.bool_]]], None] | None = None,
    ) -> dict[str, NDArray[Any]]:
        """Evaluate at samples.

        Parameters
        ----------
        samples : Samples
            n points with their footprints.
        channels : tuple of str
            What to hand back.
        told : callable, optional
            Told of each layer where its channels left their range, by channel, (n,) bool; where its mask is 0
            it does not count.

        Returns
        -------
        values : dict of str to array
            (n,) or (n, 3) float32; ``region`` is int32.
        """
        count = len(samples)
        values: dict[str, NDArray[Any]] = {}
        for channel in channels:
            shape = (count,) if CHANNELS[channel] == 1 else (count, CHANNELS[channel])
            values[channel] = np.full(
                shape, BARE.get(channel, 0), np.int32 if channel == "region" else np.float32
            )
        for i, (pattern, mask) in enumerate(zip(self.patterns, self.masks, strict=True)):
            with located(self.recipe, "layer", i, "mask", label=f"{layer_label(self.recipe, i)}.mask"):
                cover = covering(mask, samples)
            asked, rows = samples, None  # a layer is asked only where it covers something
            if cover is not None and not cover.all():
                rows = np.flatnonzero(cover)
                asked, cover = samples.taken(rows), cover[rows]
            if not len(asked):
                continue
            with located(self.recipe, "layer", i, label=layer_label(self.recipe, i)):
                layers = pattern.at(asked)
            if told is not None and layers.clamped:
                told({name: _spread(at, rows, np.zeros(count, bool)) for name, at in layers.clamped.items()})
            for channel in channels:
                if channel in layers:
                    below = values[channel] if rows is None else values[channel][rows]
                    values[channel] = _spread(laid_over(below, layers[channel], cover), rows, values[channel])
        return values


def covering(mask: Field | None, samples: Samples) -> NDArray[np.float32] | None:
    """Ask a mask how much its layer covers.

    Parameters
    ----------
    mask : Field or None
        Of a layer.
    samples : Samples
        n points.

    Returns
    -------
    cover : (n,) float32 or None
        0 to 1; None covers everything.
    """
    if mask is None:
        return None
    return np.clip(mask(samples.points, samples.footprint_mm), 0, 1).astype(np.float32)


def laid_over(below: NDArray[Any], above: NDArray[Any], cover: NDArray[np.float32] | None) -> NDArray[Any]:
    """Lay one channel of a layer over what lies below.

    Parameters
    ----------
    below : (n,) or (n, 3) array
        What is there.
    above : (n,) or (n, 3) array
        What the layer writes.
    cover : (n,) float32 or None
        How much the layer covers.

    Returns
    -------
    values : (n,) or (n, 3) array
        Mixed; of ids, that which covers at least half.
    """
    if cover is None:
        return above
    if below.dtype.kind == "i":
        return np.where(cover >= 0.5, above, below)
    share = cover if below.ndim == 1 else cover[:, None]
    return below * (1 - share) + above * share


def _spread(part: NDArray[Any], rows: NDArray[np.integer] | None, whole: NDArray[Any]) -> NDArray[Any]:
    """Put what was found for some rows into a copy of the whole; `rows` is None for all."""
    if rows is None:
        return part
    result = whole.astype(np.result_type(whole, part))
    result[rows] = part
    return result


def place_stack(
    recipe: Recipe,
    surface: Surface,
    fields: FieldSet,
    *,
    features: Features | None = None,
    begun: Features | None = None,
    foreseen: "list[Foreseen] | None" = None,
    threads: int | None = None,
    tick: Tick | None = None,
) -> Stack:
    """Place every layer of a recipe on a surface.

    Parameters
    ----------
    recipe : Recipe
        What to place.
    surface : Surface
        Where.
    fields : FieldSet
        The recipe's fields on that surface.
    features : mapping of str to structured array, optional
        Take these, as `Stack.features` had them, and place nothing anew.
    begun : mapping of str to structured array, optional
        Growths to go on from, named in the same way.
    foreseen : list of Foreseen, optional
        From `surftex.bake.limits.foresee`, if it is known already, and not too many.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    stack : Stack
        Ready to be asked.

    Raises
    ------
    RecipeError
        If a layer does not fit the surface, or all together would lay too many features; the message names it.
    """
    from surftex.bake.limits import foresee, refuse_too_many

    patterns, masks = [], []
    count, left = len(recipe.layer), recipe.bake.max_features
    if features is not None:
        foreseen = []
    elif foreseen is None:
        foreseen = foresee(recipe, surface, fields)
        refuse_too_many(recipe, foreseen)
    for i in range(count):
        given = _named_for(begun or {}, i) or None
        if features is not None:
            given = _named_for(features, i)
            if not given and layer_cover(recipe, i, surface, fields).any():
                raise RecipeError(
                    f"{layer_label(recipe, i)}: the features file holds nothing for this layer; was it baked from another "
                    "recipe?"
                )
        if given is not None:
            _check_given(surface, given, layer_label(recipe, i))
        told = _LayerTick(tick, i, count)
        pattern, mask = place_layer(
            recipe, i, surface, fields, features=given, max_features=max(left, 1), threads=threads, tick=told
        )
        told_before = foreseen and foreseen[i].expected is not None
        left -= round(foreseen[i].count) if told_before else counted(pattern.features)
        patterns.append(pattern)
        masks.append(mask)
    return Stack(tuple(patterns), tuple(masks), recipe)


def place_layer(
    recipe: Recipe,
    index: int,
    surface: Surface,
    fields: FieldSet,
    *,
    features: Features | None = None,
    max_features: int | None = None,
    threads: int | None = None,
    tick: Tick | None = None,
) -> tuple[Pattern, Field | None]:
    """Place one layer of a recipe on the bodies of a surface that its mask covers.

    Parameters
    ----------
    recipe : Recipe
        What to place.
    index : int
        Of the layer, from 0.
    surface : Surface
        Where.
    fields : FieldSet
        The recipe's fields on that surface.
    features : mapping of str to structured array, optional
        Take these, as the pattern's own `features` had them, and place nothing anew.
    max_features : int, optional
        What the layers below have left of the recipe's; those of the recipe without it.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share.

    Returns
    -------
    pattern : Pattern
        Ready to be asked.
    mask : Field or None
        How much it covers; None covers everything.

    Raises
    ------
    RecipeError
        If the layer does not fit the surface; the message names it.
    """
    layer = recipe.layer[index]
    material: Any = layer.material
    try:
        covered = layer_cover(recipe, index, surface, fields, features)
        if not covered.any() and hasattr(material, "channels"):
            with located(recipe, "layer", index, label=layer_label(recipe, index)):
                unseen = Uncovered(material.channels)
            return unseen, mask_on(unseen, fields, layer.mask)
        bodies = Bodies.of(surface, covered) if covered.any() and not covered.all() else None
        if bodies is not None:
            tick = BodiesTick(tick, bodies)
            features = None if features is None else bodies.rows_here(features)
        with located(recipe, "layer", index, label=layer_label(recipe, index)):
            pattern: Pattern = material.place(
                surface if bodies is None else bodies.surface, layer_seed(recipe.seed, index),
                fields=fields if bodies is None else fields_on(bodies, fields), features=features,
                max_features=max_features or recipe.bake.max_features, threads=threads, tick=tick,
            )  # fmt: skip
    except InputError:
        raise
    except (KeyError, ValueError) as problem:
        if features is None:
            raise
        raise RecipeError(
            f"{layer_label(recipe, index)}: the features do not fit {layer.kind} ({problem}); were they placed by another "
            "recipe?"
        ) from None
    if bodies is not None:
        curves, places = (drawn_names(layer, end).values() for end in ("_curves", "_points"))
        pattern = OnBodies.of(bodies, pattern, drawn_elsewhere(bodies, fields, curves, places))
    return pattern, mask_on(pattern, fields, layer.mask)


def layer_cover(
    recipe: Recipe, index: int, surface: Surface, fields: FieldSet, features: Features | None = None
) -> NDArray[np.bool_]:
    """Tell which bodies of a surface a layer lies on.

    Parameters
    ----------
    recipe : Recipe
        With the layer.
    index : int
        Of the layer, from 0.
    surface : Surface
        With c components.
    fields : FieldSet
        The recipe's fields on it.
    features : mapping of str to structured array, optional
        What the layer was given: it lies on the bodies of these as well.

    Returns
    -------
    covered : (c,) bool
        By component.

    Raises
    ------
    RecipeError
        If the mask is wrong; the message names the layer.
    """
    with located(recipe, "layer", index, "mask", label=f"{layer_label(recipe, index)}.mask"):
        covered = covered_bodies(surface, fields, recipe.layer[index].mask)
    if features is not None and not covered.all():
        covered = covered | holding(surface, features)
    return covered


def layer_label(recipe: Recipe | None, index: int) -> str:
    """Name a layer as messages do.

    Parameters
    ----------
    recipe : Recipe or None
        With the layer.
    index : int
        Of the layer, from 0.

    Returns
    -------
    label : str
        With a number, from 1, where there are several.
    """
    return "layer" if recipe is None or len(recipe.layer) == 1 else f"layer[{index + 1}]"


def layer_seed(seed: int, index: int) -> int:
    """Give each layer a seed of its own, so that two alike do not coincide.

    Parameters
    ----------
    seed : int
        Of the recipe.
    index : int
        Of the layer, from 0.

    Returns
    -------
    seed : int
        The recipe's own for the first layer.
    """
    return seed if index == 0 else stream(seed, "layer", index).key


def feature_counts(features: Features) -> dict[str, int]:
    """Count what was placed.

    Parameters
    ----------
    features : mapping of str to structured array
        As `Stack.features`.

    Returns
    -------
    counts : dict of str to int
        Points, or whole curves, by kind.
    """
    return {
        kind: len(np.unique(table["curve"])) if "curve" in (table.dtype.names or ()) else len(table)
        for kind, table in features.items()
    }


def counted(features: Features) -> int:
    """Count what ``max_features`` bounds.

    Parameters
    ----------
    features : mapping of str to structured array
        As `Stack.features`.

    Returns
    -------
    count : int
        Of all kinds and layers.
    """
    return sum(feature_counts(features).values())


def _prefix(index: int) -> str:
    return "" if index == 0 else f"layer{index + 1}_"


class _LayerTick(PartTick):
    """Part of a layer in the placing of all; what grows in it goes by the layer's names."""

    def __init__(self, tick: Tick | None, index: int, count: int) -> None:
        super().__init__(tick, index / count, (index + 1) / count)
        self.prefix = _prefix(index)

    def keep(self, generation: int, last: int, make: Callable[[], Features]) -> None:
        super().keep(
            generation, last, lambda: {f"{self.prefix}{kind}": table for kind, table in make().items()}
        )


def _named_for(features: Features, index: int) -> dict[str, NDArray]:
    """Features of one layer, by its own names."""
    prefix = _prefix(index)
    own = {kind.removeprefix(prefix): table for kind, table in features.items() if kind.startswith(prefix)}
    return own if index else {kind: table for kind, table in own.items() if not _OTHER_LAYER.match(kind)}


def _check_given(surface: Surface, features: Features, label: str) -> None:
    from surftex.features.given import check_given

    try:
        check_given(surface, features)
    except InputError as problem:
        raise RecipeError(f"{label}: {problem}") from None
