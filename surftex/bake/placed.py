"""What placed the features of a file: told in it, and compared with the bake that starts from it."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePath
from typing import Any

from pydantic import BaseModel

from surftex.errors import InputError
from surftex.files.features import features_told
from surftex.recipe.fields import named_files
from surftex.recipe.model import Recipe
from surftex.surface.surface import Surface

_ROUNDING = 1e-3
"""By which the size of a mesh may differ that was written and read again."""


def placed_by(recipe: Recipe, surface: Surface) -> dict[str, Any]:
    """Tell what decides where features lie; colours, heights and masks of layers do not.

    Parameters
    ----------
    recipe : Recipe
        That placed them, or shall be baked from them.
    surface : Surface
        Where.

    Returns
    -------
    told : dict
        ``seed``, ``size_mm`` of the longest side, ``layer``: material and parameters of each, ``fields``: those that the
        parameters use. JSON types.
    """
    layers = [{"material": layer.kind, **_placing(layer.material)} for layer in recipe.layer]
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
