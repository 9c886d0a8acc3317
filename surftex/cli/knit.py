"""``surftex knit``: pictures joined, and the borders between them drawn anew."""

import json
from argparse import Namespace

from surftex.cli.say import out


def run(options: Namespace) -> None:
    """Knit pictures and name the files.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    SurftexError
        If a file or an option is wrong, or a picture cannot be written.
    """
    from surftex.bake.mending import knit_files
    from surftex.cli.watch import Watch

    names = ("zone", "width", "order", "radius", "spacings")
    asked = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    with Watch(quiet=options.quiet, verbose=options.verbose) as watch:
        files = knit_files(
            options.subject, options.out, side="below" if options.below else "right", seed=options.seed,
            threads=options.threads, tick=lambda share: watch("mend", share), **asked,
        )  # fmt: skip
    if options.json:
        out(json.dumps({"files": files}, indent=1, ensure_ascii=False))
    elif not options.quiet:
        out("\n".join(files))
