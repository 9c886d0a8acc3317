"""`Live`: the page of a recipe that changes, of which no more is computed again than the change asks for.

From cheap to dear: *kept* (nothing to do), *shaped* (depths, widths and colours, from distances measured before),
*gathered* (the same features, measured anew), *placed* (features placed anew). The layers are
those of a bake, texel by texel.
"""

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from surftex.bake.covered import bodies_of, covered_bodies, mask_on
from surftex.bake.fields import make_fields
from surftex.bake.stack import (
    BARE,
    Stack,
    covering,
    feature_counts,
    laid_over,
    layer_seed,
    place_layer,
)
from surftex.bake.stages import Stages
from surftex.bake.unwrapping import Unwrapping
from surftex.charts.texels import default_gutter_px, texels
from surftex.errors import RecipeError
from surftex.fields.fieldset import FieldSet
from surftex.files.images import srgb_codes
from surftex.kernels.pool import Tick, slices, stopped_by
from surftex.maps.normal import NormalPage, surface_tangents
from surftex.materials.layers import CHANNELS, Layers, Pattern, Reshaping
from surftex.preview.focus import Piece, for_piece, piece_around
from surftex.recipe.layer import Layer
from surftex.recipe.model import Recipe
from surftex.surface.surface import Surface

Effort = Literal["kept", "shaped", "gathered", "placed"]

_EFFORTS: tuple[Effort, ...] = ("kept", "shaped", "gathered", "placed")
_SLICE = 1 << 15
_STEPS = 16383
_SCREEN = srgb_codes(np.linspace(0, 1, _STEPS + 1, dtype=np.float32))
_ROOM = 1.6
"""How much wider elements are flooded than they are."""

_SHOWN = ("height_mm", "base_color", "roughness", "metallic", "region")


@dataclass(frozen=True, eq=False)
class Frame:
    """What a recipe looks like, as pictures for a graphics card.

    Attributes
    ----------
    pictures : mapping of str to (h, w, 3) array
        ``base_color`` uint8 sRGB codes; ``surface`` uint8: occlusion, roughness, metallic; ``normal`` uint16, with
        the bitangent's sign taken in, so that it is the cross product of normal and tangent everywhere.
    changed : frozenset of str
        Pictures that are other than in the frame before.
    effort : str
        The dearest thing that was done: kept, shaped, gathered or placed.
    first_look : bool
        Whether it is only true around one place, and more will follow.
    features : mapping of str to int
        How many there are of each kind.
    """

    pictures: Mapping[str, NDArray[Any]]
    changed: frozenset[str]
    effort: Effort
    first_look: bool
    features: Mapping[str, int]


@dataclass(eq=False)
class _Placed:
    """One layer as it is, and what was measured of it."""

    layer: Layer
    seed: int
    fields: FieldSet
    pattern: Pattern
    base: Pattern
    gathered: list[Any] | None
    layers: list[Layers]
    cover: list[NDArray[np.float32] | None]


