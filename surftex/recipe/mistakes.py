"""Mistakes in a recipe, told in one line: where, which key, what is wrong, what may have been meant."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ValidationError

from surftex.errors import RecipeError
from surftex.materials.checked import in_one_line, told
from surftex.materials.hints import nearest
from surftex.recipe.fields import CURVES, DIRECTIONS, KINDS, expression_of, places_file
from surftex.recipe.layer import Layer, drawn_names, material_class, plain_types, preset_material
from surftex.recipe.lines import Path

if TYPE_CHECKING:
    from surftex.fields.expressions import Expression
    from surftex.recipe.model import Recipe

Where = Callable[[Path], str]
"""Says where a key was written, for the start of a message; text or an empty string."""


_TABLES = {"mesh": ', such as path = "bag.obj"', "bake": ", such as resolution = 2048"}


def checked_recipe(values: dict[str, Any], where: Where = lambda path: "") -> "Recipe":
    """Validate a recipe, its expressions and the names they use.

    Parameters
    ----------
    values : dict
        As read from TOML.
    where : callable
        Where each key was written.

    Returns
    -------
    recipe : Recipe
        Right as far as can be known without its mesh.

    Raises
    ------
    RecipeError
        With each mistake, located.
    """
    from surftex.recipe.model import Recipe

    try:
        recipe = Recipe.model_validate(values)
    except ValidationError as problem:
        raise RecipeError(told_mistakes(problem, values, where)) from None
    _check_names(recipe, where)
    return recipe


def told_mistakes(problem: ValidationError, values: dict[str, Any], where: Where = lambda path: "") -> str:
    """Tell what is wrong with a recipe.

    Parameters
    ----------
    problem : ValidationError
        Of the whole.
    values : dict
        As read from TOML.
    where : callable
        Where each key was written.

    Returns
    -------
    text : str
        One line: each mistake, located.
    """
    found: dict[Path, str] = {}
    for error in sorted(problem.errors(include_url=False), key=lambda error: error["type"] == "missing"):
        path, text = _mistake(dict(error), values)
        if error["type"] == "missing" and any(other[:-1] == path[:-1] for other in found):
            continue  # a key that is missing where another is unknown was mistyped
        found.setdefault(path, f"{where(path)}{_joined(path, values)}: {text}")
    return in_one_line(found.values())


def _mistake(error: dict[str, Any], values: dict[str, Any]) -> tuple[Path, str]:
    from surftex.recipe.model import NO_LAYER

    context = error.get("ctx", {})
    path = _key_path(error["loc"], values)
    if error["type"] == "at_key":
        path = (*path, context["key"])
    name = str(path[-1]) if path else ""
    if path == ("layer",) and isinstance(values.get("layer"), dict):
        return path, "write [[layer]] with two brackets, once for each layer"
    if error["type"] == "field_kind" and isinstance(error["input"], dict):
        known = {key for model in KINDS.values() for key in model.model_fields}
        odd = next((key for key in error["input"] if key not in known), None)
        if odd is not None:
            return (*path, odd), f"unknown key{nearest(odd, KINDS)}"
    if error["type"] == "extra_forbidden":
        return path, f"unknown key{nearest(name, _known_keys(path[:-1], values))}"
    if error["type"] == "missing":
        if path == ("layer",):
            return path, NO_LAYER
        return path, "this key is needed and missing"
    if path == ("surftex",):
        return path, f"{error['input']!r}: this surftex reads version 1 of the format; write surftex = 1"
    if path in (("mesh",), ("bake",)) and not isinstance(error["input"], dict):
        return path, f"write [{name}] on a line by itself, and its keys on the lines below{_TABLES[name]}"
    return path, told(error)


def _key_path(location: tuple[str | int, ...], values: dict[str, Any]) -> Path:
    """Keep of pydantic's location what stands in the recipe: no tags of unions, no names of types."""
    path: list[str | int] = []
    rest = list(location)
    if rest[:1] == ["fields_"]:
        rest[0] = "fields"
    if rest[:1] == ["layer"] and len(rest) > 2 and rest[2] == "material":
        del rest[2]
    if rest[:1] == ["fields"] and len(rest) > 2 and (rest[2] in KINDS or rest[2] == "expression"):
        del rest[2]
    node: Any = values
    for step in rest:
        inside = isinstance(node, dict) or (isinstance(step, int) and isinstance(node, (list, tuple)))
        if not inside:
            break
        if isinstance(node, dict) and step not in node and any(mark in str(step) for mark in "[(-"):
            break
        path.append(step)
        node = node.get(step) if isinstance(node, dict) else dict(enumerate(node)).get(int(step))
    return tuple(path)


def _known_keys(path: Path, values: dict[str, Any]) -> list[str]:
    from surftex.recipe.model import BakeSettings, MeshSettings, Recipe

    match path:
        case ():
            return [field.alias or name for name, field in Recipe.model_fields.items()]
        case ("mesh",):
            return list(MeshSettings.model_fields)
        case ("bake",):
            return list(BakeSettings.model_fields)
        case ("layer", _):
            table = _value_at(values, path) or {}
            return ["material", "preset", "mask", *(key for key in _material_keys(table) if key != "kind")]
        case ("fields", _):
            table = _value_at(values, path) or {}
            return [key for kind, model in KINDS.items() if kind in table for key in model.model_fields]
    return []


