"""``surftex cache``: compiled kernels, unwraps and features, which make the second bake faster than the first."""

import time
from argparse import Namespace

from surftex.cli.say import note, out
from surftex.cli.watch import COMPILING
from surftex.files import shelf
from surftex.kernels import store
from surftex.recipe.layer import MATERIALS


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
    if store.cold(MATERIALS) and not options.quiet:
        note(COMPILING)
    from surftex.kernels.ahead import compile_all

    compile_all(MATERIALS)
    store.mark_warm(MATERIALS)
    if not options.quiet:
        out(f"{store.folder()}: kernels are compiled, {time.perf_counter() - started:.1f} s")
