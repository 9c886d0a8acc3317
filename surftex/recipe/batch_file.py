"""A batch as it is written: its keys, and what is wrong with one of them alone."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, StrictInt, StrictStr, ValidationError

from surftex.errors import RecipeError
from surftex.materials.checked import told
from surftex.materials.hints import nearest
from surftex.recipe import lines
from surftex.recipe.model import BakeSettings, MeshSettings
from surftex.recipe.read import parsed, read_text

Words = Annotated[
    tuple[StrictStr, ...], BeforeValidator(lambda value: [value] if isinstance(value, str) else value)
]


class BatchOptions(BaseModel):
    """What a job and the whole batch may say about how to bake; None leaves what the recipe says."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    resolution: Any = None
    maps: Any = None
    gutter: Any = None
    unwrapper: Any = None
    uv: Any = None
    equalise: Any = None
    udim: Any = None
    texels_per_mm: Any = None
    displaced: Any = None
    displaced_format: Any = None
    displaced_edge: Any = None
    materialx: Any = None
    usd: Any = None
    usd_format: Any = None
    max_features: Any = None
    units: Any = None
    size: Any = None
    part: Any = None
    crease: Any = None
    set: Words = ()


class JobEntry(BatchOptions):
    """One job beside the product: a mesh with a material, or a recipe that names its own."""

    mesh: StrictStr | None = None
    material: StrictStr | None = None
    recipe: StrictStr | None = None
    seed: StrictInt | None = None
    out: StrictStr | None = None


class BatchFile(BatchOptions):
    """A batch as it is written."""

    surftex: Literal[1] = 1
    meshes: Words = ()
    materials: Words = ()
    seeds: tuple[StrictInt, ...] = ()
    out: StrictStr = "out"
    job: tuple[JobEntry, ...] = ()


Where = Callable[[lines.Path], str]


def read_batch(file: Path) -> tuple[BatchFile, Where]:
    """Read the file of a batch.

    Parameters
    ----------
    file : Path
        TOML.

    Returns
    -------
    written : BatchFile
        Each option is right by itself.
    where : callable
        Says where a key stands.

    Raises
    ------
    RecipeError
        With file, line and key, in one line.
    """
    values, known = parsed(read_text(file, what="batch"), str(file))
    where = _where(str(file), known)
    return _validated(values, where), where


def _where(name: str, known: dict[lines.Path, int]) -> Where:
    def where(path: lines.Path) -> str:
        line = next((known[path[:n]] for n in range(len(path), 0, -1) if path[:n] in known), None)
        return f"{name}: " if line is None else f"{name}:{line}: "

    return where


def _validated(values: dict[str, Any], where: Where) -> BatchFile:
    try:
        written = BatchFile.model_validate(values)
    except ValidationError as problem:
        error = problem.errors(include_url=False)[0]
        path = tuple(error["loc"])
        if error["type"] == "extra_forbidden":
            model = JobEntry if path[0] == "job" else BatchFile
            text = f"unknown key{nearest(str(path[-1]), model.model_fields)}"
        else:
            text = told(error)
        raise RecipeError(f"{where(path)}{joined(path)}: {text}") from None
    _check_options(written, (), where)
    for i, entry in enumerate(written.job):
        _check_options(entry, ("job", i), where)
    return written


def _check_options(entry: BatchOptions, path: lines.Path, where: Where) -> None:
    """Check each option alone, so that a mistake is told where it stands."""
    for model in (BakeSettings, MeshSettings):
        for key in BatchOptions.model_fields.keys() & model.model_fields:
            value = getattr(entry, key)
            try:
                model.model_validate({} if value is None else {key: value})
            except ValidationError as problem:
                for error in problem.errors(include_url=False):
                    if error["loc"]:  # others are of options that do not go together, which `composed` tells
                        label = joined((*path, key))
                        raise RecipeError(f"{where((*path, key))}{label}: {told(error)}") from None


def joined(path: lines.Path) -> str:
    """Write a path as a user would, counted from 1."""
    text = "".join(f"[{step + 1}]" if isinstance(step, int) else f".{step}" for step in path)
    return text.removeprefix(".")