class Live:
    """The page of one surface.

    Parameters
    ----------
    surface : Surface
        What is looked at.
    recipe : Recipe
        Says how it is unwrapped.
    resolution : int
        Side of the page in texels.
    threads : int, optional
        None means every core.
    """

    def __init__(
        self, surface: Surface, recipe: Recipe, *, resolution: int = 1024, threads: int | None = None
    ) -> None:
        self.surface, self.threads, self.resolution = surface, threads, resolution
        settings = recipe.bake.model_copy(update={"resolution": resolution})
        with Unwrapping(surface, settings, Stages(), threads, remember=True) as unwrapping:
            self.atlas = unwrapping.atlas()
        gutter = min(8, default_gutter_px(self.atlas, resolution))
        self.texels = texels(surface, self.atlas, resolution, gutter_px=gutter, threads=threads)
        self.tangents = surface_tangents(surface, self.atlas)
        self._normals = NormalPage.of(surface, self.atlas, self.texels, tangents=self.tangents)
        self._mirror = np.sign(self.tangents[self.texels.host, 0, 3]).astype(np.float32)
        samples = self.texels.samples
        order = np.argsort(samples.points.face, kind="stable")
        self._chosen = [order[first : first + _SLICE] for first in range(0, len(order), _SLICE)]
        self._samples = [samples.taken(chosen) for chosen in self._chosen]
        self._placed: list[_Placed] = []
        self.height_mm = np.zeros(len(self.texels), np.float32)
        """(t,) height at the mapped texels, as last drawn."""
        self._values: list[dict[str, NDArray[Any]]] = []
        self._pictures: dict[str, NDArray[Any]] = {}
        self._filled = set[str]()
        self._free = np.ones(resolution**2, bool)
        self._free[self.texels.texel] = False
        self._fields: tuple[Any, FieldSet] | None = None

    @property
    def stack(self) -> Stack:
        """Patterns and masks as last drawn in full."""
        masks = (mask_on(placed.pattern, placed.fields, placed.layer.mask) for placed in self._placed)
        return Stack(tuple(placed.pattern for placed in self._placed), tuple(masks))

    def channel(self, name: str) -> NDArray[Any]:
        """Look up a channel as last drawn.

        Parameters
        ----------
        name : str
            height_mm, base_color, roughness, metallic or region.

        Returns
        -------
        values : (t,) or (t, 3) array
            At the mapped texels; as where no layer covers, before anything is drawn.
        """
        values = bare(name, len(self.texels))
        for chosen, part in zip(self._chosen, self._values, strict=False):
            values[chosen] = part[name]
        return values

    def effort(self, recipe: Recipe) -> Effort:
        """Tell what drawing a recipe would take.

        Parameters
        ----------
        recipe : Recipe
            What would be drawn.

        Returns
        -------
        effort : str
            kept, shaped, gathered or placed.
        """
        found = {self._layer_effort(recipe, i) for i in range(len(recipe.layer))}
        return next(effort for effort in reversed(_EFFORTS) if effort in found)

    def first_look(
        self, recipe: Recipe, place_mm: NDArray[np.float64], *, stop: threading.Event | None = None
    ) -> Frame | None:
        """Draw a recipe on the piece of the surface around one place, soon.

        Parameters
        ----------
        recipe : Recipe
            What to draw.
        place_mm : (3,) float
            What is looked at, in the frame of `Surface.vertices`.
        stop : Event, optional
            Ends the work early.

        Returns
        -------
        frame : Frame or None
            None where the whole is done as soon, or the piece would hold too much to be seen soon.

        Raises
        ------
        RecipeError
            If the recipe does not fit the surface.
        Stopped
            If `stop` is set.
        """
        piece = piece_around(recipe, self.surface, place_mm)
        if piece is None or not self._values:
            return None
        with stopped_by(stop or threading.Event()):
            return self._looked(for_piece(recipe, piece), piece)

    def draw(self, recipe: Recipe, *, stop: threading.Event | None = None, tick: Tick | None = None) -> Frame:
        """Draw a recipe.

        Parameters
        ----------
        recipe : Recipe
            What to draw.
        stop : Event, optional
            Ends the work early; what was drawn before stays.
        tick : callable, optional
            Told the finished share.

        Returns
        -------
        frame : Frame
            Its pictures; the arrays are the same from frame to frame.

        Raises
        ------
        RecipeError
            If the recipe does not fit the surface.
        Stopped
            If `stop` is set.
        """
        with stopped_by(stop or threading.Event()):
            return self._drawn(recipe, tick)

    def _drawn(self, recipe: Recipe, tick: Tick | None) -> Frame:
        placed = [self._layer(recipe, i, tick) for i in range(len(recipe.layer))]
        effort = self.effort(recipe)
        covers = [layer.cover for layer in placed]
        stacked = self._sliced(
            lambda k: _stacked(
                [layer.layers[k] for layer in placed], [c[k] for c in covers], len(self._chosen[k])
            )
        )
        self._placed = placed  # from here on nothing can fail
        counts = feature_counts(self.stack.features)
        return self._shown(stacked, effort, counts, first_look=False)

    def _looked(self, recipe: Recipe, piece: Piece) -> Frame | None:
        """Draw the texels of a piece, and leave all others as they were."""
        fields = piece.fields(self._field_set(recipe))
        inside = np.flatnonzero(piece.shown[self.texels.points.face])
        samples = piece.samples(self.texels.samples.taken(inside))
        values = {name: bare(name, len(samples)) for name in _SHOWN}
        for i in range(len(recipe.layer)):
            try:
                pattern, mask = place_layer(
                    recipe,
                    i,
                    piece.surface,
                    fields,
                    max_features=piece.most(recipe.bake.max_features),
                    threads=self.threads,
                )
            except RecipeError:
                return None  # what is wrong with the whole is told by drawing it

            def work(first: int, last: int, pattern: Pattern = pattern) -> Layers:
                return pattern.at(samples.taken(np.arange(first, last)))

            parts = slices(work, len(samples), size=_SLICE, threads=self.threads)
            cover = covering(mask, samples)
            for name in pattern.channels:
                if name in values and parts:
                    above = np.concatenate([part[name] for part in parts])
                    values[name] = laid_over(values[name], above, cover)
        place = np.full(len(self.texels), -1, np.int64)
        place[inside] = np.arange(len(inside))
        stacked = [dict(part) for part in self._values]
        for part, chosen in zip(stacked, self._chosen, strict=True):
            seen = np.flatnonzero(place[chosen] >= 0)
            for name, value in values.items():
                part[name] = part[name].copy()
                part[name][seen] = value[place[chosen[seen]]]
        return self._shown(stacked, "placed", {}, first_look=True)

    def _field_set(self, recipe: Recipe) -> FieldSet:
        key = (recipe.fields_, recipe.seed)
        if self._fields is None or self._fields[0] != key:
            self._fields = (key, make_fields(recipe, self.surface))
        return self._fields[1]

    def _layer_effort(self, recipe: Recipe, index: int) -> Effort:
        if index >= len(self._placed):
            return "placed"
        kept, material = self._placed[index], recipe.layer[index].material
        before = kept.layer.material
        if (
            type(material) is not type(before)
            or kept.seed != layer_seed(recipe.seed, index)
            or kept.fields is not self._field_set(recipe)
        ):
            return "placed"
        if not self._same_bodies(kept, recipe.layer[index]):
            return "placed"
        if material == before:
            return "kept"
        if isinstance(kept.base, Reshaping):
            if kept.base.reshaped(material) is not None:
                return "shaped"
            if kept.base.keeps(material):
                return "gathered"
        return "placed"

    def _same_bodies(self, kept: _Placed, layer: Layer) -> bool:
        """Tell whether a layer lies where it is to be seen: on the bodies that its mask covers, or it covers none."""
        if layer.mask == kept.layer.mask:
            return True
        covered = covered_bodies(self.surface, kept.fields, layer.mask)
        number, lies = bodies_of(kept.pattern), np.ones(len(covered), bool)
        if number is not None:
            lies[:] = False
            lies[list(number)] = True
        return not covered.any() or bool((covered == lies).all())

    def _layer(self, recipe: Recipe, index: int, tick: Tick | None) -> _Placed:
        """Do for one layer what its change asks for."""
        layer, fields = recipe.layer[index], self._field_set(recipe)
        effort = self._layer_effort(recipe, index)
        kept = self._placed[index] if index < len(self._placed) else None
        if kept is not None and effort in ("kept", "shaped"):
            same_mask = layer.mask == kept.layer.mask
            mask = mask_on(kept.pattern, fields, layer.mask)
            cover = kept.cover if same_mask else [covering(mask, samples) for samples in self._samples]
            if effort == "kept":
                return replace(kept, layer=layer, cover=cover)
            shaped = cast(Any, kept.base).reshaped(layer.material)
            measured = cast(list[Any], kept.gathered)
            layers = self._sliced(lambda k: shaped.shape(measured[k], self._samples[k].footprint_mm))
            return replace(kept, layer=layer, pattern=shaped, layers=layers, cover=cover)
        features = kept.pattern.features if kept is not None and effort == "gathered" else None
        base, mask = place_layer(
            _roomy(recipe), index, self.surface, fields, features=features, threads=self.threads, tick=tick
        )
        gathered, pattern = None, base
        if isinstance(base, Reshaping):
            pattern = cast(Any, base.reshaped(layer.material))
            gathered = self._sliced(lambda k: base.gather(self._samples[k]))
            layers = self._sliced(lambda k: pattern.shape(gathered[k], self._samples[k].footprint_mm))
        else:
            layers = self._sliced(lambda k: pattern.at(self._samples[k]))
        cover = [covering(mask, samples) for samples in self._samples]
        seed = layer_seed(recipe.seed, index)
        return _Placed(layer, seed, fields, pattern, base, gathered, layers, cover)

    def _sliced(self, work: Callable[[int], Any]) -> list[Any]:
        """Do a piece of work for every slice of the texels."""
        return slices(lambda first, last: work(first), len(self._samples), size=1, threads=self.threads)

    def _shown(
        self,
        values: list[dict[str, NDArray[Any]]],
        effort: Effort,
        counts: dict[str, int],
        *,
        first_look: bool,
    ) -> Frame:
        """Turn numbers into pictures: those that are others than before."""
        new = {
            name
            for name in _SHOWN
            if not self._values
            or any(not _same(a[name], b[name]) for a, b in zip(self._values, values, strict=True))
        }
        self._values = values
        texel = self.texels.texel
        changed = set()
        if "base_color" in new:
            page = self._page("base_color", np.uint8)
            self._sliced(lambda k: _put(page, texel[self._chosen[k]], _screen(values[k]["base_color"])))
            changed.add("base_color")
        if new & {"roughness", "metallic"}:
            page = self._page("surface", np.uint8)
            self._sliced(lambda k: _put(page, texel[self._chosen[k]], _surface_codes(values[k])))
            changed.add("surface")
        if "height_mm" in new:
            page = self._page("normal", np.uint16)
            for chosen, part in zip(self._chosen, values, strict=True):
                self.height_mm[chosen] = part["height_mm"]
            normal = self._normals.encoded(self.height_mm, threads=self.threads)

            def work(first: int, last: int) -> None:
                part = normal[first:last]
                part[:, 1] *= self._mirror[first:last]
                _put(page, texel[first:last], ((part + 1) * np.float32(32767.5)).astype(np.uint16))

            slices(work, len(texel), size=_SLICE, threads=self.threads)
            changed.add("normal")
        for name in changed - self._filled:
            flat = self._pictures[name].reshape(-1, 3)
            flat[self._free] = flat[texel].mean(axis=0)
            self._filled.add(name)
        return Frame(MappingProxyType(self._pictures), frozenset(changed), effort, first_look, counts)

    def _page(self, name: str, kind: Any) -> NDArray[Any]:
        """Look up the rows of a picture."""
        if name not in self._pictures:
            self._pictures[name] = np.zeros((self.resolution, self.resolution, 3), kind)
        return self._pictures[name].reshape(-1, 3)


