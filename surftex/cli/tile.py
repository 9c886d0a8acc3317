"""``surftex tile``: grown leather on a square that repeats."""

import json
from argparse import Namespace
from pathlib import Path

from surftex.cli.bake import exchange_settings, frames_of
from surftex.cli.say import note, out
from surftex.cli.watch import ColdWatch
from surftex.errors import RecipeError


def run(options: Namespace) -> None:
    """Grow a tile, save it, and say what was made.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    SurftexError
        With everything a user can mend, in one line.
    """
    from surftex.bake.growing import Growth
    from surftex.bake.saving import save_maps
    from surftex.bake.tiling import bake_tile
    from surftex.files.output import check_output
    from surftex.kernels import store
    from surftex.maps.exchange import exchange_names
    from surftex.recipe.model import Recipe
    from surftex.recipe.read import recipe_for
    from surftex.units import length_mm

    named = str(options.subject)
    name = Path(named).stem if named.lower().endswith(".toml") else named
    recipe = Recipe.of(
        recipe_for(named, allow_outside=options.allow_outside, changes=options.changes),
        resolution=options.resolution, seed=options.seed, maps=options.maps, max_features=options.max_features,
        **exchange_settings(options),
    )  # fmt: skip
    try:
        side = length_mm(options.side)
    except RecipeError as problem:
        raise RecipeError(f"--side: {problem}") from None
    folder, stem = Path(options.out or f"{name}-tile"), f"{name}-tile"
    names = [f"{stem}.glb", *exchange_names(stem, **recipe.bake.exchange), "features.npz", "report.json"]
    check_output(folder, names, overwrite=options.overwrite)
    growth = Growth(options.growth, options.frames)
    manner = {"threads": options.threads, "quiet": options.quiet, "verbose": options.verbose}
    with ColdWatch(cold=store.cold(["cells"]), **manner) as watch:
        maps = bake_tile(recipe, side, growth=growth, threads=options.threads, progress=watch, stem=stem)
        paths = save_maps(
            maps, folder, recipe.bake, more=frames_of(maps, recipe, growth, options, watch), overwrite=options.overwrite,
            threads=options.threads, progress=watch,
        )  # fmt: skip
    store.mark_warm(["cells"])
    report = json.loads((folder / "report.json").read_text("utf-8"))
    if not options.quiet:
        for warning in report["warnings"]:
            note(f"warning: {warning}")
    if options.json:
        out(json.dumps(report, indent=1, ensure_ascii=False))
    elif not options.quiet:
        cells = report["cells"]
        out(f"{folder}: {len(paths)} files; {report['resolution']} x {report['resolution']} over {side:g} mm; "
            f"{report['features']['particle']:,} particle, {cells['count']:,} cell, {100 * cells['triangles']:.0f} % with "
            f"three sides, area varies by {100 * cells['area_cv']:.0f} %; {report['wall_s']:.1f} s")  # fmt: skip
