"""``surftex preview``: shape a material live, in a window or in a browser."""

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from surftex.cli.say import note, out
from surftex.errors import RecipeError

if TYPE_CHECKING:
    from surftex.preview.desk import Desk
    from surftex.recipe.model import Recipe

_FIRST = "calf"
"""What a mesh is shown in where nobody names a material."""


def run(options: Namespace) -> None:
    """Open the preview, and stay until it is closed.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    SurftexError
        With everything a user can mend, in one line.
    """
    if options.web and options.picture:
        raise RecipeError("--picture draws the window, and --web has none; leave one of them out")
    if options.picture:
        from surftex.preview.pictures import check_picture

        check_picture(options.picture)
    if not 0 <= options.port <= 65535:
        raise RecipeError(f"--port {options.port}: a port is 0, for any that is free, to 65535")
    recipe, name = make_recipe(options)
    save_as = Path(options.out or f"{Path(recipe.mesh.path or 'mesh').stem}-{name}.toml")
    if options.web:
        from surftex.preview.web import check_web

        check_web()
    else:
        from surftex.preview.scene import check_display

        check_display(off_screen=options.picture is not None)
    if save_as.exists() and not (options.quiet or options.picture):
        note(f"note: {save_as} is there, and save replaces it; --out names another")
    if options.subject == recipe.mesh.path and options.material is None and not options.quiet:
        note(f"note: {_FIRST} is shown; --material names another, and surftex presets lists them")
    desk = _desk(options, recipe)
    try:
        if options.web:
            from surftex.preview.web import serve

            def told(address: str) -> None:
                out(address)
                if not options.quiet:
                    note("open this address in a browser; whoever has it can use it; Ctrl-C ends")

            try:
                serve(desk, host=options.host, port=options.port, save_as=save_as, ready=told)
            except KeyboardInterrupt:
                raise KeyboardInterrupt("the page is closed") from None
        else:
            _window(desk, options, save_as)
    finally:
        desk.close()


def make_recipe(options: Namespace) -> "tuple[Recipe, str]":
    """Put a recipe together from the command line.

    Parameters
    ----------
    options : Namespace
        Of ``preview``.

    Returns
    -------
    recipe : Recipe
        With its mesh.
    name : str
        What to call its material.

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
    read: Any = {"allow_outside": options.allow_outside, "changes": options.changes}
    material = options.material or _FIRST
    recipe = load_recipe(options.subject, **read) if own else recipe_for(material, **read)
    if own and recipe.mesh.path is None:
        raise RecipeError(f"{options.subject}: names no mesh; add path under [mesh], or write "
                          f"surftex preview MESH --material {options.subject}")  # fmt: skip
    scale = {key: getattr(options, key) for key in ("units", "size", "part", "crease")}
    whole = composed(recipe, None if own else options.subject, scale, seed=options.seed)
    return whole, Path(options.subject if own else material).stem


def _desk(options: Namespace, recipe: "Recipe") -> "Desk":
    from surftex.bake.loading import load
    from surftex.preview.desk import Desk

    resolution = 1024 if options.resolution is None else options.resolution
    if not 64 <= resolution <= 8192:
        raise RecipeError(f"--resolution {resolution}: a preview takes 64 to 8192")
    mesh = recipe.mesh
    surface = load(mesh.path, units=mesh.units, size=mesh.size, part=mesh.part, crease=mesh.crease)
    if not options.quiet:
        for warning in surface.warnings:
            note(f"warning: {warning}")
    return Desk(recipe, surface, resolution=resolution, threads=options.threads)


def _window(desk: "Desk", options: Namespace, save_as: Path) -> None:
    from surftex.preview.window import Window

    window = Window(desk, off_screen=options.picture is not None, save_as=save_as)
    try:
        if options.picture is None:
            window.show()
            return
        from surftex.preview.pictures import save_picture

        desk.worker.wait()
        save_picture(options.picture, window.picture(smooth=True))
        if not options.quiet:
            out(options.picture)
    finally:
        window.close()
