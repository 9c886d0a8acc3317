"""Reading recipes: from a TOML file, or from the name of a preset, with the changes of a command line."""

import re
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from surftex.errors import RecipeError
from surftex.recipe import lines
from surftex.recipe.changes import change
from surftex.recipe.fields import named_files
from surftex.recipe.layer import preset_material
from surftex.recipe.mistakes import checked_recipe
from surftex.recipe.model import Recipe
from surftex.units import MM_PER_UNIT

_LARGEST_BYTES = 4 * 2**20

_BARE_LENGTH = re.compile(rf"=\s*[-+.\d]+\s*({'|'.join(MM_PER_UNIT)})\s*(#.*)?$")


def load_recipe(path: str | Path, *, allow_outside: bool = False, changes: Iterable[str] = ()) -> Recipe:
    """Read a recipe from a file.

    Parameters
    ----------
    path : path
        A TOML file.
    allow_outside : bool
        Whether the files it names may lie outside its folder.
    changes : iterable of str
        ``key=value``, as of ``--set``.

    Returns
    -------
    recipe : Recipe
        With the paths it names made absolute.

    Raises
    ------
    RecipeError
        With file, line and key.
    """
    file = Path(path)
    return recipe_from_text(
        read_text(file), name=str(file), folder=file.parent, allow_outside=allow_outside, changes=changes
    )


def recipe_from_text(
    text: str,
    *,
    name: str = "recipe",
    folder: Path | None = None,
    allow_outside: bool = False,
    changes: Iterable[str] = (),
) -> Recipe:
    """Read a recipe from text.

    Parameters
    ----------
    text : str
        TOML.
    name : str
        What messages call it.
    folder : Path, optional
        Where the paths it names start; the current folder without it.
    allow_outside : bool
        Whether those paths may leave the folder.
    changes : iterable of str
        ``key=value``, as of ``--set``.

    Returns
    -------
    recipe : Recipe
        With the paths it names made absolute.

    Raises
    ------
    RecipeError
        With name, line and key.
    """
    values, known = parsed(text, name)
    where = lines.Places(name, known, {change(values, each): each for each in changes})
    recipe = checked_recipe(values, where)
    return _with_paths(recipe, folder or Path(), where, allow_outside=allow_outside).located(where)


def recipe_from_preset(name: str, *, changes: Iterable[str] = ()) -> Recipe:
    """Make the recipe of a preset.

    Parameters
    ----------
    name : str
        Of the preset, of any material.
    changes : iterable of str
        ``key=value``, as of ``--set``.

    Returns
    -------
    recipe : Recipe
        With one layer.

    Raises
    ------
    RecipeError
        If there is no such preset, or a change does not fit.
    """
    values: dict[str, Any] = {"surftex": 1, "layer": [{"material": preset_material(name), "preset": name}]}
    where = lines.Places(changes={change(values, each): each for each in changes})
    return checked_recipe(values, where).located(where)


def recipe_for(material: str | Path, *, allow_outside: bool = False, changes: Iterable[str] = ()) -> Recipe:
    """Read what a command calls a material: a preset's name or a recipe's file.

    Parameters
    ----------
    material : str or path
        Text that ends in ``.toml`` is a file.
    allow_outside : bool
        Whether the files that a recipe names may lie outside its folder.
    changes : iterable of str
        ``key=value``, as of ``--set``.

    Returns
    -------
    recipe : Recipe
        Checked as far as can be known without its mesh.

    Raises
    ------
    RecipeError
        If there is no such preset or file, or it is wrong.
    """
    if str(material).lower().endswith(".toml"):
        return load_recipe(material, allow_outside=allow_outside, changes=changes)
    return recipe_from_preset(str(material), changes=changes)


