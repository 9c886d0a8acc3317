"""`run_batch`: many bakes side by side, each whole or not there, none done twice."""

import json
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

from surftex.bake.executors import Workers, given_up
from surftex.bake.jobs import (
    Outcome,
    Task,
    is_done,
    job_contents,
    job_key,
    job_lock,
    perform,
    prepared,
    told_warnings,
    write_files,
)
from surftex.errors import SurftexError, WorkError
from surftex.files.output import check_room, write_whole
from surftex.files.workplace import clear_remains
from surftex.interrupts import undisturbed
from surftex.recipe.batch import REPORT, Batch, Job

MOST_DEATHS = 2
"""A job whose worker was killed this often, alone on the machine the last time, has failed."""

_KILLED = "its worker was killed; out of memory? Try a lower resolution"
_RETRY_S = 0.5

State = Literal["done", "kept", "failed", "not started"]


@dataclass(frozen=True)
class JobResult:
    """How a job of a batch ended.

    Attributes
    ----------
    name : str
        Of the job.
    state : str
        ``done`` in this run, ``kept`` from an earlier one, ``failed``, ``not started``.
    reason : str or None
        One line where it failed or was not started.
    wall_s : float
        Of this job.
    folder : str
        Of its files.
    exit_code : int
        That the command would have ended with.
    warnings : tuple of str
        Of its bake.
    """

    name: str
    state: State
    reason: str | None
    wall_s: float
    folder: str
    exit_code: int = 0
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class BatchResult:
    """How a batch ended.

    Attributes
    ----------
    results : tuple of JobResult
        In the order of the jobs.
    wall_s : float
        Of all.
    """

    results: tuple[JobResult, ...]
    wall_s: float

    @property
    def exit_code(self) -> int:
        """0 if all is done, else the gravest of the failures."""
        return max(result.exit_code for result in self.results)

    def count(self, state: State) -> int:
        """Count the jobs in a state.

        Parameters
        ----------
        state : str
            One of the four.

        Returns
        -------
        count : int
            Jobs.
        """
        return sum(result.state == state for result in self.results)


Told = Callable[[JobResult, int, int], None]
"""Told each result, how many there are, and how many there will be; may raise to cancel."""


def run_batch(
    batch: Batch,
    workers: Workers,
    *,
    resume: bool = True,
    keep_going: bool = False,
    overwrite: bool = False,
    by_bytes: bool = False,
    told: Told | None = None,
) -> BatchResult:
    """Do the jobs of a batch.

    Parameters
    ----------
    batch : Batch
        From `surftex.recipe.batch.load_batch`.
    workers : Workers
        From `surftex.bake.executors`.
    resume : bool
        Leave alone what an earlier run has done.
    keep_going : bool
        Do the other jobs when one fails; without it none is started any more.
    overwrite : bool
        Write into folders that no batch made.
    by_bytes : bool
        Send meshes and take files as bytes, where workers do not share this machine's folders.
    told : callable, optional
        Told each result.

    Returns
    -------
    result : BatchResult
        Also in ``batch-report.json`` in the output.

    Raises
    ------
    InputError
        If the output cannot be made or written to.
    WorkError
        If the disk is full, or the workers are gone.
    KeyboardInterrupt
        If it was interrupted; it says how many jobs are done. The report is written.
    """
    check_room(batch.out)
    run = _Run(
        batch,
        workers,
        resume=resume,
        keep_going=keep_going,
        overwrite=overwrite,
        by_bytes=by_bytes,
        told=told,
    )
    try:
        return run.all()
    except KeyboardInterrupt:
        how_to_go_on = ""
        with suppress(KeyboardInterrupt), undisturbed():  # asked once more, it ends all the same
            how_to_go_on = run.cut_short("interrupted")
            run.leave()
        raise KeyboardInterrupt(how_to_go_on) from None
    finally:
        run.leave()


class _Flight:
    """A job that is being done: its lock is held."""

    def __init__(self, index: int, lock: ExitStack, executor: Executor) -> None:
        self.index, self.lock, self.executor = index, lock, executor


