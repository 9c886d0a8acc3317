"""Failures, by who can mend them: one line each, saying what is wrong, where, and how to mend it."""

from collections.abc import Iterator
from contextlib import contextmanager


class SurftexError(Exception):
    """Any failure that surftex foresees; `exit_code` is what the command returns for it."""

    exit_code = 3


class InputError(SurftexError, ValueError):
    """What was handed in is wrong, and its owner can mend it."""

    exit_code = 2


class MeshFileError(InputError):
    """A mesh file that cannot be read, or holds no surface."""


class SurfaceError(InputError):
    """Arrays that do not describe a surface, or points that do not lie on it."""


class RecipeError(InputError):
    """A recipe, preset, parameter or option that does not fit."""


class WorkError(SurftexError):
    """The input was right and the work failed: disk full, a killed child, memory."""


@contextmanager
def naming(name: str) -> Iterator[None]:
    """Put the name of a parameter before what is wrong with it.

    Parameters
    ----------
    name : str
        Such as ``"skin.freckle_where"``.

    Yields
    ------
    None
        While the parameter is worked with.

    Raises
    ------
    RecipeError
        In place of an `InputError` whose message has no such name yet.
    """
    try:
        yield
    except InputError as problem:
        text = str(problem)
        raise RecipeError(text if text.startswith(f"{name}: ") else f"{name}: {text}") from None
