"""`JOBS.toml`: meshes times materials times seeds, and single jobs beside them, as a list of complete recipes."""

import errno
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from surftex.errors import RecipeError
from surftex.recipe import lines
from surftex.recipe.batch_file import BatchFile, BatchOptions, JobEntry, Where, read_batch
from surftex.recipe.compose import composed
from surftex.recipe.finding import alike, matching, short_names
from surftex.recipe.model import BakeSettings, MeshSettings, Recipe

REPORT = "batch-report.json"
"""File beside the folders of the jobs."""

_MOST_JOBS = 1_000_000
_LONGEST_NAME = 200
"""Bytes: file systems take 255, and what is hidden beside a folder while it is made has a longer name."""


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
    written, where = read_batch(file)
    return _Reader(written, file.parent.resolve() / file.name, where, allow_outside=allow_outside).batch()


class _Reader:
    """Turns a batch as it is written into jobs."""

    def __init__(self, written: BatchFile, file: Path, where: Where, *, allow_outside: bool) -> None:
        self.written, self.root, self.where, self.allow_outside = written, file.parent, where, allow_outside
        self.file, self.out = file, self.inside(written.out, ("out",))
        self.recipes: dict[tuple[str, tuple[str, ...]], Recipe] = {}
        self.taken: dict[str, str] = {}
        self.names: dict[Path, str] = {}
        self.labels: dict[Path, str] = {}
        self.presets: set[str] = set()

    def batch(self) -> Batch:
        written = self.written
        if bool(written.meshes) != bool(written.materials):
            missing = "materials" if written.meshes else "meshes"
            raise RecipeError(f"{self.where(())}{missing}: this key is needed beside the other")
        jobs = [*self.product(), *self.singles()]
        if not jobs:
            raise RecipeError(f"{self.where(())}no jobs; give meshes and materials, or [[job]] tables")
        return Batch(tuple(jobs), self.out)

    def product(self) -> list[Job]:
        written = self.written
        meshes = self.files(written.meshes, "meshes", lambda text: True)
        materials = self.files(written.materials, "materials", _is_file)
        seeds = tuple(dict.fromkeys(written.seeds)) or (None,)
        if len(meshes) * len(materials) * len(seeds) > _MOST_JOBS:
            raise RecipeError(f"{self.where(('meshes',))}more than {_MOST_JOBS:,} jobs; split the batch")
        self.names = short_names((Path(mesh) for mesh in meshes), self.root)
        self.presets = {material for material in materials if not _is_file(material)}
        recipes = [Path(material) for material in materials if _is_file(material)]
        self.labels = short_names(recipes, self.root, taken=self.presets, suffixes=False)
        jobs = []
        for mesh in meshes:
            for material, path in materials.items():
                name = f"{self.names[Path(mesh)]}-{self.labels.get(Path(material), material)}"
                first = self.job(name, material, Path(mesh), seeds[0], JobEntry(), path)
                for seed in seeds:
                    own = name if seed is None else f"{name}-{seed}"
                    recipe = first.recipe if seed is None else first.recipe.model_copy(update={"seed": seed})
                    self.take(own, ("meshes",), "meshes")
                    jobs.append(Job(own, recipe))
        return jobs

    def files(
        self, written: tuple[str, ...], key: str, is_file: Callable[[str], bool]
    ) -> dict[str, lines.Path]:
        """Find what a list of names and globs means, each once, and where it is written."""
        found: dict[str, lines.Path] = {}
        for i, text in enumerate(written):
            path = (key, i)
            if not is_file(text):
                found.setdefault(text, path)
                continue
            try:
                matches = matching(text, self.root, self.is_own)
            except RecipeError as problem:
                raise RecipeError(f"{self.where(path)}{key}: {problem}") from None
            names = [text] if matches is None else [str(each.relative_to(self.root)) for each in matches]
            for name in names:
                found.setdefault(str(self.inside(name, path)), path)
        return found

    def is_own(self, file: Path) -> bool:
        """Tell what a glob leaves out: this batch, and what it has baked."""
        return file == self.file or (self.out != self.root and file.is_relative_to(self.out))

    def take(self, name: str, path: lines.Path, key: str) -> None:
        """Refuse what cannot be a folder beside the report, or is another job's."""
        if not name.isprintable():
            problem = f"{name!r:.60} cannot be a folder: a letter of it cannot be shown"
        elif len(os.fsencode(name)) > _LONGEST_NAME:
            problem = f"{name!r:.60}... is too long for a folder; at most {_LONGEST_NAME} bytes"
        elif name.casefold() == REPORT:
            problem = f"{name!r} is the report of the batch; give the job another folder"
        elif alike(name) in self.taken:
            other = self.taken[alike(name)]
            both = repr(other) if other == name else f"{other!r} and {name!r}, one folder on many disks"
            mend = "give it another out" if path[0] == "job" else "write one of them as a [[job]] with an out"
            problem = f"two jobs write to {both}; {mend}"
        else:
            self.taken[alike(name)] = name
            return
        raise RecipeError(f"{self.where(path)}{key}: {problem}")

    def singles(self) -> list[Job]:
        """Read the single jobs; their names leave those of the product as they are."""
        meshes, recipes = [], []
        for i, entry in enumerate(self.written.job):
            path: lines.Path = ("job", i)
            if (entry.material is None) == (entry.recipe is None):
                raise RecipeError(f"{self.where(path)}job: give either material or recipe")
            key = "recipe" if entry.recipe else "material"
            material = entry.recipe or entry.material or ""
            is_file = entry.recipe is not None or _is_file(material)
            recipes.append(str(self.inside(material, (*path, key))) if is_file else material)
            meshes.append(None if entry.mesh is None else self.inside(entry.mesh, (*path, "mesh")))
            if entry.mesh is None and entry.recipe is None:
                raise RecipeError(f"{self.where(path)}job: a material needs a mesh")
        files = [Path(each) for each in recipes if _is_file(each)]
        presets = {each for each in recipes if not _is_file(each)} | self.presets
        labels = self.further(files, self.labels, presets, suffixes=False)
        names = self.further(filter(None, meshes), self.names, set(), suffixes=True)
        return [self.single(i, meshes[i], recipes[i], names, labels) for i in range(len(meshes))]

    def further(
        self, files: Iterable[Path], known: dict[Path, str], taken: set[str], *, suffixes: bool
    ) -> dict[Path, str]:
        """Name files beside those that the product has named."""
        taken = {*taken, *known.values(), *(file.stem for file in known)}
        new = (file for file in files if file not in known)
        return known | short_names(new, self.root, taken=taken, suffixes=suffixes)

    def single(
        self, index: int, mesh: Path | None, material: str, names: dict[Path, str], labels: dict[Path, str]
    ) -> Job:
        entry, path = self.written.job[index], ("job", index)
        name = entry.out or "-".join(
            [
                *([] if mesh is None else [names[mesh]]),
                labels.get(Path(material), material),
                *([] if entry.seed is None else [str(entry.seed)]),
            ]
        )
        if Path(name).name != name or name.startswith("."):
            raise RecipeError(f"{self.where((*path, 'out'))}job.out: {name!r} is no name of a folder")
        self.take(name, (*path, "out"), "job.out" if entry.out else "job")
        return self.job(
            name, material, mesh, entry.seed, entry, (*path, "recipe" if entry.recipe else "material")
        )

    def job(
        self, name: str, material: str, mesh: Path | None, seed: int | None, entry: JobEntry, path: lines.Path
    ) -> Job:
        own = {key: value for key in BatchOptions.model_fields if (value := getattr(entry, key)) is not None}
        given = {key: own.get(key, getattr(self.written, key)) for key in BatchOptions.model_fields}
        changes = (*self.written.set, *entry.set)
        try:
            recipe = self.recipe(material, changes)
            if mesh is None and recipe.mesh.path is None:
                raise RecipeError(f"{material}: names no mesh; add mesh to the job, or path under its [mesh]")
        except RecipeError as problem:
            text = str(problem)
            for i, each in enumerate(changes):
                if text.startswith((f"--set {each}", f"--set {each!r}")):
                    k = i - len(self.written.set)
                    path = ("set", i) if k < 0 else (*path[:2], "set", k)
                    text = text.removeprefix("--")
                    break
            raise RecipeError(f"{self.where(path)}{text}") from None
        settings = {key: given[key] for key in BakeSettings.model_fields if key in given}
        scale = {key: given[key] for key in MeshSettings.model_fields if key in given}
        try:
            return Job(name, composed(recipe, mesh, scale, seed=seed, **settings))
        except RecipeError as problem:  # options that do not go together
            text = str(problem).removeprefix("bake: ")
            key = next(
                (key for key, value in given.items() if value is not None and key in text.split()), None
            )
            if key is not None:
                path = (*path[:2], key) if key in own else (key,)
            raise RecipeError(f"{self.where(path)}{text}") from None

    def recipe(self, named: str, changes: tuple[str, ...]) -> Recipe:
        from surftex.recipe.read import recipe_for

        if (named, changes) not in self.recipes:
            self.recipes[named, changes] = recipe_for(
                named, allow_outside=self.allow_outside, changes=changes
            )
        return self.recipes[named, changes]

    def inside(self, text: str, path: lines.Path) -> Path:
        key = next(str(step) for step in reversed(path) if isinstance(step, str))
        try:
            place = (self.root / text).resolve()
        except (OSError, ValueError, RuntimeError) as problem:
            raise RecipeError(f"{self.where(path)}{key}: {text!r} is no path: {problem}") from None
        if _too_long(place):
            raise RecipeError(f"{self.where(path)}{key}: {text[:60]!r}... is too long for a path")
        if not self.allow_outside and not place.is_relative_to(self.root):
            raise RecipeError(
                f"{self.where(path)}{key}: {text!r} leaves the batch's folder; allow it with --allow-outside"
            )
        return place


def _is_file(material: str) -> bool:
    return material.lower().endswith(".toml")


def _too_long(place: Path) -> bool:
    try:
        place.lstat()
    except OSError as problem:
        return problem.errno == errno.ENAMETOOLONG
    return False
