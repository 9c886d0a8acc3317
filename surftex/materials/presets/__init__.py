"""The shelf: one TOML file per preset, named as users name it, in a folder per material."""

import tomllib
from functools import cache
from importlib.resources import files
from typing import Any, TypeVar

from surftex.errors import RecipeError
from surftex.materials.checked import Checked
from surftex.materials.hints import nearest

Model = TypeVar("Model", bound=Checked)


@cache
def _shelf(kind: str) -> dict[str, dict[str, Any]]:
    shelf = {}
    for file in sorted(files(__name__).joinpath(kind).iterdir(), key=lambda file: file.name):
        if file.name.endswith(".toml"):
            shelf[file.name.removesuffix(".toml")] = tomllib.loads(file.read_text("utf-8"))
    return shelf


def captions(kind: str) -> dict[str, str]:
    """List the presets of a material.

    Parameters
    ----------
    kind : str
        The material, such as ``"leather"``.

    Returns
    -------
    captions : dict of str to str
        What each looks like, by name.
    """
    return {name: values["caption"] for name, values in _shelf(kind).items()}


def shelved(kind: str, suffix: str) -> list[str]:
    """List the files beside the presets of a material.

    Parameters
    ----------
    kind : str
        The material.
    suffix : str
        End of their names.

    Returns
    -------
    names : list of str
        Without the suffix, in order.
    """
    here = files(__name__).joinpath(kind).iterdir()
    return sorted(file.name.removesuffix(suffix) for file in here if file.name.endswith(suffix))


def parameters(kind: str, name: str) -> dict[str, Any]:
    """Read what a preset sets.

    Parameters
    ----------
    kind : str
        The material.
    name : str
        The preset.

    Returns
    -------
    parameters : dict
        As written in the file, without the caption; a preset that builds on another holds both.

    Raises
    ------
    RecipeError
        If there is none of that name; the message names the nearest.
    """
    shelf = _shelf(kind)
    if not isinstance(name, str):
        raise RecipeError(f"{kind} preset {name!r}: a preset is named by text, such as {next(iter(shelf))!r}")
    if name not in shelf:
        raise RecipeError(f"there is no {kind} preset {name!r}{nearest(name, shelf)}")
    values = {key: value for key, value in shelf[name].items() if key != "caption"}
    base = values.pop("base", None)
    return {**parameters(kind, base), **values} if base else values


def preset(model: type[Model], name: str, changes: dict[str, Any]) -> Model:
    """Make a material from a preset.

    Parameters
    ----------
    model : type
        The material's class; its `kind` names the folder.
    name : str
        The preset.
    changes : dict
        Parameters to set otherwise.

    Returns
    -------
    material : BaseModel
        Checked, with all parameters written out.

    Raises
    ------
    RecipeError
        If the preset is unknown, or a change does not fit.
    """
    kind = model.model_fields["kind"].default
    return model(**{**parameters(kind, name), **changes})
