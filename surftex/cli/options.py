"""The options of every command. argparse: it imports ten times faster than what is built on top of it."""

import argparse
import re
import sys
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from surftex import __version__
from surftex.errors import RecipeError

_CODES = "exit codes: 0 done, 2 the input or the recipe is wrong, 3 the work failed, 130 interrupted"


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, with a hint, and leaves the exit code to `main`."""

    def error(self, message: str) -> NoReturn:
        """Raise instead of printing the usage.

        Parameters
        ----------
        message : str
            From argparse.

        Raises
        ------
        RecipeError
            With the command whose help to ask for.
        """
        if message.startswith("argument COMMAND: invalid choice: "):
            from surftex.materials.hints import nearest

            word, _, known = message.removeprefix("argument COMMAND: invalid choice: ").partition(
                " (choose from "
            )
            names = [name.strip(" ')") for name in known.split(",")]
            message = f"unknown command {word}{nearest(word.strip(chr(39)), names)}"
        raise RecipeError(f"{message}; see {self.prog} --help")


def _joined(arguments: Sequence[str]) -> list[str]:
    """Join ``--view -90,10`` to ``--view=-90,10``: what begins with a minus and goes on with a number is no option."""
    joined: list[str] = []
    for word in arguments:
        if joined and re.fullmatch(r"--[a-z-]+", joined[-1]) and re.fullmatch(r"-[\d.][\d.,eE+-]*", word):
            joined[-1] += f"={word}"
        else:
            joined.append(word)
    return joined


def parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Read a command line.

    Parameters
    ----------
    arguments : sequence of str, optional
        Those of this process without it.

    Returns
    -------
    options : Namespace
        ``command`` is None where none was given.

    Raises
    ------
    RecipeError
        Naming the argument that is wrong, and the nearest option.
    """
    parser, commands = make_parser()
    options, rest = parser.parse_known_args(_joined(sys.argv[1:] if arguments is None else arguments))
    if rest:
        from surftex.materials.hints import nearest

        chosen = commands.get(options.command or "", parser)
        known = [
            name for action in chosen._actions for name in action.option_strings if name.startswith("--")
        ]
        odd = next((each for each in rest if each.startswith("-")), rest[0])
        what = "option" if odd.startswith("-") else "argument"
        hint = nearest(odd.split("=")[0], known) if what == "option" else ""
        chosen.error(f"unknown {what} {odd}{hint if 'mean' in hint else ''}")
    return options


def make_parser() -> tuple[Parser, dict[str, Parser]]:
    """Describe all commands.

    Returns
    -------
    parser : Parser
        Of the whole.
    commands : dict of str to Parser
        Of each command.
    """
    parser = Parser(
        prog="surftex",
        description="Texture features placed on a surface by walking distance, baked to seamless maps.",
        epilog=_CODES,
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"surftex {__version__}")
    commands: dict[str, Parser] = {}
    choices: Any = parser.add_subparsers(dest="command", metavar="COMMAND", title="commands")
    choices.required = False

    def command(name: str, text: str, **options: Any) -> Parser:
        commands[name] = choices.add_parser(name, help=text, description=text, allow_abbrev=False, **options)
        return commands[name]

    _bake(
        command("bake", "Bake a material onto a mesh: maps, a GLB that shows them, a report.", epilog=_CODES)
    )
    _tile(
        command(
            "tile",
            "Grow leather from particles on a square that repeats: maps, a GLB, a report.",
            epilog=_CODES,
        )
    )
    _batch(
        command(
            "batch", "Bake many meshes with many materials; what is done is not done again.", epilog=_CODES
        )
    )
    _inspect(command("inspect", "Say what a mesh is, what is wrong with it, and what a bake would cost."))
    presets = command("presets", "List the presets, or print one as a recipe to start from.")
    presets.add_argument("name", nargs="?", metavar="NAME", help="print this preset as TOML")
    presets.add_argument("--json", action="store_true", help="as JSON")
    _learn(command("learn", "Learn a texture from a picture: a model of some kilobytes.", epilog=_CODES))
    _synthesize(command("synthesize", "Draw a picture of a texture from its model; it tiles.", epilog=_CODES))
    _fill(command("fill", "Replace a part of a picture by the texture around it.", epilog=_CODES))
    _knit(command("knit", "Join pictures and draw the borders between them anew.", epilog=_CODES))
    _erode(command("erode", "Let a mask, a layout or a composite age step by step.", epilog=_CODES))
    _analyse(
        command(
            "analyse",
            "Spectrum, statistics and a section of a height map, as PNG and JSON; all texels count, gaps too.",
        )
    )
    _match(
        command(
            "match", "Match a render model to light in skin, over all its biology: a table.", epilog=_CODES
        )
    )
    _preview(command("preview", "Shape a material live, in a window or in a browser.", epilog=_CODES))
    _render(command("render", "Draw stills, turntables and contact sheets of a mesh or of a bake's GLB."))
    cache = command("cache", "Look after the compiled kernels, and the unwraps and features that are kept.")
    action = cache.add_mutually_exclusive_group(required=True)
    action.add_argument(
        "--warm", action="store_true", help="compile everything now, as for a container image"
    )
    action.add_argument("--clear", action="store_true", help="delete everything that is kept")
    action.add_argument("--where", action="store_true", help="print the folders")
    action.add_argument("--size", action="store_true", help="print how much is kept")
    for each in commands.values():
        _manner(each)
    return parser, commands


