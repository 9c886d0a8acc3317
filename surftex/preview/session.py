"""`Session`: what is being made, and every command that changes it; no window, no page, no pictures.

A session holds a recipe, the strokes and places drawn on the surface, and which layers are switched off. Each
command makes a new state and keeps the old one, so that all can be undone. `save` writes a recipe that bakes what
is seen.
"""

import hashlib
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import chain, count
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

from surftex.errors import InputError, RecipeError, WorkError
from surftex.files.strokes import Stroke, read_strokes, write_strokes
from surftex.materials.hints import nearest
from surftex.preview.controls import Control, controls
from surftex.recipe.fields import CurvesEntry, DistanceEntry, StrokesEntry
from surftex.recipe.layer import Layer, preset_material
from surftex.recipe.mistakes import checked_recipe
from surftex.recipe.model import Recipe
from surftex.recipe.write import recipe_text
from surftex.surface.points import SurfacePoints
from surftex.surface.surface import Surface

Use = Literal["direction", "curves", "distance"]
"""What strokes are for: a direction field, lines such as wrinkles, or the distance to points, such as of moles."""

_ENTRY: dict[str, tuple[type, str]] = {
    "direction": (StrokesEntry, "strokes"),
    "curves": (CurvesEntry, "curves"),
    "distance": (DistanceEntry, "distance_to"),
}
"""Kind of field for each use, and its key that names the file."""


def _entry(before: Any, use: Use, path: Path) -> Any:
    """Make the field that reads a file, with whatever else was said of it before."""
    kind, key = _ENTRY[use]
    return kind(**{key: str(path)}) if before is None else before.model_copy(update={key: str(path)})


@dataclass(frozen=True, eq=False)
class Drawing:
    """Strokes and places of one field.

    Attributes
    ----------
    use : str
        What they are for.
    strokes : tuple of Stroke
        Lines in the order of drawing.
    points : mapping of str to SurfacePoints
        Single places by name.
    """

    use: Use
    strokes: tuple[Stroke, ...] = ()
    points: Mapping[str, SurfacePoints] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True, eq=False)
class State:
    """Everything that a command can change.

    Attributes
    ----------
    recipe : Recipe
        As it would be saved, were no layer switched off.
    hidden : frozenset of int
        Layers that are switched off.
    drawings : mapping of str to Drawing
        By the name of their field.
    """

    recipe: Recipe
    hidden: frozenset[int] = frozenset()
    drawings: Mapping[str, Drawing] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def shown(self) -> Recipe:
        """The recipe with the layers that are switched off covering nothing."""
        layers = tuple(
            layer.model_copy(update={"mask": 0.0}) if i in self.hidden else layer
            for i, layer in enumerate(self.recipe.layer)
        )
        return self.recipe.model_copy(update={"layer": layers})


