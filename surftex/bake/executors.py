"""Where the jobs of a batch run: processes on this machine, or the workers of a Dask cluster.

Both are a `concurrent.futures.Executor`; what differs is how they are started, and what a death looks like.
"""

import logging
import multiprocessing
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any, Protocol
from urllib.parse import urlsplit

from surftex.errors import InputError, WorkError
from surftex.interrupts import calm
from surftex.kernels.pool import thread_count

PATIENCE_S = 60.0
"""A cluster that has had no worker for this long is given up."""

_ANSWER_S = 10.0
_CALM_S = 2.0
_LOOK_S = 2.0


class Workers(Protocol):
    """Processes that take jobs.

    Attributes
    ----------
    count : int
        Jobs that run side by side.
    threads : int
        Of each job.
    """

    count: int
    threads: int

    def executor(self) -> Executor:
        """Lend the executor; a new one after `renew`."""
        ...

    def renew(self, broken: Executor) -> None:
        """Start anew after a worker has died and taken its executor with it."""
        ...

    def abandon(self) -> None:
        """End the jobs that are being done, at once."""
        ...

    def lost(self) -> str | None:
        """Say why no job can be handed out any more; None while all is well."""
        ...


class LocalWorkers:
    """Processes on this machine; they end with the one that started them, however it ends.

    Parameters
    ----------
    count : int
        Processes.
    threads : int
        Of each job.
    starting : callable, optional
        Called once, before the first process is started.
    """

    def __init__(self, count: int, threads: int, starting: Callable[[], None] | None = None) -> None:
        self.count, self.threads, self._starting = count, threads, starting
        self._executor: ProcessPoolExecutor | None = None
        self._leash: Connection | None = None

    def executor(self) -> Executor:
        """Start the processes if they are not there.

        Returns
        -------
        executor : Executor
            Of spawned processes.
        """
        if self._executor is None:
            if self._starting is not None:
                self._starting()
                self._starting = None
            spawning = multiprocessing.get_context("spawn")
            held, self._leash = spawning.Pipe(duplex=False)
            self._executor = ProcessPoolExecutor(self.count, spawning, _attend, (held,))
        return self._executor

    def renew(self, broken: Executor) -> None:
        """Let go of a broken pool; the next `executor` starts another.

        Parameters
        ----------
        broken : Executor
            The one that a worker took with it; nothing happens if it was let go of before.
        """
        if broken is self._executor:
            self.abandon()

    def lost(self) -> str | None:
        """Say that all is well: processes of this machine can always be started again.

        Returns
        -------
        reason : None
            Always.
        """
        return None

    def abandon(self) -> None:
        """End all processes now, whatever they are at."""
        if self._leash is not None:
            self._leash.close()
            self._leash = None
        if self._executor is not None:
            self._executor.shutdown(wait=True, cancel_futures=True)
            self._executor = None


