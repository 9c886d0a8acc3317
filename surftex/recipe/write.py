"""Writing a recipe to start from."""

import json
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from surftex.recipe.fields import named_files
from surftex.recipe.layer import Layer, material_class
from surftex.recipe.model import BakeSettings, MeshSettings, Recipe


def starter(material: str, preset: str, caption: str, parameters: dict[str, Any]) -> str:
    """Write a preset as a recipe.

    Parameters
    ----------
    material : str
        Name of the material.
    preset : str
        Name of the preset.
    caption : str
        What it looks like.
    parameters : dict
        What the preset sets.

    Returns
    -------
    text : str
        TOML that bakes the same, with every parameter of the preset written out to be changed.
    """
    rows = [
        f"# {preset}: {' '.join(caption.split())}",
        "surftex = 1",
        "seed = 0",
        "",
        "[bake]",
        "resolution = 2048",
    ]
    rows += ["", "[[layer]]", f"material = {toml_value(material)}"]
    rows += [f"{key} = {toml_value(value)}" for key, value in parameters.items()]
    return "\n".join(rows) + "\n"


def recipe_text(recipe: Recipe, folder: Path) -> str:
    """Write a recipe out.

    Parameters
    ----------
    recipe : Recipe
        What to write.
    folder : Path
        Where the file will lie: paths inside it are written as seen from there, others in full.

    Returns
    -------
    text : str
        TOML that reads back as an equal recipe; of layers and tables, what differs from preset and defaults.
    """
    root = folder.resolve()

    def path(text: str) -> str:
        place = Path(text).resolve()
        return place.relative_to(root).as_posix() if place.is_relative_to(root) else str(place)

    rows = ["surftex = 1", f"seed = {recipe.seed}"]
    mesh = {**_differing(recipe.mesh, MeshSettings())}
    if recipe.mesh.path is not None:
        mesh["path"] = path(recipe.mesh.path)
    for name, table in (("mesh", mesh), ("bake", _differing(recipe.bake, BakeSettings()))):
        if table:
            rows += ["", f"[{name}]", *(f"{key} = {toml_value(value)}" for key, value in table.items())]
    if recipe.fields_:
        rows += ["", "[fields]"]
    for name, entry in recipe.fields_.items():
        value: Any = entry
        if isinstance(entry, BaseModel):
            value = entry.model_dump(mode="json", exclude_none=True)
            value |= {key: path(value[key]) for key in named_files(entry)}
        rows.append(f"{name} = {toml_value(value)}")
    for layer in recipe.layer:
        rows += [
            "",
            "[[layer]]",
            *(f"{key} = {toml_value(value)}" for key, value in _layer_table(layer).items()),
        ]
    return "\n".join(rows) + "\n"


def _differing(model: BaseModel, base: BaseModel) -> dict[str, Any]:
    values, usual = model.model_dump(mode="json"), base.model_dump(mode="json")
    return {key: value for key, value in values.items() if value != usual[key]}


def _layer_table(layer: Layer) -> dict[str, Any]:
    """Collect what a layer says beyond its preset; beyond the defaults, where the preset sets what it leaves out."""
    model, table = material_class(layer.kind), {"material": layer.kind}
    if layer.preset is not None:
        differing = _differing(layer.material, model.preset(layer.preset))
        table["preset"] = layer.preset
    else:
        differing = _differing(layer.material, model())
    if any(value is None for value in differing.values()):
        table.pop("preset", None)
        differing = {
            key: value for key, value in _differing(layer.material, model()).items() if value is not None
        }
    mask = {} if layer.mask == 1 else {"mask": layer.mask}
    return {**table, **mask, **differing}


def toml_value(value: Any) -> str:
    """Write one value as TOML.

    Parameters
    ----------
    value : Any
        Text, number, truth, or a list or table of them.

    Returns
    -------
    text : str
        TOML on one line.

    Raises
    ------
    TypeError
        For anything else.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml_value(each)}" for key, each in value.items()) + " }"
    raise TypeError(f"TOML has no {type(value).__name__}")
