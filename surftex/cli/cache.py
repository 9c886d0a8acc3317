"""``surftex cache``: the compiled kernels that make the second bake faster than the first."""

import time
from argparse import Namespace

from surftex.cli.say import note, out
from surftex.kernels import store


def run(options: Namespace) -> None:
    """Say where the kernels are kept, delete them, or compile them all.

    Parameters
    ----------
    options : Namespace
        From the command line.
    """
    if options.where:
        out(str(store.folder()))
        return
    if options.clear:
        count = store.clear()
        if not options.quiet:
            out(f"{store.folder()}: {count} files deleted")
        return
    started = time.perf_counter()
    if not store.is_warm() and not options.quiet:
        note("compiling kernels, once; this takes about half a minute")
    from surftex.bake.warming import warm

    warm()
    store.mark_warm()
    if not options.quiet:
        out(f"{store.folder()}: kernels are compiled, {time.perf_counter() - started:.1f} s")