class ClusterWorkers:
    """Workers of a Dask cluster.

    Parameters
    ----------
    client : distributed.Client
        Connected.
    address : str
        Of the scheduler, for messages.
    count : int
        Jobs that run side by side.
    telling : callable, optional
        Told a line when the last worker goes, and when one comes.
    clock : callable
        Seconds.
    """

    def __init__(
        self, client: Any, address: str, count: int, telling: Callable[[str], None] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:  # fmt: skip
        self.client, self.address, self.count, self.threads = client, address, count, 1
        self._telling, self._clock = telling, clock
        self._looked = clock()
        self._deserted: float | None = None
        self._executor: Executor = client.get_executor(pure=False)

    def executor(self) -> Executor:
        """Lend the client's executor.

        Returns
        -------
        executor : Executor
            Jobs of a worker that dies run again elsewhere.
        """
        return self._executor

    def renew(self, broken: Executor) -> None:
        """Do nothing: a cluster mends itself.

        Parameters
        ----------
        broken : Executor
            Not used.
        """

    def abandon(self) -> None:
        """Cancel what has not begun; what runs on workers is thrown away when it ends."""
        self._executor.shutdown(wait=False)

    def lost(self) -> str | None:
        """Look whether the scheduler is there, and has workers; these may stay away for `PATIENCE_S`.

        Returns
        -------
        reason : str or None
            One line.
        """
        if self.client.status != "running":
            return f"the scheduler at {self.address} is gone"
        now = self._clock()
        if now - self._looked < _LOOK_S:
            return None
        self._looked = now
        try:
            there = bool(self.client.nthreads())
        except (OSError, TimeoutError):
            return None  # the status will tell
        return self._attended(now) if there else self._alone(now)

    def _attended(self, now: float) -> None:
        if self._deserted is not None:
            self._tell(f"workers are there again after {now - self._deserted:.0f} s")
        self._deserted = None

    def _alone(self, now: float) -> str | None:
        if self._deserted is None:
            self._deserted = now
            self._tell(
                f"the scheduler at {self.address} has no workers any more; waiting {PATIENCE_S:.0f} s for one, "
                f"such as dask worker {self.address}"
            )
        if now - self._deserted < PATIENCE_S:
            return None
        return f"the scheduler at {self.address} has had no workers for {PATIENCE_S:.0f} s"

    def _tell(self, line: str) -> None:
        if self._telling is not None:
            self._telling(line)


@contextmanager
def local_workers(
    count: int | None = None, starting: Callable[[], None] | None = None
) -> Iterator[LocalWorkers]:
    """Lend processes on this machine.

    Parameters
    ----------
    count : int, optional
        One per core without it.
    starting : callable, optional
        Called once, before the first process is started.

    Yields
    ------
    workers : LocalWorkers
        The cores are shared out among them. They are ended with the block.

    Raises
    ------
    InputError
        If the count is not positive.
    """
    cores = thread_count(None)
    if count is not None and count < 1:
        raise InputError(f"workers is {count}; it takes at least 1")
    number = count or cores
    workers = LocalWorkers(number, max(1, cores // number), starting)
    try:
        yield workers
    finally:
        workers.abandon()


@contextmanager
def cluster_workers(
    address: str, count: int | None = None, telling: Callable[[str], None] | None = None
) -> Iterator[ClusterWorkers]:
    """Lend the workers of a Dask cluster.

    Parameters
    ----------
    address : str
        Of its scheduler, such as ``tcp://host:8786``.
    count : int, optional
        Jobs that run side by side; as many as the cluster has threads without it.
    telling : callable, optional
        Told a line when the last worker goes, and when one comes.

    Yields
    ------
    workers : ClusterWorkers
        They go on when the block ends.

    Raises
    ------
    InputError
        If Dask is not installed, or the address is none.
    WorkError
        If no scheduler or no worker answers.
    """
    try:
        from dask import config
        from distributed import Client
    except ImportError:
        raise InputError("--scheduler needs Dask; install it with pip install 'surftex[cluster]'") from None
    _check_address(address)
    try:
        client = Client(address, timeout=_ANSWER_S, set_as_default=False)
    except (OSError, TimeoutError):
        raise WorkError(f"no scheduler answers at {address}; start one with dask scheduler") from None
    except ValueError as problem:
        raise InputError(f"{address!r} is no address of a scheduler: {problem}") from None
    talk = logging.getLogger("distributed.client")
    usual = talk.level
    talk.setLevel(logging.CRITICAL)  # that the scheduler is gone is told by `lost`, in a line
    try:
        cores: Any = client.nthreads()
        threads = sum(cores.values())
        if not threads:
            raise WorkError(
                f"the scheduler at {address} has no workers; start some with dask worker {address}"
            )
        # Meshes that are sent as bytes are no mistake that Dask should warn of.
        with config.set({"distributed.admin.large-graph-warning-threshold": "1 TiB"}):
            yield ClusterWorkers(client, address, count or threads, telling)
    finally:
        client.close(timeout=5)
        talk.setLevel(usual)


def given_up(problem: BaseException) -> bool:
    """Tell whether a cluster gave a job up because every worker died of it.

    Parameters
    ----------
    problem : BaseException
        That the job's future holds.

    Returns
    -------
    given_up : bool
        False without Dask.
    """
    distributed: Any = sys.modules.get("distributed")
    return distributed is not None and isinstance(problem, distributed.KilledWorker)


def _check_address(address: str) -> None:
    """Refuse what is no address, or where nobody listens: a client of Dask takes long to find out."""
    try:
        parts = urlsplit(address if "://" in address else f"tcp://{address}")
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = parts = None
    if parts is None or parts.scheme not in ("tcp", "tls", "ws", "wss") or not host or not port:
        raise InputError(f"{address!r} is no address of a scheduler; it takes one such as tcp://host:8786")
    try:
        socket.create_connection((host, port), timeout=_ANSWER_S).close()
    except (OSError, UnicodeError):
        raise WorkError(f"no scheduler answers at {address}; start one with dask scheduler") from None


def _attend(held: Connection) -> None:
    """Be a worker: leave interruptions to the driver, and end when it lets go of its end of the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)

    def watch() -> None:
        try:
            held.poll(None)
        finally:
            with calm(_CALM_S):  # what is being made or moved on the disk is better not left half done
                os._exit(1)

    threading.Thread(target=watch, daemon=True, name="surftex-leash").start()
