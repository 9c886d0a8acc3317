"""``surftex cache``: compiled kernels, unwraps and features, which make the second bake faster than the first."""

import time
from argparse import Namespace

from surftex.cli.say import note, out
from surftex.files import shelf
from surftex.kernels import store


def run(options: Namespace) -> None:
    """Say where and how much is kept, delete it, or compile all kernels.

    Parameters
    ----------
    options : Namespace
        From the command line.
    """
    if options.where:
        out(f"{store.folder()}\n{shelf.folder()}")
        return
    if options.size:
        count, size = shelf.held()
        out(
            f"{shelf.folder()}: {count} results, {size / 1e6:.1f} MB of at most {shelf.MOST_BYTES / 1e6:.0f} MB"
        )
        return
    if options.clear:
        count, results = store.clear(), shelf.clear()
        if not options.quiet:
            out(f"{store.folder()}: {count} files deleted\n{shelf.folder()}: {results} files deleted")
        return
    started = time.perf_counter()
    if not store.is_warm() and not options.quiet:
        note("compiling kernels, once; this takes most of a minute")
    from surftex.bake.warming import warm

    warm()
    store.mark_warm()
    if not options.quiet:
        out(f"{store.folder()}: kernels are compiled, {time.perf_counter() - started:.1f} s")
