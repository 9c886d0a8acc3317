"""`JOBS.toml`: meshes times materials times seeds, and single jobs beside them, as a list of complete recipes."""

import os
import tomllib
import unicodedata
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, StrictInt, StrictStr, ValidationError

from surftex.errors import RecipeError
from surftex.recipe import lines
from surftex.recipe.compose import composed
from surftex.recipe.hints import nearest
from surftex.recipe.model import BakeSettings, MeshSettings, Recipe
from surftex.recipe.read import read_text

REPORT = "batch-report.json"
"""File beside the folders of the jobs."""

_MOST_JOBS = 1_000_000
_LONGEST_NAME = 200
"""Bytes: file systems take 255, and what is hidden beside a folder while it is made has a longer name."""

Words = Annotated[
    tuple[StrictStr, ...], BeforeValidator(lambda value: [value] if isinstance(value, str) else value)
]


class _Options(BaseModel):
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
    materialx: Any = None
    usd: Any = None
    usd_format: Any = None
    max_features: Any = None
    units: Any = None
    size: Any = None
    part: Any = None
    set: Words = ()


class JobEntry(_Options):
    """One job beside the product: a mesh with a material, or a recipe that names its own."""

    mesh: StrictStr | None = None
    material: StrictStr | None = None
    recipe: StrictStr | None = None
    seed: StrictInt | None = None
    out: StrictStr | None = None


class BatchFile(_Options):
    """A batch as it is written."""

    surftex: Literal[1] = 1
    meshes: Words = ()
    materials: Words = ()
    seeds: tuple[StrictInt, ...] = ()
    out: StrictStr = "out"
    job: tuple[JobEntry, ...] = ()


@dataclass(frozen=True)
class Job:
    """One bake of a batch.

    Attributes
    ----------
    name : str
        Of its folder inside the batch's output.
    recipe : Recipe
        Complete, with the absolute path of its mesh.
    """

    name: str
    recipe: Recipe


@dataclass(frozen=True)
class Batch:
    """The jobs of a batch, in the order in which they are written.

    Attributes
    ----------
    jobs : tuple of Job
        With names of their own.
    out : Path
        The folder that holds a folder for each.
    """

    jobs: tuple[Job, ...]
    out: Path


def load_batch(path: str | Path, *, allow_outside: bool = False) -> Batch:
    """Read a batch from a TOML file.

    Parameters
    ----------
    path : path
        Of the file; the paths and globs in it start from its folder.
    allow_outside : bool
        Whether they may leave that folder.

    Returns
    -------
    batch : Batch
        Meshes times materials times seeds, then the single jobs. Meshes need not exist yet, where they are
        not found by a glob.

    Raises
    ------
    RecipeError
        With file, line and key, in one line.
    """
    file = Path(path)
    text = read_text(file, what="batch")
    values, where = _parsed(text, str(file))
    written = _validated(values, where)
    return _Reader(written, file.parent.resolve(), where, allow_outside=allow_outside).batch()


Where = Callable[[lines.Path], str]


def _parsed(text: str, name: str) -> tuple[dict[str, Any], Where]:
    try:
        values, known = tomllib.loads(text), lines.key_lines(text)
    except tomllib.TOMLDecodeError as problem:
        what, _, place = str(problem).partition(" (at line ")
        line = place.split(",")[0] if place else str(text.count("\n") + 1)
        raise RecipeError(f"{name}:{line}: {what[:1].lower() + what[1:]}") from None
    except RecursionError:
        raise RecipeError(f"{name}: nested too deeply to be read") from None
    except ValueError:  # of int, which tells no line
        raise RecipeError(f"{name}: a number has too many digits to be read") from None

    def where(path: lines.Path) -> str:
        line = next((known[path[:n]] for n in range(len(path), 0, -1) if path[:n] in known), None)
        return f"{name}: " if line is None else f"{name}:{line}: "

    return values, where


