"""``surftex analyse``: what a height map is like."""

import json
from argparse import Namespace

from surftex.cli.say import note, out


def run(options: Namespace) -> None:
    """Analyse a height map, and name the files that were written.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    SurftexError
        If it is no height map, or the files cannot be written.
    """
    from surftex.preview.analyse import analyse_file

    result = analyse_file(options.subject, options.out, options.section, options.mm_per_texel)
    if not options.quiet:
        for warning in result["warnings"]:
            note(f"warning: {warning}")
    if options.json:
        out(json.dumps(result, indent=1, ensure_ascii=False))
    elif not options.quiet:
        out("\n".join(map(str, result["files"])))
