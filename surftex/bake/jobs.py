"""One job of a batch: what tells it apart, whether it is done, doing it, in this process or far away.

A job is known by a key over the bytes of its mesh, of every file that its recipe names, the complete recipe and
the version of surftex. The key stands in the job's ``report.json`` beside the hash of each file; a job counts as
done when all of them still match.
"""

import hashlib
import json
import os
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from surftex.errors import InputError, SurftexError, WorkError
from surftex.files.locks import locked
from surftex.files.meshes import mesh_files
from surftex.files.output import check_output, file_hashes, whole_output
from surftex.files.reading import read_bytes
from surftex.recipe.batch import Job
from surftex.recipe.model import Recipe
from surftex.recipe.read import recipe_files

LOCKS = ".surftex-batch"
"""Folder inside the output that holds a lock for each job, and so tells which folders a batch made."""


@dataclass(frozen=True)
class Task:
    """What a worker is handed; it can be pickled.

    Attributes
    ----------
    recipe : Recipe
        Complete, with the path of its mesh.
    key : str
        From `job_key`.
    folder : str or None
        Where the worker writes; None means that it hands the files back.
    contents : mapping of str to bytes, or None
        Bytes of the mesh and of all files that the recipe names, by path; None means that the worker reads them.
    overwrite : bool
        Whether files of an earlier job may be replaced.
    threads : int
        Of the bake; cannot change a byte.
    """

    recipe: Recipe
    key: str
    folder: str | None
    contents: Mapping[str, bytes] | None
    overwrite: bool
    threads: int


@dataclass(frozen=True)
class Outcome:
    """How a job ended.

    Attributes
    ----------
    problem : str or None
        One line where it failed.
    exit_code : int
        0, or the code that the command would have ended with.
    wall_s : float
        Of the job.
    peak_rss_mb : float
        Of its process so far.
    files : mapping of str to bytes
        Where the worker was to hand them back.
    warnings : tuple of str
        Of the bake.
    """

    problem: str | None = None
    exit_code: int = 0
    wall_s: float = 0.0
    peak_rss_mb: float = 0.0
    files: Mapping[str, bytes] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()


def job_contents(recipe: Recipe) -> dict[str, bytes]:
    """Read the mesh and every file that a recipe names.

    Parameters
    ----------
    recipe : Recipe
        With the path of its mesh.

    Returns
    -------
    contents : dict of str to bytes
        By path.

    Raises
    ------
    MeshFileError
        If one cannot be read.
    """
    mesh = Path(recipe.mesh.path or "")
    found = {str(path): read_bytes(path) for path in mesh_files(mesh)}
    return found | {
        str(path): read_bytes(path, purpose="file of the recipe") for path in recipe_files(recipe)
    }


def job_key(recipe: Recipe, contents: Mapping[str, bytes]) -> str:
    """Tell a job from all others that would give other bytes.

    Parameters
    ----------
    recipe : Recipe
        Complete.
    contents : mapping of str to bytes
        From `job_contents`.

    Returns
    -------
    key : str
        SHA-256 in hexadecimal. Where the files lie does not matter, what they hold and their names do.
    """
    from surftex import __version__

    named = {path: f"{Path(path).name} {hashlib.sha256(data).hexdigest()}" for path, data in contents.items()}
    told = [__version__, _renamed(recipe.written_out(), named), sorted(named.values())]
    digest = hashlib.sha256(json.dumps(told, sort_keys=True).encode())
    return digest.hexdigest()


def is_done(folder: Path, key: str) -> bool:
    """Tell whether a folder holds what a job gives, whole.

    Parameters
    ----------
    folder : Path
        Of the job.
    key : str
        From `job_key`.

    Returns
    -------
    done : bool
        True when its report carries the key and every file listed there has its hash.
    """
    try:
        report = json.loads((folder / "report.json").read_text("utf-8"))
        listed = dict(report["outputs"])
        return report.get("job_key") == key and listed.items() <= file_hashes(folder).items()
    except (OSError, ValueError, KeyError, TypeError):
        return False


def told_warnings(folder: Path) -> tuple[str, ...]:
    """Read again what the bake of a job that is done had warned of.

    Parameters
    ----------
    folder : Path
        Of a job that `is_done`.

    Returns
    -------
    warnings : tuple of str
        A line each.
    """
    return tuple(json.loads((folder / "report.json").read_text("utf-8")).get("warnings", ()))


def prepared(job: Job, folder: Path, *, overwrite: bool) -> None:
    """Clear what a killed job left, and refuse a folder that no batch made.

    Parameters
    ----------
    job : Job
        Whose lock is held.
    folder : Path
        Of the job.
    overwrite : bool
        Whether a folder that no batch made may be written to.

    Raises
    ------
    InputError
        If the folder holds files of somebody else.
    WorkError
        If it cannot be written to.
    """
    check_output(folder, overwrite=True)
    check_made(job, folder, overwrite=overwrite)
    try:
        _mark(job, folder).touch()
    except OSError as problem:
        raise WorkError(f"{folder}: cannot write: {problem.strerror}") from None


def check_made(job: Job, folder: Path, *, overwrite: bool) -> None:
    """Refuse a folder that no batch made.

    Parameters
    ----------
    job : Job
        Any.
    folder : Path
        Of the job.
    overwrite : bool
        Whether such a folder may be written to.

    Raises
    ------
    InputError
        If the folder holds files of somebody else.
    WorkError
        If it cannot be read.
    """
    try:
        strange = (
            not overwrite and not _mark(job, folder).exists() and folder.is_dir() and any(folder.iterdir())
        )
    except OSError as problem:
        raise WorkError(f"{folder}: cannot write: {problem.strerror}") from None
    if strange:
        raise InputError(
            f"{folder} holds files that no batch made; move them away, or allow it with --overwrite"
        )


