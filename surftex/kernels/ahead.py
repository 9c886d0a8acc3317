"""Compiling kernels before they are called, from a list of them: a second process begins at its end.

`signatures.txt` has a row for each kernel and the types that a bake calls it with, in the order of the first call, and
the kinds of material that want it. What it lacks is compiled when it is called.
"""

import importlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from numba import types

LIST = Path(__file__).with_name("signatures.txt")


def listed(kinds: Iterable[str]) -> list[tuple[str, str]]:
    """Look up what kinds of material want.

    Parameters
    ----------
    kinds : iterable of str
        Such as "leather".

    Returns
    -------
    rows : list of (name, signature)
        ``module.kernel``, and the types of its arguments as an expression, in the order of the first call.
    """
    wanted = set(kinds)
    rows = (row.split(" ", 2) for row in LIST.read_text("utf-8").splitlines())
    return [(name, signature) for which, name, signature in rows if wanted & set(which.split(","))]


def compile_one(name: str, signature: str) -> None:
    """Compile a kernel for a signature, or load it from disk.

    Parameters
    ----------
    name, signature : str
        From `listed`.
    """
    module, function = name.split(".")
    known = vars(importlib.import_module(f"surftex.kernels.{module}"))
    known[function].compile(eval(signature, known, vars(types)))  # a row of this package's own file


def compile_all(kinds: Iterable[str]) -> None:
    """Compile all that kinds of material want, in two processes.

    Parameters
    ----------
    kinds : iterable of str
        Such as "leather".
    """
    kinds = tuple(kinds)
    with second_process(kinds):
        for row in listed(kinds):
            compile_one(*row)


@contextmanager
def second_process(kinds: Iterable[str]) -> Iterator[None]:
    """Let a second process compile, from the end of the list on, what this one has not come to yet.

    Both keep what they compile on disk, and look there first. Where no process can be started, there is none.

    Parameters
    ----------
    kinds : iterable of str
        Of material.

    Yields
    ------
    None
        The work; the other process is ended after it.
    """
    path = os.pathsep.join(folder for folder in sys.path if folder)
    try:
        child = subprocess.Popen(
            [sys.executable, "-m", __name__, str(os.getpid()), *kinds],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": path},
        )  # fmt: skip
    except OSError:
        yield
        return
    try:
        yield
    finally:
        child.kill()
        child.wait()


def _backwards(parent: int, kinds: list[str]) -> None:
    """Compile from the end of the list while the parent lives; Ctrl-C is meant for the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for row in reversed(listed(kinds)):
        if os.name == "posix" and os.getppid() != parent:
            return
        compile_one(*row)


if __name__ == "__main__":
    _backwards(int(sys.argv[1]), sys.argv[2:])
