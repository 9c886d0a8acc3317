"""Writes the reference pages from the code itself: `python -m docs.make_reference`.

Materials and recipe tables come from the models, commands from the parser, the Python interface from its docstrings.
A test compares the pages with what this writes, so that they cannot fall behind.
"""

import importlib
import inspect
import sys
from pathlib import Path

from numpydoc.docscrape import ClassDoc, FunctionDoc
from pydantic_core import PydanticUndefined

import surftex as sx
from surftex.charts.gate import AREA_SHARE, GAP_PX, GROSS_SHARE, LEAST_COVERAGE
from surftex.charts.quality import ANISOTROPY_LIMIT, DENSITY_LIMIT
from surftex.cli.options import make_parser
from surftex.preview.controls import controls
from surftex.recipe.layer import MATERIALS, Layer, material_class, plain_types
from surftex.recipe.model import BakeSettings, MeshSettings, Recipe

HERE = Path(__file__).resolve().parent
LENGTHS = ("size", "displaced_edge")
MADE = "Written by `python -m docs.make_reference`; change the code, not this page.\n"


def cell(text):
    """Text in a table."""
    return " ".join(str(text).split()).replace("|", "\\|")


def value(thing):
    """A default as TOML would have it."""
    if isinstance(thing, bool):
        return str(thing).lower()
    if thing is None or thing is PydanticUndefined:
        return ""
    if isinstance(thing, (tuple, list)):
        return f"`[{', '.join(f'{each:.4g}' if isinstance(each, float) else repr(each) for each in thing)}]`"
    return (
        f"`{thing:g}`"
        if isinstance(thing, float)
        else f"`{thing!r}`"
        if isinstance(thing, str)
        else f"`{thing}`"
    )


def limits(control, field):
    """Unit and range of a parameter."""
    if control.kind == "choice":
        return ", ".join(control.choices)
    if control.kind == "switch":
        return "true or false"
    if control.kind == "colour":
        return "`#rrggbb`, or three linear numbers"
    schema = {name: bound for mark in field.metadata for name in ("ge", "gt", "le", "lt")
              if (bound := getattr(mark, name, None)) is not None}  # fmt: skip
    words = [f"{sign} {schema[name]:g}" for name, sign in (("ge", "≥"), ("gt", ">"), ("le", "≤"), ("lt", "<"))
             if name in schema and abs(schema[name]) < 1e6]  # fmt: skip
    kind = {"whole": "whole", "range": "two numbers", "text": "name or expression"}.get(control.kind, "")
    also = "or an expression" if control.kind != "text" and str in plain_types(field.annotation) else ""
    return ", ".join(part for part in (control.unit, kind, " ".join(words), also) if part)


def materials():
    """Every material: its parameters by group, and its shelf."""
    rows = ["# Materials of a recipe", "", MADE]
    rows += [
        'Each is the `material` of a `[[layer]]`; lengths are millimetres, or text with a unit such as `"0.8 mm"`.'
    ]
    rows += ["Parameters that take an expression read the fields of the recipe ([fields](recipe.md)).", ""]
    for name in MATERIALS:
        model = material_class(name)
        rows += [f"## {name}", "", inspect.getdoc(model) or "", ""]
        blank = model.model_construct()
        group = None
        for control in controls(blank):
            field = model.model_fields[control.key]
            if control.group != group:
                group = control.group
                rows += [
                    "",
                    f"**{group}**",
                    "",
                    "| parameter | default | takes | what it is |",
                    "| --- | --- | --- | --- |",
                ]
            rows.append(f"| `{control.key}` | {value(getattr(blank, control.key, None))} | {cell(limits(control, field))} "
                        f"| {cell(control.text)} |")  # fmt: skip
        rows += ["", "Presets:", ""]
        rows += [f"- `{preset}`: {cell(caption)}" for preset, caption in model.presets().items()]
        rows.append("")
    return "\n".join(rows)


def taken(schema):
    """What a key takes, from its JSON schema."""
    if "anyOf" in schema:
        return " or ".join(
            dict.fromkeys(taken(each) for each in schema["anyOf"] if each.get("type") != "null")
        )
    if "enum" in schema:
        return ", ".join(f"`{each}`" for each in schema["enum"])
    names = {
        "integer": "whole number",
        "number": "number",
        "boolean": "true or false",
        "array": "list of text",
        "string": "text",
    }
    words = [f"{sign} {schema[name]:g}" for name, sign in (("minimum", "≥"), ("exclusiveMinimum", ">"), ("maximum", "≤"))
             if name in schema]  # fmt: skip
    return " ".join([names.get(schema.get("type"), ""), *words]).strip()


