"""Slices of a serial kernel over a few threads: same bytes for any number of them, with progress and cancel."""

import os
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from typing import Any, TypeVar

Result = TypeVar("Result")

Tick = Callable[[float], None]
"""Told the finished share of a piece of work, 0 to 1; may raise to cancel it."""


_CALLER = threading.local()


class Stopped(Exception):  # noqa: N818  (nothing went wrong)
    """Work that nobody wants any more has ended early."""


@contextmanager
def stopped_by(event: threading.Event) -> Iterator[None]:
    """Let an event end the work of this thread between two slices, whoever calls for them.

    Parameters
    ----------
    event : Event
        Once it is set, `slices` raises `Stopped`.

    Yields
    ------
    None
        The block that can be ended.
    """
    before = getattr(_CALLER, "event", None)
    _CALLER.event = event
    try:
        yield
    finally:
        _CALLER.event = before


def _go_on() -> None:
    event = getattr(_CALLER, "event", None)
    if event is not None and event.is_set():
        raise Stopped


class PartTick:
    """Part of a piece of work, told as its share of the whole; what else is to be seen of it goes along.

    Parameters
    ----------
    tick : callable or None
        Told the share of the whole; where it has a method `detail`, that is told words, such as a live count.
    first : float
        Share of the whole at the beginning of the part.
    last : float
        Share at its end.
    """

    def __init__(self, tick: Tick | None, first: float = 0.0, last: float = 1.0) -> None:
        self.tick, self.first, self.last = tick, first, last

    def __call__(self, share: float) -> None:
        """Tell the share of the part."""
        if self.tick is not None:
            self.tick(self.first + (self.last - self.first) * share)

    def detail(self, text: str) -> None:
        """Tell what is happening."""
        tell = getattr(self.tick, "detail", None)
        if tell is not None:
            tell(text)

    def keep(self, generation: int, last: int, make: Callable[[], Any]) -> None:
        """Offer what has grown so far: `make` gives it as features, as long as it is asked before the next offer."""
        take = getattr(self.tick, "keep", None)
        if take is not None:
            take(generation, last, make)


def thread_count(threads: int | None) -> int:
    """Resolve the number of threads to use.

    Parameters
    ----------
    threads : int or None
        None means every core this process may use.

    Returns
    -------
    threads : int
        At least 1.
    """
    return (
        max(1, threads)
        if threads is not None
        else max(1, len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1)
    )


def slices(
    work: Callable[[int, int], Result],
    count: int,
    *,
    size: int,
    threads: int | None = None,
    tick: Tick | None = None,
) -> list[Result]:
    """Call ``work(first, last)`` over [0, count) in slices of a fixed size.

    Parameters
    ----------
    work : callable
        Gets the slice [first, last); releases the interpreter lock; writes only what is its own.
    count : int
        Items of work in all.
    size : int
        Items in a slice. It must not depend on the number of threads, so that the results cannot.
    threads : int, optional
        None means every core.
    tick : callable, optional
        Told the finished share after each slice.

    Returns
    -------
    results : list
        One per slice, in the order of the slices.

    Raises
    ------
    Stopped
        If the event of `stopped_by` is set.
    """
    _go_on()
    firsts = range(0, count, size)
    bounds = [(first, min(first + size, count)) for first in firsts]
    workers = min(thread_count(threads), len(bounds))
    if workers <= 1:
        results = []
        for i, (first, last) in enumerate(bounds):
            results.append(work(first, last))
            _go_on()
            if tick:
                tick((i + 1) / len(bounds))
        return results
    with ThreadPoolExecutor(workers) as pool:
        futures = [pool.submit(work, first, last) for first, last in bounds]
        try:
            for done, future in enumerate(as_completed(futures), 1):
                future.result()
                _go_on()
                if tick:
                    tick(done / len(bounds))
        except BaseException:
            for future in futures:
                future.cancel()
            raise
        return [future.result() for future in futures]


_BLAS = threading.Lock()
_LIMITS: list[Any] = []
_HOLDERS = 0
_KNOWN: dict[int, Any] = {}


def _libraries() -> Any:
    """Look up the BLAS libraries of this process; it takes a millisecond, and again only once modules were imported."""
    found = _KNOWN.get(len(sys.modules))
    if found is None:
        from threadpoolctl import ThreadpoolController

        _KNOWN.clear()
        modules = len(sys.modules)
        found = _KNOWN[modules] = ThreadpoolController()
    return found


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Keep BLAS on one thread: on small blocks several mostly wait, and rounding would depend on their number.

    Blocks may overlap in several threads: the last one that is left sets back what was there before the first.

    Yields
    ------
    None
        The block in which it holds, also for libraries that were loaded in a block around it.
    """
    global _HOLDERS
    with _BLAS:
        _HOLDERS += 1
        _LIMITS.append(_libraries().limit(limits=1, user_api="blas"))
    try:
        yield
    finally:
        with _BLAS:
            _HOLDERS -= 1
            while _LIMITS and not _HOLDERS:
                _LIMITS.pop().restore_original_limits()
