"""`Checked`: models whose mistakes are told in one line, in the words of the command."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from surftex.errors import RecipeError
from surftex.materials.hints import nearest

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)

Model = TypeVar("Model", bound="Checked")

MOST_TOLD = 8
"""Mistakes that a line names; of more it tells how many."""


class _Told(ModelMetaclass):
    """Turns what is wrong with a call of the class into one line; validation inside another model is left as it is."""

    def __call__(self: type[Model], *arguments: Any, **values: Any) -> Model:  # type: ignore[misc]
        try:
            return super().__call__(*arguments, **values)  # type: ignore[misc]
        except ValidationError as problem:
            raise RecipeError(self.mistakes(problem, values)) from None


class Checked(BaseModel, metaclass=_Told):
    """What a user writes: it never changes, and an unknown key is a mistake."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, values: Any) -> Any:
        """Take numpy's numbers as Python's."""
        if not isinstance(values, Mapping):
            return values
        return {
            key: value.item() if isinstance(value, np.generic) else value for key, value in values.items()
        }

    @classmethod
    def mistakes(cls, problem: ValidationError, values: Mapping[str, Any]) -> str:
        """Tell what is wrong with values of this model.

        Parameters
        ----------
        problem : ValidationError
            Of this model alone.
        values : mapping
            That were given.

        Returns
        -------
        text : str
            One line: each key, with what is wrong, and what may have been meant.
        """
        field = cls.model_fields.get("kind")
        name = cls.__name__ if field is None else field.default
        found: dict[str, str] = {}
        for error in problem.errors(include_url=False):
            key, *rest = error["loc"] or ("",)
            place = "".join(f"[{step + 1}]" for step in rest if isinstance(step, int))
            text = told(error)
            if error["type"] == "extra_forbidden":
                text = f"unknown key{nearest(str(key), [key for key in cls.model_fields if key != 'kind'])}"
            elif error["type"] == "missing":
                text = "this key is needed and missing"
            found.setdefault(str(key), f"{name}.{key}{place}: {text}" if key else f"{name}: {text}")
        return in_one_line(found.values())


def told(error: Mapping[str, Any]) -> str:
    """Say what is wrong with a value.

    Parameters
    ----------
    error : mapping
        One of pydantic's.

    Returns
    -------
    text : str
        With the value, where the reason does not show it.
    """
    text = str(error["msg"]).removeprefix("Value error, ")
    if str(error["input"]) == "nan" and error["type"].startswith(("less_than", "greater_than")):
        text = "Input should be a finite number"
    if text.startswith("Input "):
        return f"{_shown(error['input'])}: {text.removeprefix('Input ')}"
    return text


def in_one_line(mistakes: Iterable[str]) -> str:
    """Put mistakes into a line.

    Parameters
    ----------
    mistakes : iterable of str
        Each located.

    Returns
    -------
    text : str
        All of them, or the first `MOST_TOLD` and how many more there are.
    """
    every = list(mistakes)
    more = len(every) - MOST_TOLD
    rest = f"; and {more} more mistake{'s' if more > 1 else ''}" if more > 0 else ""
    return "; also ".join(every[:MOST_TOLD]) + rest


def _shown(value: Any) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."
