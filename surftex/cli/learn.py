"""``surftex learn``: the model of a texture, from a photograph."""

import json
from argparse import Namespace

from surftex.cli.say import out
from surftex.errors import InputError


def run(options: Namespace) -> None:
    """Learn a texture and name the model.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    SurftexError
        If a picture or an option is wrong, or the model cannot be written.
    """
    from surftex.bake.texturing import ALIGNED, learn_file
    from surftex.cli.watch import Watch

    asked = {name: getattr(options, name) for name in ("order", "pairs", "spacings", "radius", "threads")}
    with Watch(quiet=options.quiet, verbose=options.verbose) as watch:
        report = learn_file(
            options.subject, options.out, shrink=options.shrink, seed=options.seed,
            aligned={name: getattr(options, name) for name in ALIGNED},
            labels=options.labels, within=_within(options.within), over=options.over,
            as_labels=options.as_labels, segments=options.segment,
            tick=lambda share: watch("learn", share),
            **{name: value for name, value in asked.items() if value is not None},
        )  # fmt: skip
    if options.json:
        out(json.dumps(report, indent=1, ensure_ascii=False))
    elif not options.quiet:
        out(
            f"{report['model']}: {report['bytes']} bytes, {report['pairs']} pairs, {report['quads']} fours; "
            f"{report['cpu_s']:.1f} CPU-s"
        )


def _within(texts: list[str]) -> dict[int, str]:
    found = {}
    for text in texts:
        label, sign, path = text.partition("=")
        if not (label.isdecimal() and sign and path):
            raise InputError(f"--within {text!r} parts nothing; write --within 1=labels.png")
        found[int(label)] = path
    return found