def _bake(parser: Parser) -> None:
    parser.add_argument(
        "subject", metavar="MESH|RECIPE.toml", help="a mesh file, or a recipe that names its own"
    )
    parser.add_argument("--material", metavar="NAME|FILE.toml", help="a preset, or a recipe")
    parser.add_argument("--out", metavar="DIR", help="folder for the files (default: ./<mesh>-<material>)")
    parser.add_argument(
        "--resolution", type=_whole, metavar="N", help="side of the maps in texels (default: 2048)"
    )
    parser.add_argument("--seed", type=_whole, metavar="N", help="of everything random (default: 0)")
    parser.add_argument(
        "--maps", metavar="A,B,...", help="such as height,normal (default: what the material makes)"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="changes",
        help='change a parameter, such as leather.cell_size="2 mm" (a bare length is millimetres); may be repeated',
    )  # fmt: skip
    _scale(parser)
    parser.add_argument(
        "--uv",
        choices=["auto", "keep", "unwrap"],
        help="the file's own UVs: keep them where they are good, keep them with a warning of their flaws, or unwrap anew "
        "(default: auto)",
    )
    parser.add_argument(
        "--unwrapper", choices=["auto", "xatlas", "uvunwrap"], help="who unwraps (default: auto)"
    )
    parser.add_argument(
        "--features",
        metavar="FILE.npz",
        help="start from the features of an earlier bake; it says with which seed, size and parameters",
    )
    parser.add_argument(
        "--growth", metavar="FILE.npz", help="keep the growth of cells in this file, and go on from it"
    )
    _frames(parser)
    parser.add_argument("--displaced", action="store_true", help="write the displaced mesh as well")
    parser.add_argument(
        "--displaced-format",
        choices=["glb", "obj", "ply", "stl"],
        help="of the displaced mesh: glb in metres, the others in millimetres (default: glb)",
    )
    _exchange(parser)
    parser.add_argument(
        "--max-features", type=_whole, metavar="N", help="refuse beyond this (default: 5000000)"
    )
    parser.add_argument(
        "--udim",
        action="store_true",
        default=None,
        help="several tiles: those of the file's own UVs, or see --texels-per-mm",
    )
    parser.add_argument(
        "--texels-per-mm", type=_number, metavar="X", help="unwrap over as many tiles as this density takes"
    )
    parser.add_argument("--threads", type=_whole, metavar="N", help="threads to use (default: all cores)")
    parser.add_argument(
        "--tile", type=_whole, metavar="ROWS", help="rows worked on at a time, to bound memory"
    )
    parser.add_argument(
        "--allow-outside", action="store_true", help="let a recipe name files outside its folder"
    )
    parser.add_argument(
        "--cache", action=argparse.BooleanOptionalAction, default=True,
        help="take unwrap and features of an earlier bake from the cache (default: --cache)",
    )  # fmt: skip
    parser.add_argument("--overwrite", action="store_true", help="replace files of an earlier bake")
    parser.add_argument("--json", action="store_true", help="print the report on stdout")