def recipe():
    """The tables of a recipe beside its fields."""
    rows = ["# Tables of a recipe", "", MADE, "A recipe is TOML: two keys at the top, then tables."]
    rows += ["A key that is not listed is a mistake, told with its line and the nearest name.", ""]
    rows += [
        'Lengths are text with a unit (`um`, `mm`, `cm`, `m`, `in`), such as `"0.9 mm"`; a bare number is millimetres.',
        "",
    ]
    for title, model, left_out in (
        ("At the top", Recipe, {"mesh", "bake", "fields_", "layer"}),
        ("`[mesh]`", MeshSettings, set()),
        ("`[bake]`", BakeSettings, set()),
        ("`[[layer]]`", Layer, {"material"}),
    ):
        about = "" if model is Recipe else inspect.getdoc(model)
        rows += [
            f"## {title}",
            "",
            about,
            "",
            "| key | default | takes | what it is |",
            "| --- | --- | --- | --- |",
        ]
        if model is Layer:
            kinds = ", ".join(f"`{name}`" for name in MATERIALS)
            rows.append(f"| `material` |  | {kinds} | What the layer is of; that of the preset without it. |")
        known = model.model_json_schema()["properties"]
        for key, field in model.model_fields.items():
            if key not in left_out:
                takes = "length" if key in LENGTHS else cell(taken(known[key]))
                rows.append(
                    f"| `{key}` | {value(field.default)} | {takes} | {cell(field.description or '')} |"
                )
        rows.append("")
        if model is Layer:
            rows += ["All other keys are [parameters of the material](reference-materials.md).", ""]
    rows += [
        "## `[fields]`",
        "",
        "Masks, directions and curves by name: [Fields of a recipe](recipe.md).",
        "",
    ]
    stretch, density = f"{ANISOTROPY_LIMIT:g} times", f"{DENSITY_LIMIT:g} times"
    rows += [
        "## When own UVs are kept",
        "",
        f"`auto` keeps them where {100 * AREA_SHARE:g} % of the area is stretched at most {stretch}",
        f"and at most {density} denser or sparser than the mean, no face leaves 0..1 (or its tile),",
        f"no texel lies in two faces, charts are {GAP_PX} texels apart and cover {100 * LEAST_COVERAGE:g} % of the page;",
        "else it unwraps anew and says why.",
        f"`keep` refuses overlaps, UVs off the page, and more than {100 * GROSS_SHARE:g} % of the area beyond those limits",
        "or without texels; everything else becomes a warning with its figures. Mirrored charts may pass.",
        "`surftex inspect` says what a bake would do.",
        "",
    ]
    return "\n".join(rows)


def commands():
    """Every command and its options."""
    parser, known = make_parser()
    rows = ["# Commands", "", MADE, cell(parser.epilog), ""]
    for name, each in known.items():
        rows += [
            f"## surftex {name}",
            "",
            cell(each.description),
            "",
            "| option | what it does |",
            "| --- | --- |",
        ]
        for action in each._actions:
            if action.help in ("==SUPPRESS==", None) or action.dest == "help":
                continue
            shown = (
                ", ".join(f"`{option}`" for option in action.option_strings)
                or f"`{action.metavar or action.dest}`"
            )
            meta = action.metavar or (",".join(map(str, action.choices)) if action.choices else "")
            if action.option_strings and meta and action.nargs != 0:
                shown += f" {cell(meta)}"
            rows.append(f"| {shown} | {cell(action.help % {'default': action.default, 'prog': name})} |")
        rows.append("")
    return "\n".join(rows)


def python():
    """Every public name."""
    rows = ["# Python", "", MADE, "Arrays are numpy, lengths millimetres, colours linear sRGB.", ""]
    for name in sx.__all__:
        thing = getattr(sx, name)
        if callable(thing) and inspect.ismodule(thing):  # a room that is called like the function in it
            thing = getattr(importlib.import_module(f"surftex.{name}.{name}"), name)
        if inspect.ismodule(thing):
            rows += [f"## sx.{name}", "", (inspect.getdoc(thing) or "").splitlines()[0], ""]
            for part in getattr(thing, "__all__", []):
                rows += described(f"sx.{name}.{part}", getattr(thing, part), "###")
        elif callable(thing):
            rows += described(f"sx.{name}", thing, "##")
    return "\n".join(rows)


def described(name, thing, level):
    """A function or a class, from its docstring."""
    doc = ClassDoc(thing) if inspect.isclass(thing) else FunctionDoc(thing) if callable(thing) else None
    if doc is None:
        return []
    told = "(...)" if inspect.isclass(thing) else signature(thing)
    rows = [
        f"{level} {name}",
        "",
        f"`{name.split('.')[-1]}{told}`",
        "",
        *doc["Summary"],
        "",
        *doc["Extended Summary"],
        "",
    ]
    for title in ("Parameters", "Attributes", "Returns", "Raises"):
        entries = [entry for entry in doc[title] if entry.desc or entry.type]
        if entries and not (title in ("Parameters", "Attributes") and hasattr(thing, "model_fields")):
            rows += [f"*{title}*", ""]
            rows += [f"- {f'`{entry.name}` ' if entry.name else ''}*{cell(entry.type)}*: {cell(' '.join(entry.desc))}"
                     for entry in entries]  # fmt: skip
            rows.append("")
    if doc["Examples"]:
        rows += ["```python", *doc["Examples"], "```", ""]
    if inspect.isclass(thing):
        for member, each in vars(thing).items():
            plain = each.__func__ if isinstance(each, (staticmethod, classmethod)) else each
            if not member.startswith("_") and inspect.isfunction(plain) and plain.__doc__:
                rows += [f"- `.{member}{signature(plain)}`: {plain.__doc__.strip().splitlines()[0]}"]
        rows.append("")
    return rows


def signature(function):
    """Names and defaults, without types."""
    try:
        found = inspect.signature(function)
    except (TypeError, ValueError):
        return "(...)"
    plain = [
        each.replace(annotation=inspect.Parameter.empty)
        for each in found.parameters.values()
        if each.name != "self"
    ]
    return str(found.replace(parameters=plain, return_annotation=inspect.Signature.empty))


PAGES = {
    "reference-materials.md": materials,
    "reference-commands.md": commands,
    "reference-python.md": python,
    "reference-recipe.md": recipe,
}


def page(name):
    """Make a page."""
    lines = [line.rstrip() for line in PAGES[name]().splitlines()]
    kept = [line for i, line in enumerate(lines) if line or (i and lines[i - 1])]
    return "\n".join(kept).rstrip() + "\n"


if __name__ == "__main__":
    for name in PAGES:
        text = page(name)
        (HERE / name).write_text(text, "utf-8")
        print(f"{name}: {len(text.splitlines())} lines", file=sys.stderr)