def parsed(text: str, name: str) -> tuple[dict[str, Any], dict[lines.Path, int]]:
    """Parse TOML.

    Parameters
    ----------
    text : str
        TOML.
    name : str
        What messages call it.

    Returns
    -------
    values : dict
        As written.
    known : dict of tuple to int
        Line of each key.

    Raises
    ------
    RecipeError
        With name and line.
    """
    try:
        return tomllib.loads(text), lines.key_lines(text)
    except tomllib.TOMLDecodeError as problem:
        what, _, place = str(problem).partition(" (at line ")
        number = int(place.split(",")[0]) if place else text.rstrip().count("\n") + 1
        written = (text.split("\n")[number - 1 : number] or [""])[0].strip()
        hint = "; write a length in quotes" if _BARE_LENGTH.search(written) else ""
        raise RecipeError(f"{name}:{number}: {what[:1].lower() + what[1:]}: {written:.60}{hint}") from None
    except RecursionError:
        raise RecipeError(f"{name}: nested too deeply to be read") from None
    except ValueError:  # of int, which tells no line
        raise RecipeError(f"{name}: a number has too many digits to be read") from None


def read_text(file: Path, *, what: str = "recipe") -> str:
    """Read the text of a recipe or a batch.

    Parameters
    ----------
    file : Path
        UTF-8, at most 4 MiB.
    what : str
        What messages call it.

    Returns
    -------
    text : str
        With plain line ends.

    Raises
    ------
    RecipeError
        If it cannot be read, is too large, or is no text.
    """
    try:
        if not file.is_file():
            problem = "is no file" if file.exists() else "does not exist"
            raise RecipeError(f"the {what} {str(file)!r} {problem}")
        if file.stat().st_size > _LARGEST_BYTES:
            raise RecipeError(f"the {what} {str(file)!r} has {file.stat().st_size} bytes; is it a {what}?")
        return file.read_bytes().decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as problem:
        line = problem.object[: problem.start].count(b"\n") + 1
        raise RecipeError(f"{file}:{line}: not UTF-8 text; save the {what} as UTF-8") from None
    except (OSError, ValueError) as problem:
        if isinstance(problem, RecipeError):
            raise
        reason = getattr(problem, "strerror", None) or problem
        raise RecipeError(f"the {what} {str(file)!r} cannot be read: {reason}") from None


def _with_paths(recipe: Recipe, folder: Path, where: Any, *, allow_outside: bool) -> Recipe:
    """Make the paths that a recipe names absolute, and keep them inside its folder."""
    root = folder.resolve()

    def inside(text: str, path: lines.Path) -> str:
        label = f"{where(path)}{'.'.join(map(str, path))}"
        try:
            found = (root / text).resolve()
        except (OSError, ValueError, RuntimeError) as problem:
            raise RecipeError(f"{label}: {text!r} is no path: {problem}") from None
        if not allow_outside and not found.is_relative_to(root):
            raise RecipeError(
                f"{label}: {text!r} leaves the recipe's folder; allow it with allow_outside (--allow-outside)"
            )
        return str(found)

    mesh, fields = recipe.mesh, dict(recipe.fields_)
    if mesh.path is not None:
        mesh = mesh.model_copy(update={"path": inside(mesh.path, ("mesh", "path"))})
    for name, entry in fields.items():
        for key in named_files(entry):
            place = inside(getattr(entry, key), ("fields", name, key))
            fields[name] = fields[name].model_copy(update={key: place})  # type: ignore[union-attr]
    layers = list(recipe.layer)
    for i, layer in enumerate(layers):
        for key in layer.named_files:
            place = inside(getattr(layer.material, key), ("layer", i, key))
            material = layers[i].material.model_copy(update={key: place})
            layers[i] = layers[i].model_copy(update={"material": material})
    return recipe.model_copy(update={"mesh": mesh, "fields_": fields, "layer": tuple(layers)})


def recipe_files(recipe: Recipe) -> list[Path]:
    """List the files that a recipe's fields and layers name.

    Parameters
    ----------
    recipe : Recipe
        From `load_recipe`.

    Returns
    -------
    paths : list of Path
        In the order of the fields, then of the layers; the mesh is not among them.
    """
    found: dict[Path, None] = {}
    for entry in recipe.fields_.values():
        found.update((Path(getattr(entry, key)), None) for key in named_files(entry))
    for layer in recipe.layer:
        found.update((Path(getattr(layer.material, key)), None) for key in layer.named_files)
    return list(found)