def _tile(parser: Parser) -> None:
    parser.add_argument(
        "subject", metavar="NAME|RECIPE.toml", help="a preset of cells, or a recipe with one layer of them"
    )
    parser.add_argument(
        "--side", required=True, metavar="LENGTH", help='of the square, such as "40 mm"; six cells or more'
    )
    parser.add_argument("--out", metavar="DIR", help="folder for the files (default: ./<name>-tile)")
    parser.add_argument(
        "--resolution", type=_whole, metavar="N", help="side of the maps in texels (default: 2048)"
    )
    parser.add_argument("--seed", type=_whole, metavar="N", help="of everything random (default: 0)")
    parser.add_argument("--maps", metavar="A,B,...", help="such as height,normal (default: all but region)")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="changes",
        help="change a parameter, such as cells.relief=0.2; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--growth", metavar="FILE.npz", help="keep the growth in this file, and go on from it"
    )
    _frames(parser)
    _exchange(parser)
    parser.add_argument(
        "--max-features", type=_whole, metavar="N", help="refuse beyond this (default: 5000000)"
    )
    parser.add_argument("--threads", type=_whole, metavar="N", help="threads to use (default: all cores)")
    parser.add_argument(
        "--allow-outside", action="store_true", help="let a recipe name files outside its folder"
    )
    parser.add_argument("--overwrite", action="store_true", help="replace files of an earlier tile")
    parser.add_argument("--json", action="store_true", help="print the report on stdout")


def _batch(parser: Parser) -> None:
    parser.add_argument("subject", metavar="JOBS.toml", help="meshes, materials, seeds, and single jobs")
    parser.add_argument(
        "--workers", type=_whole, metavar="N", help="jobs side by side (default: one per core)"
    )
    parser.add_argument(
        "--scheduler", metavar="tcp://HOST:PORT", help="let the workers of a Dask cluster do the jobs"
    )
    parser.add_argument(
        "--shared-files", action="store_true", help="the cluster's workers see this machine's folders"
    )
    parser.add_argument(
        "--resume", action=argparse.BooleanOptionalAction, default=True,
        help="leave alone what an earlier run has done (default: --resume)",
    )  # fmt: skip
    parser.add_argument("--keep-going", action="store_true", help="do the other jobs when one fails")
    parser.add_argument(
        "--dry-run", action="store_true", help="print the plan, with estimates, and do nothing"
    )
    parser.add_argument(
        "--allow-outside",
        action="store_true",
        help="let the batch and its recipes name files outside their folder",
    )
    parser.add_argument("--overwrite", action="store_true", help="write into folders that no batch made")
    parser.add_argument("--json", action="store_true", help="print the report on stdout")


def _inspect(parser: Parser) -> None:
    parser.add_argument("subject", metavar="MESH", help="a mesh file")
    parser.add_argument(
        "--material",
        metavar="NAME|FILE.toml",
        help="what a bake would cost of: a preset, or a recipe (default: calf)",
    )
    parser.add_argument(
        "--allow-outside", action="store_true", help="let a recipe name files outside its folder"
    )
    _scale(parser)
    parser.add_argument("--json", action="store_true", help="as JSON")


def _learn(parser: Parser) -> None:
    parser.add_argument("subject", metavar="IMAGE", help="a photograph of the texture: PNG or JPEG")
    parser.add_argument(
        "-o", "--out", metavar="MODEL.stex", required=True, help="the model; replaced if there"
    )
    parser.add_argument(
        "--order",
        choices=["quad", "pair"],
        help="fours of pixels beside pairs, or pairs alone (default: quad)",
    )
    parser.add_argument(
        "--pairs", type=_whole, metavar="N", help="most pairs of each band (default: 16, or 30 alone)"
    )
    parser.add_argument(
        "--spacings",
        type=_whole_numbers,
        metavar="A,B,...",
        help="between the corners of fours (default: 1,2,4)",
    )
    parser.add_argument(
        "--radius",
        type=_whole,
        metavar="PIXELS",
        help="longest pair; beyond the period of a weave (default: 24)",
    )
    parser.add_argument(
        "--shrink", type=_whole, metavar="N", default=1, help="first make one pixel of N x N (default: 1)"
    )
    parser.add_argument("--mask", metavar="IMAGE", help="white where to learn from")
    parser.add_argument(
        "--labels", metavar="LABELS.png", help="learn a composite: each tone is a texture of its own"
    )
    parser.add_argument(
        "--segment",
        type=_whole,
        metavar="N",
        help="learn a composite of N textures, parted by tone and roughness",
    )
    parser.add_argument(
        "--within", action="append", default=[], metavar="LABEL=LABELS.png",
        help="part a label, counted from 0 by tone, into labels itself; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--over", action="store_true", help="the lightest label lies over the others, as cracks or lichen do"
    )
    parser.add_argument(
        "--as-labels", action="store_true", help="the picture is a label map itself: learn its layout"
    )
    parser.add_argument("--height", metavar="IMAGE", help="height aligned with the picture, learnt beside it")
    parser.add_argument("--roughness", metavar="IMAGE", help="roughness aligned with the picture")
    _drawing(parser)