class Session:
    """A recipe on a surface, and its history.

    Parameters
    ----------
    recipe : Recipe
        To start from.
    surface : Surface
        Where.
    """

    def __init__(self, recipe: Recipe, surface: Surface) -> None:
        self.surface = surface
        self._past: list[tuple[str, State]] = []
        self._future: list[tuple[str, State]] = []
        self._last = ""
        self.state = State(recipe)
        self._folder = tempfile.TemporaryDirectory(prefix="surftex-")
        self._ranges: dict[tuple[int, str], tuple[Control, ...]] = {}

    @property
    def recipe(self) -> Recipe:
        """What is to be seen now."""
        return self.state.shown

    @property
    def history(self) -> tuple[str, ...]:
        """What was done, from the first to the last that can be undone."""
        return tuple(name for name, _ in self._past)

    def close(self) -> None:
        """Forget what was drawn and not saved."""
        self._folder.cleanup()

    def controls(self, layer: int = 0) -> tuple[Control, ...]:
        """Give the controls of a layer; their ranges stay while its preset stays.

        Parameters
        ----------
        layer : int
            From 0.

        Returns
        -------
        controls : tuple of Control
            Group by group.
        """
        chosen = self._layer(layer)
        key = (layer, f"{chosen.kind} {chosen.preset}")
        if key not in self._ranges:
            self._ranges[key] = controls(chosen.material)
        return self._ranges[key]

    def value(self, key: str, layer: int = 0) -> Any:
        """Look up a parameter.

        Parameters
        ----------
        key : str
            Its name.
        layer : int
            From 0.

        Returns
        -------
        value : Any
            As the material has it.

        Raises
        ------
        RecipeError
            If the material has no such parameter.
        """
        material = self._layer(layer).material
        if key not in type(material).model_fields:
            raise RecipeError(
                f"{self._layer(layer).kind} has no parameter {key!r}{nearest(key, type(material).model_fields)}"
            )
        return getattr(material, key)

    def set(self, key: str, value: Any, layer: int = 0) -> None:
        """Change a parameter; moving one slider on and on is undone in one step.

        Parameters
        ----------
        key : str
            Its name.
        value : Any
            As a recipe would have it: lengths may carry units, numbers may be expressions.
        layer : int
            From 0.

        Raises
        ------
        RecipeError
            If the value does not fit; nothing has changed then.
        """
        self.value(key, layer)
        chosen = self._layer(layer)
        table = {**chosen.table(), key: value}
        table.pop("preset", None)
        given = {name: each for name, each in table.items() if each is not None or name == key}
        made = self._checked({"layer": self._with_layer(layer, given)}, layer)
        self._go(f"set layer {layer + 1} {key}", recipe=self._kept_preset(made, layer), joined=True)

    def set_mask(self, mask: float | str, layer: int = 0) -> None:
        """Change where a layer lies.

        Parameters
        ----------
        mask : float or str
            0 to 1, or an expression over the recipe's fields.
        layer : int
            From 0.

        Raises
        ------
        RecipeError
            If it is neither.
        """
        table = {**self._layer(layer).table(), "mask": mask}
        given = {name: each for name, each in table.items() if each is not None and name != "preset"}
        made = self._checked({"layer": self._with_layer(layer, given)}, layer)
        self._go(f"mask layer {layer + 1}", recipe=self._kept_preset(made, layer), joined=True)

    def preset(self, name: str, layer: int = 0) -> None:
        """Put another preset in the place of a layer's material.

        Parameters
        ----------
        name : str
            Of any material.
        layer : int
            From 0.

        Raises
        ------
        RecipeError
            If there is no such preset.
        """
        mask = self._layer(layer).mask
        table = {"material": preset_material(name), "preset": name, "mask": mask}
        self._ranges = {key: value for key, value in self._ranges.items() if key[0] != layer}
        self._go(f"preset {name}", recipe=self._checked({"layer": self._with_layer(layer, table)}, layer))

    def seed(self, seed: int) -> None:
        """Draw everything random anew.

        Parameters
        ----------
        seed : int
            Any whole number.

        Raises
        ------
        RecipeError
            If it is none.
        """
        self._go(f"seed {seed}", recipe=self._checked({"seed": seed}, None), joined=True)

    def toggle(self, layer: int) -> None:
        """Switch a layer off, or on again.

        Parameters
        ----------
        layer : int
            From 0.

        Raises
        ------
        RecipeError
            If there is none of that number.
        """
        self._layer(layer)
        self._go(f"toggle layer {layer + 1}", hidden=self.state.hidden ^ {layer})

    def stroke(self, name: str, points: SurfacePoints, use: Use = "direction", **numbers: float) -> None:
        """Add a stroke to a field; the field is made if there is none.

        Parameters
        ----------
        name : str
            Of the field.
        points : SurfacePoints
            At least two places in order.
        use : str
            direction, curves or distance.
        **numbers : float
            Such as ``width_mm`` and ``depth_mm`` of curves.

        Raises
        ------
        RecipeError
            If the field is there, and was made of something else.
        """
        if len(points) < 2:
            raise RecipeError(f"a stroke takes two places or more, not {len(points)}")
        old = self._drawing(name, use)
        made = replace(old, strokes=(*old.strokes, Stroke(points, numbers=dict(numbers))))
        self._draw(f"stroke {name}", name, made)

    def pick(self, name: str, point: SurfacePoints) -> None:
        """Add a single place to a field of distances; the field is made if there is none.

        Parameters
        ----------
        name : str
            Of the field.
        point : SurfacePoints
            One place.

        Raises
        ------
        RecipeError
            If the field is there, and was made of something else.
        """
        old = self._drawing(name, "distance")
        called = next(free for k in count(len(old.points) + 1) if (free := f"{name} {k}") not in old.points)
        made = replace(old, points=MappingProxyType({**old.points, called: point}))
        self._draw(f"pick {name}", name, made)

    def free_name(self, name: str, use: Use) -> str:
        """Find a field that can be drawn into.

        Parameters
        ----------
        name : str
            What it is to be called.
        use : str
            direction, curves or distance.

        Returns
        -------
        name : str
            The same, or where that field is something else, with the next number that is free.
        """
        for called in chain((name,), (f"{name}_{k}" for k in count(2))):
            try:
                self._drawing(called, use)
            except RecipeError:
                continue
            return called
        raise AssertionError("numbers do not end")

    @contextmanager
    def one_step(self) -> Iterator[None]:
        """Let all that is done meanwhile be undone in one step, under the name of the first of it."""
        before = len(self._past)
        yield
        del self._past[before + 1 :]
        self._last = ""

    def undo(self) -> str | None:
        """Take back the last command.

        Returns
        -------
        name : str or None
            What was taken back; None where there is nothing.
        """
        return self._move(self._past, self._future)

    def redo(self) -> str | None:
        """Do again what was taken back last.

        Returns
        -------
        name : str or None
            What was done; None where there is nothing.
        """
        return self._move(self._future, self._past)

    def save(self, path: str | Path, *, overwrite: bool = False) -> list[Path]:
        """Write a recipe that bakes what is seen, and beside it the strokes that were drawn.

        Parameters
        ----------
        path : path
            Of the TOML file.
        overwrite : bool
            Whether files of these names may be replaced.

        Returns
        -------
        paths : list of Path
            What was written, the recipe last.

        Raises
        ------
        InputError
            If a file is there already.
        WorkError
            If the disk does not take them.
        """
        target = Path(path)
        target = target if target.suffix.lower() == ".toml" else target.with_name(target.name + ".toml")
        files = {name: target.with_name(f"{target.stem}-{name}.json") for name in self.state.drawings}
        taken = [each for each in (*files.values(), target) if each.exists()]
        if taken and not overwrite:
            raise InputError(f"{taken[0]} is there already; choose another name")
        recipe, entries = self.recipe, dict(self.recipe.fields_)
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            for name, place in files.items():
                drawing = self.state.drawings[name]
                write_strokes(place, self.surface, drawing.strokes, drawing.points)
                entries[name] = _entry(entries.get(name), drawing.use, place.resolve())
            text = recipe_text(recipe.model_copy(update={"fields_": entries}), target.parent)
            draft = target.with_name(f".{target.name}.draft")
            draft.write_text(text, "utf-8")
            shutil.move(draft, target)
        except OSError as problem:
            raise WorkError(f"{target}: cannot write: {problem.strerror or problem}") from None
        return [*files.values(), target]

    def _layer(self, index: int) -> Layer:
        layers = self.state.recipe.layer
        if not 0 <= index < len(layers):
            raise RecipeError(f"there is no layer {index + 1}; the recipe has {len(layers)}")
        return layers[index]

    def _with_layer(self, index: int, table: Mapping[str, Any]) -> list[Any]:
        layers: list[Any] = list(self.state.recipe.layer)
        layers[index] = dict(table)
        return layers

    def _checked(self, changes: Mapping[str, Any], layer: int | None) -> Recipe:
        values = dict(self.state.recipe)
        values["fields"] = values.pop("fields_")
        return checked_recipe({**values, **changes}).located(self.state.recipe.places)

    def _kept_preset(self, recipe: Recipe, index: int) -> Recipe:
        """Remember what preset a layer started from."""
        layers = list(recipe.layer)
        layers[index] = layers[index].model_copy(update={"preset": self._layer(index).preset})
        return recipe.model_copy(update={"layer": tuple(layers)})

    def _drawing(self, name: str, use: Use) -> Drawing:
        drawing = self.state.drawings.get(name)
        entry = self.state.recipe.fields_.get(name)
        if drawing is None and entry is not None:
            kind, key = _ENTRY[use]
            file = getattr(entry, key) if isinstance(entry, kind) else None
            if not (isinstance(file, str) and file.lower().endswith(".json")):
                raise RecipeError(f"the recipe has a field {name!r} of its own; choose another name")
            held = read_strokes(file, self.surface)
            return Drawing(use, held.strokes, MappingProxyType(dict(held.points)))
        if drawing is not None and drawing.use != use:
            raise RecipeError(f"{name!r} holds a {drawing.use}, and cannot hold a {use} as well")
        return drawing or Drawing(use)

    def _draw(self, what: str, name: str, drawing: Drawing) -> None:
        digest = hashlib.sha256()
        for points in (*(stroke.points for stroke in drawing.strokes), *drawing.points.values()):
            digest.update(points.face.tobytes() + points.barycentric.tobytes() + b"/")
        digest.update(
            repr([(stroke.name, sorted(stroke.numbers.items())) for stroke in drawing.strokes]).encode()
        )
        path = Path(self._folder.name) / f"{name}-{digest.hexdigest()[:16]}.json"
        write_strokes(path, self.surface, drawing.strokes, drawing.points)
        fields = self.state.recipe.fields_
        entries = {**fields, name: _entry(fields.get(name), drawing.use, path)}
        recipe = self.state.recipe.model_copy(update={"fields_": entries})
        self._go(what, recipe=recipe, drawings=MappingProxyType({**self.state.drawings, name: drawing}))

    def _go(self, name: str, *, joined: bool = False, **changes: Any) -> None:
        before = self.state
        self.state = replace(before, **changes)
        if not (joined and self._past and self._past[-1][0] == name and self._last == name):
            self._past.append((name, before))
        self._last = name
        self._future.clear()

    def _move(self, source: list[tuple[str, State]], sink: list[tuple[str, State]]) -> str | None:
        if not source:
            return None
        name, state = source.pop()
        sink.append((name, self.state))
        self.state, self._last = state, ""
        return name
