"""``surftex analyse``: what a height map is like."""

import json
from argparse import Namespace
from typing import Any

from surftex.cli.say import note, out


def run(options: Namespace) -> None:
    """Analyse a height map, name the files that were written, and print the main numbers.

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
        out("\n".join([*map(str, result["files"]), *_rows(result)]))


def _rows(result: dict[str, Any]) -> list[str]:
    """Tell the numbers that most ask for; the JSON has all."""
    relief, ring, size = result["statistics"], result["ring"], result["size"]
    rows = [
        f"map: {size[0]} x {size[1]} texels of {result['mm_per_texel']:.4g} mm, all of which count{_gaps(result['coverage'])}",
        f"relief: rms {relief['rms']:.4g} mm about a mean of {relief['mean']:.4g} mm; 1 % to 99 % from {relief['p01']:.4g} to "
        f"{relief['p99']:.4g} mm; skew {relief['skew']:.3g}",
    ]
    if ring["spacing_mm"] is None:
        return [*rows, "spectrum: no wavelength stands out"]
    return [
        *rows,
        f"spectrum: features repeat every {ring['spacing_mm']:.4g} mm ({ring['cycles_per_mm']:.4g} cycles per mm); ring "
        f"{ring['axis_ratio']:.3g} times as long as wide, along {ring['long_axis_deg']:.0f} degrees",
    ]


def _gaps(coverage: float | None) -> str:
    """Say how many texels lie between charts, where a report tells."""
    if coverage is None:
        return ", gaps between charts too"
    return (
        f"; {100 * (1 - coverage):.0f} % lie in gaps between charts, and repeat the nearest"
        if coverage < 0.995
        else ""
    )
