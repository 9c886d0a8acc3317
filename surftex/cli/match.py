"""``surftex match``: a render model matched to skin, over all its biology, as a table."""

import dataclasses
import json
from argparse import Namespace
from typing import Any

from surftex.cli.say import note, out
from surftex.errors import InputError, SurftexError


class _InterruptedError(SurftexError):
    """The work was stopped, and what is done of it is kept."""

    exit_code = 130


def run(options: Namespace) -> None:
    """Make a table and name it.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    SurftexError
        If an option is wrong, the table cannot be written, or the work was interrupted.
    """
    from surftex.bake.matching import match_to_file
    from surftex.cli.watch import Watch
    from surftex.optics.making import Making

    making = Making(
        shader=options.shader, engine=options.engine, seed=options.seed, paths=options.paths,
        beam_paths=options.beam_paths, nodes=_nodes(options.nodes), step_nm=options.step_nm,
        fit_reflectance=options.fit_reflectance, facing=options.facing,
        lock_surface=options.lock_surface, tissue=_tissue(options.changes),
    )  # fmt: skip
    path = options.out or f"skin-{making.shader}.npz"
    try:
        with Watch(quiet=options.quiet, verbose=options.verbose) as watch:
            report = match_to_file(
                making, path, overwrite=options.overwrite, remember=options.cache, threads=options.threads,
                tick=lambda share: watch("match", share),
            )  # fmt: skip
    except KeyboardInterrupt:
        raise _InterruptedError(
            f"interrupted; {path} was not written, but its finished pieces are kept: "
            "the same command goes on from them"
            if options.cache
            else f"interrupted; {path} was not written, and nothing is kept"
        ) from None
    if not options.quiet:
        for warning in report["warnings"]:
            note(f"warning: {warning}")
    if options.json:
        out(json.dumps(report, indent=1, ensure_ascii=False))
    elif not options.quiet:
        if report["pieces_of_earlier_runs"]:
            note(f"{report['pieces_of_earlier_runs']} of {report['pieces']} pieces are of an earlier run")
        out(f"{path}: {report['entries']} entries; {report['cpu_s']:.1f} CPU-s, {report['wall_s']:.1f} s")


def _pairs(texts: list[str], what: str) -> dict[str, str]:
    pairs = {}
    for text in texts:
        name, sign, value = text.partition("=")
        if not sign or not name.strip() or not value.strip():
            raise InputError(f"{text!r} sets nothing; write {what}")
        if name.strip() in pairs:
            raise InputError(
                f"{name.strip()} is set twice, to {pairs[name.strip()]} and {value.strip()}; keep one"
            )
        pairs[name.strip()] = value.strip()
    return pairs


def _nodes(texts: list[str]) -> dict[str, int]:
    from surftex.optics.making import NODES

    found = {}
    for name, value in _pairs(
        [each for text in texts for each in text.split(",")], "--nodes melanin=8,blood=6"
    ).items():
        if not value.isdecimal():
            raise InputError(f"nodes of {name} are {value!r}; they are a whole number")
        found[name] = int(value)
    return NODES | found


def _tissue(changes: list[str]) -> Any:
    """Tissue with some of its numbers and words changed."""
    from surftex.materials.hints import nearest
    from surftex.optics.tissue import Tissue

    usual, found = Tissue().parameters(), {}
    known = [name for name, value in usual.items() if isinstance(value, (float, str))]
    for name, value in _pairs(changes, "--set fold=0.4").items():
        if name not in known:
            raise InputError(f"tissue has no {name!r}{nearest(name, known)}")
        if isinstance(usual[name], str):
            found[name] = value
            continue
        try:
            found[name] = float(value)
        except ValueError:
            raise InputError(f"{name} is {value!r}; it is a number") from None
    return dataclasses.replace(Tissue(), **found)
