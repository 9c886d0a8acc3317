"""``surftex batch``: many bakes from one file."""

import sys
from argparse import Namespace
from typing import Any

from surftex.bake.batch import BatchResult, JobResult
from surftex.cli.say import note, out
from surftex.cli.watch import COMPILING
from surftex.errors import InputError, RecipeError, SurftexError, WorkError
from surftex.recipe.batch import REPORT, Batch, Job, load_batch


def run(options: Namespace) -> None:
    """Do the jobs of a batch, a line each, and a summary.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    SurftexError
        If the batch itself is wrong, or jobs have failed.
    """
    if options.shared_files and not options.scheduler:
        raise RecipeError("--shared-files says something of a cluster; add --scheduler, or leave it out")
    batch = load_batch(options.subject, allow_outside=options.allow_outside)
    if options.dry_run:
        _plan(batch, options)
        return

    from surftex.bake.batch import run_batch
    from surftex.bake.executors import cluster_workers, local_workers

    lending: Any = (
        cluster_workers(options.scheduler, options.workers, None if options.quiet else note)
        if options.scheduler
        else local_workers(options.workers, starting=lambda: _warm(batch, options))
    )
    try:
        with lending as workers, _Watch(options, len(batch.jobs)) as watch:
            result = run_batch(
                batch, workers, resume=options.resume, keep_going=options.keep_going, overwrite=options.overwrite,
                by_bytes=bool(options.scheduler) and not options.shared_files, told=watch,
            )  # fmt: skip
    except KeyboardInterrupt as cut:
        raise KeyboardInterrupt(str(cut) or "interrupted; the same command goes on") from None
    _sum_up(batch, result, options)


def _warm(batch: Batch, options: Namespace) -> None:
    """Compile kernels before there are several workers that would."""
    from surftex.kernels import store

    cold = store.cold(layer.kind for job in batch.jobs for layer in job.recipe.layer)
    if not cold:
        return
    if not options.quiet:
        note(COMPILING)
    from surftex.kernels.ahead import compile_all

    compile_all(cold)
    store.mark_warm(cold)


def _sum_up(batch: Batch, result: BatchResult, options: Namespace) -> None:
    report = batch.out / REPORT
    if options.json:
        out(report.read_text("utf-8").rstrip())
    elif not options.quiet:
        counts = ", ".join(
            f"{count} {state}"
            for state in ("done", "kept", "failed", "not started")
            if (count := result.count(state))
        )
        out(f"{batch.out}: {len(result.results)} jobs: {counts}; {result.wall_s:.1f} s")
    if result.exit_code:
        raise _JobsFailedError(result, report)


class _JobsFailedError(SurftexError):
    """Some jobs have failed; each had its line already."""

    def __init__(self, result: BatchResult, report: Any) -> None:
        count = result.count("failed")
        super().__init__(f"{count} of {len(result.results)} jobs failed; {report} has the reasons")
        self.exit_code = result.exit_code


class _Watch:
    """A line for each job that has ended, over a bar on a terminal."""

    def __init__(self, options: Namespace, total: int) -> None:
        self.quiet, self.bar, self.task = options.quiet, None, None
        if sys.stderr is not None and sys.stderr.isatty() and not options.quiet:
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

            columns = TextColumn("baking"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
            self.bar: Any = Progress(*columns, console=Console(stderr=True), transient=True)
            self.task = self.bar.add_task("baking", total=total)

    def __enter__(self) -> "_Watch":
        if self.bar is not None:
            self.bar.start()
        return self

    def __exit__(self, *problem: Any) -> None:
        if self.bar is not None:
            self.bar.stop()

    def __call__(self, result: JobResult, ended: int, total: int) -> None:
        if self.bar is not None:
            self.bar.update(self.task, completed=ended)
        if result.state == "failed" or not self.quiet:
            what = (
                f"{result.wall_s:.1f} s"
                if result.state == "done"
                else result.reason or "as an earlier run left it"
            )
            note(f"[{ended}/{total}] {result.name}: {result.state}: {what}")
        if result.state == "done" and not self.quiet:
            for warning in result.warnings:
                note(f"{result.name}: warning: {warning}")


def _plan(batch: Batch, options: Namespace) -> None:
    """Print what would be done, kept and refused; nothing is written. Ends as the batch would."""
    import json

    from surftex.bake.cost import recipe_costs

    costs = recipe_costs(job.recipe for job in batch.jobs)
    rows: list[dict[str, Any]] = []
    for job, cost in zip(batch.jobs, costs, strict=True):
        row = {"name": job.name, "mesh": job.recipe.mesh.path, "resolution": job.recipe.bake.resolution}
        rows.append(row | {"kept": False} | cost)
        if "problem" not in cost:
            rows[-1] |= _foreseen(batch, job, resume=options.resume, overwrite=options.overwrite)
    bad = sum("problem" in row for row in rows)
    if options.json:
        out(json.dumps({"out": str(batch.out), "jobs": rows}, indent=1, ensure_ascii=False))
    else:
        for row in rows:
            what = f"about {row.get('seconds', 0):.0f} CPU-s, {row.get('memory_mb', 0)} MB"
            what = "kept, as an earlier run left it" if row["kept"] else row.get("problem", what)
            out(f"{row['name']}: {row['mesh']}, {row['resolution']}^2: {what}")
        seconds = sum(row["seconds"] for row in rows if not row["kept"] and "problem" not in row)
        kept = sum(row["kept"] for row in rows)
        out(f"{len(rows)} jobs, {kept} of them kept, about {seconds:.0f} CPU-s")
    if bad:
        grave = any(row.get("exit_code") == WorkError.exit_code for row in rows)
        raise (WorkError if grave else InputError)(f"{bad} of {len(rows)} jobs would fail")


def _foreseen(batch: Batch, job: Job, *, resume: bool, overwrite: bool) -> dict[str, Any]:
    """Tell whether a job is done already, names a file that cannot be read, or has no folder to go to."""
    from surftex.bake.jobs import check_made, is_done, job_contents, job_key
    from surftex.files.output import check_room

    folder = batch.out / job.name
    try:
        key = job_key(job.recipe, job_contents(job.recipe))
        if resume and is_done(folder, key):
            return {"kept": True}
        check_made(job, folder, overwrite=overwrite)
        check_room(folder)
    except SurftexError as problem:
        return {"problem": str(problem), "exit_code": problem.exit_code}
    return {}