def _mark(job: Job, folder: Path) -> Path:
    return folder.parent / LOCKS / f"{job.name}.made"


@contextmanager
def job_lock(out: Path, name: str) -> Iterator[bool]:
    """Keep other batches from a job.

    Parameters
    ----------
    out : Path
        Output of the batch.
    name : str
        Of the job.

    Yields
    ------
    held : bool
        False if another batch is at it. The lock ends with the block, or with the process, however it dies.

    Raises
    ------
    WorkError
        If the output cannot be written to.
    """
    try:
        (out / LOCKS).mkdir(parents=True, exist_ok=True)
        lock = locked(out / LOCKS / f"{name}.lock")
    except OSError as problem:
        raise WorkError(f"{out}: cannot write, or lock what is written: {problem.strerror}") from None
    with lock or nullcontext():
        yield lock is not None


def perform(task: Task) -> Outcome:
    """Do a job, in whichever process this is.

    Parameters
    ----------
    task : Task
        What to do.

    Returns
    -------
    outcome : Outcome
        Failures included; nothing is raised but interruptions.
    """
    from surftex.bake.stages import peak_rss_mb

    started = time.perf_counter()
    problem, code, files, warnings = None, 0, {}, ()
    try:
        files, warnings = _performed(task)
    except SurftexError as failure:
        problem, code = str(failure), failure.exit_code
    except MemoryError:
        problem, code = "not enough memory; lower the resolution, or use fewer workers", WorkError.exit_code
    except Exception as failure:  # noqa: BLE001  (one job must not take the others with it)
        problem, code = f"unexpected failure: {type(failure).__name__}: {failure}", WorkError.exit_code
    return Outcome(problem, code, round(time.perf_counter() - started, 3), peak_rss_mb(), files, warnings)


def _performed(task: Task) -> tuple[dict[str, bytes], tuple[str, ...]]:
    """Do a job; gives the files that are handed back, and the warnings of the bake."""
    if task.contents is None and task.folder is not None:
        return {}, _bake_into(task.recipe, task, Path(task.folder))
    with tempfile.TemporaryDirectory(prefix="surftex-") as scratch:
        recipe = task.recipe
        if task.contents is not None:
            recipe = _unpacked(recipe, task.contents, Path(scratch) / "in")
        folder = Path(task.folder) if task.folder is not None else Path(scratch) / "out"
        warnings = _bake_into(recipe, task, folder)
        if task.folder is not None:
            return {}, warnings
        return {path.name: path.read_bytes() for path in folder.iterdir()}, warnings


def _bake_into(recipe: Recipe, task: Task, folder: Path) -> tuple[str, ...]:
    """Bake and save; the report names the recipe as it was given, and the job's key. Gives the warnings."""
    from surftex.bake.bake import run
    from surftex.bake.saving import save

    baked = run(recipe, threads=task.threads, remember=True)
    report = {**baked.maps.report, "recipe": task.recipe.written_out(), "job_key": task.key}
    maps = replace(baked.maps, report=report)
    save(replace(baked, maps=maps), folder, overwrite=task.overwrite, threads=task.threads)
    return tuple(report["warnings"])


def write_files(folder: Path, files: Mapping[str, bytes], *, overwrite: bool) -> None:
    """Write what a worker handed back: all of it, or nothing.

    Parameters
    ----------
    folder : Path
        Of the job.
    files : mapping of str to bytes
        By name.
    overwrite : bool
        Whether files of an earlier job may be replaced.

    Raises
    ------
    WorkError
        If the disk does not take them.
    """
    with whole_output(folder, overwrite=overwrite) as workplace:
        for name, data in files.items():
            (workplace / Path(name).name).write_bytes(data)


def _unpacked(recipe: Recipe, contents: Mapping[str, bytes], scratch: Path) -> Recipe:
    """Write the files of a job into a folder, and let the recipe name them there."""
    root = Path(os.path.commonpath([str(Path(path).parent) for path in contents]))
    moved = {}
    for path, data in contents.items():
        place = scratch / Path(path).relative_to(root)
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(data)
        moved[path] = str(place)
    mesh = recipe.mesh.model_copy(update={"path": moved[str(recipe.mesh.path)]})
    fields = {}
    for name, written in recipe.fields_.items():
        entry: Any = written
        if isinstance(entry, BaseModel):
            here = {key: moved[value] for key, value in entry if isinstance(value, str) and value in moved}
            entry = entry.model_copy(update=here)
        fields[name] = entry
    layers = []
    for layer in recipe.layer:
        material: Any = layer.material
        here = {key: moved[str(getattr(material, key))] for key in layer.named_files}
        layers.append(layer.model_copy(update={"material": material.model_copy(update=here)}))
    return recipe.model_copy(update={"mesh": mesh, "fields_": fields, "layer": tuple(layers)})


def _renamed(value: Any, named: Mapping[str, str]) -> Any:
    """Put names for paths, wherever they stand in JSON."""
    if isinstance(value, dict):
        return {key: _renamed(each, named) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_renamed(each, named) for each in value]
    return named.get(value, value) if isinstance(value, str) else value