def _synthesize(parser: Parser) -> None:
    parser.add_argument("subject", metavar="MODEL.stex", help="from surftex learn")
    parser.add_argument(
        "-o", "--out", metavar="IMAGE.png", required=True, help="the picture; replaced if there"
    )
    parser.add_argument("--size", type=_side_by_side, metavar="WxH", help="in pixels (default: 512x512)")
    parser.add_argument("--sweeps", type=_whole, metavar="N", help="how often each pixel is drawn")
    parser.add_argument(
        "--compare", metavar="IMAGE", help="measure the result against this picture, both as grey"
    )
    parser.add_argument(
        "--shrink",
        type=_whole,
        metavar="N",
        default=1,
        help="of that picture first make one pixel of N x N, as for learn (default: 1)",
    )
    parser.add_argument(
        "--labels", metavar="LABELS.png", help="a layout for a composite, in place of a drawn one"
    )
    parser.add_argument(
        "--age", type=_whole, metavar="STEPS", default=0, help="by which what lies over a composite has grown"
    )
    _drawing(parser)


def _fill(parser: Parser) -> None:
    parser.add_argument("subject", metavar="IMAGE", help="the picture: PNG or JPEG")
    parser.add_argument("--mask", metavar="IMAGE", required=True, help="white where it shall be replaced")
    parser.add_argument(
        "-o", "--out", metavar="IMAGE.png", required=True, help="the result; replaced if there"
    )
    parser.add_argument("--model", metavar="MODEL.stex", help="what to draw there (default: what is around)")
    _mending(
        parser, "around the mask from which the texture is learnt; more where they are few (default: 24)"
    )


def _knit(parser: Parser) -> None:
    parser.add_argument("subject", nargs="+", metavar="IMAGE", help="two pictures or more, side by side")
    parser.add_argument(
        "-o", "--out", metavar="IMAGE.png", required=True, help="the result; replaced if there"
    )
    parser.add_argument("--below", action="store_true", help="each below the one before, not at its right")
    parser.add_argument(
        "--width", type=_whole, metavar="PIXELS", help="drawn anew on either side (default: 14)"
    )
    _mending(parser, "on either side of a border from which its texture is learnt (default: 24)")


def _mending(parser: Parser, zone: str) -> None:
    parser.add_argument("--zone", type=_whole, metavar="PIXELS", help=zone)
    parser.add_argument("--order", choices=["quad", "pair"], help="as for learn (default: quad)")
    parser.add_argument("--radius", type=_whole, metavar="PIXELS", help="as for learn (default: 24)")
    parser.add_argument(
        "--spacings", type=_whole_numbers, metavar="A,B,...", help="as for learn (default: 1,2,4)"
    )
    _drawing(parser)


def _erode(parser: Parser) -> None:
    parser.add_argument("subject", metavar="MASK.png|MODEL.stex", help="a mask, white where worn; or a model")
    parser.add_argument(
        "-o", "--out", metavar="IMAGE.png", required=True, help="<image>_0.png is the youngest"
    )
    parser.add_argument("--shrink", type=_whole, metavar="STEPS", default=1, help="steps back (default: 1)")
    parser.add_argument("--grow", type=_whole, metavar="STEPS", default=3, help="steps on (default: 3)")
    parser.add_argument(
        "--size", type=_side_by_side, metavar="WxH", help="of what a model draws (default: 512x512)"
    )
    _drawing(parser)


