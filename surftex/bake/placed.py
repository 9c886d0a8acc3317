"""What placed the features of a file: told in it, and compared with the bake that starts from it."""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePath
from typing import Any

import numpy as np
from pydantic import BaseModel

from surftex.bake.covered import bodies_of
from surftex.bake.stack import layer_cover
from surftex.errors import InputError
from surftex.fields.fieldset import FieldSet
from surftex.files.features import features_told
from surftex.recipe.fields import named_files
from surftex.recipe.model import Recipe
from surftex.surface.surface import Surface

_ROUNDING = 1e-3
"""By which the size of a mesh may differ that was written and read again."""


def placed_by(recipe: Recipe, surface: Surface, patterns: Sequence[Any] = ()) -> dict[str, Any]:
    """Tell what decides where features lie; colours and heights do not, masks only by the bodies that they cover.

    Parameters
    ----------
    recipe : Recipe
        That placed them, or shall be baked from them.
    surface : Surface
        Where.
    patterns : sequence of Pattern, optional
        What was placed, a pattern for each layer.

    Returns
    -------
    told : dict
        ``seed``, ``size_mm`` of the longest side, ``layer``: material and parameters of each, and ``bodies``, the numbers of
        the components that it was placed on, where these are not all; ``fields``: those that the parameters use. JSON types.
    """
    layers = [{"material": layer.kind, **_placing(layer.material)} for layer in recipe.layer]
    for layer, pattern in zip(layers, patterns, strict=False):
        if (bodies := bodies_of(pattern)) is not None:
            layer["bodies"] = list(bodies)
    entries = {name: _entry(entry) for name, entry in recipe.fields_.items()}
    used: dict[str, Any] = {}
    words = list(_words(layers))
    while words:
        name = words.pop()
        if name in entries and name not in used:
            used[name] = entries[name]
            words += _words(entries[name])
    return {"seed": recipe.seed, "size_mm": surface.longest_side_mm, "layer": layers, "fields": used}


def start_from(file: Path, recipe: Recipe, surface: Surface) -> tuple[Recipe, tuple[str, ...]]:
    """Compare what placed a file's features with the bake that starts from them.

    Parameters
    ----------
    file : Path
        A features file.
    recipe : Recipe
        Of the bake.
    surface : Surface
        Of the bake.

    Returns
    -------
    recipe : Recipe
        With the file's seed, where it said none itself.
    warnings : tuple of str
        That the file does not say what placed it, where it does not.

    Raises
    ------
    InputError
        Naming the first value in which they differ, as it was and as it is.
    """
    told = features_told(file)
    if told is None:
        text = "does not say what placed it; seed, size and parameters are taken to be those of this bake"
        return recipe, (f"{file}: {text}",)
    if "seed" not in recipe.model_fields_set and isinstance(told.get("seed"), int):
        recipe = recipe.model_copy(update={"seed": told["seed"]})
    now = placed_by(recipe, surface)
    for name, was, value in _differing(told, now):
        raise InputError(
            f"{file}: was placed with {name} {_shown(was)}, and this bake says {_shown(value)}; "
            "make them alike, or leave the features out to place anew"
        )
    return recipe, ()


def refuse_uncovered(file: Path, recipe: Recipe, surface: Surface, fields: FieldSet) -> None:
    """Refuse to start from features that lie on fewer bodies than the masks cover.

    Parameters
    ----------
    file : Path
        A features file.
    recipe : Recipe
        Of the bake.
    surface : Surface
        Of the bake.
    fields : FieldSet
        The recipe's fields on it.

    Raises
    ------
    InputError
        Naming the first layer that covers a body on which nothing of it was placed.
    """
    told = (features_told(file) or {}).get("layer")
    layers = told if isinstance(told, list) else []
    for i, layer in enumerate(layers):
        bodies = layer.get("bodies") if isinstance(layer, Mapping) else None
        if not isinstance(bodies, list) or i >= len(recipe.layer):
            continue
        covered = layer_cover(recipe, i, surface, fields)
        more = len({*np.flatnonzero(covered).tolist()}.difference(bodies))
        if more:
            label = f"layer[{i + 1}].mask" if len(layers) > 1 else "mask"
            raise InputError(
                f"{file}: was placed on {len(bodies)} of the {len(covered)} bodies of the mesh, and {label} covers {more} "
                f"more; make it cover no other, or leave the features out to place anew"
            )


def _placing(material: Any) -> dict[str, Any]:
    values = getattr(material, "placing", dict)()
    for key in getattr(material, "files", ()):
        if key in values:
            values[key] = PurePath(str(values[key])).name
    return {key: list(value) if isinstance(value, tuple) else value for key, value in values.items()}


def _entry(entry: Any) -> Any:
    if not isinstance(entry, BaseModel):
        return entry
    return entry.model_dump(mode="json") | {
        key: PurePath(str(getattr(entry, key))).name for key in named_files(entry)
    }


def _words(value: Any) -> Iterator[str]:
    """Every word in any text of it, which may be the name of a field."""
    if isinstance(value, str):
        yield from re.findall(r"[^\W\d]\w*", value)
    elif isinstance(value, Mapping):
        for each in value.values():
            yield from _words(each)
    elif isinstance(value, (list, tuple)):
        for each in value:
            yield from _words(each)


def _differing(told: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[tuple[str, Any, Any]]:
    """Values that differ, by what a user calls them; keys that only one of two versions knows do not count."""
    before, layers = told.get("layer"), now["layer"]
    before = before if isinstance(before, list) else []
    if len(before) != len(layers):
        yield "layers", len(before), len(layers)
        return
    several = len(layers) > 1
    for i, (was, value) in enumerate(zip(before, layers, strict=True)):
        label = f"layer[{i + 1}]." if several else ""
        if isinstance(was, Mapping):
            yield from (
                (f"{label}{key}", was[key], value[key])
                for key in value
                if key in was and was[key] != value[key]
            )
    fields = told.get("fields")
    fields = fields if isinstance(fields, Mapping) else {}
    for name in [*now["fields"], *fields]:
        if fields.get(name) != now["fields"].get(name):
            yield f"fields.{name}", fields.get(name), now["fields"].get(name)
    if told.get("seed") != now["seed"]:
        yield "seed", told.get("seed"), now["seed"]
    size = told.get("size_mm")
    if not isinstance(size, (int, float)) or not abs(size - now["size_mm"]) <= _ROUNDING * now["size_mm"]:
        yield "size", f"{_shown(size)} mm", f"{_shown(now['size_mm'])} mm"


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    text = "none" if value is None else str(value)
    text = "".join(letter if letter.isprintable() else "?" for letter in text)
    return text if len(text) <= 80 else text[:77] + "..."
