"""``surftex render``: stills, turntables and contact sheets, drawn off screen."""

from argparse import Namespace
from typing import Any

from surftex.cli.say import out
from surftex.errors import RecipeError


def run(options: Namespace) -> None:
    """Draw what was asked for.

    Parameters
    ----------
    options : Namespace
        From the command line.

    Raises
    ------
    SurftexError
        If there is nothing to draw, or the picture cannot be written.
    """
    from surftex.preview.render import render_files

    asked: dict[str, Any] = {
        "size": options.picture_size,
        "views": [_view(each) for each in options.view] or None,
        "lights": options.light or None,
        "turntable": options.turntable,
        "zoom": options.zoom,
        "target": options.target,
        "up": options.up,
        "background": options.background,
    }
    given = {name: value for name, value in asked.items() if value is not None}
    for path in render_files(options.subject, options.out, sheet=options.sheet, **given):
        if not options.quiet:
            out(str(path))


def _view(text: str) -> str | tuple[float, float]:
    if "," not in text:
        return text
    try:
        azimuth, elevation = map(float, text.split(","))
    except ValueError:
        raise RecipeError(
            f"--view {text!r} is no view; write a name, or azimuth,elevation in degrees"
        ) from None
    return azimuth, elevation
