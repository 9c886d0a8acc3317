"""A layer of a recipe: one material, from the shelf or written out, and where it lies."""

import importlib
import types
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Union, get_args, get_origin

from pydantic import (
    BaseModel,
    Field,
    SerializeAsAny,
    StrictFloat,
    StrictInt,
    StrictStr,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from surftex.errors import RecipeError
from surftex.materials.checked import Checked
from surftex.materials.hints import nearest

if TYPE_CHECKING:
    from collections.abc import Mapping

MATERIALS: "Mapping[str, tuple[str, str]]" = {
    "leather": ("surftex.materials.leather.model", "Leather"),
    "cells": ("surftex.materials.cells.model", "Cells"),
    "skin": ("surftex.materials.skin.model", "Skin"),
    "composite": ("surftex.materials.composite.model", "Composite"),
}
"""Name of each material, and where its class is."""


def material_class(name: str) -> Any:
    """Look up the class of a material.

    Parameters
    ----------
    name : str
        One of `MATERIALS`.

    Returns
    -------
    material : type
        A pydantic model with `preset`, `presets` and `place`.

    Raises
    ------
    RecipeError
        If there is none of that name.
    """
    if name not in MATERIALS:
        raise RecipeError(f"unknown material {name!r}{nearest(name, MATERIALS)}")
    module, attribute = MATERIALS[name]
    return getattr(importlib.import_module(module), attribute)


def all_presets() -> dict[str, dict[str, str]]:
    """List the shelves of all materials.

    Returns
    -------
    presets : dict of str to dict
        For each material, what each preset looks like, by name.
    """
    return {name: material_class(name).presets() for name in MATERIALS}


def preset_material(name: str) -> str:
    """Find the material that has a preset.

    Parameters
    ----------
    name : str
        Of the preset.

    Returns
    -------
    material : str
        One of `MATERIALS`.

    Raises
    ------
    RecipeError
        If no shelf holds it; the message names the nearest.
    """
    shelves = all_presets()
    for material, presets in shelves.items():
        if name in presets:
            return material
    known = [preset for presets in shelves.values() for preset in presets]
    hint = nearest(name, known) or "; surftex presets lists them"
    raise RecipeError(f"there is no preset {name!r}{hint}")


class Layer(Checked):
    """A material and where it lies.

    In TOML the material's parameters stand in the same table: ``material = "leather"``, ``preset = "calf"``,
    ``cell_size = "0.9 mm"``, ``mask = "1 - toe"``. Either of material and preset may be left out.
    """

    material: SerializeAsAny[BaseModel]
    preset: StrictStr | None = Field(
        default=None, description="Where the parameters start from; the table's own keys go before it."
    )
    mask: StrictFloat | StrictInt | StrictStr = Field(
        default=1.0,
        description="How much the layer covers, 0 to 1: a number, or an expression over the fields.",
    )

    @model_validator(mode="before")
    @classmethod
    def _gather(cls, table: Any) -> Any:
        """Put the keys of a flat table where they belong."""
        if not isinstance(table, dict) or isinstance(table.get("material"), BaseModel):
            return table
        own = {key: table[key] for key in ("preset", "mask") if key in table}
        kind, preset = table.get("material"), table.get("preset")
        for key, value in (("material", kind), ("preset", preset)):
            if value is not None and not isinstance(value, str):
                raise at_key(key, f"{value!r} is not the name of a {key}")
        if kind is None and preset is None:
            raise at_key("material", f"a layer needs a material ({', '.join(MATERIALS)}) or a preset")
        key = "material" if kind is not None else "preset"
        try:
            kind = preset_material(str(preset)) if kind is None else str(kind)
            model = material_class(kind)
            key = "preset"
            base = _preset_parameters(kind, preset)
        except RecipeError as problem:
            raise at_key(key, str(problem)) from None
        rest = {key: value for key, value in table.items() if key not in ("material", "preset", "mask")}
        return {**own, "material": (model, {**base, **rest})}

    @field_validator("material", mode="before")
    @classmethod
    def _material(cls, value: Any) -> Any:
        """Check the material's parameters by its own class."""
        if isinstance(value, tuple):
            model, parameters = value
            for key, given in parameters.items():
                field = model.model_fields.get(key)
                if (
                    isinstance(given, bool)
                    and field is not None
                    and bool not in plain_types(field.annotation)
                ):
                    raise at_key(key, f"{str(given).lower()} is neither a number nor text")
            return model.model_validate(parameters)
        return value

    @property
    def kind(self) -> str:
        """Name of the material."""
        return str(getattr(self.material, "kind", type(self.material).__name__.lower()))

    @property
    def named_files(self) -> tuple[str, ...]:
        """Keys of the material that name files; a value without a suffix is the name of something on the shelf."""
        keys = getattr(self.material, "files", ())
        return tuple(key for key in keys if PurePath(str(getattr(self.material, key) or "")).suffix)

    def table(self) -> dict[str, Any]:
        """Write the layer out as a flat table with every default.

        Returns
        -------
        table : dict
            JSON types only.
        """
        parameters = self.material.model_dump(mode="json", exclude={"kind"})
        preset = {} if self.preset is None else {"preset": self.preset}
        return {"material": self.kind, **preset, "mask": self.mask, **parameters}


def drawn_names(layer: Layer, end: str) -> dict[str, str]:
    """List what was drawn for a layer.

    Parameters
    ----------
    layer : Layer
        Of a recipe.
    end : str
        How the parameters end that name it: ``"_curves"`` or ``"_points"``.

    Returns
    -------
    names : dict of str to str
        By parameter.
    """
    return {
        key: value
        for key in type(layer.material).model_fields
        if key.endswith(end) and isinstance(value := getattr(layer.material, key), str)
    }


def at_key(key: str, problem: str) -> PydanticCustomError:
    """Make a validation error that knows which key of its table it means.

    Parameters
    ----------
    key : str
        Of the table being validated.
    problem : str
        What is wrong.

    Returns
    -------
    error : PydanticCustomError
        To raise.
    """
    return PydanticCustomError("at_key", "{problem}", {"problem": problem, "key": key})


def plain_types(annotation: Any) -> set[Any]:
    """Take an annotation apart.

    Parameters
    ----------
    annotation : type
        Of a field.

    Returns
    -------
    types : set
        What it is a union of, without limits and validators.
    """
    if get_origin(annotation) in (Union, types.UnionType):
        return set[Any]().union(*(plain_types(each) for each in get_args(annotation)))
    if hasattr(annotation, "__metadata__"):
        return plain_types(get_args(annotation)[0])
    return {annotation}


def _preset_parameters(kind: str, preset: str | None) -> dict[str, Any]:
    if preset is None:
        return {}
    from surftex.materials.presets import parameters

    return parameters(kind, preset)
