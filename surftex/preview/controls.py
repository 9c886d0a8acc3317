"""Controls made from the parameters of a material: what a window or a page shows for each."""

import types
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, Union, get_args, get_origin

import numpy as np
from pydantic import BaseModel

from surftex.errors import InputError
from surftex.recipe.layer import material_class

Kind = Literal["number", "whole", "switch", "choice", "colour", "range", "text"]

_LARGEST = 1e6
"""Limits beyond this are there to catch mistakes, and no end of a slider."""


@dataclass(frozen=True)
class Control:
    """What is shown for one parameter.

    Attributes
    ----------
    key : str
        Name of the parameter.
    group : str
        Group it stands in.
    text : str
        One sentence about it.
    kind : str
        number, whole, switch, choice, colour (three linear numbers), range (two numbers) or text.
    unit : str
        ``mm`` or nothing.
    low : float
        Left end of its slider.
    high : float
        Right end; values beyond it may be typed.
    choices : tuple of str
        Of a choice.
    """

    key: str
    group: str
    text: str
    kind: Kind
    unit: str = ""
    low: float = 0.0
    high: float = 1.0
    choices: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """Name to be read."""
        return self.key.replace("_", " ")

    @property
    def step(self) -> float:
        """Least step of its slider."""
        return (
            1.0 if self.kind == "whole" else float(10.0 ** np.floor(np.log10((self.high - self.low) / 200)))
        )

    def shown(self, value: Any) -> str:
        """Write a value as it is shown beside a slider.

        Parameters
        ----------
        value : Any
            Of the parameter.

        Returns
        -------
        text : str
            With its unit.
        """
        if isinstance(value, bool):
            return "yes" if value else "no"
        if value is None:
            return "-"
        if isinstance(value, (tuple, list)):
            return " ".join(f"{each:.3g}" if isinstance(each, float) else str(each) for each in value)
        text = f"{value:.3g}" if isinstance(value, float) else str(value)
        return f"{text} {self.unit}" if self.unit and not isinstance(value, str) else text


def controls(material: BaseModel) -> tuple[Control, ...]:
    """Make the controls of a material, with ranges that hold what it is set to.

    Parameters
    ----------
    material : BaseModel
        Such as a `Leather`.

    Returns
    -------
    controls : tuple of Control
        In the order of its parameters; those that share a group are neighbours.
    """
    made = []
    for key in type(material).model_fields:
        if key == "kind":
            continue
        made.append(_control(type(material), key, getattr(material, key, None)))
    order = list(dict.fromkeys(control.group for control in made))
    return tuple(sorted(made, key=lambda control: order.index(control.group)))


def _control(model: type[BaseModel], key: str, value: Any) -> Control:
    field = model.model_fields[key]
    extra = field.json_schema_extra
    group = str(extra.get("group", "other")) if isinstance(extra, dict) else "other"
    text = field.description or ""
    kinds, limits, choices = _taken_apart(field.annotation, list(field.metadata))
    if choices:
        return Control(key, group, text, "choice", choices=choices)
    if kinds == {bool}:
        return Control(key, group, text, "switch")
    low, high = limits.get("low", -np.inf), limits.get("high", np.inf)
    unit = "mm" if limits.get("length") else ""
    numeric = bool(kinds & {int, float})
    if "tuple3" in kinds and "color" in key:
        return Control(key, group, text, "colour")
    if "tuple2" in kinds:
        top = _top(high, [*value, *_usual(model, key)], 2, whole=False)
        return Control(key, group, text, "range", unit, max(low, 0.0), top)
    if not numeric or isinstance(value, str) or value is None or isinstance(value, tuple):
        return Control(key, group, text, "text", unit)
    whole = float not in kinds
    top = _top(high, [value, *_usual(model, key)], 1, whole=whole)
    bottom = low if low > -_LARGEST else min(0.0, float(value))
    return Control(
        key, group, text, "whole" if whole else "number", unit, float(bottom), max(top, bottom + 1e-6)
    )


def _top(high: float, values: list[Any], count: int, *, whole: bool) -> float:
    """Right end of a slider: the limit, or a round number well above what it is set to, or usually is."""
    if high <= _LARGEST:
        return float(high)
    own, usual = values[:count], sorted(abs(float(each)) for each in values[count:] if each)
    most = 4.0 * max((abs(float(each)) for each in own), default=0.0)
    most = most or (2.0 * usual[len(usual) // 2] if usual else 20.0 if whole else 1.0)
    power = 10.0 ** np.floor(np.log10(most))
    top = float(next(each for each in (1, 2, 3, 5, 8, 10) if each * power >= most) * power)
    return max(top, 10.0) if whole else top


@cache
def _usual(model: type[BaseModel], key: str) -> tuple[float, ...]:
    """Give the default of a parameter, and what presets set it to."""
    values: list[Any] = [model.model_fields[key].default]
    kind = str(getattr(model.model_fields.get("kind"), "default", ""))
    try:
        from surftex.materials.presets import parameters

        values += [parameters(kind, name).get(key) for name in material_class(kind).presets()]
    except InputError:
        pass
    flat: list[float] = []
    for value in values:
        for each in value if isinstance(value, (tuple, list)) else [value]:
            number = each
            if isinstance(each, str) and each[:1].isdigit():
                number = _length(each)
            if isinstance(number, (int, float)) and not isinstance(number, bool):
                flat.append(float(number))
    return tuple(flat)


def _length(text: str) -> float | None:
    from surftex.units import length_mm

    try:
        return length_mm(text)
    except InputError:
        return None


def _taken_apart(annotation: Any, metadata: list[Any]) -> tuple[set[Any], dict[str, Any], tuple[str, ...]]:
    """Types of a parameter, its limits, whether it is a length, and its choices."""
    kinds, limits, choices = set[Any](), dict[str, Any](), tuple[str, ...]()
    for mark in metadata:
        for name, end in (("ge", "low"), ("gt", "low"), ("le", "high"), ("lt", "high")):
            if getattr(mark, name, None) is not None:
                limits[end] = float(getattr(mark, name))
        inner = getattr(mark, "metadata", None)
        if inner:
            limits |= _taken_apart(None, list(inner))[1]
        if getattr(getattr(mark, "func", None), "__name__", "") == "_length":
            limits["length"] = True
    origin = get_origin(annotation)
    if origin is Literal:
        choices = tuple(str(each) for each in get_args(annotation))
    elif origin in (Union, types.UnionType):
        for each in get_args(annotation):
            more, far, words = _taken_apart(each, [])
            kinds |= more
            limits |= far
            choices += words
    elif hasattr(annotation, "__metadata__"):
        return _merged(_taken_apart(get_args(annotation)[0], list(annotation.__metadata__)), kinds, limits)
    elif origin is tuple:
        parts = get_args(annotation)
        _, inside, _ = _taken_apart(parts[0], [])
        limits = {**inside, **limits}
        kinds.add(f"tuple{len(parts)}" if Ellipsis not in parts else "tuple")
    elif annotation is not None:
        kinds.add(annotation)
    return kinds, limits, choices


def _merged(
    found: tuple[set[Any], dict[str, Any], tuple[str, ...]], kinds: set[Any], limits: dict[str, Any]
) -> tuple[set[Any], dict[str, Any], tuple[str, ...]]:
    return found[0] | kinds, {**found[1], **limits}, found[2]
