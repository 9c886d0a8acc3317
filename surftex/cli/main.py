"""The entry: run a command, turn every failure into one line and an exit code, leave nothing behind."""

import importlib
import os
import signal
import sys
from collections.abc import Sequence
from types import FrameType
from typing import NoReturn

from surftex.cli.say import note
from surftex.errors import SurftexError

INTERRUPTED = 130
FAILED = 3


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those of this process without it.

    Returns
    -------
    code : int
        0 done, 2 the input is wrong, 3 the work failed, 130 interrupted.
    """
    _listen()
    verbose = "-v" in (sys.argv[1:] if arguments is None else arguments)
    try:
        code = _run(arguments)
        _flush()
    except SurftexError as problem:
        note(str(problem))
        return _quiet(problem.exit_code)
    except KeyboardInterrupt as cut:
        note(str(cut) or "interrupted; nothing was written")
        return _quiet(INTERRUPTED)
    except BrokenPipeError:
        return _quiet(0)  # whoever reads has seen enough
    except MemoryError:
        note("not enough memory; lower the resolution, or free some")
        return _quiet(FAILED)
    except Exception as problem:  # noqa: BLE001  (the last line of defence)
        if verbose:
            import traceback

            traceback.print_exc()
        what = f"{type(problem).__name__}: {problem}" if str(problem) else type(problem).__name__
        note(f"unexpected failure: {what}" + ("" if verbose else "; -v shows where"))
        return _quiet(FAILED)
    return code


def process() -> int:
    """Run the command line as all that a process does: requests to end that come after its result change nothing.

    Returns
    -------
    code : int
        As `main`.
    """
    try:
        code = main()
    except KeyboardInterrupt:  # asked once more while the first was being told
        code = INTERRUPTED
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    # Python ends by SIGINT itself if that has once cut short a text it was executing, such as a named tuple's, though it
    # was caught; another text makes it forget.
    eval("0")
    return code


def _run(arguments: Sequence[str] | None) -> int:
    from surftex.cli.options import make_parser, parsed

    try:
        options = parsed(arguments)
    except SystemExit as done:  # --help and --version have printed
        return int(done.code or 0)
    if options.command is None:
        make_parser()[0].print_help()
        return 0
    command = importlib.import_module(f"surftex.cli.{options.command}")
    command.run(options)
    return 0


def _listen() -> None:
    """Let a polite request to end unwind the stack, so that children and half-written files go away."""

    def end(number: int, frame: FrameType | None) -> NoReturn:
        raise KeyboardInterrupt

    try:
        signal.signal(signal.SIGTERM, end)
    except ValueError:
        return  # not the main thread: whoever called us listens


def _flush() -> None:
    """Find out now whether everything printed has arrived."""
    if sys.stdout is not None:
        try:
            sys.stdout.flush()
        except BrokenPipeError:
            raise
        except OSError as problem:
            from surftex.errors import WorkError

            _mute()
            raise WorkError(f"cannot write to stdout: {problem.strerror}") from None


def _quiet(code: int) -> int:
    """Keep what is still in the buffers from failing once more at exit."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        _mute()
    return code


def _mute() -> None:
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, sys.stdout.fileno())
    os.close(null)
