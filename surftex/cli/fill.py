"""``surftex fill``: a part of a picture, replaced by the texture around it."""

import json
from argparse import Namespace

from surftex.cli.say import out


def run(options: Namespace) -> None:
    """Fill a picture and name the files.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    SurftexError
        If a file or an option is wrong, or a picture cannot be written.
    """
    from surftex.bake.mending import fill_file
    from surftex.cli.watch import Watch

    asked = {
        name: getattr(options, name)
        for name in ("zone", "order", "radius", "spacings")
        if getattr(options, name) is not None
    }
    with Watch(quiet=options.quiet, verbose=options.verbose) as watch:
        files = fill_file(
            options.subject, options.mask, options.out, model=options.model, seed=options.seed,
            threads=options.threads, tick=lambda share: watch("mend", share), **asked,
        )  # fmt: skip
    if options.json:
        out(json.dumps({"files": files}, indent=1, ensure_ascii=False))
    elif not options.quiet:
        out("\n".join(files))