def _drawing(parser: Parser) -> None:
    parser.add_argument(
        "--seed", type=_whole, metavar="N", default=0, help="of everything random (default: 0)"
    )
    parser.add_argument("--threads", type=_whole, metavar="N", help="threads to use (default: all cores)")
    parser.add_argument("--json", action="store_true", help="print the report on stdout")


def _analyse(parser: Parser) -> None:
    parser.add_argument("subject", metavar="HEIGHT.exr", help="a height map, in millimetres")
    parser.add_argument(
        "-o", "--out", metavar="STEM", help="of the PNG and the JSON (default: <height>_analysis)"
    )
    parser.add_argument(
        "--section",
        type=_numbers(4),
        metavar="COLUMN,ROW,COLUMN,ROW",
        help="draw a section between two texels",
    )
    parser.add_argument(
        "--mm-per-texel", type=_number, metavar="MM", help="(default: from the bake's report)"
    )
    parser.add_argument("--json", action="store_true", help="print the result on stdout")


def _match(parser: Parser) -> None:
    parser.add_argument(
        "--shader",
        metavar="NAME",
        default="ggx-lambert",
        help="ggx-lambert, principled (GGX over Disney's diffuse lobe) or ashikhmin-shirley (default: ggx-lambert)",
    )
    parser.add_argument(
        "--engine", metavar="NAME", default="volume", help="volume, or biospec (default: volume)"
    )
    parser.add_argument("-o", "--out", metavar="TABLE.npz", help="the table (default: ./skin-<shader>.npz)")
    parser.add_argument(
        "--seed", type=_whole, metavar="N", default=0, help="of everything random (default: 0)"
    )
    parser.add_argument(
        "--nodes", action="append", default=[], metavar="A=N,B=N,...",
        help="of each parameter, such as melanin=8,blood=6; may be repeated; a parameter of one node has no effect",
    )  # fmt: skip
    parser.add_argument(
        "--paths", type=_whole, metavar="N", default=20_000, help="photons per wavelength (default: 20000)"
    )
    parser.add_argument(
        "--beam-paths", type=_whole, metavar="N", default=10_000,
        help="photons per wavelength for the subsurface radius (default: 10000)",
    )  # fmt: skip
    parser.add_argument(
        "--step-nm", type=_number, metavar="NM", default=10.0, help="between wavelengths (default: 10)"
    )
    parser.add_argument(
        "--fit-reflectance",
        action="store_true",
        help="match the reflectance too, as the thesis does, up to 0.08; else it is that of the skin's index",
    )
    parser.add_argument(
        "--facing",
        type=_number,
        metavar="P",
        default=4.0,
        help="power of both cosines that weighs directions; 0 weighs all alike, as the thesis does (default: 4)",
    )
    parser.add_argument(
        "--lock-surface", action="store_true", help="keep the surface's own gloss; match the colour alone"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="changes",
        help="change the tissue, such as fold=0.4 or base_albedo=0.6; may be repeated",
    )  # fmt: skip
    parser.add_argument("--threads", type=_whole, metavar="N", help="threads to use (default: all cores)")
    parser.add_argument(
        "--cache", action=argparse.BooleanOptionalAction, default=True,
        help="go on from pieces that an earlier run has finished, and keep the new ones (default: --cache)",
    )  # fmt: skip
    parser.add_argument("--overwrite", action="store_true", help="replace the table")
    parser.add_argument("--json", action="store_true", help="print the report on stdout")


def _preview(parser: Parser) -> None:
    parser.add_argument(
        "subject", metavar="MESH|RECIPE.toml", help="a mesh file, or a recipe that names its own"
    )
    parser.add_argument("--material", metavar="NAME|FILE.toml", help="a preset, or a recipe (default: calf)")
    parser.add_argument(
        "--resolution", type=_whole, metavar="N", help="side of the page in texels (default: 1024)"
    )
    parser.add_argument("--seed", type=_whole, metavar="N", help="of everything random (default: 0)")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="changes",
        help='change a parameter, such as leather.cell_size="2 mm"; may be repeated',
    )  # fmt: skip
    _scale(parser)
    parser.add_argument(
        "-o", "--out", metavar="FILE.toml", help="what `save` writes (default: ./<mesh>-<material>.toml)"
    )
    parser.add_argument("--picture", metavar="PICTURE.png", help="draw the window into a file, and end")
    parser.add_argument("--web", action="store_true", help="serve a page to a browser instead of a window")
    parser.add_argument(
        "--host", metavar="NAME", default="127.0.0.1", help="of the page (default: 127.0.0.1)"
    )
    parser.add_argument("--port", type=_whole, metavar="N", default=0, help="of the page (default: any free)")
    parser.add_argument("--threads", type=_whole, metavar="N", help="threads to use (default: all cores)")
    parser.add_argument(
        "--allow-outside", action="store_true", help="let a recipe name files outside its folder"
    )


