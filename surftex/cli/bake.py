"""``surftex bake``: one mesh, one recipe, one folder."""

import json
import time
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from surftex.cli.say import note, out
from surftex.cli.watch import ColdWatch, Watch
from surftex.errors import RecipeError

if TYPE_CHECKING:
    from surftex.bake.growing import Growth
    from surftex.bake.saving import More
    from surftex.maps.mapset import MapSet
    from surftex.recipe.model import Recipe


def run(options: Namespace) -> None:
    """Bake, save, and say what was made.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    SurftexError
        With everything a user can mend, in one line.
    """
    started = time.perf_counter()
    recipe = make_recipe(options)
    folder = Path(options.out) if options.out else Path(f"{_stem(recipe)}-{_material_name(options, recipe)}")
    _check(folder, recipe, overwrite=options.overwrite)

    from surftex.bake.bake import run as bake_run
    from surftex.bake.growing import Growth
    from surftex.bake.saving import save
    from surftex.kernels import store

    threads, kinds = options.threads, {layer.kind for layer in recipe.layer}
    wanted = options.growth is not None or options.frames
    growth = Growth(options.growth, options.frames) if wanted else None
    manner = {"quiet": options.quiet, "verbose": options.verbose}
    with ColdWatch(cold=store.cold(kinds), threads=threads, **manner) as watch:
        baked = bake_run(
            recipe, features=options.features, threads=threads, tile=options.tile, progress=watch,
            remember=options.cache, growth=growth,
        )  # fmt: skip
        more = None if growth is None else frames_of(baked.maps, recipe, growth, options, watch)
        paths = save(baked, folder, more=more, overwrite=options.overwrite, threads=threads, progress=watch)
    store.mark_warm(kinds)
    report = json.loads((folder / "report.json").read_text("utf-8"))
    if not options.quiet and report["scales"]["note"]:
        note(f"note: {report['scales']['note']}")
    if options.json:
        out(json.dumps(report, indent=1, ensure_ascii=False))
    elif not options.quiet:
        counts = ", ".join(f"{count:,} {kind}" for kind, count in report["features"].items())
        side, texels, tiles = report["resolution"], report["texels"], report["unwrap"]["tiles"]
        for cells in report.get("cells", {}).values():
            counts += (f"; {100 * cells['triangles']:.0f} % of the cells with three sides, their areas vary by "
                       f"{100 * cells['area_cv']:.0f} %")  # fmt: skip
        several = f" on {len(tiles)} tiles" if len(tiles) > 1 else ""
        out(f"{folder}: {len(paths)} files; {side} x {side}{several}, {texels:,} texels; {counts or 'no features'}; "
            f"{time.perf_counter() - started:.1f} s")  # fmt: skip


def frames_of(
    maps: "MapSet", recipe: "Recipe", growth: "Growth", options: Namespace, watch: Watch
) -> "More | None":
    """Prepare the frames of a growth, and say where some are missing.

    Parameters
    ----------
    maps : MapSet
        What was baked in the end.
    recipe : Recipe
        Of the bake.
    growth : Growth
        With the states that were seen.
    options : Namespace
        From the command line.
    watch : Watch
        Told how far it is.

    Returns
    -------
    more : (names, write), or None
        For `surftex.bake.saving.save`.
    """
    if not growth.frames:
        return None
    from surftex.preview.growth import frames_to_write

    missing = growth.frames - len(growth.states)
    if missing > 0 and not options.quiet:
        note(f"note: {missing} of {growth.frames} frames were not seen: the growth had passed them, or has fewer "
             "generations")  # fmt: skip
    return frames_to_write(maps, recipe, growth, threads=options.threads, progress=watch)


def make_recipe(options: Namespace) -> "Recipe":
    """Put a recipe together from the command line.

    Parameters
    ----------
    options : Namespace
        Of ``bake``.

    Returns
    -------
    recipe : Recipe
        With its mesh, its material and every setting.

    Raises
    ------
    RecipeError
        If anything is missing, doubled or wrong.
    """
    from surftex.recipe.compose import composed
    from surftex.recipe.read import load_recipe, recipe_for

    own = options.subject.lower().endswith(".toml")
    if own and options.material is not None:
        raise RecipeError(
            f"{options.subject} names its own materials; leave --material out, or name a mesh first"
        )
    if not own and options.material is None:
        raise RecipeError("a mesh needs a material: add --material NAME; surftex presets lists them")
    read: Any = {"allow_outside": options.allow_outside, "changes": options.changes}
    recipe = load_recipe(options.subject, **read) if own else recipe_for(str(options.material), **read)
    if own and recipe.mesh.path is None:
        raise RecipeError(f"{options.subject}: names no mesh; add path under [mesh], or write "
                          f"surftex bake MESH --material {options.subject}")  # fmt: skip
    scale = {key: getattr(options, key) for key in ("units", "size", "part", "crease")}
    return composed(
        recipe, None if own else options.subject, scale,
        resolution=options.resolution,
        seed=options.seed,
        maps=options.maps,
        uv=options.uv,
        unwrapper=options.unwrapper,
        max_features=options.max_features,
        udim=options.udim,
        texels_per_mm=options.texels_per_mm,
        displaced=options.displaced or options.displaced_format is not None or None,
        displaced_format=options.displaced_format,
        **exchange_settings(options),
    )  # fmt: skip


def exchange_settings(options: Namespace) -> dict[str, Any]:
    """Read what is wanted beside maps and GLB.

    Parameters
    ----------
    options : Namespace
        Of ``bake`` or ``tile``.

    Returns
    -------
    settings : dict
        Keys of `surftex.recipe.model.BakeSettings`; a format alone asks for USD.
    """
    usd = True if options.usd_format is not None else options.usd
    return {"materialx": options.materialx, "usd": usd, "usd_format": options.usd_format}


def _stem(recipe: "Recipe") -> str:
    return Path(recipe.mesh.path or "mesh").stem


def _material_name(options: Namespace, recipe: "Recipe") -> str:
    named = options.material or options.subject
    if named.lower().endswith(".toml"):
        return Path(named).stem
    return recipe.layer[0].preset or recipe.layer[0].kind


def _check(folder: Path, recipe: "Recipe", *, overwrite: bool) -> None:
    """Refuse before any work what could not be written in the end."""
    from surftex.files.output import check_output
    from surftex.maps.exchange import exchange_names

    stem = _stem(recipe)
    names = [f"{stem}.glb", *exchange_names(stem, **recipe.bake.exchange), "features.npz", "report.json"]
    check_output(folder, names, overwrite=overwrite)
