"""``--set key=value``: changes to a recipe from the command line."""

import re
import tomllib
from typing import Any

from surftex.errors import RecipeError
from surftex.materials.hints import nearest
from surftex.recipe.lines import Path

_NUMBERED = re.compile(r"layer\[(\d+)\]")
_TABLES = ("mesh", "bake", "fields")
_TOP = ("seed",)


def change(values: dict[str, Any], text: str) -> Path:
    """Apply one change to the tables of a recipe.

    Parameters
    ----------
    values : dict
        As read from TOML; changed in place.
    text : str
        ``KEY=VALUE``. KEY is a parameter of the only layer (``cell_size``), of a named one
        (``leather.cell_size``, ``calf.cell_size``, ``layer[2].cell_size``, counted from 1), or a key of a
        table (``bake.resolution``, ``fields.wear``, ``seed``). VALUE is TOML; what is not is taken as text.

    Returns
    -------
    path : tuple
        The key that was changed.

    Raises
    ------
    RecipeError
        If the text is no change, or it is unclear which layer is meant.
    """
    key, equals, written = text.partition("=")
    names = key.strip().split(".")
    if not equals or not all(names):
        raise RecipeError(f"--set {text!r} is no change; write key=value, such as leather.cell_size='2 mm'")
    path = _path(values, names, text)
    _put(values, path, _value(written.strip()), text)
    return path


def _put(values: dict[str, Any], path: Path, value: Any, text: str) -> None:
    in_layer = path[0] == "layer"
    table: Any = values["layer"][path[1]] if in_layer else values
    for step in path[2 if in_layer else 0 : -1]:
        table = table.setdefault(step, {})
        if not isinstance(table, dict):
            raise RecipeError(f"--set {text}: {step} is no table")
    table[path[-1]] = value


def _path(values: dict[str, Any], names: list[str], text: str) -> Path:
    first, rest = names[0], tuple(names[1:])
    if first in _TABLES and rest:
        return (first, *rest)
    if first in _TOP and not rest:
        return (first,)
    layers = values.get("layer", [])
    if not isinstance(layers, list) or not all(isinstance(layer, dict) for layer in layers):
        raise RecipeError("layer: write each layer as a table, [[layer]]")
    if not rest:
        return ("layer", _only(layers, range(len(layers)), text), first)
    numbered = _NUMBERED.fullmatch(first)
    if numbered:
        index = int(numbered[1])
        if not 1 <= index <= len(layers):
            raise RecipeError(f"--set {text}: there is no {first}; layers count from 1 to {len(layers)}")
        return ("layer", index - 1, *rest)
    if first == "layer":
        return ("layer", _only(layers, range(len(layers)), text), *rest)
    named = [i for i, layer in enumerate(layers) if first in (layer.get("material"), layer.get("preset"))]
    if not named:
        named = [i for i, layer in enumerate(layers) if "material" not in layer and _is_of(layer, first)]
    if not named:
        known = [
            *_TABLES,
            "layer",
            *(str(layer[key]) for layer in layers for key in ("material", "preset") if key in layer),
        ]
        raise RecipeError(f"--set {text}: nothing is called {first!r}{nearest(first, dict.fromkeys(known))}")
    return ("layer", _only(layers, named, text), *rest)


def _is_of(layer: dict[str, Any], material: str) -> bool:
    from surftex.recipe.layer import preset_material

    try:
        return preset_material(str(layer.get("preset"))) == material
    except RecipeError:
        return False


def _only(layers: list[dict[str, Any]], candidates: Any, text: str) -> int:
    if len(layers) == 0:
        raise RecipeError(f"--set {text}: the recipe has no layer")
    if len(candidates) > 1:
        choices = ", ".join(f"layer[{i + 1}]" for i in candidates)
        raise RecipeError(f"--set {text}: which layer? Write one of {choices} before the key")
    return candidates[0]


def _value(written: str) -> Any:
    try:
        read = tomllib.loads(f"value = {written}\n")
    except ValueError:  # TOML has mistakes, int too many digits
        return written
    return read["value"] if set(read) == {"value"} else written
