"""Writing a recipe to start from."""

import json
from typing import Any


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