class _Run:
    def __init__(
        self, batch: Batch, workers: Workers, *, resume: bool, keep_going: bool, overwrite: bool, by_bytes: bool,
        told: Told | None,
    ) -> None:  # fmt: skip
        self.batch, self.workers, self.told = batch, workers, told
        self.resume, self.keep_going, self.overwrite, self.by_bytes = resume, keep_going, overwrite, by_bytes
        self.waiting: deque[int] = deque(range(len(batch.jobs)))
        self.suspects: deque[int] = deque()
        self.flights: dict[Future[Outcome], _Flight] = {}
        self.deaths: dict[int, int] = {}
        self.results: dict[int, JobResult] = {}
        self.started = time.perf_counter()
        self.stopping = False

    def all(self) -> BatchResult:
        """Do all jobs."""
        while self.waiting or self.suspects or self.flights:
            blocked = self.start_some()
            if self.flights:
                done, _ = wait(self.flights, timeout=_RETRY_S, return_when=FIRST_COMPLETED)
                for future in done:
                    self.land(future)
                self.check_workers()
            elif blocked:
                time.sleep(_RETRY_S)
        return self.write()

    def start_some(self) -> bool:
        """Hand out jobs while there are free workers; True if some are in the hands of another batch."""
        blocked: list[int] = []
        # Jobs whose worker died are done one at a time, to find out whose fault it was.
        while not self.stopping and (self.waiting or self.suspects):
            alone = bool(self.suspects)
            if len(self.flights) >= (1 if alone else self.workers.count):
                break
            index = (self.suspects if alone else self.waiting).popleft()
            if not self.start(index):
                blocked.append(index)
        self.waiting.extend(blocked)
        if self.stopping:
            for index in sorted([*self.waiting, *self.suspects]):
                self.finish(index, "not started", "an earlier job failed; go on with --keep-going", 0.0)
            self.waiting.clear()
            self.suspects.clear()
        return bool(blocked)

    def start(self, index: int) -> bool:
        """Start a job, or find it done; False if another batch is at it."""
        job, folder = self.batch.jobs[index], self.folder(index)
        with ExitStack() as stack:
            if not stack.enter_context(job_lock(self.batch.out, job.name)):
                return False
            clear_remains(folder)
            try:
                contents = job_contents(job.recipe)
                key = job_key(job.recipe, contents)
                if self.resume and is_done(folder, key):
                    self.finish(index, "kept", None, 0.0, warnings=told_warnings(folder))
                    return True
                prepared(job, folder, overwrite=self.overwrite)
            except SurftexError as problem:
                self.fail(index, str(problem), problem.exit_code)
                return True
            task = Task(
                job.recipe, key, None if self.by_bytes else str(folder), contents if self.by_bytes else None,
                overwrite=True, threads=self.workers.threads,
            )  # fmt: skip
            executor = self.workers.executor()
            with undisturbed():  # a job that is handed out is known as one
                self.flights[executor.submit(perform, task)] = _Flight(index, stack.pop_all(), executor)
        return True

    def land(self, future: "Future[Outcome]") -> None:
        """Take the result of a job that has ended, one way or the other."""
        flight = self.flights.pop(future)
        folder = self.folder(flight.index)
        with flight.lock:
            try:
                outcome = future.result()
                if outcome.problem is None and outcome.files:
                    write_files(folder, outcome.files, overwrite=True)
            except (BrokenProcessPool, CancelledError) as death:
                clear_remains(folder)
                self.died(flight, death)
                return
            except SurftexError as problem:
                outcome = Outcome(str(problem), problem.exit_code)
            except Exception as problem:  # noqa: BLE001  (a cluster has failures of its own)
                what = (
                    _KILLED
                    if given_up(problem)
                    else f"the worker failed: {type(problem).__name__}: {problem}"
                )
                outcome = Outcome(what, WorkError.exit_code)
            if outcome.problem is None:
                self.finish(flight.index, "done", None, outcome.wall_s, warnings=outcome.warnings)
            else:
                self.fail(flight.index, outcome.problem, outcome.exit_code, outcome.wall_s)

    def died(self, flight: _Flight, death: BaseException) -> None:
        """Give a job whose worker was killed another chance, alone."""
        if isinstance(death, BrokenProcessPool):
            self.workers.renew(flight.executor)
        index = flight.index
        self.deaths[index] = self.deaths.get(index, 0) + 1
        if self.deaths[index] >= MOST_DEATHS:
            self.fail(index, _KILLED, WorkError.exit_code)
        else:
            self.suspects.append(index)

    def check_workers(self) -> None:
        """Stop when nobody is left to do the work."""
        reason = self.workers.lost()
        if reason is None:
            return
        raise WorkError(self.cut_short(reason))

    def cut_short(self, reason: str) -> str:
        """Report what has not ended as not started; gives the line that says how to go on."""
        for index in range(len(self.batch.jobs)):
            if index not in self.results:
                self.results[index] = self.result(index, "not started", reason, 0.0, WorkError.exit_code)
        done = sum(result.state in ("done", "kept") for result in self.results.values())
        self.write()
        return f"{reason}; {done} of {len(self.batch.jobs)} jobs are done, the same command goes on"

    def fail(self, index: int, reason: str, code: int, wall_s: float = 0.0) -> None:
        """Note a failure."""
        self.stopping = not self.keep_going
        self.finish(index, "failed", reason, wall_s, code)

    def finish(
        self, index: int, state: State, reason: str | None, wall_s: float, code: int = 0,
        warnings: tuple[str, ...] = (),
    ) -> None:  # fmt: skip
        """Note a result, and tell it."""
        self.results[index] = self.result(index, state, reason, wall_s, code, warnings)
        if self.told is not None:
            self.told(self.results[index], len(self.results), len(self.batch.jobs))

    def result(
        self, index: int, state: State, reason: str | None, wall_s: float, code: int,
        warnings: tuple[str, ...] = (),
    ) -> JobResult:  # fmt: skip
        job: Job = self.batch.jobs[index]
        return JobResult(job.name, state, reason, wall_s, str(self.folder(index)), code, warnings)

    def folder(self, index: int) -> Path:
        """Folder of a job."""
        return self.batch.out / self.batch.jobs[index].name

    def write(self) -> BatchResult:
        """Write the report of the batch, whole."""
        result = BatchResult(
            tuple(self.results[index] for index in sorted(self.results)),
            round(time.perf_counter() - self.started, 3),
        )
        write_report(self.batch.out, result)
        return result

    def leave(self) -> None:
        """End the workers where the batch is cancelled, and let go of what they were doing."""
        if self.flights:
            self.workers.abandon()
        while self.flights:
            _, flight = self.flights.popitem()
            with flight.lock:
                clear_remains(self.folder(flight.index))


def write_report(out: Path, result: BatchResult) -> None:
    """Write ``batch-report.json``, whole.

    Parameters
    ----------
    out : Path
        Output of the batch.
    result : BatchResult
        Its results.

    Raises
    ------
    WorkError
        If the disk does not take it.
    """
    from surftex import __version__

    states = {state: result.count(state) for state in ("done", "kept", "failed", "not started")}
    report = {
        "version": __version__,
        "wall_s": result.wall_s,
        "states": states,
        "jobs": [{**asdict(each), "folder": Path(each.folder).name} for each in result.results],
    }
    data = (json.dumps(report, indent=1, ensure_ascii=False) + "\n").encode()
    write_whole(out / REPORT, data, parents=True)
