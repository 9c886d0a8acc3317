"""Progress on stderr: a bar on a terminal, a line per stage with -v and where the work is long, nothing with -q."""

import sys
import time
from contextlib import ExitStack
from typing import Any

from surftex.cli.say import note

TITLES = {
    "load": "reading the mesh",
    "own uv": "checking the mesh's own UVs",
    "unwrap": "unwrapping",
    "place": "placing features",
    "bake": "baking",
    "equalise": "evening out seams",
    "seams": "measuring seams",
    "scales": "comparing scales",
    "displace": "displacing the mesh",
    "frames": "drawing frames",
    "save": "writing files",
    "match": "matching",
    "learn": "learning the texture",
    "synthesize": "drawing the texture",
    "mend": "drawing anew",
}
"""What each stage is called on the screen."""


PATIENCE_S = 10.0
"""Work that is done sooner has no lines in a log, so that whoever is refused at once reads one line."""


class Watch:
    """Shows how far a bake is; called with a stage and its share.

    On a terminal that is a bar. In a log there is a line for each stage when it ends, once the work has lasted
    `PATIENCE_S`; a stage that lasts so long by itself has one before.

    Parameters
    ----------
    quiet : bool
        Show nothing.
    verbose : bool
        Print a line per stage.
    """

    def __init__(self, *, quiet: bool = False, verbose: bool = False) -> None:
        self.quiet, self.verbose = quiet, verbose and not quiet
        self.bar: Any = None
        self.tasks: dict[str, Any] = {}
        self.started: dict[str, float] = {}
        self.details: dict[str, str] = {}
        self.began = time.perf_counter()
        self.held: list[str] = []
        self.named: set[str] = set()
        terminal = sys.stderr is not None and sys.stderr.isatty()
        self.lines = not quiet and (verbose or not terminal)
        if terminal and not quiet and not verbose:
            from rich.console import Console
            from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

            columns = TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeElapsedColumn()
            self.bar = Progress(*columns, console=Console(stderr=True), transient=True)

    def __enter__(self) -> "Watch":
        if self.bar is not None:
            self.bar.start()
        return self

    def __exit__(self, *problem: Any) -> None:
        if self.bar is not None:
            self.bar.stop()

    def detail(self, stage: str, text: str) -> None:
        """Show what is happening in a stage.

        Parameters
        ----------
        stage : str
            As for a call.
        text : str
            Such as a live count.
        """
        self.details[stage] = text
        if self.bar is not None and stage in self.tasks:
            self.bar.update(self.tasks[stage], description=f"{TITLES.get(stage, stage)}: {text}")

    def say(self, line: str) -> None:
        """Print a line at once, unless nothing is to be shown.

        Parameters
        ----------
        line : str
            Such as a warning.
        """
        if not self.quiet:
            note(line)

    def __call__(self, stage: str, share: float) -> None:
        """Show the share of a stage.

        Parameters
        ----------
        stage : str
            One of `TITLES`, or any other name.
        share : float
            0 to 1.
        """
        if self.bar is not None:
            if stage not in self.tasks:
                self.tasks[stage] = self.bar.add_task(TITLES.get(stage, stage), total=1.0)
            self.bar.update(self.tasks[stage], completed=share)
        elif self.lines:
            self._tell(stage, share)

    def _tell(self, stage: str, share: float) -> None:
        """Print a line for a stage that has ended; with patience, unless every stage is asked for."""
        now, title = time.perf_counter(), TITLES.get(stage, stage)
        began = self.started.setdefault(stage, now)
        if share == 1.0 and 0 <= began < now:
            detail = f" ({self.details[stage]})" if stage in self.details else ""
            self.held.append(f"{title}: {now - began:.2f} s{detail}")
            self.started[stage] = -1.0
        elif 0 <= began < now - PATIENCE_S and stage not in self.named:
            self.held.append(f"{title} ...")
            self.named.add(stage)
        if self.verbose or now > self.began + PATIENCE_S:
            for line in self.held:
                note(line)
            self.held.clear()


COMPILING = "compiling kernels, once; this takes most of a minute"


class ColdWatch(Watch):
    """Watch that tells when kernels are to be compiled, once the mesh is known to be good.

    Parameters
    ----------
    cold : tuple of str
        Kinds of material whose kernels are not there yet.
    threads : int or None
        How many may be used; with more than one, a second process helps to compile.
    **manner : Any
        As for `Watch`.
    """

    def __init__(self, *, cold: tuple[str, ...], threads: int | None, **manner: Any) -> None:
        super().__init__(**manner)
        self.cold, self.threads = cold, threads
        self.helped = ExitStack()

    def __call__(self, stage: str, share: float) -> None:
        """As `Watch`."""
        if self.cold and stage != "load":
            kinds, self.cold = self.cold, ()  # first of all: stages of several threads come here
            self.say(COMPILING)
            from surftex.kernels.ahead import second_process
            from surftex.kernels.pool import thread_count

            if thread_count(self.threads) > 1:
                self.helped.enter_context(second_process(kinds))
        super().__call__(stage, share)

    def __exit__(self, *problem: Any) -> None:
        self.helped.close()
        super().__exit__(*problem)