def _material_keys(table: dict[str, Any]) -> list[str]:
    try:
        kind = table.get("material") or preset_material(table.get("preset", ""))
        return list(material_class(kind).model_fields)
    except RecipeError:
        return []


def _value_at(values: Any, path: Path) -> Any:
    for step in path:
        try:
            values = values[step]
        except (KeyError, IndexError, TypeError):
            return None
    return values


def _joined(path: Path, values: dict[str, Any]) -> str:
    """Write a path as a user would: layers counted from 1, the only layer without a number."""
    text = ""
    for i, step in enumerate(path):
        if isinstance(step, int):
            only = path[0] == "layer" and i == 1 and len(values.get("layer", ())) == 1
            text += "" if only else f"[{step + 1}]"
        else:
            text += f".{step}" if text else step
    return text or "recipe"


def _check_names(recipe: "Recipe", where: Where) -> None:
    """Read every expression, and look up every name in them, before any mesh is loaded."""
    from surftex.fields.fieldset import check_name, refuse_circles

    values = {"layer": recipe.layer}

    def located(path: Path, problem: RecipeError) -> RecipeError:
        return RecipeError(f"{where(path)}{_joined(path, values)}: {problem}")

    directions = {name for name, entry in recipe.fields_.items() if isinstance(entry, DIRECTIONS)}
    curves = {name for name, entry in recipe.fields_.items() if isinstance(entry, CURVES)}
    numbers = {*recipe.fields_} - directions - curves
    needs: dict[str, Expression] = {}
    for name, entry in recipe.fields_.items():
        try:
            check_name(name)
            text = expression_of(entry)
            if text is not None:
                needs[name] = _checked_expression(text, numbers, directions, curves)
        except RecipeError as problem:
            key = (
                ("distance_to",)
                if isinstance(entry, BaseModel) and "distance_to" in type(entry).model_fields
                else ()
            )
            raise located(("fields", name, *key), problem) from None
    try:
        refuse_circles(needs)
    except RecipeError as problem:
        raise located(("fields",), problem) from None
    for i, layer in enumerate(recipe.layer):
        for key, text in _expressions(layer).items():
            try:
                _checked_expression(text, numbers, directions, curves)
            except RecipeError as problem:
                raise located(("layer", i, key), problem) from None
        for key, name in drawn_names(layer, "_curves").items():
            if name not in curves:
                hint = nearest(name, curves) or "; [fields] has none"
                what = f"curves {name!r} do not exist{hint}"
                if name in numbers | directions:
                    what = f"field {name!r} is a {'number' if name in numbers else 'direction'}, not curves"
                raise located(("layer", i, key), RecipeError(what))
        places = {name for name, entry in recipe.fields_.items() if places_file(entry) is not None}
        for key, name in drawn_names(layer, "_points").items():
            if name not in places:
                hint = nearest(name, places) or '; write one such as spots = { distance_to = "spots.json" }'
                raise located(("layer", i, key), RecipeError(f"places {name!r} do not exist{hint}"))
        for key, name in _directions(layer).items():
            if name not in directions:
                kind = f"does not exist{nearest(name, directions) or '; [fields] has none'}"
                if name in numbers | curves:
                    kind = f"is {'a number' if name in numbers else 'curves'}, not a direction"
                what = RecipeError(f"field {name!r} {kind}")
                raise located(("layer", i, key), what)


def _checked_expression(
    value: str | float, numbers: set[str], directions: set[str], curves: set[str]
) -> "Expression":
    from surftex.fields.expressions import Expression
    from surftex.units import length_mm

    try:
        expression = Expression.parse(value)
    except RecipeError as problem:
        words = str(value).split()
        if len(words) == 2 and words[0].replace(".", "", 1).isdigit():
            length_mm(str(value))
        raise problem from None
    for name in sorted(expression.names):
        if name in directions:
            raise RecipeError(f"{expression.text!r}: field {name!r} is a direction, not a number")
        if name in curves:
            raise RecipeError(f"{expression.text!r}: field {name!r} is curves, not a number; try distance_to")
        if name not in numbers:
            hint = nearest(name, numbers) or "; [fields] has none"
            raise RecipeError(f"{expression.text!r}: unknown field {name!r}{hint}")
    return expression


def _expressions(layer: Layer) -> dict[str, str]:
    """Parameters that may be numbers and are text."""
    found = {"mask": str(layer.mask)} if isinstance(layer.mask, str) else {}
    for key, field in type(layer.material).model_fields.items():
        value = getattr(layer.material, key)
        if isinstance(value, str) and float in plain_types(field.annotation):
            found[key] = value
    return found


def _directions(layer: Layer) -> dict[str, str]:
    """Parameters that name a direction: text or nothing, and no file."""
    return {
        key: value
        for key, field in type(layer.material).model_fields.items()
        if isinstance(value := getattr(layer.material, key), str)
        and plain_types(field.annotation) == {str, type(None)}
        and not key.endswith(("_curves", "_points"))
        and key not in getattr(layer.material, "files", ())
    }
