"""``surftex synthesize``: a picture of a texture, from its model."""

import json
from argparse import Namespace

from surftex.cli.say import note, out


def run(options: Namespace) -> None:
    """Draw a texture and name the files.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    SurftexError
        If the model or an option is wrong, or a picture cannot be written.
    """
    from surftex.bake.texturing import synthesize_file
    from surftex.cli.watch import Watch

    with Watch(quiet=options.quiet, verbose=options.verbose) as watch:
        report = synthesize_file(
            options.subject, options.out, seed=options.seed, sweeps=options.sweeps, compare=options.compare,
            shrink=options.shrink, size=options.size, labels=options.labels, age=options.age, threads=options.threads,
            tick=lambda share: watch("synthesize", share),
        )  # fmt: skip
    if not options.quiet:
        for warning in report["warnings"]:
            note(f"warning: {warning}")
    if options.json:
        out(json.dumps(report, indent=1, ensure_ascii=False))
    elif not options.quiet:
        out("\n".join(report["files"]))
        for name, value in report.get("metrics", {}).items():
            out(f"{name}: {value:.4g}")