def _render(parser: Parser) -> None:
    parser.add_argument("subject", metavar="MESH|GLB", help="what to draw")
    parser.add_argument(
        "-o", "--out", metavar="PICTURE.png", required=True, help="the picture; replaced if there"
    )
    parser.add_argument(
        "--picture-size", type=_side_by_side, metavar="WxH", help="in pixels (default: 1280x960)"
    )
    parser.add_argument(
        "--view", action="append", default=[], metavar="NAME|AZIMUTH,ELEVATION",
        help="such as front, top, or 30,20 (default: three-quarter); may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--light", action="append", default=[], choices=["studio", "portrait", "raking"],
        help="(default: studio); may be repeated",
    )  # fmt: skip
    parser.add_argument("--turntable", type=_whole, metavar="N", help="N pictures, once around")
    parser.add_argument("--sheet", action="store_true", help="several pictures in one, with their names")
    parser.add_argument("--zoom", type=_number, metavar="X", help="1 shows everything, 10 a tenth of it")
    parser.add_argument(
        "--target", type=_numbers(3), metavar="X,Y,Z", help="place in mm to have in the middle"
    )
    parser.add_argument("--up", choices=["x", "y", "z"], help="axis that points up (default: y)")
    parser.add_argument("--background", metavar="COLOUR", help="such as #e9e7e4")


def _frames(parser: Parser) -> None:
    parser.add_argument(
        "--frames",
        type=_whole,
        metavar="N",
        default=0,
        help="draw the growth of cells in N pictures as well, at most 2000",
    )


def _exchange(parser: Parser) -> None:
    parser.add_argument(
        "--materialx", action="store_true", default=None, help="write the material as MaterialX as well"
    )
    parser.add_argument(
        "--usd", action="store_true", default=None, help="write mesh and material as USD as well"
    )
    parser.add_argument(
        "--usd-format",
        choices=["usda", "usdc", "usdz"],
        help="text, binary, or one file with everything inside (default: usda)",
    )


def _scale(parser: Parser) -> None:
    parser.add_argument(
        "--units", choices=["mm", "cm", "m", "in"], help="unit of the file's coordinates; --size overrules it"
    )
    parser.add_argument(
        "--size",
        metavar="LENGTH",
        help='length of the longest side, such as "300 mm"; a bare number is millimetres; with --part, that of the whole file',
    )
    parser.add_argument("--part", metavar="NAME", help="only this material slot, group or node")
    parser.add_argument(
        "--crease", type=_number, metavar="DEGREES",
        help="edges that bend by more are hard, others smooth (default: the file's normals, or all smooth)",
    )  # fmt: skip


def _manner(parser: Parser) -> None:
    manner = parser.add_mutually_exclusive_group()
    manner.add_argument("-q", "--quiet", action="store_true", help="no progress, no warnings")
    manner.add_argument(
        "-v", "--verbose", action="store_true", help="a line per stage; tracebacks of failures"
    )


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None


def _numbers(count: int) -> Callable[[str], tuple[float, ...]]:
    def read(text: str) -> tuple[float, ...]:
        numbers = tuple(_number(each) for each in text.split(","))
        if len(numbers) != count:
            raise argparse.ArgumentTypeError(f"{text!r} is not {count} numbers with commas between")
        return numbers

    return read


def _whole_numbers(text: str) -> tuple[int, ...]:
    return tuple(_whole(each) for each in text.split(","))


def _side_by_side(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal() and int(width) and int(height)):
        raise argparse.ArgumentTypeError(f"{text!r} is no size; write it as 1280x960")
    return int(width), int(height)


def _whole(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from None
