"""Requests to end that come at a bad moment wait for a better one."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_BUSY = threading.RLock()


@contextmanager
def undisturbed(done: str = "") -> Iterator[None]:
    """Let requests to end wait until a block is over, then obey.

    A mask of signals would not do: another thread can take them, and Python runs the handler here all the same.

    Parameters
    ----------
    done : str
        What to say after a success.

    Yields
    ------
    None
        The block: some milliseconds, or the seconds in which a kernel is compiled.

    Raises
    ------
    KeyboardInterrupt
        After the block, if a request came in it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # handlers run in the main thread alone
        return
    came: list[tuple[int, FrameType | None]] = []
    usual = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    usual = {number: handler for number, handler in usual.items() if callable(handler)}
    with _BUSY:
        try:
            for number in usual:
                signal.signal(number, lambda *request: came.append(request))
            yield
        finally:
            for number, handler in usual.items():
                signal.signal(number, handler)
    try:
        for number, frame in came:
            usual[signal.Signals(number)](number, frame)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(done) if done else KeyboardInterrupt from None


@contextmanager
def calm(seconds: float) -> Iterator[bool]:
    """Wait until no block is undisturbed any more, and let none begin: for a thread that is about to end the process.

    Parameters
    ----------
    seconds : float
        At most.

    Yields
    ------
    calm : bool
        False if a block went on for longer.
    """
    free = _BUSY.acquire(timeout=seconds)
    try:
        yield free
    finally:
        if free:
            _BUSY.release()
