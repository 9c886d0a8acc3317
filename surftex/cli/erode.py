"""``surftex erode``: a mask, a layout or a composite, from age to age."""

import json
from argparse import Namespace

from surftex.cli.say import out


def run(options: Namespace) -> None:
    """Draw a series of ages and name the files.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    SurftexError
        If a file or an option is wrong, or a picture cannot be written.
    """
    from surftex.bake.mending import erode_file
    from surftex.cli.watch import Watch

    with Watch(quiet=options.quiet, verbose=options.verbose) as watch:
        files = erode_file(
            options.subject, options.out, shrink=options.shrink, grow=options.grow, size=options.size,
            seed=options.seed, threads=options.threads, tick=lambda share: watch("mend", share),
        )  # fmt: skip
    if options.json:
        out(json.dumps({"files": files}, indent=1, ensure_ascii=False))
    elif not options.quiet:
        out("\n".join(files))
