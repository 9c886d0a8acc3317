"""Stages of a bake: how far each is, for whoever watches, and what each took, for the report."""

import os
import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from surftex.errors import InputError
from surftex.kernels.pool import Tick
from surftex.words import sort_of

Progress = Callable[[str, float], None]
"""Told the name of a stage and its finished share, 0 to 1; may raise to cancel the bake."""


class StageTick:
    """Tells how far a stage is.

    Parameters
    ----------
    stages : Stages
        Of the bake.
    name : str
        Of the stage.
    """

    def __init__(self, stages: "Stages", name: str) -> None:
        self.stages, self.name = stages, name

    def __call__(self, share: float) -> None:
        """Tell the finished share, 0 to 1."""
        self.stages.tell(self.name, share)

    def detail(self, text: str) -> None:
        """Tell what is happening, such as a live count."""
        self.stages.tell_detail(self.name, text)


@dataclass
class Stages:
    """Times each stage of a bake.

    Attributes
    ----------
    progress : callable or None
        Who watches.
    done : list of dict
        ``name``, ``wall_s`` and ``cpu_s`` of each finished stage, in the order of their ends.
    warned : set of str
        Warnings that have been told.
    """

    progress: Progress | None = None
    done: list[dict[str, str | float]] = field(default_factory=list)
    started: float = field(default_factory=time.perf_counter)
    warned: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        if self.progress is not None and not callable(self.progress):
            raise InputError(f"progress is {sort_of(self.progress)}; it takes a function of stage and share")

    @contextmanager
    def stage(self, name: str, *, children: bool = False) -> Iterator[Tick]:
        """Run a stage.

        Parameters
        ----------
        name : str
            What it is called.
        children : bool
            Whether its work is done by child processes, beside other stages: only their time counts.

        Yields
        ------
        tick : callable
            To be told the stage's finished share.
        """
        self.tell(name, 0.0)
        wall, cpu = time.perf_counter(), _cpu_s(children=children)
        yield StageTick(self, name)
        self.done.append(
            {
                "name": name,
                "wall_s": round(time.perf_counter() - wall, 4),
                "cpu_s": round(_cpu_s(children=children) - cpu, 4),
            }
        )
        self.tell(name, 1.0)

    def tell_detail(self, name: str, text: str) -> None:
        """Pass words on, where who watches has a method `detail`.

        Parameters
        ----------
        name : str
            Of the stage.
        text : str
            Such as a live count.
        """
        tell = getattr(self.progress, "detail", None)
        if tell is not None:
            tell(name, text)

    @property
    def has_listener(self) -> bool:
        """Whether who watches has a method `say`."""
        return hasattr(self.progress, "say")

    def say(self, line: str) -> None:
        """Pass a line on, where who watches has a method `say`.

        Parameters
        ----------
        line : str
            To be read at once.
        """
        tell = getattr(self.progress, "say", None)
        if tell is not None:
            tell(line)

    def warn(self, *warnings: str) -> None:
        """Tell warnings as soon as they are known, each once.

        Parameters
        ----------
        *warnings : str
            Those that were told before are passed over.
        """
        for warning in warnings:
            if warning not in self.warned:
                self.warned.add(warning)
                self.say(f"warning: {warning}")

    def tell(self, name: str, share: float) -> None:
        """Pass a share on.

        Parameters
        ----------
        name : str
            Of the stage.
        share : float
            0 to 1.
        """
        if self.progress is not None:
            self.progress(name, min(1.0, max(0.0, share)))

    def wall_s(self) -> float:
        """Measure the time since the first stage could begin.

        Returns
        -------
        wall_s : float
            Seconds.
        """
        return round(time.perf_counter() - self.started, 4)


def peak_rss_mb() -> float:
    """Measure the most memory that this process has held.

    Returns
    -------
    peak : float
        MB of 10^6 bytes; 0 where the system does not tell.
    """
    status = Path("/proc/self/status")
    if status.exists():  # what getrusage tells begins with the memory of the process that started this one
        told = re.search(r"VmHWM:\s*(\d+) kB", status.read_text())
        if told:
            return round(int(told[1]) * 1024 / 1e6, 1)
    try:
        import resource
    except ImportError:
        return 0.0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return round(peak * (1.0 if sys.platform == "darwin" else 1024.0) / 1e6, 1)


def _cpu_s(*, children: bool) -> float:
    times = os.times()
    below = times.children_user + times.children_system
    return below if children else time.process_time()