def _validated(values: dict[str, Any], where: Where) -> BatchFile:
    try:
        return BatchFile.model_validate(values)
    except ValidationError as problem:
        error = problem.errors(include_url=False)[0]
        path = tuple(error["loc"])
        key = ".".join(str(step + 1) if isinstance(step, int) else step for step in path)
        if error["type"] == "extra_forbidden":
            model = JobEntry if path[0] == "job" else BatchFile
            text = f"unknown key{nearest(str(path[-1]), model.model_fields)}"
        else:
            text = str(error["msg"])
            text = text[:1].lower() + text[1:]
        raise RecipeError(f"{where(path)}{key}: {text}") from None


class _Reader:
    """Turns a batch as it is written into jobs."""

    def __init__(self, written: BatchFile, root: Path, where: Where, *, allow_outside: bool) -> None:
        self.written, self.root, self.where, self.allow_outside = written, root, where, allow_outside
        self.recipes: dict[tuple[str, tuple[str, ...]], Recipe] = {}

    def batch(self) -> Batch:
        written = self.written
        if bool(written.meshes) != bool(written.materials):
            missing = "materials" if written.meshes else "meshes"
            raise RecipeError(f"{self.where(())}{missing}: this key is needed beside the other")
        jobs = [*self.product(), *(self.single(i, entry) for i, entry in enumerate(written.job))]
        if not jobs:
            raise RecipeError(f"{self.where(())}no jobs; give meshes and materials, or [[job]] tables")
        taken: dict[str, str] = {}
        for job in jobs:
            alike = unicodedata.normalize("NFC", job.name).casefold()
            if alike in taken:
                other = taken[alike]
                both = (
                    repr(other)
                    if other == job.name
                    else f"{other!r} and {job.name!r}, one folder on many disks"
                )
                raise RecipeError(
                    f"{self.where(('job',))}two jobs write to {both}; give one of them another out"
                )
            taken[alike] = job.name
        return Batch(tuple(jobs), self.inside(written.out, ("out",)))

    def product(self) -> list[Job]:
        written = self.written
        meshes, seeds = self.meshes(), written.seeds or (None,)
        if len(meshes) * len(written.materials) * len(seeds) > _MOST_JOBS:
            raise RecipeError(f"{self.where(('meshes',))}more than {_MOST_JOBS:,} jobs; split the batch")
        names = _distinct(meshes, self.root)
        jobs = []
        for mesh in meshes:
            for i, material in enumerate(written.materials):
                name = f"{names[mesh]}-{Path(material).stem if _is_file(material) else material}"
                first = self.job(name, material, mesh, seeds[0], JobEntry(), ("materials", i))
                jobs += [
                    first
                    if seed is None
                    else Job(f"{name}-{seed}", first.recipe.model_copy(update={"seed": seed}))
                    for seed in seeds
                ]
        for job in jobs:
            self.check_folder(job.name, ("meshes",), "meshes")
        return jobs

    def check_folder(self, name: str, path: lines.Path, key: str) -> None:
        """Refuse what cannot be a folder beside the report."""
        if not name.isprintable():
            problem = f"{name!r:.60} cannot be a folder: a letter of it cannot be shown"
        elif len(os.fsencode(name)) > _LONGEST_NAME:
            problem = f"{name!r:.60}... is too long for a folder; at most {_LONGEST_NAME} bytes"
        elif name.casefold() == REPORT:
            problem = f"{name!r} is the report of the batch; give the job another folder"
        else:
            return
        raise RecipeError(f"{self.where(path)}{key}: {problem}")

    def single(self, index: int, entry: JobEntry) -> Job:
        path: lines.Path = ("job", index)
        if (entry.material is None) == (entry.recipe is None):
            raise RecipeError(f"{self.where(path)}job: give either material or recipe")
        material = entry.recipe or entry.material or ""
        mesh = None if entry.mesh is None else self.inside(entry.mesh, (*path, "mesh"))
        if mesh is None and entry.recipe is None:
            raise RecipeError(f"{self.where(path)}job: a material needs a mesh")
        label = Path(material).stem if _is_file(material) else material
        name = entry.out or "-".join(
            [
                *([] if mesh is None else [mesh.stem]),
                label,
                *([] if entry.seed is None else [str(entry.seed)]),
            ]
        )
        if Path(name).name != name or name.startswith("."):
            raise RecipeError(f"{self.where((*path, 'out'))}job.out: {name!r} is no name of a folder")
        self.check_folder(name, (*path, "out"), "job.out")
        key = "recipe" if entry.recipe else "material"
        return self.job(name, material, mesh, entry.seed, entry, (*path, key))

    def job(
        self, name: str, material: str, mesh: Path | None, seed: int | None, entry: JobEntry, path: lines.Path
    ) -> Job:
        given = {
            key: mine if (mine := getattr(entry, key)) is not None else getattr(self.written, key)
            for key in _Options.model_fields
            if key != "set"
        }
        named = str(self.inside(material, path)) if _is_file(material) else material
        try:
            recipe = self.recipe(named, (*self.written.set, *entry.set))
            settings = {key: given[key] for key in BakeSettings.model_fields if key in given}
            scale = {key: given[key] for key in MeshSettings.model_fields if key in given}
            if mesh is None and recipe.mesh.path is None:
                raise RecipeError(f"{material}: names no mesh; add mesh to the job, or path under its [mesh]")
            return Job(name, composed(recipe, mesh, scale, seed=seed, **settings))
        except RecipeError as problem:
            raise RecipeError(f"{self.where(path)}{problem}") from None

    def recipe(self, named: str, changes: tuple[str, ...]) -> Recipe:
        from surftex.recipe.read import recipe_for

        if (named, changes) not in self.recipes:
            self.recipes[named, changes] = recipe_for(
                named, allow_outside=self.allow_outside, changes=changes
            )
        return self.recipes[named, changes]

    def meshes(self) -> list[Path]:
        found: dict[Path, None] = {}
        out = Path(os.path.normpath(self.root / self.written.out))  # what earlier runs have baked
        for i, pattern in enumerate(self.written.meshes):
            path = ("meshes", i)
            if not any(mark in pattern for mark in "*?["):
                found[self.inside(pattern, path)] = None
                continue
            if Path(pattern).is_absolute() or ".." in Path(pattern).parts:
                raise RecipeError(
                    f"{self.where(path)}meshes: {pattern!r} leaves the batch's folder; name those files one by one"
                )
            try:
                matches = sorted(
                    each
                    for each in self.root.glob(pattern)
                    if each.is_file() and (out == self.root or not each.is_relative_to(out))
                )
            except (ValueError, OSError) as problem:
                raise RecipeError(f"{self.where(path)}meshes: {pattern!r} is no pattern: {problem}") from None
            if not matches:
                raise RecipeError(f"{self.where(path)}meshes: nothing matches {pattern!r} in {self.root}")
            found.update((self.inside(str(each.relative_to(self.root)), path), None) for each in matches)
        return list(found)

    def inside(self, text: str, path: lines.Path) -> Path:
        key = next(str(step) for step in reversed(path) if isinstance(step, str))
        try:
            place = (self.root / text).resolve()
        except (OSError, ValueError, RuntimeError) as problem:
            raise RecipeError(f"{self.where(path)}{key}: {text!r} is no path: {problem}") from None
        if not self.allow_outside and not place.is_relative_to(self.root):
            raise RecipeError(
                f"{self.where(path)}{key}: {text!r} leaves the batch's folder; allow it with --allow-outside"
            )
        return place


def _is_file(material: str) -> bool:
    return material.lower().endswith(".toml")


def _distinct(meshes: list[Path], root: Path) -> dict[Path, str]:
    """Name each mesh by its stem, or, where two share one, by its path below the batch."""
    stems = Counter(mesh.stem for mesh in meshes)
    names = {}
    for mesh in meshes:
        below = mesh.relative_to(root) if mesh.is_relative_to(root) else Path(*mesh.parts[1:])
        names[mesh] = mesh.stem if stems[mesh.stem] == 1 else "-".join(below.parts)
    return names