def bare(channel: str, count: int) -> NDArray[Any]:
    """Make a channel as it is where no layer covers.

    Parameters
    ----------
    channel : str
        One of `CHANNELS`.
    count : int
        Samples.

    Returns
    -------
    values : (count,) or (count, 3) array
        float32; `region` is int32.
    """
    shape = (count,) if CHANNELS[channel] == 1 else (count, CHANNELS[channel])
    return np.full(shape, BARE.get(channel, 0), np.int32 if channel == "region" else np.float32)


def _roomy(recipe: Recipe) -> Recipe:
    """Flood wide enough for elements that become wider."""
    layers = []
    for layer in recipe.layer:
        material: Any = layer.material
        wide = material.roomy(_ROOM) if hasattr(material, "roomy") else material
        layers.append(layer.model_copy(update={"material": wide}))
    return recipe.model_copy(update={"layer": tuple(layers)})


def _stacked(
    layers: list[Layers], covers: list[NDArray[np.float32] | None], count: int
) -> dict[str, NDArray[Any]]:
    """Lay the layers of one slice over one another."""
    result = {}
    for name in _SHOWN:
        value: NDArray[Any] | None = None
        for part, cover in zip(layers, covers, strict=True):
            if name in part:
                value = (
                    part[name]
                    if cover is None
                    else laid_over(bare(name, count) if value is None else value, part[name], cover)
                )
        result[name] = bare(name, count) if value is None else value
    return result


def _same(before: NDArray[Any], now: NDArray[Any]) -> bool:
    return before is now or np.array_equal(before, now)


def _put(page: NDArray[Any], texel: NDArray[np.int64], codes: NDArray[Any]) -> None:
    page[texel] = codes


def _screen(linear: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Encode linear light for a screen, by a table."""
    return _SCREEN[(linear * np.float32(_STEPS)).astype(np.uint16)]


def _surface_codes(values: Mapping[str, NDArray[Any]]) -> NDArray[np.uint8]:
    """Occlusion, roughness, metallic."""
    codes = np.full((len(values["roughness"]), 3), 255, np.uint8)
    codes[:, 1] = values["roughness"] * np.float32(255) + np.float32(0.5)
    codes[:, 2] = values["metallic"] * np.float32(255) + np.float32(0.5)
    return codes
