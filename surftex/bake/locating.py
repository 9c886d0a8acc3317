"""Where in a recipe a mistake stands that only shows on a surface."""

import re
from collections.abc import Iterator
from contextlib import contextmanager

from surftex.errors import InputError, RecipeError
from surftex.recipe.model import Recipe

_KEY = re.compile(r"\w+\.(\w+): ")
"""A message that names a key: of a material, or of the fields."""


@contextmanager
def located(recipe: Recipe | None, *path: str | int, label: str = "") -> Iterator[None]:
    """Put the file, the line and a label before what is wrong with a part of a recipe.

    Parameters
    ----------
    recipe : Recipe or None
        Which knows where its keys were written; None changes no message.
    *path : str or int
        Of the table that is worked with; the key is that which the message names.
    label : str
        Such as ``"layer[2]"``.

    Yields
    ------
    None
        While it is worked with.

    Raises
    ------
    RecipeError
        In place of any `InputError`; as it is where its message has a line already.
    """
    try:
        yield
    except InputError as problem:
        if recipe is None:
            raise
        text = str(problem)
        key = _KEY.match(text)
        where = recipe.where(*path, *key.groups() if key else ())
        known = bool(where) and text.startswith(where.split(":")[0])
        raise RecipeError(text if known else f"{where}{label}{label and ': '}{text}") from None
